"""The campaign in a page of Markdown, for the summary of a CI job or a merge request."""

from __future__ import annotations

from scaloft_fi.results.exchange.dossier import Dossier, verdict
from scaloft_fi.results.scoring.baseline import findings
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.telling.table import Format, Table, render


def summary(dossier: Dossier) -> str:
    """The page."""
    scored, covered = dossier.score, dossier.coverage
    ratios = (
        ("mutation score", str(scored.mutation_score), "mutants killed, of those infected in an eligible situation"),
        ("strict score", str(scored.strict_score), "mutants killed, of those flown"),
        (
            "decided score",
            str(scored.decided_score),
            "mutants decided as killed by repeated flights, of those decidable",
        ),
        ("exercised", str(scored.exercised), "credible cells of the HAZOP matrix flown, of all"),
        ("situations", covered.situations.plain, "distinct situations flown, of the grid"),
    )
    survivors = tuple(
        (mutant.subject.id, mutant.kill_rate.plain, verdict(mutant).split(";", maxsplit=1)[0])
        for mutant in dossier.survivors
    )
    killed = tuple(
        (mutant.subject.id, str(mutant.kill_rate), ", ".join(name for name, _ in mutant.requirements))
        for mutant in dossier.counted
        if mutant.killed
    )
    baselines = findings(dossier.outcomes, dossier.space)
    red = tuple(
        (finding.situation, Ratio(finding.red, finding.flown).plain, ", ".join(finding.violated))
        for finding in baselines
        if finding.red
    )
    interval = "In brackets Wilson's 95 % interval [%] over the row's population."
    tables = (
        Table(f"scaloft-fi: campaign {dossier.campaign}", ("ratio", "part/whole", "of"), ratios, (interval,)),
        Table(f"{len(survivors)} survivors", ("mutant", "killed/eligible", "why"), survivors),
        Table(f"{len(killed)} killed", ("mutant", "killed/eligible", "by"), killed),
        Table(f"{len(red)} situations with a red baseline", ("situation", "red flights", "violated"), red),
    )
    return render(tables, Format.MARKDOWN)
