"""The verification log of SACE: artefact [SS] of the stage "AS verification assurance", with its headings.

SACE (Safety Assurance of Autonomous Systems in Complex Environments, Assuring Autonomy International Programme, York)
asks for the test cases with their required results, and for a justification that their coverage suffices, considering
safety requirements, operational domain, operating scenarios and edge cases; besides, for the test environment and why
it is representative.  What only people can argue is left open, and says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from scaloft_fi.results.exchange.dossier import Dossier
from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.scoring.baseline import Tally, findings, tallies
from scaloft_fi.results.scoring.grouping import By, groups
from scaloft_fi.results.telling.table import Format, Table, render

EDGES = 10
"""How many situations with the least robustness are named as edge cases."""
OPEN = "To be argued by the safety team; nothing here argues it."
NOT_CLAIMED = (
    "That no other fault than those of the matrix is present.",
    "That the simulator is the real environment.",
    "That the HAZOP study is complete.",
)


def verification_log(dossier: Dossier) -> tuple[Table, ...]:
    """The log as tables, one a heading."""
    return (
        _cases(dossier),
        _required(dossier),
        _by_requirement(dossier),
        _domain(dossier),
        _scenarios(dossier),
        _edges(dossier),
        _environment(dossier),
        Table("Representativeness of the test environment", ("justification",), ((OPEN,),)),
        Table("Not claimed", ("claim",), tuple((claim,) for claim in NOT_CLAIMED)),
    )


def to_markdown(dossier: Dossier) -> str:
    """The log as a page."""
    head = f"# Verification log (SACE artefact [SS])\n\nCampaign {dossier.campaign} of study {dossier.study}.\n\n"
    return head + render(verification_log(dossier), Format.MARKDOWN)


def to_json(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values, by heading."""
    return {table.title: {"rows": table.records(), "notes": list(table.notes)} for table in verification_log(dossier)}


def _cases(dossier: Dossier) -> Table:
    flown = {outcome.situation for outcome in dossier.outcomes}
    rows = tuple(
        (key, dossier.words(key), ", ".join(str(seed) for seed in _seeds(dossier, key)))
        for key in sorted(flown, key=dossier.space.rank)
    )
    return Table("Test case details", ("test case", "situation", "seeds"), rows)


def _seeds(dossier: Dossier, situation: str) -> list[int]:
    return sorted({o.seed for o in dossier.outcomes if o.situation == situation and o.mutant == BASELINE})


def _required(dossier: Dossier) -> Table:
    rows = tuple((r.name, r.kind.value, r.title, r.text) for r in dossier.requirements)
    return Table("Required results", ("requirement", "kind", "in words", "formula over the flight"), rows)


def _by_requirement(dossier: Dossier) -> Table:
    """Consideration 1: are there test cases for each safety requirement, and would they show its violation."""
    tested: dict[str, Tally] = {tally.requirement: tally for tally in tallies(dossier.outcomes)}
    kills = {g.name: g for g in groups(dossier.score, By.REQUIREMENT, dossier.roster, dossier.space)}
    rows = tuple(
        (
            r.name,
            tested[r.name].triggered if r.name in tested else 0,
            kills[r.name].killed.plain if r.name in kills else "n/a",
            f"{tested[r.name].least_rho:.3f}" if r.name in tested else "n/a",
        )
        for r in dossier.requirements
        if r.kind is not Kind.REPORTED
    )
    headers = ("requirement", "times triggered", "mutants killed by it, of those it was a test of", "least robustness")
    return Table(
        "Sufficiency of coverage (1): safety requirements", headers, rows, ("Flights of the unmutated drone.",)
    )


def _domain(dossier: Dossier) -> Table:
    """Consideration 2: enough range of each feature of the domain, and enough combinations of features."""
    rows = tuple((f"{strength}-way", ratio.plain) for strength, ratio in dossier.coverage.t_way)
    note = "Combinations of values of that many axes that some test case has, of all there are."
    return Table("Sufficiency of coverage (2): operational domain model", ("strength", "covered"), rows, (note,))


def _scenarios(dossier: Dossier) -> Table:
    """Consideration 3: each operating scenario, what the unmutated drone does there, what a fault does."""
    killing = {g.name: g for g in groups(dossier.score, By.SITUATION, dossier.roster, dossier.space)}
    rows = tuple(
        (
            f.situation,
            ", ".join(f.violated) or "holds all",
            ", ".join(f.vacuous),
            killing[f.situation].killed.plain if f.situation in killing else "n/a",
        )
        for f in findings(dossier.outcomes, dossier.space)
    )
    headers = ("situation", "the unmutated drone violates", "never tests", "mutants killed, of those eligible there")
    return Table("Sufficiency of coverage (3): operating scenarios", headers, rows)


def _edges(dossier: Dossier) -> Table:
    """Consideration 4: low probability, high impact."""
    worst = sorted(_robustness(dossier), key=lambda row: (row[0], dossier.space.rank(row[2].situation), row[2].seed))
    rows = tuple((o.situation, o.seed, name, f"{rho:.3f}") for rho, name, o in worst[:EDGES])
    headers = ("situation", "seed", "requirement", "robustness")
    note = f"The {EDGES} least robust flights of the unmutated drone that hold the safety requirement."
    return Table("Sufficiency of coverage (4): edge cases", headers, rows, (note,))


def _robustness(dossier: Dossier) -> Iterator[tuple[float, str, Outcome]]:
    for outcome in dossier.outcomes:
        if outcome.mutant == BASELINE and not outcome.invalid:
            for reading in outcome.readings:
                if reading.kind is Kind.SAFETY and not reading.violated and reading.triggered:
                    yield reading.rho, reading.requirement, outcome


def _environment(dossier: Dossier) -> Table:
    rows = (("scaloft-fi", dossier.version), *sorted(dossier.platform.items()))
    note = "Flights are deterministic: scaloft-fi replay flies each again, bit for bit, on the same platform."
    return Table("Test environment", ("part", "version"), tuple(rows), (note,))
