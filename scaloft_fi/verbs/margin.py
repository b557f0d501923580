"""`scaloft-fi margin`: the smallest magnitude of a fault that is killed, by bisection."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import click

from scaloft_fi.analysis.detection import LARGER, Verdict
from scaloft_fi.analysis.margin import Margin, Scale, Strike, When, lowest, margins, whens
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import PhasedFault, Tried, detection_of, phased_fault
from scaloft_fi.campaign.plan import parse_seeds
from scaloft_fi.campaign.processes import cores, one_thread_each
from scaloft_fi.campaign.progress import Progress, Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.margin import find, target
from scaloft_fi.campaign.runs.request import choose_situations
from scaloft_fi.campaign.store.archive import campaign_folder, study_of
from scaloft_fi.defaults import CAMPAIGN, Seeds
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Matrix, SeverityClass, cell_of, parse
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.marks import About
from scaloft_fi.mutants.catalogue import realise, source_of
from scaloft_fi.output import in_campaign, say
from scaloft_fi.study import Study
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.options import Option, SeedsOption, Several, campaign_over, several, typed, verb
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

UNKNOWN = "?"
"""What stands where the flights bound no threshold."""


def magnitude_text(scale: Scale, magnitude: float) -> str:
    """A magnitude with its unit.

    >>> magnitude_text(Scale("s"), 0.5)
    '0.5 s'
    """
    return f"{magnitude:g} {scale.unit}".rstrip()


def margin_text(margin: Margin) -> str:
    """The threshold in a cell of a table; `!` where the response is not monotone.

    >>> s = Scale("s", 1, 0.0)
    >>> [margin_text(Margin(s, *ends)) for ends in ((1.3, 1.4), (1.0, 3.0), (5.0, None), (None, 0.5), (None, None))]
    ['1.4 s', '1-3 s', '> 5 s', '<= 0.5 s', '?']
    >>> margin_text(Margin(Scale("m", -1), 0.1, None)), margin_text(Margin(s, 1.0, 3.0, again=(5.0,)))
    ('< 0.1 m', '1-3 s !')
    >>> margin_text(Margin(s, 1.0, None, 3.0)), margin_text(Margin(s, 0.5, 3.0, 1.0))
    ('seen 1-3 s', '0.5-3 s')
    """
    if not margin.known:
        return UNKNOWN
    scale, survives = margin.scale, margin.survives
    beyond, within = (">", "<=") if scale.sign > 0 else ("<", ">=")
    strong = margin.kills if margin.kills is not None else margin.seen
    if strong is None:
        text = f"{beyond} {magnitude_text(scale, survives or 0.0)}"
    elif survives is None:
        text = f"{within} {magnitude_text(scale, strong)}"
    elif scale.close(survives, strong):
        text = magnitude_text(scale, strong)
    else:
        text = f"{survives:g}-{magnitude_text(scale, strong)}"
    return "seen " * (margin.kills is None and margin.seen is not None) + text + " !" * bool(margin.again)


ENDS = tuple(f"margin.{key}" for key in ("known", "survives", "seen", "kills", "monotone", "again"))
"""What an answer has of a margin."""


@dataclass(frozen=True)
class FaultMargin:
    """A fault.

    Attributes:
        fault: the fault with its phase, as an id without the magnitude.
        of: the same.
        margin: over all situations.
    """

    fault: str
    of: PhasedFault
    margin: Margin
    KEYS = ("fault", "of.cell", "of.unit", "of.phase_s", "of.event", *ENDS)


@dataclass(frozen=True)
class SituationMargin:
    """A fault in a situation.

    Attributes:
        fault: the fault with its phase, as an id without the magnitude.
        situation: key of the situation.
        margin: there.
    """

    fault: str
    situation: str
    margin: Margin
    KEYS = ("fault", "situation", *ENDS, "requirements")

    @property
    def requirements(self) -> tuple[str, ...]:
        """Those that are violated at the killed magnitude, else at the seen one."""
        return self.margin.strong.requirements


_Rho = Annotated[float | None, About("the least robustness, in the requirement's unit; null: it is not finite")]


@dataclass(frozen=True)
class TriedMagnitude:
    """A magnitude in a situation.

    Attributes:
        fault: the fault with its phase, as an id without the magnitude.
        situation: key of the situation.
        tried: what its flights show.
    """

    fault: str
    situation: str
    tried: Tried
    KEYS = (
        *("fault", "situation", "tried.magnitude", "answer=tried.reaction", "tried.flown", "tried.violated"),
        *("rho", "tried.needed", "tried.anew"),
    )

    @property
    def rho(self) -> Mapping[str, _Rho]:
        """By requirement that was put to the test."""
        return {name: value if math.isfinite(value) else None for name, value in self.tried.rho}


@dataclass(frozen=True)
class Phase:
    """A phase.

    Attributes:
        fault: id of the mutant without the phase.
        strike: the phase.
        lasts_s: median duration of the baselines in these situations [s].
        acts_first_s: earliest first altered sample [s from take-off]; null: none was.
        acts_median_s: median first altered sample [s from take-off]; null: none was.
        acts_last_s: latest first altered sample [s from take-off]; null: none was.
    """

    fault: str
    strike: Strike
    lasts_s: float
    acts_first_s: float | None
    acts_median_s: float | None
    acts_last_s: float | None
    KEYS = (
        *("strike.id", "fault", "strike.phase", "strike.at_event", "acts_first_s", "acts_median_s", "acts_last_s"),
        *("strike.kills", "strike.verdict", "lasts_s"),
    )


@dataclass(frozen=True)
class Margins:
    """The smallest magnitude of each fault that is killed; with --when, where in the flight it is.

    Attributes:
        faults: the faults, each over all situations; with --when empty.
        situations: each fault in each situation; with --when empty.
        tried: each magnitude that was flown; with --when empty.
        phases: with --when: each phase at which a fault was flown; else empty.
    """

    faults: tuple[FaultMargin, ...] = ()
    situations: tuple[SituationMargin, ...] = ()
    tried: tuple[TriedMagnitude, ...] = ()
    phases: tuple[Phase, ...] = ()

    @classmethod
    def of(cls, by_fault: Mapping[PhasedFault, Sequence[Margin]]) -> Margins:
        """What a search found."""
        faults = [FaultMargin(str(one), one, lowest(listed) or unknown(one.unit)) for one, listed in by_fault.items()]
        found = [(str(fault), margin) for fault, listed in by_fault.items() for margin in listed]
        each = [SituationMargin(fault, key, margin) for fault, margin in found for key in margin.situations]
        tried = (TriedMagnitude(one.fault, one.situation, entry) for one in each for entry in one.margin.tried)
        return cls(tuple(faults), tuple(each), tuple(tried))

    @classmethod
    def when(cls, found: Iterable[When]) -> Margins:
        """What the phases of faults show."""
        struck = ((when, strike) for when in found for strike in when.strikes)
        phases = (Phase(when.fault, one, when.lasts_s, *(one.acts_s or (None, None, None))) for when, one in struck)
        return cls(phases=tuple(phases))


MARGIN = Output("margin", "1.0", Margins, rows="situations")


def unknown(unit: str) -> Margin:
    """The margin of a fault of which nothing is known."""
    return Margin(Scale(unit), None, None, shown=False)


@dataclass(frozen=True)
class CellMargin:
    """A fault.

    Attributes:
        fault: of a credible cell.
        margin: over all situations, unshifted in time.
        verdicts: of a fault without an order, by magnitude or form that was flown.
    """

    fault: Fault
    margin: Margin
    verdicts: Mapping[str, Annotated[Verdict, About("on the mutant")]]
    KEYS = ("unit", *ENDS, "verdicts")

    @property
    def unit(self) -> str:
        """Unit of its magnitudes; empty where it has none."""
        return self.fault.magnitude.unit if self.fault.magnitude else ""

    @property
    def text(self) -> str:
        """The margin; of a fault without an order the forms that are detected, else the verdict that says most."""
        for verdict in (Verdict.DETECTED, Verdict.UNDECIDED, Verdict.NOT_DETECTED):
            if forms := [form for form, own in self.verdicts.items() if own is verdict]:
                named = self.fault.magnitude and verdict is Verdict.DETECTED
                return " ".join([*(forms if named else ()), verdict.words])
        return margin_text(self.margin)


@dataclass(frozen=True)
class ToldFault:
    """A fault.

    Attributes:
        fault: how the deviation is made.
        mutants: ids in the catalogue.
    """

    fault: Fault
    mutants: tuple[str, ...]
    KEYS = (
        *("fault.seam", "fault.operator", "fault.arguments", "fault.magnitude", "fault.phases", "fault.expected"),
        "mutants",
    )


@dataclass(frozen=True)
class ToldCell:
    """A cell.

    Attributes:
        cell: of the matrix.
        severity: class of severity, one of the study's own; in no ratio; null: it has none.
        default_mutant: id of the mutant that its name stands for; empty where it has none.
        faults: how the deviation is made.
    """

    cell: Cell
    severity: str | None
    default_mutant: str
    faults: tuple[ToldFault, ...]
    KEYS = (
        *("cell=cell.name", "cell.guideword", "cell.parameter", "cell.status", "cell.deviation", "cell.causes"),
        *("cell.effect", "severity", "cell.requirements", "cell.reason", "cell.predicted", "default_mutant", "faults"),
    )

    @classmethod
    def of(cls, cell: Cell, severity: SeverityClass | None) -> ToldCell:
        """What is told of a cell with its class of severity."""
        ids = ((one, tuple(id_ for rung in one.rungs for id_ in cell.mutant_ids(one, rung))) for one in cell.faults)
        faults = tuple(ToldFault(*each) for each in ids)
        return cls(cell, severity.id if severity else None, cell.default_id if faults else "", faults)


@dataclass(frozen=True)
class MatrixCell:
    """A cell.

    Attributes:
        told: the cell.
        margins: with --margins: the margins of its faults, over all situations; null: not asked for.
    """

    told: ToldCell
    margins: tuple[CellMargin, ...] | None
    KEYS = ("told.*", "margins")


@dataclass(frozen=True)
class MatrixCells:
    """The deviation matrix, every cell with its reason.

    Attributes:
        cells: the cells, parameter by parameter.
    """

    cells: tuple[MatrixCell, ...]


MATRIX = Output("matrix", "1.1", MatrixCells, rows="cells")


def told_cells(matrix: Matrix, margins: Mapping[str, tuple[CellMargin, ...]] | None) -> MatrixCells:
    """What `matrix` answers; `margins` as of `cell_margins`, None: not asked for."""
    told = (ToldCell.of(cell, matrix.severities.get(cell.name)) for cell in matrix)
    return MatrixCells(tuple(MatrixCell(one, margins[one.cell.name] if margins is not None else None) for one in told))


def cell_margins(scored: Score, matrix: Matrix, kind: Kind = Kind.SAFETY) -> Mapping[str, tuple[CellMargin, ...]]:
    """The margins of the faults of each cell, by its name; of a cell that is not credible none.

    Args:
        scored: score of a campaign.
        matrix: whose cells.
        kind: of the requirements whose violation kills.
    """
    by_fault = margins((), scored, matrix, kind)  # no robustness is asked for
    verdicts = {mutant.subject.id: detection_of(mutant, kind).verdict for mutant in scored.mutants}

    def of(cell: Cell, fault: Fault) -> CellMargin:
        phased = phased_fault(cell.name, fault)
        listed = by_fault.get(phased, ())
        ids = [] if listed else [cell.mutant_ids(fault, rung)[0] for rung in fault.rungs]
        own = {parse(id_).magnitude or id_: verdicts[id_] for id_ in ids if id_ in verdicts}
        return CellMargin(fault, lowest(listed) or unknown(phased.unit), own)

    return {
        cell.name: tuple(of(cell, one) for one in cell.faults) if cell.status is CellStatus.CREDIBLE else ()
        for cell in matrix
    }


def margins_of_cells(
    study: Study, campaign: str, *, operability: bool
) -> tuple[Matrix, Mapping[str, tuple[CellMargin, ...]]]:
    """The matrix of a campaign and the margins of its cells, as of `cell_margins`.

    Raises:
        InputError: there is no such campaign.
    """
    with snapshot(study, campaign) as now:
        matrix = now.study.matrix
        for warning in now.stale.invalid:
            say(f"warning: {warning}")
        return matrix, cell_margins(now.score, matrix, _kind(operability))


def margin_texts(matrix: Matrix, found: Mapping[str, Sequence[CellMargin]]) -> Mapping[str, str]:
    """What each cell shows, by its name; `found` as of `cell_margins`."""
    others = {CellStatus.NOT_MEANINGFUL: "-", CellStatus.CONTROL: "CONTROL", CellStatus.TO_DO: "to do"}
    told = {name: [one.text for one in listed if one.text != UNKNOWN] for name, listed in found.items()}
    return {cell.name: others.get(cell.status) or "; ".join(told[cell.name]) or UNKNOWN for cell in matrix}


HEADERS = ("situation", "margin", "survives", "seen", "killed", "violated", "robustness", "flown at", "again")
ENDS_LEGEND = (
    "Survives: the strongest magnitude that does, below the others.  Killed: the mildest at which the mutant is "
    "detected and most flights violate a steady requirement; seen: the mildest at which most do, but too few to detect "
    "it.  Violated: flights at the killed magnitude, else at the seen one; robustness: at the surviving one and there, "
    "below 0 it is violated."
)
LEGEND_AT = 11
"""Where the meanings begin in the legend [characters]."""
LEGEND = (
    "1.4 s      the smallest magnitude that is killed in any situation, known to a tenth; nothing milder flown is",
    "1-3 s      1 s survives, 3 s is killed in some situation; the least lies between (scaloft-fi margin CELL bisects)",
    "> 5 s      nothing flown is killed; in each known situation 5 s or more survives;  < 0.1 m: smaller is worse",
    "<= 0.5 s   is killed, and in some situation nothing milder survives;  >= 60 s: the same where smaller is worse",
    "seen 1-3 s 1 s survives, at 3 s most flights violate, too few to call the mutant detected: more seeds decide",
    "!          not monotone: a stronger magnitude survives where a milder one is killed or seen",
    "detected   a fault without magnitudes is detected (or not detected, or undecided); y detected: in this form",
    "?          not known yet (a situation takes ten baselines);   -  not meaningful;  CONTROL  has no margin",
)


def margin_tables(
    by_fault: Mapping[PhasedFault, Sequence[Margin]],
    requirements: Sequence[Requirement],
    seeds: int,
    campaign: str = CAMPAIGN,
    grid: str = "",
) -> tuple[Table, ...]:
    """A table for each fault: a row for each situation, the smallest margin and the requirements' limits below.

    Args:
        by_fault: the margins.
        requirements: of the study.
        seeds: number of seeds that were asked for.
        campaign: name of the campaign, for commands.
        grid: name of its grid, where that is a further grid of the study.
    """
    where = in_campaign(campaign), f"{in_campaign('NAME')}{f' --grid {grid}' if grid else ''}"
    tables = []
    for fault, listed in by_fault.items():
        least = lowest(listed)
        of = f"Smallest over {sum(margin.known for margin in listed)} of {len(listed)} situations"
        ends = {"survives": least.survives, "is seen": least.seen, "is killed": least.kills} if least else {}
        at = ", ".join(f"{_magnitude(least, end)} {what}" for what, end in ends.items() if least and end is not None)
        smallest = f"{of}: {margin_text(least)} ({at})." if least else f"{of}: none is known."
        notes = [smallest, ENDS_LEGEND, *_seen(fault, listed, *where)]
        if least and least.again:
            notes.append("Not monotone (!): magnitudes under `again` survive although a milder one is killed or seen.")
        if any(not margin.known for margin in listed):
            unsteady = "no requirement that the cell puts at risk is steady by ten baselines"
            notes.append(f"?: {unsteady}, or no sample changes.")
        violated = {name for margin in listed for name in margin.strong.requirements}
        for one in (one for one in requirements if one.name in violated):
            trigger = f"; trigger: {one.trigger}" if one.trigger else ""
            named = [f"; {name}: {text}" for name, text in one.definitions if name in one.text + one.trigger]
            notes.append(f"{one.name}: {one.title}  {one.text}{trigger}{''.join(named)} [{one.unit}]")
        if seeds == 1:
            notes.append("One seed: a threshold of these flights, not of the fault; fly more with --seeds.")
        tables.append(Table(f"Margin of {fault}", HEADERS, tuple(map(_row, listed)), tuple(notes)))
    return tuple(tables)


def _seen(fault: PhasedFault, listed: Sequence[Margin], where: str, anew_in: str) -> list[str]:
    """How many seeds would decide what is seen below every kill, with the command in this campaign or in a new one."""
    groups: dict[tuple[int, bool], dict[float, str]] = {}
    for margin in listed:
        if margin.seen is not None:
            entry = margin.at(margin.seen)
            many = (entry.needed or LARGER[-1] + 1, entry.anew)
            groups.setdefault(many, {})[margin.seen] = magnitude_text(margin.scale, margin.seen)
    notes = []
    for (seeds, anew), seen in sorted(groups.items()):
        at = ", ".join(seen[magnitude] for magnitude in sorted(seen))
        mutant = fault.at(f"{min(seen):g}{fault.unit}")
        if seeds > LARGER[-1]:
            notes.append(f"Seen, too seldom for {LARGER[-1]} seeds to decide: {at}.")
        else:
            command = f"scaloft-fi margin{anew_in if anew else where} {mutant} --seeds {seeds}"
            own = " in a campaign of its own" * anew
            notes.append(f"Seen, decided by {seeds} seeds{own}: {at} (`{command}`).")
    return notes


def _row(margin: Margin) -> tuple[str, ...]:
    strong, survivor = margin.strong, margin.at(margin.survives)
    before = dict(survivor.rho)
    rho = [(name, before.get(name, math.nan), now) for name, now in strong.rho if name in strong.requirements]
    return (
        ", ".join(margin.situations),
        margin_text(margin),
        _magnitude(margin, margin.survives),
        _magnitude(margin, margin.seen),
        _magnitude(margin, margin.kills),
        ", ".join(f"{name} {count}/{strong.flown}" for name, count in strong.violated if name in strong.requirements),
        ", ".join(f"{name} {_number(mild)} / {_number(now)}" for name, mild, now in rho),
        " ".join(f"{entry.magnitude:g}" for entry in margin.tried),
        " ".join(f"{magnitude:g}" for magnitude in margin.again),
    )


def _magnitude(margin: Margin, magnitude: float | None) -> str:
    return "" if magnitude is None or not margin.known else magnitude_text(margin.scale, magnitude)


def _number(value: float) -> str:
    return "?" if math.isnan(value) else f"{value:.2g}"


WHEN_HEADERS = ("phase", "acts at [s]", "in the flight", "kills", "verdict")
RAIL = 30
"""Width of the rail that stands for the flight [characters]."""
WHEN_LEGEND = (
    "Acts at: first altered sample, median over the flights (earliest to latest); kills: situations with a kill, of "
    "those that put it to the test.  In the flight: X some kill, o none, - not put to the test, at the median."
)


def when_tables(found: Iterable[When]) -> tuple[Table, ...]:
    """For each fault a table of the times at which it was flown, and one of the events."""
    tables = []
    for when in found:
        for kinds, strikes in (("times", when.told(at_events=False)), ("events", when.told(at_events=True))):
            detected = sum(strike.verdict is Verdict.DETECTED for strike in strikes)
            told = f"Detected at {detected} of {len(strikes)} {kinds}; the rail is the baseline's {when.lasts_s:.0f} s."
            rows = tuple(
                (one.phase or "#0s", _acts(one), _rail(one, when.lasts_s), one.kills.short, one.verdict.words)
                for one in strikes
            )
            if rows:
                tables.append(Table(f"When {when.fault} strikes: {kinds}", WHEN_HEADERS, rows, (told, WHEN_LEGEND)))
    return tuple(tables)


def _acts(strike: Strike) -> str:
    if strike.acts_s is None:
        return "never"
    first, median, last = strike.acts_s
    return f"{median:.1f}" + (f" ({first:.1f} to {last:.1f})" if first < last else "")


def _rail(strike: Strike, lasts_s: float) -> str:
    """The flight as a row of dots, with the phase's mark where it acts.

    >>> from scaloft_fi.analysis.roster import Ratio
    >>> _rail(Strike("NO-depth@3s#sight", "#sight", True, (5.0, 6.0, 7.0), Ratio(1, 4), Verdict.DETECTED), 60.0)
    '...X..........................'
    """
    if strike.acts_s is None or not lasts_s:
        return "." * RAIL
    place = min(RAIL - 1, int(RAIL * strike.acts_s[1] / lasts_s))
    mark = "X" if strike.kills.part else "o" if strike.kills.whole else "-"
    return "." * place + mark + "." * (RAIL - 1 - place)


def margin(
    study: Study,
    campaign: str,
    mutants: Sequence[str],
    options: RunOptions,
    *,
    situations: Sequence[str] = (),
    seeds: Sequence[int] = (0,),
    tolerance: float | None = None,
    operability: bool = False,
    progress: Callable[[], Progress],
) -> Answer:
    """The smallest magnitude of each fault that is killed, situation by situation; flies what the campaign lacks.

    Args:
        study: the study, with the grid of the campaign.
        campaign: name of the campaign, which need not exist.
        mutants: names of cells, or ids, whose faults are searched.
        options: options of the run.
        situations: keys, aliases or patterns; by default the whole grid, or what the grid chooses.
        seeds: seeds of the flights.
        tolerance: the width of the interval at which the search ends, in the unit of the magnitude; by default a tenth
            of the strong end's distance from no fault.
        operability: whether violations of operability requirements kill, instead of those of safety requirements.
        progress: makes the progress display of a round.

    Raises:
        GateError: a gate failed.
        InputError: there is no such mutant or situation, a fault has no order, or the study cannot be flown.
        Interrupted: the user stopped the search; all outcomes are saved.
    """
    study.check()
    targets = {one.subject: one for one in (target(study.matrix, text, tolerance) for text in mutants)}
    chosen = study.grid.select(situations)
    if not situations:
        chosen = choose_situations(study.grid.choose, chosen, seeds, 0, study.space, study.grid.chosen_at).situations
    folder, kind = campaign_folder(study, campaign), _kind(operability)
    by_fault = find(study, tuple(targets.values()), chosen, seeds, folder, options, kind=kind, progress=progress)
    tables = margin_tables(by_fault, study.requirements, len(seeds), campaign, study.space.grid)
    return Answer(MARGIN, lambda: Margins.of(by_fault), lambda: tables)


def when_answer(
    study: Study, campaign: str, mutants: MarginMutants, *, operability: options.Operability = False
) -> Answer:
    """At which times and events of the flight faults are killed, of the flights that a campaign holds.

    Raises:
        InputError: a mutant has no phases, or the campaign fewer than two of them.
    """
    asked = {name: realise(study.matrix, name) for name in several(mutants, "mutants")}
    for name, mutant in asked.items():
        if not source_of(study.matrix, mutant)[0].phases:
            raise InputError(f"mutant {name!r} has no phases: {mutant.cell} strikes all the time, or at one time")
    with snapshot(study, campaign) as now:
        flown, campaign = whens(now.outcomes, now.score, _kind(operability)), now.name
    found = []
    for name, mutant in asked.items():
        bare = mutant.id.partition("#")[0]
        own = [one for one in flown if one.fault == bare or (name == mutant.cell and cell_of(one.fault) == name)]
        if not own:
            command = f"scaloft-fi run --mutant '{bare}' --mutant '{bare}#*' --campaign {campaign}"
            raise InputError(f"campaign {campaign!r} has fewer than two phases of {bare}; fly them: {command}")
        found += own
    return Answer(MARGIN, lambda: Margins.when(found), lambda: when_tables(found))


def _kind(operability: bool) -> Kind:
    return Kind.OPERABILITY if operability else Kind.SAFETY


MarginMutants = Annotated[Several, Option("Names of cells, or ids.", "", metavar="CELL|ID...", complete=names.mutants)]
MarginSeeds = Annotated[Seeds, SeedsOption("Seeds 0..N-1, or A to B inclusive.", complete=names.seeds, default="1")]
Tolerance = Annotated[
    float | None,
    Option(
        "Bisect until the interval is no wider than this, in the magnitude's own unit.",
        metavar="NUMBER",
        type=click.FloatRange(min=0.0, min_open=True),
        otherwise="a tenth of the strong end's distance from no fault",
    ),
]


@verb(
    "margin",
    sections={
        "Where": "--study --campaign --grid",
        "What is flown": "--situation --seeds --tolerance --when --operability",
        "How": "--jobs --same-platform --untrusted",
        "What is printed": "--format --tables --warnings --quiet --help",
    },
)
def margin_command(
    *,
    mutants: MarginMutants,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    grid: options.FlownGrid,
    situations: options.Situations,
    seeds: MarginSeeds,
    tolerance: Tolerance,
    when: Annotated[
        bool,
        Option(
            "Fly nothing; show of the flights of --campaign at which times and events of the flight the fault is "
            "killed."
        ),
    ],
    operability: options.Operability,
    jobs: options.Jobs,
    same_platform: options.SamePlatform,
    untrusted: options.Untrusted,
    warnings: options.Warnings,
    quiet: options.Quiet,
) -> Answer:
    """Find the smallest magnitude of each fault that is killed, situation by situation.

    The whole ladder is flown first.  Between the strongest magnitude that survives and the mildest of which most
    flights violate a requirement lies an interval.  The interval is halved again and again, in all situations at once.
    A magnitude is killed where its flights detect the mutant; else it is only seen, and the table says how many --seeds
    would decide.  A cell's name means its first fault; an id with a magnitude picks a fault by the unit.  A time or an
    event after # picks a phase (NO-depth@3s#5s, NO-depth@3s#waypoint).  The flights are ordinary flights of the
    campaign: nothing is flown twice, and `scaloft-fi matrix --margins` shows what was found.

    Examples:
        Find how late a detection may come: `scaloft-fi margin LATE-human`
        Search two faults in light only, to a tenth of their unit:
            `scaloft-fi margin LESS-depth LATE-human --situation '*D0*' --tolerance 0.1`
        Show at which times of the flight a fault is killed: `scaloft-fi margin NO-depth --when`
    """
    one_thread_each()
    campaign = campaign_over(grid, campaign)
    if when:
        if situations or seeds != "1" or tolerance is not None:
            raise click.UsageError("--when flies nothing and goes with no --situation, --seeds or --tolerance")
        return when_answer(Study.open(study_folder, grid), campaign, mutants, operability=operability)

    study = study_of(study_folder, campaign, grid)
    options.allow(study, untrusted=untrusted)
    return margin(
        study,
        campaign,
        mutants,
        RunOptions(jobs=jobs or cores(), warnings=warnings, same_platform=same_platform, command=typed()),
        situations=situations,
        seeds=parse_seeds(seeds),
        tolerance=tolerance,
        operability=operability,
        progress=Silence if quiet else Progress,
    )
