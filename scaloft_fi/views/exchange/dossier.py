"""What a campaign's evidence is written from: the study's parts, its outcomes and what follows from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property

from scaloft_fi.analysis.coverage import Coverage, coverage
from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import MutantScore, Score, score
from scaloft_fi.analysis.survivor import Accepted, Disposition, accepted_survivors, score_without
from scaloft_fi.hazop.matrix import Cell, Matrix, worst_first
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Requirement
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import JudgedFlight, flights_of
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.exchange.steps import Step, steps
from scaloft_fi.views.flights.export import FlightRow, columns, export_rows
from scaloft_fi.views.score.accepted import acceptance
from scaloft_fi.views.score.finds import next_find
from scaloft_fi.views.score.verdict import next_command, verdict, why


@dataclass(frozen=True)
class Dossier:
    """A campaign and what it was flown with: all that an export format is made of.

    Attributes:
        study, campaign: names.
        version: of scaloft-fi.
        platform: on which the campaign was flown.
        matrix, space, roster, requirements: of the study.
        outcomes: of the campaign that count.
        spending: how the campaign spends alpha.
        sources: per file of the deviation matrix, by its path in the study, its text.
        grid_file: path of the grid's file in the study.
        finds: of the study.
        deterministic: whether flights of its stack repeat their bits.
        searchable: whether `seek` can search it.
        dispositions: the survivors that somebody accepted.
        today: the day by which dispositions expire; None = none does.
        archive: reads the files of the campaign's archive, by their paths.
    """

    study: str
    campaign: str
    version: str
    platform: Mapping[str, str]
    matrix: Matrix
    space: Space
    roster: Roster
    requirements: tuple[Requirement, ...]
    outcomes: tuple[Outcome, ...]
    spending: Spending
    sources: Mapping[str, str]
    grid_file: str = "sim/situations.yaml"
    finds: KnownFinds = NO_FINDS
    deterministic: bool = True
    searchable: bool = True
    dispositions: tuple[Disposition, ...] = ()
    today: date | None = None
    archive: Callable[[], Mapping[str, bytes]] = dict

    @cached_property
    def score(self) -> Score:
        """The campaign's score."""
        return score(self.outcomes, self.roster, self.space, self.spending)

    @cached_property
    def rows(self) -> list[FlightRow]:
        """One row per flight, in the order of mutants, situations and seeds: see `scaloft_fi.views.flights.export`."""
        return export_rows(self.outcomes, self.roster, self.space, self._names)

    @property
    def columns(self) -> list[str]:
        """The columns of the rows."""
        return columns(self.rows, self._names)

    @property
    def _names(self) -> list[str]:
        return [requirement.name for requirement in self.requirements]

    @cached_property
    def coverage(self) -> Coverage:
        """Its situation coverage."""
        return coverage(self.outcomes, self.space)

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of the mutants' flights."""
        return tuple(sorted({o.seed for o in self.outcomes if o.subject.guideword}))

    def of(self, *verdicts: Verdict) -> tuple[MutantScore, ...]:
        """The mutants that the ratios count, of each credible cell flown its default, with one of these verdicts.

        Those of the worst class of severity stand first.
        """
        members = (mutant for mutant in self.score.counted if mutant.verdict in verdicts)
        return tuple(worst_first(members, lambda mutant: mutant.severity))

    @cached_property
    def accepted(self) -> Mapping[str, Disposition]:
        """The survivors that somebody accepted, of the mutants that the ratios count, by id."""
        return dict(accepted_survivors(self.score, self.roster, self.dispositions, self.today))

    @property
    def without_accepted(self) -> Ratio:
        """Mutants detected, of those flown that are no accepted survivors."""
        return score_without(self.score, [Accepted(*one) for one in self.accepted.items()])

    def acceptance(self, mutant: MutantScore) -> str:
        """Who accepted a survivor, until when and why; empty where nobody did."""
        known = self.accepted.get(mutant.subject.id)
        return acceptance(known) if known else ""

    def verdict(self, mutant: MutantScore) -> str:
        """The verdict on a mutant and what it rests on, in a line."""
        return verdict(mutant, self.score.lacking)

    def why(self, mutant: MutantScore) -> str:
        """What the verdict rests on."""
        return why(mutant, self.score.lacking)

    def next_command(self, mutant: MutantScore) -> str:
        """What to call next for a mutant that is not detected."""
        return next_command(mutant, self.score.lacking, self.campaign, self.space.grid, self.finds)

    def steps(self, mutant: MutantScore) -> list[Step]:
        """What to call about a mutant that is not detected."""
        flights = self._judged.get(mutant.subject.id, ())
        searchable = self.searchable and next_find(mutant, self.finds) is None
        return steps(
            mutant, flights, self.next_command(mutant), self.cell(mutant), self.campaign, searchable=searchable
        )

    @cached_property
    def _judged(self) -> Mapping[str, Sequence[JudgedFlight]]:
        """The flights of each mutant beside their baselines, by its id."""
        judged: dict[str, list[JudgedFlight]] = {}
        for flight in flights_of(self.outcomes):
            judged.setdefault(flight.outcome.mutant, []).append(flight)
        return judged

    def find_told(self, mutant: MutantScore) -> str:
        """`; next: ` and the command, where a search found a situation that shows a mutant; else empty."""
        return f"; next: {self.next_command(mutant)}" if next_find(mutant, self.finds) else ""

    def shows(self, control: MutantScore) -> bool:
        """Whether a control shows itself by safety or operability.

        It does when it is detected, or when it was flown once and that flight violates what its baseline holds.
        """
        if control.detected or control.operability.detected:
            return True
        flights = self._judged.get(control.subject.id, ())
        return len(flights) == 1 and bool(flights[0].revealed or flights[0].operability_revealed)

    def cell(self, mutant: MutantScore) -> Cell:
        """The cell that a mutant comes from."""
        return self.matrix.cell(cell_of(mutant.subject.id))

    def place(self, mutant: MutantScore) -> tuple[str, int]:
        """File in the study and line of the cell that a mutant comes from."""
        path, _, line = self.cell(mutant).place.rpartition(":")
        path = path.replace("\\", "/")
        return next((name for name in self.sources if path.endswith(name)), path), int(line)

    def words(self, situation: str) -> str:
        """A situation in words: `corner, light`."""
        return ", ".join(self.space.words_of(situation)) if situation in self.space.point else situation
