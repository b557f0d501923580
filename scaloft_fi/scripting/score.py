"""The score of a campaign, for scripts and notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import By
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.scripting.arguments import in_python
from scaloft_fi.views.columns import Columns, ColumnType
from scaloft_fi.views.tables.html import html
from scaloft_fi.views.tables.table import Format

if TYPE_CHECKING:
    from scaloft_fi.analysis.score import MutantScore
    from scaloft_fi.views.scored_campaign import ScoredCampaign

TEXT, WHOLE, NUMBER, TEXTS = ColumnType.TEXT, ColumnType.WHOLE, ColumnType.NUMBER, ColumnType.TEXTS
MUTANT_COLUMNS = {
    **dict.fromkeys(("mutant", "guideword", "parameter", "magnitude", "verdict", "firm", "status"), TEXT),
    **dict.fromkeys(("killed_in", "tested_in", "flown_in"), WHOLE),
    "killed_by": TEXTS,
    **dict.fromkeys(("first_s", "seeds", "seeds_needed"), NUMBER),
}
PAIR_COLUMNS = {
    **dict.fromkeys(("situation", "requirement", "kind", "state"), TEXT),
    **dict.fromkeys(("violated", "flights"), WHOLE),
}


class CampaignScore:
    """The score of a campaign; each ratio has `part`, `whole` and `value` (None for 0 of 0).

    Args:
        scored: the campaign with its score.
    """

    def __init__(self, scored: ScoredCampaign) -> None:
        self._scored = scored

    @property
    def mutation_score(self) -> Ratio:
        """Mutants that the safety requirements detect, of the credible cells' default mutants flown."""
        return self._scored.score.mutation_score

    @property
    def firm(self) -> Ratio:
        """Mutants detected whichever one seed is left out, of the same."""
        return self._scored.score.firm

    @property
    def exercised(self) -> Ratio:
        """Credible cells whose default mutant was flown, of all credible cells."""
        return self._scored.score.exercised

    @property
    def infected(self) -> Ratio:
        """Mutants that changed a sample, of those flown."""
        return self._scored.score.infected

    @property
    def tested(self) -> Ratio:
        """Mutants that were put to the test, of those flown."""
        return self._scored.score.tested

    @property
    def operability(self) -> Ratio:
        """Mutants that the operability requirements detect, of those flown."""
        return self._scored.score.operability

    @property
    def alpha(self) -> float:
        """Accepted chance 0..1 that a fault without effect is called detected."""
        return self._scored.score.alpha

    @property
    def expected_false(self) -> float:
        """Number of mutants without effect that are called detected, expected at most."""
        return self._scored.score.expected_false

    @cached_property
    def mutants(self) -> Columns:
        """One row for each mutant, ladders too, in the order of the catalogue.

        `firm` says of a detected one whether it hangs on a seed; it is empty for the others.
        `killed_in`, `tested_in` and `flown_in` count situations, `killed_by` has the requirements, `first_s` is the
        earliest violation [s from the start], `seeds` is what the verdict rests on, `seeds_needed` what would decide.
        """
        return Columns("Mutants", MUTANT_COLUMNS, map(_mutant, self._scored.score.mutants))

    @cached_property
    def controls(self) -> Columns:
        """The same of the controls, which are in no ratio."""
        return Columns("Controls", MUTANT_COLUMNS, map(_mutant, self._scored.score.controls))

    @cached_property
    def pairs(self) -> Columns:
        """One row for each situation with a requirement: of how many baseline flights how many violate, and its state.

        The state is `steady`, `red`, `unsteady`, `open`, `vacuous` or `unknown`.
        """
        pairs = self._scored.score.pool.pairs.values()
        rows = (
            {
                "situation": pair.situation,
                "requirement": pair.requirement,
                "kind": pair.kind.value,
                "state": pair.state.value,
                "violated": pair.violated,
                "flights": pair.flights,
            }
            for pair in pairs
        )
        return Columns("Pairs", PAIR_COLUMNS, rows)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know beside the score, in sentences; often nothing."""
        return self._scored.warnings

    def record(self, by: str | None = None) -> dict[str, Any]:
        """The score as plain JSON values: what `scaloft-fi score --format json` prints.

        Args:
            by: `guideword`, `parameter`, `severity`, `situation`, `requirement` or `axis`, to have the score part by
                part too.

        Raises:
            InputError: there is no such grouping.
        """
        return self._scored.record(_by(by))

    def text(self, *, by: str | None = None, everything: bool = False) -> str:
        """What `scaloft-fi score` prints.

        Args:
            by: as for `record`.
            everything: whether every mutant and every table is shown, not only the first screen.

        Raises:
            InputError: there is no such grouping.
        """
        with in_python():
            return self._scored.text(Format.TABLE, by=_by(by), everything=everything)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<score of campaign {self._scored.campaign!r}: {self.mutation_score} detected>"

    def _repr_html_(self) -> str:
        return html((*self._scored.screen(whole=False), *self._scored.run))


def _mutant(mutant: MutantScore) -> Mapping[str, Any]:
    rate, safety = mutant.kill_rate, mutant.safety
    return {
        "mutant": mutant.subject.id,
        "guideword": mutant.subject.guideword,
        "parameter": mutant.subject.parameter,
        "magnitude": mutant.subject.magnitude,
        "verdict": mutant.verdict.value,
        "firm": mutant.firmness.value if mutant.firmness else "",
        "status": mutant.status.value,
        "killed_in": rate.part,
        "tested_in": rate.whole,
        "flown_in": mutant.kill_rate_flown.whole,
        "killed_by": [name for name, _ in mutant.requirements],
        "first_s": mutant.first.t_s if mutant.first else None,
        "seeds": safety.seeds,
        "seeds_needed": safety.needed,
    }


def _by(name: str | None) -> By | None:
    if name is None:
        return None
    if name not in {by.value for by in By}:
        raise InputError(f"by={name!r} must be a grouping of the score{did_you_mean(name, [by.value for by in By])}")
    return By(name)
