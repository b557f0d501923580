"""The argument over the campaign: goal structuring notation (gsn2x), and the verification log of SACE.

Every mutant flown that is not detected stands in it as a counter-goal against the claim it weakens: an argument that
hides what speaks against it convinces nobody.  A survivor that somebody accepted is justified by that, until the last
day of the acceptance; the goal over the others stays undeveloped.

SACE (Safety Assurance of Autonomous Systems in Complex Environments, Assuring Autonomy International Programme, York)
asks for the test cases with their required results, and for a justification that their coverage suffices, considering
safety requirements, operational domain, operating scenarios and edge cases; besides, for the test environment and why
it is representative.  What only people can argue is left open, and says so.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import Any

import yaml

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.pool import findings, tallies
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.analysis.survivor import judge
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.requirement import Kind, rho_text
from scaloft_fi.verbs.export.dossier import Dossier, export_format
from scaloft_fi.verbs.first_screen import NOT_COMPARED, false_detections
from scaloft_fi.verbs.verdict import NO_POOL
from scaloft_fi.views.table import Format, Table, markdown, ranges, render

COUNTER = {
    Verdict.UNDECIDED: "might not have been revealed",
    Verdict.NOT_DETECTED: "would not have been revealed",
    Verdict.NOT_TESTED: "was not put to the test",
}
"""What speaks against the suite, by the verdict on a mutant."""


@export_format("gsn", "the argument in goal structuring notation, for gsn2x")
def gsn(dossier: Dossier) -> str:
    """The argument as YAML text."""
    return yaml.safe_dump(nodes(dossier), sort_keys=False, allow_unicode=True, width=120)


def nodes(dossier: Dossier) -> dict[str, Any]:
    """The argument's nodes by id, the module's head among them."""
    names = ", ".join(requirement.name for requirement in dossier.requirements)
    seeds = ", ".join(map(str, dossier.seeds)) or "none"
    size = f"{len(dossier.space.axes)} axes, {len(dossier.space.points)} situations"
    argument: dict[str, Any] = {
        "module": {"name": "situation_coverage_and_fault_detection", "brief": f"Campaign {dossier.campaign}"},
        "G1": {
            "text": "The test cases sufficiently cover the operating scenarios (SACE artefact [E], activity 29)",
            "supportedBy": ["S1"],
            "inContextOf": ["C1", "C2", "C3", "A1"],
        },
        "C1": {"text": f"Operational domain model: {size}"},
        "C2": {"text": f"Requirements in signal temporal logic: {names}"},
        "C3": {"text": f"{len(dossier.score.mutants)} mutants from a HAZOP deviation matrix, seeds {seeds}"},
        "A1": {"text": "The simulator represents the operating environment (argued elsewhere)"},
        "S1": {
            "text": "Argue over the extent of coverage and over its power to reveal faults",
            "supportedBy": ["G2", "G3", "G4"],
        },
        "G2": {"text": _coverage(dossier), "supportedBy": ["Sn1"]},
        "Sn1": {"text": "Coverage table: scaloft-fi score"},
        **_detection(dossier),
    }
    counted = dossier.of(*COUNTER)
    if counted or not dossier.score.pooled:
        argument |= _justified(dossier, counted)
    else:
        argument["G4"] = {"text": "Every mutant flown is detected", "supportedBy": ["Sn3"]}
        argument["Sn3"] = {"text": "Verdict on every mutant: scaloft-fi score"}
    for number, mutant in enumerate(counted, start=1):
        severity = f" (severity: {mutant.severity.id}, {mutant.severity.title})" if mutant.severity else ""
        argument[f"CG{number}"] = {
            "text": f"{mutant.subject.id} {COUNTER[mutant.verdict]}{severity}",
            "challenges": "G3",
            "supportedBy": [f"CSn{number}"],
        }
        argument[f"CSn{number}"] = {"text": f"{mutant.subject.id} is {dossier.verdict(mutant)}"}
    return argument


def _justified(dossier: Dossier, counted: Sequence[MutantScore]) -> dict[str, Any]:
    """The goal over the mutants that are not detected: a goal for each that was accepted, one for all others."""
    text, accepted = "Each mutant that is not detected is justified", [m for m in counted if dossier.acceptance(m)]
    if not accepted:
        return {"G4": {"text": text, "undeveloped": True}}
    found: dict[str, Any] = {}
    for number, mutant in enumerate(accepted):
        goal, solution = f"G{5 + number}", f"Sn{4 + number}"
        found[goal] = {"text": f"That {mutant.subject.id} is not detected is justified", "supportedBy": [solution]}
        found[solution] = {"text": f"hazop/dispositions.yaml: {dossier.acceptance(mutant)}"}
    if others := len(counted) - len(accepted):
        found[f"G{5 + len(accepted)}"] = {"text": f"{others} other mutants are justified", "undeveloped": True}
    return {"G4": {"text": text, "supportedBy": [name for name in found if name.startswith("G")]}, **found}


def _coverage(dossier: Dossier) -> str:
    """Of the grid, with the largest strength of which every combination was flown; where there is none, with each."""
    covered = dossier.coverage
    whole = [strength for strength, ratio in covered.t_way if ratio.part == ratio.whole > 0]
    flown = f"{covered.situations} of the situations were flown"
    if whole:
        every = f"combination of the values of any {max(whole)} axes" if max(whole) > 1 else "value of every axis"
        return f"{flown}, among them every {every}"
    parts = ", ".join(f"{strength}-way {ratio}" for strength, ratio in covered.t_way)
    return f"{flown}, of the combinations of their values {parts}"


def _detection(dossier: Dossier) -> dict[str, Any]:
    """The claim over the mutants, and what it rests on; nothing where there is no pool to decide by."""
    scored = dossier.score
    if not scored.pooled:
        return {"G3": {"text": f"The suite detects faults (no verdict: {NO_POOL})", "undeveloped": True}}
    claim = (
        f"The suite detects {scored.mutation_score} of the mutants flown, {scored.firm.part} without any one seed too"
    )
    rule = "more violations of a safety requirement than chance explains, beside the unmutated drone's own flights"
    return {
        "G3": {"text": claim, "supportedBy": ["Sn2"], "inContextOf": ["C4", "C5"]},
        "C4": {"text": f"Detected: {rule} (exact stratified test, alpha {scored.alpha:g})"},
        "C5": {"text": false_detections(scored.alpha, scored.tested.part)},
        "Sn2": {"text": "Verdicts and kills: scaloft-fi score; every flight: scaloft-fi export"},
    }


REPEATS = "Flights are deterministic: scaloft-fi replay flies each again, bit for bit, on the same platform."
NO_REPEATS = "The stack is not deterministic: no flight can be flown again bit for bit; verdicts rest on several seeds."
EDGES = 10
"""How many situations with the least robustness are named as edge cases."""
NO_VERDICTS = f"No verdicts: {NO_POOL}."
OPEN = "To be argued by the safety team; nothing here argues it."
NOT_CLAIMED = (
    "That no other fault than those of the matrix is present.",
    "That the simulator is the real environment.",
    "That the HAZOP study is complete.",
    NOT_COMPARED,
)


def verification_log(dossier: Dossier) -> tuple[Table, ...]:
    """The log as tables, one a heading."""
    required = tuple((r.name, r.kind.value, r.title, r.text) for r in dossier.requirements)
    combined = tuple((f"{strength}-way", str(ratio)) for strength, ratio in dossier.coverage.t_way)
    combinations = "Combinations of values of that many axes that some test case has, of all there are."
    parts = (("scaloft-fi", dossier.version), *sorted(dossier.platform.items()))
    repeats = REPEATS if dossier.deterministic else NO_REPEATS
    coverage = "Sufficiency of coverage (2): operational domain model"
    return (
        _cases(dossier),
        Table("Required results", ("requirement", "kind", "in words", "formula over the flight"), required),
        _by_requirement(dossier),
        *_accepted(dossier),
        Table(coverage, ("strength", "covered"), combined, (combinations,)),
        _scenarios(dossier),
        _edges(dossier),
        Table("Test environment", ("part", "version"), parts, (repeats,)),
        Table("Representativeness of the test environment", ("justification",), ((OPEN,),)),
        Table("Not claimed", ("claim",), tuple((claim,) for claim in NOT_CLAIMED)),
    )


@export_format("sace", "the verification log, SACE artefact [SS], Markdown")
def to_markdown(dossier: Dossier) -> str:
    """The log as a page."""
    campaign, study = markdown(dossier.campaign), markdown(dossier.study)
    head = f"# Verification log (SACE artefact [SS])\n\nCampaign {campaign} of study {study}.\n\n"
    return head + render(verification_log(dossier), Format.MARKDOWN)


@export_format("sace-json", "the verification log as JSON")
def to_json(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values, by heading."""
    return {table.title: {"rows": table.records(), "notes": list(table.notes)} for table in verification_log(dossier)}


def _cases(dossier: Dossier) -> Table:
    seeds = defaultdict[tuple[str, bool], set[int]](set)
    for outcome in dossier.outcomes:
        seeds[outcome.situation, outcome.mutant == BASELINE].add(outcome.seed)
    rows = tuple(
        (key, dossier.words(key), ranges(seeds[key, False]), ranges(seeds[key, True]))
        for key in sorted({key for key, _ in seeds}, key=dossier.space.rank)
    )
    headers = ("test case", "situation", "seeds of the mutants", "seeds of the unmutated drone")
    return Table("Test case details", headers, rows)


def _by_requirement(dossier: Dossier) -> Table:
    """Consideration 1: are there test cases for each safety requirement, and would they show its violation."""
    tested = {tally.requirement: tally for tally in tallies(dossier.outcomes)}

    def row(name: str) -> tuple[str, int, str, str]:
        able = [mutant for mutant in dossier.score.counted if name in mutant.tests]
        detected = Ratio(sum(name in (*m.safety.by, *m.operability.by) for m in able), len(able))
        tally = tested.get(name)
        return name, tally.triggered if tally else 0, str(detected), rho_text(tally.least_rho) if tally else "n/a"

    rows = tuple(row(r.name) for r in dossier.requirements if r.kind is not Kind.REPORTED)
    detected = "mutants detected by it, of those that it put to the test"
    headers = ("requirement", "times triggered", detected, "least robustness")
    fates = Counter(mutant.verdict for mutant in dossier.score.counted)
    verdicts = ", ".join(f"{fates[verdict]} {verdict.words}" for verdict in Verdict)
    firm = f"  Detected whichever one seed is left out: {dossier.score.firm.part}."
    told = f"Mutants flown, by safety requirements: {verdicts}.{firm}"
    notes = "Triggered, robustness: flights of the unmutated drone.", told if dossier.score.pooled else NO_VERDICTS
    return Table("Sufficiency of coverage (1): safety requirements", headers, rows, notes)


def _accepted(dossier: Dossier) -> tuple[Table, ...]:
    """The survivors that somebody accepted, and acceptances that do not hold; no table where there are none."""
    rows = tuple(
        (one.mutant, one.state.value, known.owner, known.reason, known.expires.isoformat())
        for one in judge(dossier.score, dossier.roster, dossier.dispositions, dossier.today)
        if (known := one.disposition) is not None and dossier.score.pooled
    )
    notes = (f"Without accepted survivors the tests detect {dossier.without_accepted} of the mutants flown.",)
    headers = ("mutant", "state", "owner", "reason", "expires")
    return (Table("Accepted survivors", headers, rows, notes),) if rows else ()


def _scenarios(dossier: Dossier) -> Table:
    """Consideration 3: each operating scenario, what the unmutated drone does there, what a fault does."""
    pairs, counted = dossier.score.pool.pairs.values(), dossier.score.counted

    def row(key: str, vacuous: Sequence[str]) -> tuple[str, ...]:
        own = [one for one in pairs if one.situation == key and one.violated]
        often = [f"{one.requirement} in {one.violated} of {one.flights}" for one in own]
        tests = [one for mutant in counted for one in mutant.results if one.situation == key and one.tested]
        killed = Ratio(sum(bool(one.kills) for one in tests), len(tests))
        return key, ", ".join(often) or "nothing", ", ".join(vacuous), str(killed)

    rows = tuple(row(one.situation, one.vacuous) for one in findings(dossier.outcomes, dossier.space))
    headers = ("situation", "the unmutated drone violates", "never tests", "mutants killed, of those put to the test")
    return Table("Sufficiency of coverage (3): operating scenarios", headers, rows)


def _edges(dossier: Dossier) -> Table:
    """Consideration 4: low probability, high impact."""
    robust = [
        (reading.rho, reading.requirement, outcome)
        for outcome in dossier.outcomes
        if outcome.mutant == BASELINE and not outcome.invalid
        for reading in outcome.readings
        if reading.kind is Kind.SAFETY and not reading.violated and reading.triggered
    ]
    worst = sorted(robust, key=lambda row: (row[0], dossier.space.rank(row[2].situation), row[2].seed))
    rows = tuple((o.situation, o.seed, name, f"{rho:.3f}") for rho, name, o in worst[:EDGES])
    headers = ("situation", "seed", "requirement", "robustness")
    note = f"The {EDGES} least robust flights of the unmutated drone that hold the safety requirement."
    return Table("Sufficiency of coverage (4): edge cases", headers, rows, (note,))
