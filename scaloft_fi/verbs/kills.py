"""`scaloft-fi kills`: what kills what, and what to do about the rest."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Annotated, Any

import click

from scaloft_fi.analysis import kill_matrix as suites
from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillMatrix, kill_matrix
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.survivor import backgrounds
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.space import Space
from scaloft_fi.mutants.catalogue import select
from scaloft_fi.output import printable, tell_line, write_named
from scaloft_fi.registry import grouped
from scaloft_fi.study import Study
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.options import Option, Several, answer, check_writable, several, verb
from scaloft_fi.verbs.snapshot import Snapshot, Stale, snapshot
from scaloft_fi.verbs.verdict import Next, Stage, Survivor, short_units, survivors
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.picture import FAINT, INK, png, svg, text
from scaloft_fi.views.table import Table, TableCell, said, xml

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
    known = [row.firmness for row in matrix.mutants if row.firmness]
    firm = sum(firmness.firm for firmness in known)
    notes = [f"Detected mutants: {len(known)}, of them {firm} firmly: whichever one seed is left out."]
    if matrix.not_firm:
        notes[0] += f"  Not firm: {', '.join(matrix.not_firm)}."
    if matrix.scattered:
        spread = "Their violations are spread over situations; in none do most flights violate."
        notes.append(f"Detected without a kill, so in no table of kills: {', '.join(matrix.scattered)}.  {spread}")
    return [replace(shown[0], notes=(*shown[0].notes, *notes)), *shown[1:]]


def interaction_table(listed: Sequence[suites.Interaction]) -> Table:
    """Per killed mutant its condition and its kill interaction order."""
    rows = []
    for one in listed:
        order = str(one.order) if one.order == one.order_at_most else f"{one.order}-{one.order_at_most}"
        rows.append((one.mutant, one.killing, order, one.condition))
    return Table("Killed where", ("mutant", "situations", "order", "condition"), tuple(rows), (ORDER,))


def order_table(orders: Sequence[suites.KillOrder]) -> Table:
    """The histogram of orders, cumulative, beside NIST's."""
    rows: list[tuple[TableCell, ...]] = []
    for size, mutants, _, share in orders:
        nist = [_percent(shares[size - 1] if 1 <= size <= len(shares) else None) for shares in suites.NIST.values()]
        rows.append((size, mutants, _percent(share) or "n/a", *nist))
    notes = (
        "Default mutants of credible cells that are killed, % with at most this order; NIST's failures beside them.",
        f"Source: {suites.NIST_SOURCE}; blank: not at hand.  NIST counts input variables, here axes of the grid count.",
    )
    return Table("Kill interaction orders", ("order", "mutants", "at most %", *suites.NIST), tuple(rows), notes)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0f}"


def situation_table(listed: Sequence[suites.SituationKills], space: Space, *, short: bool = False) -> Table:
    """Per situation what it kills and what it alone kills; `short` leaves out those between."""
    shown = [entry for entry in listed if not short or entry.alone or not entry.killed]
    rows = tuple(
        (
            entry.situation,
            ", ".join(space.words_of(entry.situation)),
            str(Ratio(len(entry.killed), entry.tested)),
            str(entry.minimal),
            ", ".join(entry.alone),
        )
        for entry in shown
    )
    idle = [entry for entry in listed if not entry.killed]
    untested = sum(not entry.tested for entry in idle)
    left = f"{len(listed) - len(shown)} situations are left out: what is killed there is killed elsewhere too."
    notes = (
        *([left] if short and len(shown) < len(listed) else []),
        f"In {len(idle)} of {len(listed)} situations flown no mutant is killed; {untested} of them test none.",
        COUNTED,
    )
    headers = ("situation", "values", "killed/tested", "minimal mutants", "killed only there")
    return Table("Situations", headers, rows, notes)


def suite_table(suite: suites.Suite, matrix: KillMatrix) -> Table:
    """The smallest set of situations that keeps every kill, and how far its first ones come."""
    rows = []
    for number, key in enumerate(suite.situations, start=1):
        so_far, own = suites.chosen_kills(matrix, suite.situations[:number]), suites.chosen_kills(matrix, [key])
        needed = "yes" if key in suite.needed else ""
        words = ", ".join(matrix.space.words_of(key))
        rows.append((key, words, needed, own.killed.part, str(so_far.killed), str(so_far.dominator_score)))
    size = len(suite.situations)
    others = "an unknown number" if suite.alternatives is None else str(suite.alternatives)
    proved = f"{size}, proved; sets of that size: {others}"
    found = proved if suite.exact else f"at most {size}; chosen greedily, too many to prove it"
    headers = ("situation", "values", "needed", "killed there", "killed so far", "minimal so far")
    notes = f"Fewest situations that keep every kill: {found}.", COUNTED
    return Table("Smallest set of situations", headers, tuple(rows), notes)


def chosen_table(chosen: suites.ChosenKills) -> Table:
    """What some situations kill together."""
    minimal = "minimal mutants killed, of all: redundant mutants do not count"
    rows = (
        ("killed", str(chosen.killed), "of the mutants killed in any situation flown"),
        ("dominator score", str(chosen.dominator_score), minimal),
        ("lost", str(len(chosen.lost)), ", ".join(chosen.lost)),
    )
    note = "Dominator score: Kurtz et al., FSE 2016; of every situation flown together it is 1 by construction."
    return Table(f"These {len(chosen.situations)} situations", ("", "mutants", ""), rows, (note, COUNTED))


def subsumption_table(graph: suites.Subsumption, *, short: bool = False) -> Table:
    """The subsumption graph as indented rows; `short` leaves only the minimal mutants."""
    above, below = defaultdict[int, list[suites.Node]](list), defaultdict[int, list[suites.Node]](list)
    for upper, lower in graph.edges:
        above[lower].append(graph.nodes[upper])
        below[upper].append(graph.nodes[lower])
    rows: list[tuple[str, int, str]] = []

    def add(node: suites.Node) -> None:
        others = ", ".join(upper.name for upper in above[node.node])
        rows.append(("> " * node.layer + ", ".join(node.mutants), len(node.kills), others))
        # a node stands below the last of the nodes that subsume it directly from the layer before
        for lower in below[node.node]:
            if [upper for upper in above[lower.node] if upper.layer == lower.layer - 1][-1:] == [node]:
                add(lower)

    for node in graph.minimal:
        add(node)
    if short:
        rows = [row for row in rows if not row[0].startswith("> ")]
    sets = f"{len(graph.nodes)} different kill sets, {len(graph.minimal)} of them minimal: what kills these kills all."
    notes = [f"{graph.killed} killed mutants, {sets}"]
    notes.append("`--show subsumption` lists the rest." if short else INDENTED)
    return Table("Subsumption", ("mutants", "killed in", "subsumed by"), tuple(rows), tuple(notes))


def redundancy_table(listed: Sequence[suites.Redundancy]) -> Table:
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
        (one.mutant, *[one.severity or ""] * classed, *(one.verdict.words, one.stage.value, one.next.value, one.why))
        for one in listed
    )
    headers = ("mutant", *["severity"] * classed, "verdict", "stopped at", "next", "why")
    counts = Counter(one.next for one in listed)
    ends = f"Survivors: {len(listed)}; next: {', '.join(f'{each} {counts[each]}' for each in Next if counts[each])}."
    return Table("Survivors", headers, rows, (_STOPPED, _STEADY, _WAY, *[ends] * bool(listed)))


def survivor_summary(listed: Sequence[Survivor], then: str) -> Table:
    """How many survivors have which verdict and stopped where, by what to do next; `then`: the step of the campaign."""
    groups = grouped(listed, lambda entry: (entry.stage, entry.verdict, entry.next))
    rows = tuple(
        (verdict.words, stage.value, then.value, len(own), ", ".join(entry.mutant for entry in own))
        for stage, verdict, then in product(Stage, Verdict, Next)
        if (own := groups.get((stage, verdict, then)))
    )
    notes = (_STOPPED, "`--show survivors` says of each why, and what to do.", f"What next: {then}")
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


PARTS = {
    "conditions": "conditions",
    "situations": "situations",
    "suite": "summary",
    "subsumption": "subsumption_nodes",
    "survivors": "survivors",
}
"""The parts that can be asked for, and the table of each that `csv` prints where it alone is asked for."""


@dataclass(frozen=True)
class CampaignKills:
    """Where mutants are killed, which situations are needed, and what would change the rest.

    Attributes:
        matrix: the rows asked for.
        stale: the stored flights that no longer count and were not flown again.
        chosen: what the situations of --situation kill together; null: not asked for.
        conditions: how the kills of each mutant depend on the axes; null: not asked for.
        orders: mutants by how many axes have to be right; null: not asked for.
        situations: each situation flown, as a test; null: not asked for.
        suite: the fewest situations that together kill every mutant that any situation kills; null: not asked for.
        subsumption: which kills imply which; null: not asked for.
        redundancies: cells with two or more killed mutants; null: not asked for.
        survivors: the mutants that are not detected, those of the worst class of severity first; null: not asked for.
    """

    matrix: KillMatrix
    stale: Stale
    chosen: suites.ChosenKills | None = None
    conditions: tuple[suites.Interaction, ...] | None = None
    orders: tuple[suites.KillOrder, ...] | None = None
    situations: tuple[suites.SituationKills, ...] | None = None
    suite: suites.Suite | None = None
    subsumption: suites.Subsumption | None = None
    redundancies: tuple[suites.Redundancy, ...] | None = None
    survivors: tuple[Survivor, ...] | None = None
    KEYS = (
        *("matrix.values", "mutants=matrix.rows", "matrix.results", "detected_without_kill=matrix.scattered", "chosen"),
        *("conditions", "orders", "situations", "suite", "subsumption", "redundancies", "survivors", "stale"),
    )


KILLS = Output("kills", "1.1", CampaignKills, rows="mutants")


def kills(
    study: Study,
    campaign: str,
    mutants: KilledMutants = (),
    situations: Together = (),
    *,
    show: Show = (),
    by_requirement: ByRequirement = False,
) -> Answer:
    """Where mutants are killed, which situations are needed, and what would change the survivors.

    Raises:
        InputError: there is no such campaign, mutant, situation or part, or the campaign holds no such flight.
    """
    patterns, keys, show = several(mutants, "mutants"), several(situations, "situations"), several(show, "show")
    for part in show:
        if part not in PARTS:
            raise InputError(f"--show={part!r} must be one of {', '.join(PARTS)}{did_you_mean(part, PARTS)}")
    with snapshot(study, campaign) as now:
        study = now.study
        matrix, stale = _chosen(now, patterns), now.stale
        wanted = show or tuple(part for part in PARTS if part != "conditions" or not study.tests_of)
        cases = _survivors(now, matrix) if "survivors" in wanted else None
        then = now.next_step
    found = suites.interactions(matrix) if "conditions" in wanted else None
    graph = suites.subsumption(matrix.kill_sets(by_requirement)) if "subsumption" in wanted else None
    told = CampaignKills(
        matrix,
        stale,
        chosen=suites.chosen_kills(matrix, (one.key for one in study.grid.select(keys))) if keys else None,
        conditions=found,
        orders=None if found is None else suites.orders(found, matrix.space),
        situations=suites.situation_kills(matrix) if "situations" in wanted else None,
        suite=suites.minimal_suite(matrix.kills, matrix.flown) if "suite" in wanted else None,
        subsumption=graph,
        redundancies=None if graph is None else suites.redundancies(graph),
        survivors=cases,
    )
    return Answer(
        KILLS,
        lambda: told,
        lambda: [said(table, of_tests=matrix.space.of_tests) for table in _tables(told, then, short=not show)],
        rows=PARTS[show[0]] if len(show) == 1 else "",
        warnings=(*stale.sentences, *(study.finds.warnings if "survivors" in wanted else ())),
    )


def _chosen(now: Snapshot, patterns: Sequence[str]) -> KillMatrix:
    """The rows that `patterns` mean.

    Raises:
        InputError: a pattern means nothing, or nothing that the campaign holds.
    """
    study = now.study
    matrix = kill_matrix(now.score, study.roster, study.space)
    if not patterns:
        return matrix
    asked = [mutant.id for mutant in select(patterns, study.matrix, study.catalogue)]
    flown = [id_ for id_ in asked if id_ in matrix.row]
    if not flown:
        raise InputError(f"the campaign holds no flight of {', '.join(asked[:3])}{', ...' if len(asked) > 3 else ''}")
    return matrix.only(flown)


def _survivors(now: Snapshot, matrix: KillMatrix) -> tuple[Survivor, ...]:
    """The survivors among `matrix`, judged beside all that the campaign holds."""
    ids = {row.id for row in matrix.mutants if row.verdict is not Verdict.DETECTED}
    outcomes = now.outcomes_of({BASELINE, *ids})
    seeds = sorted({outcome.seed for outcome in outcomes if outcome.mutant in ids})
    tracked = now.with_tracks(outcomes, lambda one: one.seed in seeds[:1])
    known = backgrounds(now.study.matrix, [mutant.subject.id for mutant in now.score.mutants])
    units = short_units(now.study.requirements)
    return survivors(tracked, now.score, matrix, known, units, now.name, now.study.finds)


def _tables(told: CampaignKills, then: str, *, short: bool) -> list[Table]:
    """A table for each part that was asked for, but none for redundancies where there are none; `then`: what next."""
    made: dict[str, Callable[[Any], Table]] = {
        "chosen": chosen_table,
        "conditions": interaction_table,
        "orders": order_table,
        "situations": lambda listed: situation_table(listed, told.matrix.space, short=short),
        "suite": lambda suite: suite_table(suite, told.matrix),
        "subsumption": lambda graph: subsumption_table(graph, short=short),
        "redundancies": redundancy_table,
    }
    parts = {name: getattr(told, name) for name in made if getattr(told, name) is not None}
    shown = [made[name](part) for name, part in parts.items() if part or name != "redundancies"]
    listed = told.survivors
    last = [] if listed is None else [survivor_summary(listed, then) if short else survivor_table(listed)]
    return [*with_detected(shown, told.matrix), *last]


MARGIN, TOP = 24.0, 92.0
LINE, PAD = 16.0, 8.0
GAP_X, GAP_Y = 72.0, 14.0
CHAR_W = 7.9
"""Widest a letter of the font is on average at size 12 [px]."""
MOST_LINES, LONGEST_NAME = 8, 34
SWEEPS = 4


Box = tuple[float, float, float, float]
"""Left, top, width, height [px]."""
Slot = tuple[int, int, int]
"""What takes a place in a layer: (layer, node, -1), or (layer, above, below) where an edge passes through."""


def draw_subsumption(graph: suites.Subsumption) -> str:
    """The graph as the text of an SVG file: layers from left to right (Sugiyama, Tagawa and Toda, 1981)."""
    title, (boxes, wide, high) = "What subsumes what", _places(graph)
    sets = f"{len(graph.nodes)} kill sets, {len(graph.minimal)} minimal (thick frames)"
    parts = [
        text(MARGIN, 34, title, size=20, weight="bold"),
        text(MARGIN, 56, f"{graph.killed} killed mutants, {sets}.", colour=FAINT, size=13),
        text(MARGIN, 74, "What kills a mutant kills those its lines lead to, on the right.", colour=FAINT, size=13),
    ]
    parts += [_edge([boxes[slot] for slot in _way(graph, *edge)]) for edge in graph.edges]
    for node in graph.nodes:
        parts += _box(node, boxes[node.layer, node.node, -1], thick=node.minimal)
    return svg(max(wide, 620.0), high, title, parts, font_size=12)


def _way(graph: suites.Subsumption, above: int, below: int) -> list[Slot]:
    """The slots of an edge: of the node above, of the layers between that it passes through, of the node below."""
    first, last = graph.nodes[above].layer, graph.nodes[below].layer
    return [(first, above, -1), *((layer, above, below) for layer in range(first + 1, last)), (last, below, -1)]


def _places(graph: suites.Subsumption) -> tuple[dict[Slot, Box], float, float]:
    """Where everything is, and the size of the picture [px]."""
    layers = _ordered(graph)
    lines = {slot: _lines(graph.nodes[slot[1]]) for members in layers for slot in members if slot[2] < 0}
    heights = {slot: 2 * PAD + LINE * len(lines[slot]) - 4 if slot in lines else 4.0 for own in layers for slot in own}
    tall = [sum(heights[slot] for slot in members) + GAP_Y * (len(members) - 1) for members in layers]
    high = max(tall, default=0.0)
    boxes: dict[Slot, Box] = {}
    x = MARGIN
    for members, own in zip(layers, tall, strict=True):
        width = 2 * PAD + CHAR_W * max(len(line) for slot in members for line in lines.get(slot, ()))
        y = TOP + (high - own) / 2
        for slot in members:
            boxes[slot] = (x, y, width, heights[slot])
            y += heights[slot] + GAP_Y
        x += width + GAP_X
    return boxes, x - GAP_X + MARGIN, TOP + high + MARGIN


def dot(graph: suites.Subsumption) -> str:
    """The graph in the DOT language of Graphviz."""

    def quoted(words: str) -> str:
        return '"' + printable(words).replace("\\", "\\\\").replace('"', '\\"') + '"'

    lines = ["digraph subsumption {", "  rankdir=LR; node [shape=box];"]
    for node in graph.nodes:
        label = quoted("\n".join([*node.mutants, f"killed in {len(node.kills)}"])).replace("\n", "\\n")
        lines.append(f"  n{node.node} [label={label}{', penwidth=3' if node.minimal else ''}];")
    lines += [f"  n{above} -> n{below};" for above, below in graph.edges]
    return "\n".join([*lines, "}", ""])


def _ordered(graph: suites.Subsumption) -> list[list[Slot]]:
    """The layers, each sorted by the mean place of its slots' neighbours, again and again, so that few lines cross."""
    layers: list[list[Slot]] = [[] for _ in {node.layer for node in graph.nodes}]
    for node in graph.nodes:
        layers[node.layer].append((node.layer, node.node, -1))
    near = defaultdict[Slot, list[Slot]](list)
    for edge in graph.edges:
        way = _way(graph, *edge)
        for slot in way[1:-1]:
            layers[slot[0]].append(slot)
        for slot, following in pairwise(way):
            near[slot].append(following)
            near[following].append(slot)
    for _ in range(SWEEPS):
        for members in layers:
            at = {slot: (number + 0.5) / len(each) for each in layers for number, slot in enumerate(each)}
            middle = {s: sum(at[n] for n in near[s]) / len(near[s]) if near[s] else at[s] for s in members}
            members.sort(key=lambda slot: (middle[slot], slot))
    return layers


def _lines(node: suites.Node) -> list[str]:
    kept = node.mutants if len(node.mutants) <= MOST_LINES else node.mutants[: MOST_LINES - 1]
    names = [name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 3] + "..." for name in kept]
    rest = len(node.mutants) - len(kept)
    return [*names, *([f"and {rest} more"] if rest else []), f"killed in {len(node.kills)}"]


def _edge(way: list[Box]) -> str:
    """A line from the right of the first box through the empty ones to an arrow at the left of the last."""
    x, y = way[0][0] + way[0][2], _middle(way[0])
    data = f"M{x:.1f},{y:.1f}"
    for number, box in enumerate(way[1:], start=1):
        last = number == len(way) - 1
        end, level = box[0] - 6 * last, _middle(box)
        bend = (end - x) / 2
        data += f"C{x + bend:.1f},{y:.1f} {end - bend:.1f},{level:.1f} {end:.1f},{level:.1f}"
        x, y = (end, level) if last else (box[0] + box[2], level)
        data += "" if last else f"H{x:.1f}"
    head = f"M{x + 6:.1f},{y:.1f}l-8,-4v8z"
    return f'<path d="{data}" fill="none" stroke="#8b929b" stroke-width="1.2"/><path d="{head}" fill="#8b929b"/>'


def _middle(box: Box) -> float:
    return box[1] + box[3] / 2


def _box(node: suites.Node, box: Box, *, thick: bool) -> list[str]:
    x, y, width, height = box
    frame = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" rx="4"'
    parts = [
        "<g>",
        f"<title>{xml(', '.join(node.mutants))}: killed in {xml(', '.join(sorted(node.kills)))}</title>",
        f'<rect {frame} fill="#ffffff" stroke="{INK}" stroke-width="{3 if thick else 1}"/>',
    ]
    lines = _lines(node)
    for number, words in enumerate(lines):
        last = number == len(lines) - 1
        parts.append(text(x + PAD, y + PAD + LINE * number + 10, words, colour=FAINT if last else "", size=12))
    return [*parts, "</g>"]


PICTURES = (".svg", ".png", ".dot")


KilledMutants = Annotated[
    Several,
    Option(
        "Names, ids or patterns.",
        "",
        metavar="[MUTANT...]",
        complete=names.mutants,
        otherwise="every mutant flown but the controls",
    ),
]
Show = Annotated[
    Several,
    Option(
        "Only this part, at length (repeatable).",
        "--show",
        type=click.Choice(tuple(PARTS)),
        otherwise="every part, shortened",
    ),
]
Together = Annotated[
    Several,
    options.SituationOption("Say also which mutants are killed in these situations together (repeatable)."),
]
ByRequirement = Annotated[bool, Option("Subsumption tells kills by different requirements of a situation apart.")]


@verb("kills")
def kills_command(
    *,
    mutants: KilledMutants = (),
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    show: Show,
    situations: Together,
    by_requirement: ByRequirement,
    style: options.TableFormat,
    tables_folder: options.TablesFolder,
    output: Annotated[Path | None, Option("Draw the subsumption graph there: .svg, .png or .dot.", metavar="FILE")],
) -> None:
    """Print where each mutant is killed, which situations are needed, and what to do about the survivors.

    MUTANT is an id, a cell's name or a pattern; without any it is every mutant flown but the controls.

    Examples:
        See where every mutant is killed: `scaloft-fi kills`
        Ask what to do about one survivor: `scaloft-fi kills MORE-human --show survivors`
        Find the fewest situations that keep every kill: `scaloft-fi kills --show suite`
    """
    check_writable(output, *PICTURES)

    study = Study.open(study_folder)
    if output is not None:
        with snapshot(study, campaign) as now:
            graph = suites.subsumption(_chosen(now, several(mutants, "mutants")).kill_sets(by_requirement))
        drawn = dot(graph) if output.suffix.lower() == ".dot" else draw_subsumption(graph)
        write_named(output, png(drawn) if output.suffix.lower() == ".png" else drawn.encode())
        tell_line(f"subsumption graph: {output}")
        return
    told = kills(study, campaign, mutants, show=show, situations=situations, by_requirement=by_requirement)
    answer(told, style, tables_folder)
