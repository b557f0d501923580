"""The kill matrix: mutants x situations of results, in the order of a Karnaugh map.

The first half of the axes runs down, the others run across, each side in the order of a reflected Gray code (Karnaugh,
"The map method for synthesis of combinational logic circuits", Trans. AIEE 72, 1953; for axes of any number of values
here).  With two values an axis the opposite edges are neighbours too.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Annotated, Literal, NamedTuple

from scaloft_fi.analysis.detection import Firmness, Verdict
from scaloft_fi.analysis.roster import OfSubject, Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Result, Score
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.judge.status import Status
from scaloft_fi.marks import ByName, Choices


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

    KEYS = (
        *("id", "guideword", "parameter", "magnitude", "kind", "counted", "status", "verdict", "firm=firmness"),
        "kill_rate",
    )
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
