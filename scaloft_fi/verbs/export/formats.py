"""The campaign in the formats of other tools: JUnit, SARIF, mutation-testing-report-schema, Markdown, GSN, SACE.

**CI and code hosts.**  One that is not detected fails; one that is undecided, not tested or an accepted survivor is
skipped; what the harness failed at is an error.
Each of these has the reason and the command to call next in its message, and in its text all steps, first the command
that flies the most telling flight again.  Controls have a suite of their own, in which those pass that show themselves
by safety or operability, and say by what.

What is undecided is a note, what is not detected or not tested is a warning.  The message ends with the commands that
fly the most telling flight again and that come next; the help of the rule, which viewers show beside it, and the
properties of the result have all steps.  An accepted survivor is suppressed, with who accepted it, why and until when.

A mutant stands in the file and on the line of its cell of the deviation matrix; the situations are its tests, and
cover it where they put it to the test.  Its readers know two scores.  Their mutation score, killed / (killed + survived
+ no coverage), is ours: detected mutants of those flown.  Their score of covered code, killed / (killed + survived), is
detected mutants of those put to the test.  For that, of the default mutants of credible cells

- `Killed` is detected,
- `Survived` is put to the test and not detected, which undecided ones are too,
- `NoCoverage` is not put to the test,
- `Pending` is every one where there is no baseline pool to decide by: readers then show no score,

and accepted survivors and what no ratio counts (controls, other magnitudes) are `Ignored`: readers show the score
without accepted survivors.  The reason says more than the status.

**The argument over the campaign** is told in goal structuring notation (gsn2x) and as the verification log of SACE.
Every mutant flown that is not detected stands in it as a counter-goal against the claim it weakens: an argument that
hides what speaks against it convinces nobody.  A survivor that somebody accepted is justified by that, until the last
day of the acceptance; the goal over the others stays undeveloped.

SACE (Safety Assurance of Autonomous Systems in Complex Environments, Assuring Autonomy International Programme, York)
asks for the test cases with their required results, and for a justification that their coverage suffices, considering
safety requirements, operational domain, operating scenarios and edge cases; besides, for the test environment and why
it is representative.  What only people can argue is left open, and says so.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree as ET

import yaml

from scaloft_fi.analysis.detection import Verdict, findings, tallies
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.analysis.survivor import judge
from scaloft_fi.hazop.matrix import class_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID
from scaloft_fi.judge.requirement import Kind, rho_text
from scaloft_fi.output import in_campaign, line
from scaloft_fi.registry import grouped
from scaloft_fi.verbs.export.dossier import Dossier, Step, export_format
from scaloft_fi.verbs.first_screen import NOT_COMPARED, false_detections, seeds_flown, shows_itself_by
from scaloft_fi.verbs.options import ENTRIES
from scaloft_fi.verbs.verdict import MOST_NAMED, NO_POOL, sentence
from scaloft_fi.views.table import Format, Table, code, counted, markdown, ranges, render, said

CONTROLS = "controls"


@export_format("junit", "a test per mutant, one that is not detected fails", ends=(".xml", ".txt"))
def junit(dossier: Dossier) -> str:
    """The XML document."""
    root = ET.Element("testsuites", name=line(f"scaloft-fi {dossier.campaign}"))
    controls = {CONTROLS: list(dossier.score.controls)} if dossier.score.controls else {}
    suites = grouped(dossier.score.faults, lambda mutant: mutant.subject.parameter)
    if dossier.invalid:
        suite = ET.SubElement(root, "testsuite", name="gates", tests="1", failures="0", errors="1", skipped="0")
        case = ET.SubElement(suite, "testcase", classname="scaloft-fi.gates", name="score")
        ET.SubElement(case, "error", message=line("; ".join(dossier.invalid)))
    for name, mutants in (*suites.items(), *controls.items()):
        suite = ET.SubElement(root, "testsuite", name=line(name))
        kinds = [_kind(dossier, mutant, control=name in controls) for mutant in mutants]
        for mutant, kind in zip(mutants, kinds, strict=True):
            case = ET.SubElement(suite, "testcase", classname=line(f"scaloft-fi.{name}"), name=line(mutant.subject.id))
            if kind:
                follows = dossier.acceptance(mutant) or f"next: {dossier.next_command(mutant)}"
                told = ET.SubElement(case, kind, message=line(f"{dossier.verdict(mutant)}; {follows}"))
                told.text = "\n".join(line(f"{step.does}: {step.command}") for step in dossier.steps(mutant))
            elif name in controls:
                ET.SubElement(case, "system-out").text = line(f"shows itself by {shows_itself_by(mutant)}")
        suite.set("tests", str(len(mutants)))
        for count, kind in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            suite.set(count, str(kinds.count(kind)))
    for count in ("tests", "failures", "errors", "skipped"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in root)))
    ET.indent(root)
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{ET.tostring(root, encoding='unicode')}\n"


def _kind(dossier: Dossier, mutant: MutantScore, *, control: bool) -> str:
    """What stands under the test case; empty for a pass.

    A control that does not show itself fails where it was tested and nothing is open.
    """
    verdicts = {mutant.verdict, mutant.operability.verdict} if control else {mutant.verdict}
    if mutant.shown_by if control else mutant.detected:
        return ""
    if not mutant.flown:
        return "error"
    failed = Verdict.NOT_DETECTED in verdicts and Verdict.UNDECIDED not in verdicts
    return "failure" if failed and not dossier.acceptance(mutant) else "skipped"


SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


@export_format(
    "sarif", "what is not detected on the lines of the HAZOP matrix, SARIF 2.1.0", ends=(".sarif", ".json", ".txt")
)
def sarif(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values: a rule is a cell whose mutant is not detected, a result is that mutant."""
    mutants = dossier.of(Verdict.UNDECIDED, Verdict.NOT_DETECTED, Verdict.NOT_TESTED)
    by_cell = grouped(mutants, lambda mutant: dossier.cell(mutant).name)
    cells, rules = list(by_cell), [_rule(dossier, name, members) for name, members in by_cell.items()]
    driver = {"name": "scaloft-fi", "version": dossier.version, "rules": rules}
    told = [{"level": "error", "message": {"text": sentence}} for sentence in dossier.invalid]
    run = {
        "tool": {"driver": driver},
        **({"invocations": [{"executionSuccessful": False, "toolExecutionNotifications": told}]} if told else {}),
        "columnKind": "unicodeCodePoints",
        "results": [_result(dossier, mutant, cells.index(dossier.cell(mutant).name)) for mutant in mutants],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _rule(dossier: Dossier, name: str, mutants: Sequence[MutantScore]) -> dict[str, Any]:
    """The rule of a cell, whose help says what to call about its mutants."""
    first = Step("cell", "The deviation with its causes", f"scaloft-fi matrix --cell {name}")
    told = [first, *(step for mutant in mutants for step in dossier.steps(mutant))]
    cell = dossier.matrix.cell(name)
    return {
        "id": name,
        "shortDescription": {"text": cell.deviation or name},
        "fullDescription": {"text": cell.effect or name},
        "help": {
            "text": "\n".join(f"{step.does}: {step.command}" for step in told),
            "markdown": "\n".join(f"- {step.does}: {code(step.command)}" for step in told),
        },
    }


def _result(dossier: Dossier, mutant: MutantScore, rule: int) -> dict[str, Any]:
    """Its list of suppressions is empty where nobody accepted the mutant (SARIF 2.1.0, 3.27.23)."""
    (name, line), steps, accepted = dossier.place(mutant), dossier.steps(mutant), dossier.acceptance(mutant)
    commands = "".join(f"  {step.does}: {step.command}." for step in steps if step.name in ("replay", "next"))
    uri = quote(f"{dossier.within}{name}", errors="surrogateescape")
    place = {"artifactLocation": {"uri": uri}, "region": {"startLine": line}}
    suppression = {"kind": "external", "status": "accepted", "justification": accepted}
    return {
        "ruleId": dossier.cell(mutant).name,
        "ruleIndex": rule,
        "level": "note" if mutant.verdict is Verdict.UNDECIDED else "warning",
        "message": {"text": f"{mutant.subject.id} is {dossier.verdict(mutant)}.{commands}"},
        "locations": [{"physicalLocation": place}],
        "suppressions": [suppression] if accepted else [],
        "partialFingerprints": {"mutant/v1": mutant.subject.id},
        "properties": {step.name: step.command for step in steps},
    }


THRESHOLDS = {"high": 80, "low": 60}
"""Where readers turn the colour of a score: the defaults of StrykerJS."""


@export_format("mutation-testing", "mutation-testing-report-schema 2", ends=(".json", ".txt"))
def mutation_testing(dossier: Dossier) -> dict[str, Any]:
    """The report as plain JSON values."""
    files: dict[str, dict[str, Any]] = {
        name: {"language": "yaml", "source": text, "mutants": []} for name, text in sorted(dossier.sources.items())
    }
    for mutant in (*dossier.score.mutants, *dossier.score.controls):
        name, line = dossier.place(mutant)
        files[name]["mutants"].append(_mutant(dossier, mutant, line))
    situations = sorted({outcome.situation for outcome in dossier.outcomes}, key=dossier.space.rank)
    tests = [{"id": key, "name": f"{key}: {dossier.words(key)}"} for key in situations]
    return {
        "schemaVersion": "2",
        "thresholds": THRESHOLDS,
        "framework": {"name": "scaloft-fi", "version": dossier.version},
        "files": {name: file for name, file in files.items() if file["mutants"]},
        "testFiles": {dossier.grid_file: {"tests": tests}},
    }


def _mutant(dossier: Dossier, mutant: MutantScore, line: int) -> dict[str, Any]:
    cell = dossier.cell(mutant)
    return {
        "id": mutant.subject.id,
        "mutatorName": cell.guideword,
        "description": cell.deviation,
        "replacement": mutant.subject.id,
        "location": {"start": {"line": line, "column": 1}, "end": {"line": line, "column": 1 + len(cell.guideword)}},
        "status": _status(dossier, mutant),
        "statusReason": _reason(dossier, mutant),
        "coveredBy": [result.situation for result in mutant.results if result.tested],
        "killedBy": list(mutant.killing),
        "testsCompleted": len(mutant.results),
    }


def _status(dossier: Dossier, mutant: MutantScore) -> str:
    if not dossier.roster.counts(mutant.subject):
        return "Ignored"
    if dossier.invalid or not dossier.score.pooled:
        return "Pending"
    if mutant.detected:
        return "Killed"
    if dossier.acceptance(mutant):
        return "Ignored"
    return "Survived" if mutant.tested else "NoCoverage"


def _reason(dossier: Dossier, mutant: MutantScore) -> str:
    reason = "; ".join((*dossier.invalid, dossier.verdict(mutant) + dossier.find_told(mutant)))
    if dossier.roster.is_control(mutant.subject):
        by = shows_itself_by(mutant)
        return f"a control, in no ratio{f', shows itself by {by}' if by else ''}: {reason}"
    if accepted := dossier.acceptance(mutant):
        return f"{accepted}; {reason}"
    return reason if dossier.roster.counts(mutant.subject) else f"in no ratio, only its cell's default is: {reason}"


@export_format("markdown", "a page for the summary of a CI job", ends=(".md", ".txt"))
def summary(dossier: Dossier) -> str:
    """The page."""
    mutants = [_of(dossier, verdict) for verdict in Verdict if dossier.of(verdict)]
    rows = tuple((id_, known.owner, known.reason, known.expires.isoformat()) for id_, known in dossier.accepted.items())
    accepted = [Table(f"{len(rows)} accepted survivors", ("mutant", "owner", "reason", "expires"), rows)]
    tables = (_ratios(dossier), *mutants, *(accepted if rows else ()), _findings(dossier))
    return render([said(one, of_tests=dossier.space.of_tests) for one in tables], Format.MARKDOWN)


def _ratios(dossier: Dossier) -> Table:
    scored = dossier.score
    title, headers = f"scaloft-fi: campaign {dossier.campaign}", ("ratio", "part/whole", "of")
    flown = ("situations", dossier.coverage.situations.short, "distinct situations flown, of the grid")
    credible = "credible cells of the HAZOP matrix whose mutant was flown, of all"
    exercised = ("exercised", scored.exercised.short, credible)
    others = ("without accepted", str(dossier.without_accepted), "the same, of those that are no accepted survivors")
    if not scored.pooled:
        return Table(title, headers, (exercised, flown), (*map(sentence, dossier.invalid), f"No score: {NO_POOL}."))
    rows = (
        ("mutation score", str(scored.mutation_score), "default mutants that safety requirements detect, of all flown"),
        ("firm", str(scored.firm), "default mutants detected whichever one seed is left out, of those flown"),
        *([others] if dossier.accepted else []),
        ("tested", str(scored.tested), "default mutants put to the test, of those flown"),
        ("operability", str(scored.operability), "default mutants that operability requirements detect"),
        exercised,
        flown,
    )
    detected = (
        "Detected: it violates safety requirements more often than chance explains, beside the unmutated drone's own "
        f"flights.  {false_detections(scored.alpha, sum(mutant.tested for mutant in scored.faults))}"
    )
    killed = (
        "A situation tests a mutant that changes a sample there, if the unmutated drone holds a safety requirement "
        "steadily, in nine tenths of its flights there or more; a detected mutant is killed there if most of its "
        "flights violate that requirement."
    )
    return Table(title, headers, rows, (*map(sentence, dossier.invalid), detected, killed))


def _of(dossier: Dossier, verdict: Verdict) -> Table:
    """The mutants of a verdict, each with what it rests on."""
    members = dossier.of(verdict)
    classed = any(mutant.severity for mutant in members)
    rows = tuple(
        (m.subject.id, *[class_of(m.severity)] * classed, dossier.why(m) + dossier.find_told(m)) for m in members
    )
    return Table(f"{len(rows)} {verdict.words}", ("mutant", *["severity"] * classed, "why"), rows)


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


COUNTER = {
    Verdict.UNDECIDED: "might not have been revealed",
    Verdict.NOT_DETECTED: "would not have been revealed",
    Verdict.NOT_TESTED: "was not put to the test",
}
"""What speaks against the suite, by the verdict on a mutant."""


@export_format("gsn", "the argument in goal structuring notation, for gsn2x", ends=(*ENTRIES, ".txt"))
def gsn(dossier: Dossier) -> str:
    """The argument as YAML text."""
    return yaml.safe_dump(nodes(dossier), sort_keys=False, allow_unicode=True, width=120)


def nodes(dossier: Dossier) -> dict[str, Any]:
    """The argument's nodes by id, the module's head among them."""
    names, known = ", ".join(requirement.name for requirement in dossier.requirements), in_campaign(dossier.campaign)
    mutants = dossier.score.mutants
    default = f"{len(dossier.score.counted)} of them the defaults of their cells"
    faults = f"{counted(len(mutants), 'mutant')} from a HAZOP deviation matrix, {default}"
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
        "C3": {"text": f"{faults}, {seeds_flown(mutants)} each in a situation"},
        "A1": {"text": "The simulator represents the operating environment (argued elsewhere)"},
        "S1": {
            "text": "Argue over the extent of coverage and over its power to reveal faults",
            "supportedBy": ["G2", "G3", "G4"],
        },
        "G2": {"text": _coverage(dossier), "supportedBy": ["Sn1"]},
        "Sn1": {"text": f"Coverage table: scaloft-fi score{known}"},
        **_detection(dossier),
    }
    missed = dossier.of(*COUNTER)
    if missed or dossier.invalid or not (dossier.score.pooled and dossier.score.counted):
        argument |= _justified(dossier, missed)
    else:
        argument["G4"] = {"text": "Every default mutant flown is detected", "supportedBy": ["Sn3"]}
        argument["Sn3"] = {"text": f"Verdict on every mutant: scaloft-fi score{known}"}
    for number, mutant in enumerate(missed, start=1):
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
    """The claim over the default mutants, and what it rests on; nothing where none was flown or decided."""
    scored, known = dossier.score, in_campaign(dossier.campaign)
    if dossier.invalid or not (scored.pooled and scored.counted):
        flown = "no default mutant of a cell was flown" if scored.pooled else f"no verdict: {NO_POOL}"
        why = "; ".join(dossier.invalid) or flown
        return {"G3": {"text": f"The suite detects faults ({why})", "undeveloped": True}}
    flown = f"{scored.mutation_score} of the default mutants flown"
    claim = f"The suite detects {flown}, {scored.firm.part} without any one seed too"
    rule = "more violations of a safety requirement than chance explains, beside the unmutated drone's own flights"
    return {
        "G3": {"text": claim, "supportedBy": ["Sn2"], "inContextOf": ["C4", "C5"]},
        "C4": {"text": f"Detected: {rule} (exact stratified test, alpha {scored.alpha:g})"},
        "C5": {"text": false_detections(scored.alpha, scored.tested.part)},
        "Sn2": {"text": f"Verdicts and kills: scaloft-fi score{known}; every flight: scaloft-fi export{known}"},
    }


REPEATS = "Flights are deterministic: scaloft-fi replay{} flies each again, bit for bit, on the same platform."
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
    required = tuple((r.name, r.kind.value, r.title, r.trigger or "none", r.text) for r in dossier.requirements)
    headers = ("requirement", "kind", "in words", "trigger", "formula over the flight")
    definitions = tuple(dict.fromkeys(used for r in dossier.requirements for used in r.definitions))
    defined = Table("Definitions in the required results", ("definition", "formula over the flight"), definitions)
    combined = tuple((f"{strength}-way", str(ratio)) for strength, ratio in dossier.coverage.t_way)
    combinations = "Combinations of values of that many axes that some test case has, of all there are."
    parts = {"scaloft-fi": dossier.version, **dict(sorted(dossier.platform.items()))}
    if parts["scaloft-fi"] != dossier.version:
        parts["scaloft-fi of this log"] = dossier.version
    repeats = REPEATS.format(in_campaign(dossier.campaign)) if dossier.deterministic else NO_REPEATS
    coverage = "Sufficiency of coverage (2): operational domain model"
    return (
        _cases(dossier),
        Table("Required results", headers, required),
        *([defined] if definitions else []),
        _by_requirement(dossier),
        *_accepted(dossier),
        Table(coverage, ("strength", "covered"), combined, (combinations,)),
        _scenarios(dossier),
        _edges(dossier),
        Table("Test environment", ("part", "version"), tuple(parts.items()), (repeats,)),
        Table("Representativeness of the test environment", ("justification",), ((OPEN,),)),
        Table("Not claimed", ("claim",), tuple((claim,) for claim in NOT_CLAIMED)),
    )


@export_format("sace", "the verification log, SACE artefact [SS], Markdown", ends=(".md", ".txt"))
def to_markdown(dossier: Dossier) -> str:
    """The log as a page."""
    campaign, study = markdown(dossier.campaign), markdown(dossier.study)
    head = f"# Verification log (SACE artefact [SS])\n\nCampaign {campaign} of study {study}.\n\n"
    return head + render(verification_log(dossier), Format.MARKDOWN)


@export_format("sace-json", "the verification log as JSON", ends=(".json", ".txt"))
def to_json(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values, by heading."""
    return {table.title: {"rows": table.records(), "notes": list(table.notes)} for table in verification_log(dossier)}


def _cases(dossier: Dossier) -> Table:
    """The situations with the seeds of the flights that count."""
    flown: dict[str, dict[str, set[int]]] = {outcome.situation: {} for outcome in dossier.outcomes}
    for outcome in dossier.outcomes:
        if not outcome.invalid and outcome.mutant != PLACEBO_ID:
            flown[outcome.situation].setdefault(outcome.mutant, set()).add(outcome.seed)

    def row(key: str) -> tuple[str, str, int, str, str]:
        own = ranges(flown[key].pop(BASELINE, ()))
        return key, dossier.words(key), len(flown[key]), _seeds(dossier, flown[key]), own

    rows = tuple(map(row, sorted(flown, key=dossier.space.rank)))
    headers = ("test case", "situation", "mutants", "seeds of the mutants", "seeds of the unmutated drone")
    note = "Mutants include controls.  Where their seeds differ, those of most stand first, then who flew others."
    return Table("Test case details", headers, rows, (note,))


def _seeds(dossier: Dossier, flown: Mapping[str, Collection[int]]) -> str:
    """The seeds that most mutants flew in a situation, then who flew others: `0; LATE-human@3s: 0-4`."""
    by_seeds = grouped(sorted(flown, key=dossier.roster.rank), lambda mutant: ranges(flown[mutant]))
    most, *others = sorted(by_seeds, key=lambda seeds: (-len(by_seeds[seeds]), seeds)) or [""]
    named = {seeds: ids if len(ids) <= MOST_NAMED else [f"{len(ids)} mutants"] for seeds, ids in by_seeds.items()}
    return "; ".join([most, *(f"{', '.join(named[seeds])}: {seeds}" for seeds in others)])


def _by_requirement(dossier: Dossier) -> Table:
    """Consideration 1: are there test cases for each safety requirement, and would they show its violation."""
    tested = {tally.requirement: tally for tally in tallies(dossier.outcomes)}
    clean = [outcome for outcome in dossier.outcomes if outcome.mutant == BASELINE and not outcome.invalid]
    triggered = Counter(one.requirement for outcome in clean for one in outcome.readings if one.triggered)

    def row(name: str) -> tuple[str, int, str, str]:
        able = [mutant for mutant in dossier.score.counted if name in mutant.tests]
        detected = Ratio(sum(name in m.safety.by for m in able), len(able))
        tally = tested.get(name)
        return name, triggered[name], str(detected), rho_text(tally.least_rho) if tally else "n/a"

    rows = tuple(row(r.name) for r in dossier.requirements if r.kind is Kind.SAFETY)
    detected = "default mutants detected by it, of those that it put to the test"
    headers = ("requirement", "flights that trigger it", detected, "least robustness")
    fates = Counter(mutant.verdict for mutant in dossier.score.counted)
    verdicts = ", ".join(f"{fates[verdict]} {verdict.words}" for verdict in Verdict)
    firm = f"  Detected whichever one seed is left out: {dossier.score.firm.part}."
    told = f"Default mutants flown, by safety requirements: {verdicts}.{firm}"
    verdict = told if dossier.score.pooled else NO_VERDICTS
    notes = ("Triggered, robustness: flights of the unmutated drone.", verdict, *map(sentence, dossier.invalid))
    return Table("Sufficiency of coverage (1): safety requirements", headers, rows, notes)


def _accepted(dossier: Dossier) -> tuple[Table, ...]:
    """The survivors that somebody accepted, and acceptances that do not hold; no table where there are none."""
    rows = tuple(
        (one.mutant, one.state.value, known.owner, known.reason, known.expires.isoformat())
        for one in judge(dossier.score, dossier.roster, dossier.dispositions, dossier.today)
        if (known := one.disposition) is not None and dossier.score.pooled
    )
    notes = (f"Without accepted survivors the tests detect {dossier.without_accepted} of the default mutants flown.",)
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
    killed_of = "default mutants killed, of those tested"
    headers = ("situation", "the unmutated drone violates", "never tests", killed_of)
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
