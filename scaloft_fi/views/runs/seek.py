"""What a search found, and what it did not."""

from __future__ import annotations

from scaloft_fi.campaign.seeking.finds import ReplicationReport
from scaloft_fi.campaign.seeking.seek import SeekReport, Sought
from scaloft_fi.sim.found import FILE
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
            f"{evidence.mission}/{evidence.baselines}",
            len(find.shows) - 1,
            find.name,
        )
        for find in report.finds
        for mutant, evidence in find.shows.items()
    )
    headers = ("mutant", "violates", "flights", "p", "baseline", "margin", "mission", "others", "find")
    notes = (
        *(f"{find.name}: {find.situation}: {words(find)}." for find in report.finds),
        "Confirmed on seeds that the search never flew.  others: more sought mutants that the situation shows.",
        spending(report),
        "baseline: flights that hold the requirement by more than their spread; margin: what nine in ten reach.",
        "mission: baselines that hold every operability requirement and meet the value of every axis.",
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
                "situations: flown with one seed, where the unmutated drone holds a safety requirement with room"
                + ("." if report.anyhow else " and does its mission."),
                f"{report.used} flights in all, {report.flown} of them flown now; {ended}.",
            ),
        ),
    )


def replica_table(report: ReplicationReport) -> Table:
    """The pairs of find and mutant that were flown again, and which of them hold."""
    rows = tuple(
        (
            one.mutant,
            one.requirement,
            f"{one.again.violated}/{one.again.flights}",
            f"{one.again.p:.2g}",
            f"{one.again.held}/{one.again.baselines}",
            f"{one.again.mission}/{one.again.baselines}",
            "yes" if one.holds else "no",
            one.find,
        )
        for one in report.replicas
    )
    held = sum(one.holds for one in report.replicas)
    notes = (
        *(f"{one.find}: {one.mutant} left sim/{FILE}: {one.why}." for one in report.replicas if not one.holds),
        f"Flown on the seeds {report.first}, {report.first + 1}, ..., which nothing before used.",
        f"p: by the exact test, adjusted by Holm over all pairs here; a pair holds at alpha={report.alpha:g} or less.",
        "baseline: flights that hold the requirement by more than their spread; mission: flights that do the mission.",
        f"{report.used} flights in all, {report.flown} of them flown now.",
    )
    headers = ("mutant", "violates", "flights", "p", "baseline", "mission", "holds", "find")
    return Table(f"Replicated: {held} of {len(rows)} pairs of find and mutant hold", headers, rows, notes)


def spending(report: SeekReport) -> str:
    """How many candidates a search tested, and what they spent of alpha."""
    tested = [one for one in report.sought if one.candidates]
    if not tested:
        return f"Tested on fresh seeds: no candidate; nothing of alpha={report.alpha:g} is spent."
    candidates = sum(one.candidates for one in tested)
    shares = sum(one.spent for one in tested)
    most = max(one.spent for one in tested)
    return (
        f"Tested on fresh seeds: {candidates} candidate{'s' * (candidates > 1)} of {len(tested)} "
        f"mutant{'s' * (len(tested) > 1)}, at alpha / 2, / 4, ... for the first, second, ... of a mutant: at most "
        f"{most:.2g} of alpha={report.alpha:g} for one mutant, {shares:.2g} summed over all."
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
