"""What a search found, and what it did not."""

from __future__ import annotations

from scaloft_fi.campaign.runs.seeking.seek import SeekReport, Sought
from scaloft_fi.views.score.finds import words
from scaloft_fi.views.tables.table import Table


def seek_tables(report: SeekReport, own: str) -> tuple[Table, Table]:
    """The finds, and the mutants without one; `own` is the name of the study's own grid."""
    rows = tuple(
        (
            mutant,
            evidence.requirement + f", strikes {evidence.struck}" * bool(evidence.struck),
            f"{evidence.violated}/{evidence.flights}",
            f"{evidence.p:.2g}",
            f"{evidence.held}/{evidence.baselines}",
            f"{evidence.margin:.2g}",
            len(find.shows) - 1,
            find.name,
        )
        for find in report.finds
        for mutant, evidence in find.shows.items()
    )
    headers = ("mutant", "violates", "flights", "p", "baseline", "margin", "others", "find")
    notes = (
        *(f"{find.name}: {find.situation}: {words(find)}." for find in report.finds),
        "Confirmed on seeds that the search never flew.  others: more sought mutants that the situation shows.",
        "p: at most alpha / 2, / 4, ... for the first, second, ... candidate of a mutant.",
        "baseline: flights that hold the requirement by more than their spread; margin: what nine in ten reach.",
        f"`scaloft-fi run --grid {own}+found` flies the situations.",
    )
    left = [one for one in report.sought if not one.shown_in]
    lacking = tuple((one.mutant, one.effort.situations, why_not(one)) for one in left)
    ended = "the budget ended the search" if report.spent else "the search came to its end"
    shown = len(report.sought) - len(left)
    return (
        Table(f"Found: {shown} of {len(report.sought)} mutants, {len(report.finds)} situations", headers, rows, notes),
        Table(
            f"Not found: {len(left)}",
            ("mutant", "situations", "why"),
            lacking,
            (
                "situations: flown with one seed, where the unmutated drone holds a safety requirement with room.",
                f"{report.used} flights in all, {report.flown} of them flown now; {ended}.",
            ),
        ),
    )


def why_not(sought: Sought) -> str:
    """Why nothing was found for a mutant: the stage at which the fault stopped, and how near it came."""
    effort = sought.effort
    if sought.candidates:
        return f"{sought.candidates} candidate{'s' * (sought.candidates > 1)} that fresh seeds did not confirm"
    if not effort.situations:
        return "not flown"
    if not effort.reached:
        return "its seam carried no sample"
    if not effort.infected:
        return "it changed no sample"
    if not effort.diverged:
        return f"it changed samples in {effort.infected}, and the drone flew the same to the bit"
    if not effort.requirement:
        return f"no safety requirement is held with room in the {effort.infected} where it changed samples"
    if effort.showed:
        return f"it violated {effort.requirement} in {effort.showed}, not with every seed of the search"
    return f"it kept {effort.nearest:.0%} of the robustness of {effort.requirement} in {effort.situation}"
