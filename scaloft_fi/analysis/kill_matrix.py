"""The kill matrix: mutants x situations of results, in the order of a Karnaugh map.

The first half of the axes runs down, the others run across, each side in the order of a reflected Gray code (Karnaugh,
"The map method for synthesis of combinational logic circuits", Trans. AIEE 72, 1953; for axes of any number of values
here).  With two values an axis the opposite edges are neighbours too.

**Which situations are needed.**  Mutants are the rows to be hit, situations the columns that hit them: unate covering
(Coudert, "Two-level logic minimization: an overview", Integration 17, 1994), which integer programming solves.  The
smallest sets are counted by branch and bound, whose bound is a set of rows that share no column.

A mutant subsumes another when something kills it and whatever kills it kills the other too: kills(a) is not empty and
within kills(b).  Mutants with equal kill sets are one node; the nodes that no other subsumes are the minimal ones
(Ammann, Delamaro and Offutt, "Establishing theoretical minimal sets of mutants", ICST 2014; Kurtz et al., "Mutant
subsumption graphs", Mutation 2014).  It holds of the situations flown, not of all there could be.

The order of a mutant is the fewest literals of an implicant of its kills: the least t such that it is killed in every
situation that has certain values of t axes.  It is the analogue of the number of variables that trigger a failure in
NIST's studies of software failures.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, combinations, product
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.analysis.detection import Firmness, Verdict
from scaloft_fi.analysis.roster import OfSubject, Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Result, Score, condition, sides
from scaloft_fi.hazop.matrix import cell_of
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.judge.status import Status
from scaloft_fi.marks import ByName, Choices
from scaloft_fi.registry import grouped


def gray_order(space: Space) -> tuple[str, ...]:
    """The keys of the listed situations in the order of the reflected mixed-radix Gray code, the first axis slowest.

    In a grid of every combination, neighbours differ on one axis, by neighbouring values; where constraints leave
    situations out the rest keep their order.  Source: Knuth, The Art of Computer Programming 4A, 7.2.1.1, algorithm H.
    """
    radices = [len(values) for values in space.values]

    def rank(entry: tuple[str, tuple[str, ...]]) -> int:
        digits = [values.index(value) for values, value in zip(space.values, entry[1], strict=True)]
        return gray_rank(digits, radices)

    return tuple(key for key, _ in sorted(space.situations, key=rank))


def gray_rank(digits: Sequence[int], radices: Sequence[int]) -> int:
    """The place of a word in the reflected Gray code of these radices.

    >>> [gray_rank(word, (2, 3)) for word in [(0, 0), (0, 1), (0, 2), (1, 2), (1, 1), (1, 0)]]
    [0, 1, 2, 3, 4, 5]
    """
    rank = 0
    for digit, radix in zip(digits, radices, strict=True):
        # under a word of odd rank the rest is listed backwards
        rank = rank * radix + (radix - 1 - digit if rank % 2 else digit)
    return rank


def gray_words(radices: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """All words of the reflected Gray code of these radices, in its order.

    >>> gray_words((2, 2))
    ((0, 0), (0, 1), (1, 1), (1, 0))
    """
    return tuple(sorted(product(*map(range, radices)), key=lambda word: gray_rank(word, radices)))


MOST_CELLS = 512
"""A map of more situations than this would not be read."""


@dataclass(frozen=True)
class Fold:
    """A grid folded into a rectangle.

    Attributes:
        down, across: indices of the axes that run down, and across.
        rows, columns: values of those axes, in the order of the map.
        keys: (rows, columns) keys of the situations; None where the grid has none.
    """

    down: tuple[int, ...]
    across: tuple[int, ...]
    rows: tuple[Point, ...]
    columns: tuple[Point, ...]
    keys: tuple[tuple[str | None, ...], ...]


def fold(space: Space) -> Fold:
    """The grid as a rectangle: the first half of its axes down, the others across."""
    half = len(space.axes) // 2
    down, across = tuple(range(half)), tuple(range(half, len(space.axes)))
    rows, columns = _side(space, down), _side(space, across)
    key_of = {point: key for key, point in space.points}
    keys = tuple(tuple(key_of.get((*above, *beside)) for beside in columns) for above in rows)
    return Fold(down, across, rows, columns, keys)


def _side(space: Space, axes: tuple[int, ...]) -> tuple[Point, ...]:
    words = gray_words([len(space.values[axis]) for axis in axes])
    return tuple(tuple(space.values[axis][digit] for axis, digit in zip(axes, word, strict=True)) for word in words)


def cyclic(side: Sequence[Point]) -> bool:
    """Whether the last place of a side is a neighbour of the first.

    >>> cyclic([("0",), ("1",)]), cyclic([("0", "0"), ("0", "1"), ("1", "1"), ("1", "0"), ("2", "0"), ("2", "1")])
    (True, False)
    """
    return sum(a != b for a, b in zip(side[0], side[-1], strict=True)) <= 1


NOT_FLOWN = "not_flown"
"""The state of a situation without a flight, beside the statuses."""


@dataclass(frozen=True)
class KillEntry:
    """A mutant in a situation.

    Attributes:
        mutant: id of the mutant.
        situation: key of the situation.
        state: the furthest stage that a flight reached, or `not_flown`.
        kills: requirements that kill the mutant here, as the scores count.
        seen: safety requirements that put the fault to the test here and that a flight violates.
        tested: whether a safety requirement puts the fault to the test here.
        flown: flights that count.
        infected: whether the fault changed a sample in any.
        violated: by requirement that any flight violates, the flights that violate it.
    """

    mutant: str
    situation: str
    state: Annotated[str, Choices((*Status, NOT_FLOWN))] = NOT_FLOWN
    kills: tuple[str, ...] = ()
    seen: tuple[str, ...] = ()
    tested: bool = False
    flown: int = 0
    infected: bool = False
    violated: Annotated[tuple[tuple[str, int], ...], ByName()] = ()

    @property
    def survived(self) -> bool:
        """Whether it does not kill though the fault was tested, or could change nothing."""
        return not self.kills and (self.tested or (self.flown > 0 and not self.infected))


MutantKind = Literal["mutant", "control", "placebo"]


@dataclass(frozen=True)
class KillRow(OfSubject):
    """A mutant in every situation of the grid, and in every one with drawn numbers that was flown.

    Attributes:
        subject: the mutant.
        kind: what it is.
        counted: whether the ratios count it: the default mutant of a credible cell.
        status: the furthest stage that a flight reached.
        verdict: on the mutant.
        kill_rate: situations with a kill, of those that put it to the test.
        entries: in the grid's order; a situation that the grid does not have is left out.
        firmness: what remains of the verdict when one seed is left out; null: it is not detected.
    """

    KEYS = ("subject.*", "kind", "counted", "status", "verdict", "firm=firmness", "kill_rate")
    subject: Subject
    kind: MutantKind
    counted: bool
    status: Status
    verdict: Verdict
    kill_rate: Ratio
    entries: tuple[KillEntry, ...]
    firmness: Firmness | None = None

    @property
    def killing(self) -> tuple[str, ...]:
        """Situations with a kill."""
        return tuple(entry.situation for entry in self.entries if entry.kills)

    @property
    def surviving(self) -> tuple[str, ...]:
        """Situations without one though the fault was tested, or could change nothing."""
        return tuple(entry.situation for entry in self.entries if entry.survived)

    @cached_property
    def kills(self) -> frozenset[str]:
        """Situations with a kill, as a set."""
        return frozenset(self.killing)


class AxisWord(NamedTuple):
    """A value of an axis.

    Attributes:
        axis: id of the axis.
        value: as in keys.
        word: its short name.
    """

    axis: str
    value: str
    word: str


@dataclass(frozen=True)
class KillMatrix:
    """Mutants x situations.

    Attributes:
        space: the grid.
        rows: the mutants asked for in the canonical order, then controls, then PLACEBO.
    """

    space: Space
    rows: tuple[KillRow, ...]

    @cached_property
    def row(self) -> Mapping[str, KillRow]:
        """The row of each id."""
        return {row.id: row for row in self.rows}

    @property
    def mutants(self) -> tuple[KillRow, ...]:
        """Without controls and PLACEBO: what the analyses are about."""
        return tuple(row for row in self.rows if row.kind == "mutant")

    def only(self, ids: Collection[str]) -> KillMatrix:
        """The rows of these ids."""
        return KillMatrix(self.space, tuple(row for row in self.rows if row.id in ids))

    @cached_property
    def kills(self) -> Mapping[str, frozenset[str]]:
        """Per mutant with a kill its situations, as the scores count; controls and PLACEBO are not in it."""
        return {row.id: row.kills for row in self.mutants if row.kills}

    @cached_property
    def subsumption(self) -> Subsumption:
        """The graph of these sets."""
        return subsumption(self.kills)

    def kill_sets(self, by_requirement: bool = False) -> Mapping[str, frozenset[str]]:
        """Per mutant with a kill what kills it; `by_requirement`: as `SITUATION REQUIREMENT`, each for itself.

        A flight that ends at a contact cannot show what it would have violated later.
        """
        if not by_requirement:
            return self.kills
        return {
            row.id: frozenset(f"{entry.situation} {name}" for entry in row.entries for name in entry.kills)
            for row in self.mutants
            if row.kills
        }

    @property
    def values(self) -> tuple[AxisWord, ...]:
        """The values of the axes."""
        space = self.space
        axes = zip(space.axes, space.values, space.words, strict=True)
        return tuple(AxisWord(axis, *each) for axis, *told in axes for each in zip(*told, strict=True))

    @property
    def results(self) -> tuple[KillEntry, ...]:
        """Each of them in each situation of the grid; of a large grid in those flown."""
        return tuple(entry for row in self.rows for entry in row.entries)

    @property
    def scattered(self) -> tuple[str, ...]:
        """Ids of detected mutants without a kill: some flights violate in several situations, most in none."""
        return tuple(row.id for row in self.mutants if row.verdict is Verdict.DETECTED and not row.kills)

    @property
    def not_firm(self) -> tuple[str, ...]:
        """Detected mutants whose verdict hangs on a seed, or that have too few seeds to say."""
        return tuple(row.id for row in self.mutants if row.firmness and not row.firmness.firm)

    @cached_property
    def flown(self) -> tuple[str, ...]:
        """Situations with a flight that counts, in the grid's order."""
        flown = {entry.situation for row in self.rows for entry in row.entries if entry.flown}
        return tuple(key for key, _ in self.space.situations if key in flown)


def kill_matrix(scored: Score, roster: Roster, space: Space) -> KillMatrix:
    """The kill matrix of a campaign's score; the roster says which mutants the ratios count."""
    placebo = [scored.placebo] if scored.placebo else []
    groups: Mapping[MutantKind, Sequence[MutantScore]]
    groups = {"mutant": scored.mutants, "control": scored.controls, "placebo": placebo}
    scores = [mutant for members in groups.values() for mutant in members]
    space = space.holding({result.situation for mutant in scores for result in mutant.results})
    rows = [_row(mutant, kind, roster, space) for kind, members in groups.items() for mutant in members]
    return KillMatrix(space, tuple(rows))


def _row(mutant: MutantScore, kind: MutantKind, roster: Roster, space: Space) -> KillRow:
    results = {result.situation: result for result in mutant.results}
    return KillRow(
        subject=mutant.subject,
        kind=kind,
        counted=kind == "mutant" and roster.counts(mutant.subject),
        status=mutant.status,
        verdict=mutant.verdict,
        kill_rate=mutant.kill_rate,
        entries=tuple(_entry(mutant.subject.id, key, results.get(key)) for key, _ in space.situations),
        firmness=mutant.firmness,
    )


def _entry(mutant: str, key: str, result: Result | None) -> KillEntry:
    if result is None:
        return KillEntry(mutant, key)
    return KillEntry(
        mutant,
        key,
        state=result.status.value,
        kills=result.kills,
        seen=result.seen,
        tested=result.tested,
        flown=result.flown,
        infected=result.infected,
        violated=result.violated,
    )


MOST_ENTRIES = 10_000_000
"""Entries of the matrix looked at in one search, over all branches (some ten seconds); beyond, the answer is greedy."""
BEGUN = 5
"""Nodes that the beginning of an integer program counts as."""
MOST_COUNTED = 1_000_000
"""Minimum sets counted; beyond, their number is None."""


@dataclass(frozen=True)
class Suite:
    """Situations that together kill every mutant that any situation kills.

    Attributes:
        situations: their keys in the order of the columns; the first such set in that order, when exact.
        exact: whether no smaller set does; else it is at most this many.
        alternatives: sets of this size that do; null: not exact, or too many to count.
        needed: keys of situations in every such set, because some mutant dies nowhere else.
    """

    situations: tuple[str, ...]
    exact: bool
    alternatives: int | None
    needed: tuple[str, ...]


def minimal_suite(
    kills: Mapping[str, Collection[str]], situations: Sequence[str], *, most_entries: int = MOST_ENTRIES
) -> Suite:
    """The smallest set of situations that hits every kill set.

    Args:
        kills: per mutant the situations that kill it; empty sets are left alone.
        situations: every situation, in the order by which ties are broken.
        most_entries: entries looked at before it turns greedy.

    Raises:
        ValueError: a kill set names a situation that is not in `situations`.
    """
    place = {key: number for number, key in enumerate(situations)}
    unknown = {key for keys in kills.values() for key in keys} - set(place)
    if unknown:
        raise ValueError(f"kills in unknown situations: {sorted(unknown)}")
    rows = _minimal_rows(frozenset(place[key] for key in keys) for keys in kills.values() if keys)
    needed = tuple(situations[min(row)] for row in sorted(rows, key=sorted) if len(row) == 1)
    try:
        chosen, exact = _first_in_order(rows, most_entries), True
    except _TooMany:
        chosen, exact = _greedy(rows), False
    return Suite(
        situations=tuple(situations[column] for column in sorted(chosen)),
        exact=exact,
        alternatives=_count(rows, len(chosen), most_entries) if exact else None,
        needed=needed,
    )


Rows = frozenset[frozenset[int]]
"""What is still to be hit, each by one of its columns."""


class _TooMany(Exception):  # noqa: N818 - a limit, no error
    """The search looked at more than allowed."""


def _minimal_rows(rows: Iterable[frozenset[int]]) -> Rows:
    """The rows that contain no other: whoever hits those hits all."""
    kept: list[frozenset[int]] = []
    for row in sorted(set(rows), key=len):
        if not any(smaller <= row for smaller in kept):
            kept.append(row)
    return frozenset(kept)


def _classes(rows: Rows) -> list[list[int]]:
    """The columns, those that hit the same rows together; of equal ones the first stands for all."""
    hits: dict[int, int] = {}
    for number, row in enumerate(rows):
        for column in row:
            hits[column] = hits.get(column, 0) | 1 << number
    return list(grouped(sorted(hits), hits.__getitem__).values())


def _bound(rows: Rows) -> int:
    """How many rows, greedily picked, share no column: each needs a column of its own."""
    used: set[int] = set()
    number = 0
    for row in sorted(rows, key=lambda row: (len(row), sorted(row))):
        if not row & used:
            used |= row
            number += 1
    return number


def _first_in_order(rows: Rows, most_entries: int) -> frozenset[int]:
    """Of the smallest sets the one that comes first when each is listed in the columns' order.

    Raises:
        _TooMany: beyond a limit.
    """
    if not rows:
        return frozenset()
    from scipy.optimize import LinearConstraint, milp  # takes longer to import than other verbs take

    columns = [same[0] for same in _classes(rows)]
    every, each = np.array([[column in row for column in columns] for row in rows], float), np.ones(len(columns))
    least, most, left = np.zeros(len(columns)), np.ones(len(columns)), most_entries

    def smallest() -> NDArray[np.bool_]:
        nonlocal left
        nodes = left // every.size
        if nodes < 1:
            raise _TooMany
        hit, limits = LinearConstraint(every, lb=1), {"node_limit": nodes}
        found = milp(each, integrality=each, bounds=(least, most), constraints=hit, options=limits)
        left -= every.size * (BEGUN + (found.mip_node_count or 0))
        if found.status:
            raise _TooMany
        return np.asarray(found.x > 0.5)

    best = smallest()
    for place in range(len(columns)):
        least[place] = 1
        if not best[place] and (other := smallest()).sum() == best.sum():
            best = other
        least[place] = most[place] = best[place]
        if least.sum() == best.sum():
            break
    return frozenset(column for column, chosen in zip(columns, best, strict=True) if chosen)


def _count(rows: Rows, size: int, most_entries: int) -> int | None:
    """How many sets of `size` columns hit all rows; None beyond the limits.

    Columns that hit the same rows stand for one another, and a smallest set never has two of them.
    """
    weight = {same[0]: len(same) for same in _classes(rows)}
    looked_at = 0

    def count(left: Rows, budget: int) -> int:
        nonlocal looked_at
        looked_at += 1 + sum(map(len, left))
        if looked_at > most_entries:
            raise _TooMany
        if not left:
            return 1 if budget == 0 else 0
        if frozenset() in left or _bound(left) > budget:
            return 0
        total = 0
        branching = min(left, key=lambda row: (len(row), sorted(row)))
        barred: set[int] = set()
        for column in sorted(branching):
            # a set counts in the branch of its first column of this row
            rest = frozenset(row - barred for row in left if column not in row)
            total += weight[column] * count(rest, budget - 1)
            barred.add(column)
        return total

    try:
        number = count(frozenset(frozenset(c for c in row if c in weight) for row in rows), size)
    except _TooMany:
        return None
    return number if number <= MOST_COUNTED else None


def _greedy(rows: Rows) -> frozenset[int]:
    """Always the column that hits most, the first of equals; what later ones make superfluous is dropped."""
    chosen: list[int] = []
    left = rows
    while left:
        hits = Counter(column for row in left for column in row)
        chosen.append(max(hits, key=lambda column: (hits[column], -column)))
        left = frozenset(row for row in left if chosen[-1] not in row)
    for column in list(chosen):
        if all(row & (set(chosen) - {column}) for row in rows):
            chosen.remove(column)
    return frozenset(chosen)


@dataclass(frozen=True)
class Node:
    """Mutants with the same kills.

    Attributes:
        node: its number, from 0.
        mutants: ids, in the order given.
        kills: what kills them: keys of situations, with --by-requirement key and requirement.
        layer: the longest way to it from a node that no other subsumes.
    """

    KEYS = ("*", "minimal")
    node: int
    mutants: tuple[str, ...]
    kills: frozenset[str]
    layer: int

    @property
    def name(self) -> str:
        """The first mutant's id."""
        return self.mutants[0]

    @property
    def minimal(self) -> bool:
        """Whether no other subsumes it."""
        return self.layer == 0


class Edge(NamedTuple):
    """What kills one also kills the other.

    Attributes:
        subsuming: number of a node.
        subsumed: number of a node.
    """

    subsuming: int
    subsumed: int


@dataclass(frozen=True)
class Subsumption:
    """Which kills imply which.

    Attributes:
        nodes: mutants with the same kills, in the order of their first mutants.
        edges: what kills one also kills the other; those that follow from others are left out.
    """

    KEYS = ("*", "killed", "distinct", "minimal=least")
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]

    @cached_property
    def minimal(self) -> tuple[Node, ...]:
        """The nodes that no other subsumes."""
        return tuple(node for node in self.nodes if node.minimal)

    @property
    def killed(self) -> int:
        """Mutants in the graph: those that something kills."""
        return sum(len(node.mutants) for node in self.nodes)

    @property
    def distinct(self) -> int:
        """Nodes."""
        return len(self.nodes)

    @property
    def least(self) -> int:
        """Nodes that no other subsumes."""
        return len(self.minimal)

    def dominator_score(self, chosen: Collection[str]) -> Ratio:
        """Minimal nodes that the chosen columns kill, of all minimal nodes.

        Redundant mutants do not count in it; over all columns it is 1 by construction.  Source: Kurtz et al.,
        "Analyzing the validity of selective mutation with dominator mutants", FSE 2016.
        """
        columns = set(chosen)
        return Ratio(sum(bool(node.kills & columns) for node in self.minimal), len(self.minimal))


def subsumption(kills: Mapping[str, Collection[str]]) -> Subsumption:
    """The subsumption graph of kill sets, by mutant; mutants that nothing kills are not in it."""
    import networkx as nx

    classes = grouped((mutant for mutant, keys in kills.items() if keys), lambda mutant: frozenset(kills[mutant]))
    full = nx.DiGraph()
    full.add_nodes_from(range(len(classes)))
    full.add_edges_from(
        (above, below) for above, upper in enumerate(classes) for below, lower in enumerate(classes) if upper < lower
    )
    reduced = nx.transitive_reduction(full)
    layers = {node: layer for layer, nodes in enumerate(nx.topological_generations(reduced)) for node in nodes}
    nodes = (Node(node, tuple(classes[keys]), keys, layers[node]) for node, keys in enumerate(classes))
    return Subsumption(tuple(nodes), tuple(Edge(*edge) for edge in sorted(reduced.edges)))


@dataclass(frozen=True)
class Redundancy:
    """How many killed mutants of a cell say the same.

    Attributes:
        cell: its name.
        killed: its mutants that something kills: magnitudes and phases.
        duplicates: groups of two or more of them with the same kills.
    """

    KEYS = ("*", "redundant")
    cell: str
    killed: int
    duplicates: tuple[tuple[str, ...], ...]

    @property
    def redundant(self) -> Ratio:
        """Mutants that could be left out without losing a set of kills of the cell, of those killed."""
        return Ratio(sum(len(group) - 1 for group in self.duplicates), self.killed)


def redundancies(graph: Subsumption) -> tuple[Redundancy, ...]:
    """The redundancy within each cell that has two or more killed mutants, in the order of the nodes."""
    alike = (tuple(members) for node in graph.nodes for members in grouped(node.mutants, cell_of).values())
    return tuple(
        Redundancy(cell, killed, tuple(group for group in own if len(group) > 1))
        for cell, own in grouped(alike, lambda group: cell_of(group[0])).items()
        if (killed := sum(map(len, own))) > 1
    )


@dataclass(frozen=True)
class SituationKills:
    """A situation as a test.

    Attributes:
        situation: its key.
        killed: ids of the mutants killed there, as the scores count.
        tested: mutants that could have been killed there: it puts them to the test.
        alone: ids of those killed in no other situation.
        minimal: minimal mutants killed there, of all: what it would score without redundant mutants.
    """

    situation: str
    killed: tuple[str, ...]
    tested: int
    alone: tuple[str, ...]
    minimal: Ratio


def situation_kills(matrix: KillMatrix) -> tuple[SituationKills, ...]:
    """Every situation flown, in the grid's order, those that kill nothing too."""
    graph = matrix.subsumption
    tested = Counter(entry.situation for row in matrix.mutants for entry in row.entries if entry.tested)
    return tuple(
        SituationKills(
            situation=key,
            killed=tuple(id_ for id_, keys in matrix.kills.items() if key in keys),
            tested=tested[key],
            alone=tuple(id_ for id_, keys in matrix.kills.items() if keys == {key}),
            minimal=graph.dominator_score([key]),
        )
        for key in matrix.flown
    )


@dataclass(frozen=True)
class ChosenKills:
    """What some situations kill together.

    Attributes:
        situations: their keys.
        killed: mutants killed there, of those that are killed anywhere.
        dominator_score: minimal mutants killed there, of all minimal mutants (`Subsumption.dominator_score`).
        lost: ids of mutants that are killed elsewhere only.
    """

    situations: tuple[str, ...]
    killed: Ratio
    dominator_score: Ratio
    lost: tuple[str, ...]


def chosen_kills(matrix: KillMatrix, situations: Iterable[str]) -> ChosenKills:
    """What these situations kill together."""
    keys = tuple(dict.fromkeys(situations))
    lost = tuple(id_ for id_, kills in matrix.kills.items() if not kills & set(keys))
    whole = len(matrix.kills)
    return ChosenKills(keys, Ratio(whole - len(lost), whole), matrix.subsumption.dominator_score(keys), lost)


NIST = {
    "medical devices": (66, 97, 99),
    "browser": (29, 76, 95),
    "server": (42, 70, 89),
    "NASA GSFC": (68, 93, 98),
    "network sec.": (20, 65, None),
    "TCAS": (None, 53, None),
}
"""Share of failures [%] that one, at most two, at most three variables trigger; no failure needed more than six.

Source: Kuhn, NIST CSRC, "Interactions Involved in Software Failures - empirical data", table 1; its TCAS study used
seeded faults.  None: not published or not at hand.
"""
NIST_SOURCE = 'NIST CSRC (Kuhn), "Interactions Involved in Software Failures", table 1; TCAS: seeded faults'


@dataclass(frozen=True)
class Interaction:
    """How a mutant's kills depend on the axes.

    Attributes:
        mutant: id of the mutant.
        counted: whether the ratios count it.
        condition: the shortest condition: `human & light`.
        order: fewest axes that have to be right; 0 when it dies wherever it is tested.
        order_at_most: the same if it survived in every situation that does not say: there an order may rest on nothing.
        killing: situations where it is killed.
        unknown: situations that say nothing: not flown, or it infects there and no safety requirement is steady.
    """

    mutant: str
    counted: bool
    condition: str
    order: int
    order_at_most: int
    killing: int
    unknown: int


class KillOrder(NamedTuple):
    """The mutants of an order.

    Attributes:
        order: number of axes.
        mutants: killed mutants of this order.
        mutants_at_most: the same where nothing unknown helps.
        cumulative_percent: share of the killed mutants with at most this order [%]; null: none was killed.
    """

    order: int
    mutants: int
    mutants_at_most: int
    cumulative_percent: float | None


def interactions(matrix: KillMatrix) -> tuple[Interaction, ...]:
    """The interaction of every mutant that is killed somewhere, in the matrix's order; controls are left out."""
    return tuple(interaction(matrix.space, row) for row in matrix.mutants if row.killing)


def interaction(space: Space, row: KillRow) -> Interaction:
    """The interaction of one mutant.

    Raises:
        ValueError: it is killed nowhere.
    """
    killing, surviving = row.killing, row.surviving
    known = {space.point[key] for key in (*killing, *surviving)}
    others = [key for key, _ in space.points if key not in set(killing)]
    return Interaction(
        mutant=row.id,
        counted=row.counted,
        condition=condition(space, killing, surviving),
        order=order(space, killing, surviving),
        order_at_most=order(space, killing, others),
        killing=len(killing),
        unknown=len(space.points) - len(known),
    )


def orders(interactions: Iterable[Interaction], space: Space) -> tuple[KillOrder, ...]:
    """The histogram over the mutants that the ratios count: ladders would count one fault several times."""
    counted = [entry for entry in interactions if entry.counted]
    least, most = Counter(entry.order for entry in counted), Counter(entry.order_at_most for entry in counted)
    sizes = range(len(space.axes) + 1)
    return tuple(
        KillOrder(size, least[size], most[size], 100 * so_far / len(counted) if counted else None)
        for size, so_far in zip(sizes, accumulate(least[size] for size in sizes), strict=True)
    )


def order(space: Space, killing: Collection[str], surviving: Collection[str]) -> int:
    """Fewest literals of a box of the grid with a killing situation and no surviving one.

    A box that admits several values of an axis holds one that admits a single value, with as many literals: so it is
    enough to look for t axes whose values in some killing situation no surviving one shares.

    Raises:
        ValueError: nothing kills, or a situation both kills and is survived.
    """
    on, off = sides(space, killing, surviving)
    for size in range(len(space.axes) + 1) if on else ():
        for axes in combinations(range(len(space.axes)), size):
            spared = {tuple(point[axis] for axis in axes) for point in off}
            if any(tuple(point[axis] for axis in axes) not in spared for point in on):
                return size
    raise ValueError("an order needs a killing situation that is not survived")
