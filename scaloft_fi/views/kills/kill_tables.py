"""What kills what, as tables: conditions and orders, situations, the minimal suite, subsumption, survivors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillMatrix
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.suite import (
    NIST,
    NIST_SOURCE,
    ChosenKills,
    Interaction,
    Orders,
    Redundancy,
    SituationKills,
    Subsumption,
    Suite,
    chosen_kills,
)
from scaloft_fi.judge.space import Space
from scaloft_fi.views.kills.survivors import Stage, Survivor
from scaloft_fi.views.score.next_step import Next
from scaloft_fi.views.tables.table import Table, TableCell

COUNTED = (
    "Killed in a situation: the mutant is detected, and most of its flights there violate a requirement that the "
    "unmutated drone holds steadily there."
)
INDENTED = "Indented: killed wherever a mutant of the layer before is; subsumed by: those directly before it."
ORDER = (
    "Order: fewest axes whose values decide the kill.  Where situations say nothing (not flown, or no steady "
    "requirement tests the mutant there) it is a range: from what is known to what it would be if the mutant survived "
    "there."
)


def with_detected(shown: Sequence[Table], matrix: KillMatrix) -> list[Table]:
    """The same tables; the first tells how many mutants are detected, how many firmly, and which have no kill."""
    if not shown:
        return []
    known = [row for row in matrix.mutants if row.firmness]
    firm = sum(row.firmness.firm for row in known if row.firmness)
    notes = [f"Detected mutants: {len(known)}, of them {firm} firmly: whichever one seed is left out."]
    if matrix.not_firm:
        notes[0] += f"  Not firm: {', '.join(matrix.not_firm)}."
    if matrix.scattered:
        notes.append(
            f"Detected without a kill, so in no table of kills: {', '.join(matrix.scattered)}.  Their violations are "
            "spread over situations; in none do most flights violate."
        )
    return [replace(shown[0], notes=(*shown[0].notes, *notes)), *shown[1:]]


def interaction_table(listed: Sequence[Interaction]) -> Table:
    """Per killed mutant its condition and its kill interaction order."""
    rows = tuple((entry.mutant, entry.killing, _order(entry), entry.condition) for entry in listed)
    return Table("Killed where", ("mutant", "situations", "order", "condition"), rows, (ORDER,))


def _order(entry: Interaction) -> str:
    return str(entry.order) if entry.order == entry.order_at_most else f"{entry.order}-{entry.order_at_most}"


def order_table(orders: Orders) -> Table:
    """The histogram of orders, cumulative, beside NIST's."""
    rows: list[tuple[TableCell, ...]] = []
    for size, (count, share) in enumerate(zip(orders.counts, orders.cumulative(), strict=True)):
        nist = [_percent(shares[size - 1] if 1 <= size <= len(shares) else None) for shares in NIST.values()]
        rows.append((size, count, _percent(share) or "n/a", *nist))
    notes = (
        "Default mutants of credible cells that are killed, % with at most this order; NIST's failures beside them.",
        f"Source: {NIST_SOURCE}; blank: not at hand.  NIST counts input variables, here axes of the grid count.",
    )
    return Table("Kill interaction orders", ("order", "mutants", "at most %", *NIST), tuple(rows), notes)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0f}"


def situation_table(listed: Sequence[SituationKills], space: Space, *, short: bool = False) -> Table:
    """Per situation what it kills and what it alone kills; `short` leaves out those between."""
    shown = [entry for entry in listed if not short or entry.alone or not entry.killed]
    rows = tuple(
        (
            entry.situation,
            _words(space, entry.situation),
            str(Ratio(len(entry.killed), entry.tested)),
            str(entry.minimal),
            ", ".join(entry.alone),
        )
        for entry in shown
    )
    idle = [entry for entry in listed if not entry.killed]
    untested = sum(not entry.tested for entry in idle)
    notes = [f"In {len(idle)} of {len(listed)} situations flown no mutant is killed; {untested} of them test none."]
    notes.append(COUNTED)
    if short and len(shown) < len(listed):
        notes.insert(
            0, f"{len(listed) - len(shown)} situations are left out: what is killed there is killed elsewhere too."
        )
    return Table(
        "Situations",
        ("situation", "values", "killed/tested", "minimal mutants", "killed only there"),
        rows,
        tuple(notes),
    )


def _words(space: Space, key: str) -> str:
    return ", ".join(space.words_of(key))


def suite_table(suite: Suite, matrix: KillMatrix) -> Table:
    """The smallest set of situations that keeps every kill, and how far its first ones come."""
    rows = []
    for number, key in enumerate(suite.situations, start=1):
        so_far, own = chosen_kills(matrix, suite.situations[:number]), chosen_kills(matrix, [key])
        needed = "yes" if key in suite.needed else ""
        words = _words(matrix.space, key)
        rows.append((key, words, needed, own.killed.part, str(so_far.killed), str(so_far.dominator_score)))
    size = len(suite.situations)
    if suite.exact:
        others = "an unknown number" if suite.alternatives is None else str(suite.alternatives)
        notes = [f"Fewest situations that keep every kill: {size}, proved; sets of that size: {others}."]
    else:
        notes = [f"Fewest situations that keep every kill: at most {size}; chosen greedily, too many to prove it."]
    headers = ("situation", "values", "needed", "killed there", "killed so far", "minimal so far")
    return Table("Smallest set of situations", headers, tuple(rows), (*notes, COUNTED))


def chosen_table(chosen: ChosenKills) -> Table:
    """What some situations kill together."""
    rows = (
        ("killed", str(chosen.killed), "of the mutants killed in any situation flown"),
        (
            "dominator score",
            str(chosen.dominator_score),
            "minimal mutants killed, of all: redundant mutants do not count",
        ),
        ("lost", str(len(chosen.lost)), ", ".join(chosen.lost)),
    )
    note = "Dominator score: Kurtz et al., FSE 2016; of every situation flown together it is 1 by construction."
    return Table(f"These {len(chosen.situations)} situations", ("", "mutants", ""), rows, (note, COUNTED))


def subsumption_table(graph: Subsumption, *, short: bool = False) -> Table:
    """The subsumption graph as indented rows; `short` leaves only the minimal mutants."""
    above: dict[int, list[int]] = {place: [] for place in range(len(graph.nodes))}
    below: dict[int, list[int]] = {place: [] for place in range(len(graph.nodes))}
    for upper, lower in graph.edges:
        above[lower].append(upper)
        below[upper].append(lower)
    depth = {place: number for number, layer in enumerate(graph.layers()) for place in layer}
    rows: list[tuple[str, int, str]] = []

    def add(place: int) -> None:
        node = graph.nodes[place]
        others = [graph.nodes[upper].name for upper in above[place]]
        rows.append(("> " * depth[place] + ", ".join(node.mutants), len(node.kills), ", ".join(others)))
        # a node stands below the last of the nodes that subsume it directly from the layer before
        for lower in below[place]:
            if max((upper for upper in above[lower] if depth[upper] == depth[lower] - 1), default=-1) == place:
                add(lower)

    for place in graph.layers()[0] if graph.nodes else ():
        add(place)
    if short:
        rows = [row for row in rows if not row[0].startswith("> ")]
    sets = f"{len(graph.nodes)} different kill sets, {len(graph.minimal)} of them minimal: what kills these kills all."
    notes = [f"{graph.killed} killed mutants, {sets}"]
    notes.append("`--show subsumption` lists the rest." if short else INDENTED)
    return Table("Subsumption", ("mutants", "killed in", "subsumed by"), tuple(rows), tuple(notes))


def redundancy_table(listed: Sequence[Redundancy]) -> Table:
    """Per cell with several killed mutants, how many say what another says."""
    rows = tuple(
        (entry.cell, str(entry.redundant), "; ".join(" = ".join(group) for group in entry.duplicates))
        for entry in listed
    )
    notes = ("Redundant: killed magnitudes and phases of a cell with the kill set of another of them.",)
    return Table("Redundancy within cells", ("cell", "redundant", "same kills"), rows, notes)


def survivor_table(listed: Sequence[Survivor]) -> Table:
    """Every survivor with the next thing to do."""
    classed = any(one.severity for one in listed)
    rows = tuple(
        (
            one.mutant,
            *([one.severity or ""] if classed else []),
            *(one.verdict.words, one.stage.value, one.next.value, one.why),
        )
        for one in listed
    )
    headers = ("mutant", *(["severity"] if classed else []), "verdict", "stopped at", "next", "why")
    return Table("Survivors", headers, rows, (_STOPPED, _STEADY, _WAY))


def survivor_summary(listed: Sequence[Survivor]) -> Table:
    """How many survivors have which verdict and stopped where, by what to do next."""
    groups: dict[tuple[Stage, Verdict, Next], list[str]] = {
        (stage, verdict, then): [] for stage in Stage for verdict in Verdict for then in Next
    }
    for entry in listed:
        groups[entry.stage, entry.verdict, entry.next].append(entry.mutant)
    rows = tuple(
        (verdict.words, stage.value, then.value, len(ids), ", ".join(ids))
        for (stage, verdict, then), ids in groups.items()
        if ids
    )
    notes = (_STOPPED, "`--show survivors` says of each why, and what to do.")
    return Table("Survivors", ("verdict", "stopped at", "next", "mutants", "which"), rows, notes)


_WAY = "Off its path: from the path of the baseline, over flights of the first seed that put the mutant to the test."
_STOPPED = (
    "Mutants that are not detected.  Stopped at: reach (no sample), infect (no sample changed), propagate (same "
    "flight), reveal (another flight, no requirement violated more often than chance explains); next: what to change."
)
_STEADY = (
    "A requirement in a situation is steady when the unmutated drone holds it in nine of ten flights, red when it "
    "mostly violates it, vacuous when its trigger seldom comes true, open when flights end before it is judged."
)
