"""The campaign in a page of Markdown, for the summary of a CI job or a merge request."""

from __future__ import annotations

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.hazop.matrix import class_of
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format
from scaloft_fi.views.score.answers import false_detections
from scaloft_fi.views.score.verdict import NO_POOL
from scaloft_fi.views.tables.table import Format, Table, render


@export_format("markdown", "a page for the summary of a CI job")
def summary(dossier: Dossier) -> str:
    """The page."""
    mutants = [_of(dossier, verdict) for verdict in Verdict if dossier.of(verdict)]
    return render((_ratios(dossier), *mutants, *_accepted(dossier), _findings(dossier)), Format.MARKDOWN)


def _ratios(dossier: Dossier) -> Table:
    scored = dossier.score
    title, headers = f"scaloft-fi: campaign {dossier.campaign}", ("ratio", "part/whole", "of")
    flown = ("situations", dossier.coverage.situations.short, "distinct situations flown, of the grid")
    exercised = (
        "exercised",
        scored.exercised.short,
        "credible cells of the HAZOP matrix whose mutant was flown, of all",
    )
    if not scored.pooled:
        return Table(title, headers, (exercised, flown), (f"No score: {NO_POOL}.",))
    rows = (
        ("mutation score", str(scored.mutation_score), "mutants detected by safety requirements, of those flown"),
        ("firm", str(scored.firm), "mutants detected whichever one seed is left out, of those flown"),
        *_without_accepted(dossier),
        ("tested", str(scored.tested), "mutants put to the test, of those flown"),
        ("operability", str(scored.operability), "mutants detected by operability requirements, of those flown"),
        exercised,
        flown,
    )
    detected = (
        "Detected: it violates safety requirements more often than chance explains, beside the unmutated drone's own "
        f"flights.  {false_detections(scored.alpha, scored.tested.part)}"
    )
    killed = (
        "A situation tests a mutant that changes a sample there, if the unmutated drone holds a safety requirement "
        "steadily, in nine tenths of its flights there or more; a detected mutant is killed there if most of its "
        "flights violate that requirement."
    )
    return Table(title, headers, rows, (detected, killed))


def _without_accepted(dossier: Dossier) -> list[tuple[str, str, str]]:
    if not dossier.accepted:
        return []
    return [("without accepted", str(dossier.without_accepted), "the same, of those that are no accepted survivors")]


def _accepted(dossier: Dossier) -> tuple[Table, ...]:
    """The survivors that somebody accepted; no table where there are none."""
    rows = tuple((id_, known.owner, known.reason, known.expires.isoformat()) for id_, known in dossier.accepted.items())
    return (Table(f"{len(rows)} accepted survivors", ("mutant", "owner", "reason", "expires"), rows),) if rows else ()


def _of(dossier: Dossier, verdict: Verdict) -> Table:
    """The mutants of a verdict, each with what it rests on."""
    members = dossier.of(verdict)
    classed = any(mutant.severity for mutant in members)
    rows = tuple(
        (
            mutant.subject.id,
            *([class_of(mutant.severity)] if classed else []),
            dossier.why(mutant) + dossier.find_told(mutant),
        )
        for mutant in members
    )
    headers = ("mutant", *(["severity"] if classed else []), "why")
    return Table(f"{len(rows)} {verdict.words}", headers, rows)


def _findings(dossier: Dossier) -> Table:
    """Where the unmutated drone itself violates a safety requirement."""
    rows = tuple(
        (pair.situation, pair.requirement, f"{pair.violated}/{pair.flights}", pair.state.value)
        for pair in sorted(dossier.score.pool.pairs.values(), key=lambda pair: dossier.space.rank(pair.situation))
        if pair.kind is Kind.SAFETY and pair.violated
    )
    count = len({row[0] for row in rows})
    headers = ("situation", "requirement", "flights that violate it", "state")
    return Table(f"{count} situations where the unmutated drone violates a safety requirement", headers, rows)
