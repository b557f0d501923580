"""The campaign for CI and code hosts: JUnit, SARIF, mutation-testing-report-schema, and a summary in Markdown.

One that is not detected fails; one that is undecided, not tested or an accepted survivor is skipped; what the harness
failed at is an error.
Each of these has the reason and the command to call next in its message, and in its text all steps, first the command
that flies the most telling flight again.  Controls have a suite of their own, in which those pass that show themselves
by safety or operability.

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
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree as ET

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.console import line
from scaloft_fi.hazop.matrix import class_of
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.verbs.export.dossier import Dossier, Step, export_format
from scaloft_fi.verbs.first_screen import false_detections
from scaloft_fi.verbs.verdict import NO_POOL
from scaloft_fi.views.table import Format, Table, code, render, said

CONTROLS = "controls"


@export_format("junit", "a test per mutant, one that is not detected fails")
def junit(dossier: Dossier) -> str:
    """The XML document."""
    root = ET.Element("testsuites", name=line(f"scaloft-fi {dossier.campaign}"))
    controls = {CONTROLS: list(dossier.score.controls)} if dossier.score.controls else {}
    suites = defaultdict[str, list[MutantScore]](list)
    for mutant in dossier.score.mutants:
        suites[mutant.subject.parameter].append(mutant)
    for name, mutants in (*suites.items(), *controls.items()):
        suite = ET.SubElement(root, "testsuite", name=line(name))
        kinds = [_kind(dossier, mutant, control=name in controls) for mutant in mutants]
        for mutant, kind in zip(mutants, kinds, strict=True):
            case = ET.SubElement(suite, "testcase", classname=line(f"scaloft-fi.{name}"), name=line(mutant.subject.id))
            if kind:
                follows = dossier.acceptance(mutant) or f"next: {dossier.next_command(mutant)}"
                told = ET.SubElement(case, kind, message=line(f"{dossier.verdict(mutant)}; {follows}"))
                told.text = "\n".join(line(f"{step.does}: {step.command}") for step in dossier.steps(mutant))
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
    if dossier.shows(mutant) if control else mutant.detected:
        return ""
    if not mutant.flown:
        return "error"
    failed = Verdict.NOT_DETECTED in verdicts and Verdict.UNDECIDED not in verdicts
    return "failure" if failed and not dossier.acceptance(mutant) else "skipped"


SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


@export_format("sarif", "what is not detected on the lines of the HAZOP matrix, SARIF 2.1.0")
def sarif(dossier: Dossier) -> dict[str, Any]:
    """The log as plain JSON values: a rule is a cell whose mutant is not detected, a result is that mutant."""
    mutants = dossier.of(Verdict.UNDECIDED, Verdict.NOT_DETECTED, Verdict.NOT_TESTED)
    by_cell = defaultdict[str, list[MutantScore]](list)
    for mutant in mutants:
        by_cell[dossier.cell(mutant).name].append(mutant)
    cells, rules = list(by_cell), [_rule(dossier, name, members) for name, members in by_cell.items()]
    driver = {"name": "scaloft-fi", "version": dossier.version, "rules": rules}
    run = {
        "tool": {"driver": driver},
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
    place = {"artifactLocation": {"uri": quote(name, errors="surrogateescape")}, "region": {"startLine": line}}
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


SCHEMA_VERSION = "2"
THRESHOLDS = {"high": 80, "low": 60}
"""Where readers turn the colour of a score: the defaults of StrykerJS."""


@export_format("mutation-testing", "mutation-testing-report-schema 2")
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
        "schemaVersion": SCHEMA_VERSION,
        "thresholds": dict(THRESHOLDS),
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
    if not mutant.flown:
        return "RuntimeError"
    if not dossier.score.pooled:
        return "Pending"
    if mutant.detected:
        return "Killed"
    if dossier.acceptance(mutant):
        return "Ignored"
    return "Survived" if mutant.tested else "NoCoverage"


def _reason(dossier: Dossier, mutant: MutantScore) -> str:
    reason = dossier.verdict(mutant) + dossier.find_told(mutant)
    if dossier.roster.is_control(mutant.subject):
        return f"a control, in no ratio: {reason}"
    if accepted := dossier.acceptance(mutant):
        return f"{accepted}; {reason}"
    return reason if dossier.roster.counts(mutant.subject) else f"in no ratio, only its cell's default is: {reason}"


@export_format("markdown", "a page for the summary of a CI job")
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
        return Table(title, headers, (exercised, flown), (f"No score: {NO_POOL}.",))
    rows = (
        ("mutation score", str(scored.mutation_score), "mutants detected by safety requirements, of those flown"),
        ("firm", str(scored.firm), "mutants detected whichever one seed is left out, of those flown"),
        *([others] if dossier.accepted else []),
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
