"""The HAZOP worksheet filled back: every cell of the matrix beside what its flights say, with room for the team.

The columns are those of the classic sheet (`method.md`, section 1.3), the tool's findings, and columns that only people
can fill.  It never invents a risk matrix: severity is what the study says, and likelihood stays empty.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import Cell, CellStatus, Matrix, Parameter, SeverityClass
from scaloft_fi.hazop.render import ladder
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.space import Space
from scaloft_fi.mutants.catalogue import default_of
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.score.accepted import acceptance
from scaloft_fi.views.score.finds import effect, flies, next_find, words
from scaloft_fi.views.score.verdict import NO_POOL, would_decide
from scaloft_fi.views.worksheet.margin_record import cell_margin_values
from scaloft_fi.views.worksheet.margin_text import UNKNOWN
from scaloft_fi.views.worksheet.margins import cell_margins

SheetValue = str | int | float | None


@dataclass(frozen=True)
class Column:
    """A column of the sheet.

    Attributes:
        key: as in JSON and CSV.
        title: as people read it.
        about: what stands in it.
        short: whether it is among those that fit a page.
        width: of a spreadsheet [characters].
    """

    key: str
    title: str
    about: str
    short: bool = False
    width: int = 14


STUDY = (
    Column("cell", "Deviation id", "guideword and parameter", short=True, width=20),
    Column("node", "Study node", "the stages between which the parameter flows", width=24),
    Column("parameter", "Parameter", "what the guideword is asked of", width=18),
    Column("design_intent", "Design intent", "what every deviation deviates from", width=36),
    Column("guideword", "Guideword", "of IEC 61882, or a declared extension", width=14),
    Column("deviation", "Deviation", "what differs from the design intent", short=True, width=36),
    Column("status", "Status", "credible, control, or not meaningful", width=14),
    Column("rationale", "Rationale", "why it is not meaningful, or what the study predicts", width=36),
    Column("causes", "Possible causes", "what could bring it about", width=40),
    Column("effect", "Consequence", "what it does locally, then to the flight", width=40),
    Column(
        "severity",
        "Severity",
        "class by the study's own list; else for the team",
        short=True,
        width=10,
    ),
    Column("requirements", "Requirements", "those at risk", short=True, width=14),
    Column("operators", "Faults", "how it is made, with the ladder of magnitudes", width=36),
    Column("mutant", "Default mutant", "the one that the findings speak of", width=24),
)
FINDINGS = (
    Column("situations_flown", "Situations flown", "with a flight that counts", width=11),
    Column("reached", "Reached", "situations where the fault's seam carried a sample", width=11),
    Column("infected", "Infected", "situations where it changed a sample", width=11),
    Column("verdict", "Verdict", "by safety requirements", short=True, width=14),
    Column("firm", "Firm", "whether it stays detected when any one seed is left out", short=True, width=14),
    Column("operability", "Operability", "verdict by operability requirements", short=True, width=14),
    Column("p", "p", "chance of as many violations if the mutant did nothing (Holm), per requirement", width=18),
    Column("needed", "Would decide", "what would decide an undecided mutant, if what was seen goes on", width=22),
    Column("kill_rate", "Kills", "situations with a kill, of those that test the mutant", short=True, width=10),
    Column("killed_by", "Killed by", "requirements, with situations killed in / tested in", width=18),
    Column("margin", "Margin", "smallest magnitude that is killed in any situation", short=True, width=14),
    Column(
        "where",
        "Where",
        "shortest condition for the situations with a kill; without one, for those where a violation was seen",
        short=True,
        width=30,
    ),
    Column("killing", "Situations with a kill", "their keys", width=30),
    Column("stopped_at", "Stopped at", "stage reached in situations without a kill, with situations", width=26),
    Column("disposition", "Disposition", "of a survivor that somebody accepted", short=True, width=30),
    Column("find", "Find", "a situation that a search found, which shows the survivor", short=True, width=30),
    Column("flies_find", "Flies it", "the command that flies the find", short=True, width=40),
)
FOUND = ("find", "flies_find")
"""The columns of a survivor's find."""
SPARE = ("severity", *FOUND)
"""The columns that a page leaves out where no row has a value."""
TEAM = (
    Column("safeguards", "Existing safeguards", "for the team", width=24),
    Column("likelihood", "Likelihood", "for the team, by its own matrix", width=10),
    Column("recommendation", "Recommendation", "for the team", short=True, width=30),
    Column("responsible", "Responsible", "for the team", short=True, width=16),
    Column("due", "Due date", "for the team", width=12),
    Column("action_status", "Action status", "for the team", width=14),
)
COLUMNS = (*STUDY, *FINDINGS, *TEAM)


@dataclass(frozen=True)
class SheetRow:
    """One cell of the matrix as the sheet has it.

    Attributes:
        cell: of the matrix.
        values: by the column's key; the team's columns are empty.
        score: of its default mutant; None where it was not flown.
        margins: of its faults, as plain JSON values.
        disposition: of its default mutant; None where nobody accepted it.
        severity: class of the cell; None where it has none.
    """

    cell: Cell
    values: Mapping[str, SheetValue]
    score: MutantScore | None = None
    margins: Sequence[Mapping[str, Any]] = ()
    disposition: Disposition | None = None
    severity: SeverityClass | None = None

    @property
    def survives(self) -> bool:
        """Whether the default mutant of a credible cell was flown and is not detected."""
        return self.cell.status is CellStatus.CREDIBLE and self.score is not None and not self.score.detected


def worksheet(
    matrix: Matrix,
    outcomes: Iterable[Outcome],
    scored: Score,
    space: Space,
    dispositions: Sequence[Disposition] = (),
    finds: KnownFinds = NO_FINDS,
    campaign: str = CAMPAIGN,
) -> tuple[SheetRow, ...]:
    """The sheet, in the order of the matrix: credible cells, controls, and those that are not meaningful.

    Args:
        matrix: of the study.
        outcomes: of a campaign.
        scored: the same, scored.
        space: the grid.
        dispositions: of the study.
        finds: of the study.
        campaign: name of the campaign, for commands.
    """
    flown = {mutant.subject.id: mutant for mutant in (*scored.mutants, *scored.controls)}
    outcomes = tuple(outcomes)
    margins = cell_margins(outcomes, scored, matrix)
    bounds = cell_margin_values(outcomes, scored, matrix)
    accepted = {disposition.mutant: disposition for disposition in dispositions}
    parameters = {parameter.id: parameter for parameter in matrix.parameters}
    rows = []
    for cell in matrix:
        values: dict[str, SheetValue] = dict.fromkeys(column.key for column in COLUMNS)
        severity = matrix.severities.get(cell.name)
        values |= _of_study(cell, parameters[cell.parameter]) | {"severity": severity.id if severity else None}
        score = known = None
        if cell.status is not CellStatus.NOT_MEANINGFUL:
            mutant = default_of(cell).id
            score, known = flown.get(mutant), accepted.get(mutant)
            values |= {"mutant": mutant}
            if cell.status is CellStatus.CREDIBLE and margins[cell.name] != UNKNOWN:
                values |= {"margin": margins[cell.name]}
            values |= {"disposition": acceptance(known)} if known else {}
            if score:
                values |= _of_flights(score, space, scored.lacking) | _of_find(score, finds, campaign, space.grid)
        rows.append(SheetRow(cell, values, score, bounds[cell.name], known, severity))
    return tuple(rows)


def _of_study(cell: Cell, parameter: Parameter) -> dict[str, SheetValue]:
    return {
        "cell": cell.name,
        "node": parameter.node,
        "parameter": parameter.title,
        "design_intent": parameter.intent,
        "guideword": cell.guideword,
        "deviation": cell.deviation,
        "status": cell.status.replace("_", " "),
        "rationale": cell.reason or cell.predicted,
        "causes": "; ".join(cell.causes),
        "effect": cell.effect,
        "requirements": ", ".join(cell.requirements),
        "operators": "; ".join(f"{fault.operator} at {fault.seam} {ladder(fault)}".strip() for fault in cell.faults),
    }


def _of_flights(score: MutantScore, space: Space, lacking: Collection[str]) -> dict[str, SheetValue]:
    return {
        "situations_flown": len(score.results),
        "reached": sum(result.reached for result in score.results),
        "infected": sum(result.infected for result in score.results),
        "verdict": score.verdict.words,
        "firm": score.firmness.words if score.firmness else "",
        "operability": score.operability.verdict.words,
        "p": ", ".join(f"{name} {p:.2g}" for name, p in p_of(score).items()) or None,
        "needed": would_decide(score, lacking) or None,
        "kill_rate": f"{score.kill_rate.part} of {score.kill_rate.whole}" if score.tested else None,
        "killed_by": ", ".join(f"{name} {ratio.short}" for name, ratio in score.requirements),
        "where": score.condition(space),
        "killing": " ".join(score.killing),
        "stopped_at": _stopped(score),
    }


def _of_find(score: MutantScore, finds: KnownFinds, campaign: str, grid: str) -> dict[str, SheetValue]:
    find, mutant = next_find(score, finds), score.subject.id
    if find is None:
        return {}
    return {
        "find": f"{find.name}: {words(find)} ({effect(find.shows[mutant])})",
        "flies_find": flies(find, mutant, finds, campaign, grid),
    }


def p_of(score: MutantScore) -> Mapping[str, float]:
    """Nothing of a mutant that was not put to the test: there is nothing to explain."""
    return score.safety.p if score.tested else {}


def _stopped(score: MutantScore) -> str:
    """The stages that flights reached in situations without a kill, with situations, furthest first."""
    counts = Counter(result.status for result in score.results if not result.kills)
    return ", ".join(
        f"{status.value} {counts[status]}" for status in sorted(counts, key=lambda s: s.stage, reverse=True)
    )


def population(rows: Sequence[SheetRow]) -> str:
    """What the findings speak of, in a few sentences."""
    flown = [row.score for row in rows if row.score is not None]
    most = max((len(score.results) for score in flown), default=0)
    meaningful = sum(row.cell.status is not CellStatus.NOT_MEANINGFUL for row in rows)
    pooled = any(score.tested for score in flown) or not any(score.verdict is Verdict.UNDECIDED for score in flown)
    return (
        f"Findings speak of each cell's default mutant: {len(flown)} of the {meaningful} cells that can happen were "
        f"flown, in up to {most} situations.  A situation tests a mutant that changes a sample there, if the unmutated "
        "drone holds a safety requirement there steadily; it is a kill if most flights of a detected mutant violate "
        "that one."
    ) + ("" if pooled else f"  No verdict: {NO_POOL}.")
