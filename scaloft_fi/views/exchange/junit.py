"""The campaign as JUnit XML for CI: a test is a mutant, and passes when the mutant is detected.

One that is not detected fails; one that is undecided, not tested or an accepted survivor is skipped; what the harness
failed at is an error.
Each of these has the reason and the command to call next in its message, and in its text all steps, first the command
that flies the most telling flight again.  Controls have a suite of their own, in which those pass that show themselves
by safety or operability.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree as ET

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.console import line
from scaloft_fi.views.exchange.dossier import Dossier
from scaloft_fi.views.exchange.format import export_format

CONTROLS = "controls"


@export_format("junit", "a test per mutant, one that is not detected fails")
def junit(dossier: Dossier) -> str:
    """The XML document."""
    root = ET.Element("testsuites", name=line(f"scaloft-fi {dossier.campaign}"))
    suites: dict[str, list[MutantScore]] = {}
    for mutant in dossier.score.mutants:
        suites.setdefault(mutant.subject.parameter, []).append(mutant)
    for name, mutants in suites.items():
        root.append(_suite(dossier, name, mutants, [_kind(dossier, mutant) for mutant in mutants]))
    controls = dossier.score.controls
    if controls:
        kinds = ["" if dossier.shows(control) else _control_kind(control) for control in controls]
        root.append(_suite(dossier, CONTROLS, controls, kinds))
    for count in ("tests", "failures", "errors", "skipped"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in root)))
    ET.indent(root)
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{ET.tostring(root, encoding='unicode')}\n"


def _suite(dossier: Dossier, name: str, mutants: Sequence[MutantScore], kinds: Sequence[str]) -> ET.Element:
    suite = ET.Element("testsuite", name=line(name))
    for mutant, kind in zip(mutants, kinds, strict=True):
        case = ET.SubElement(suite, "testcase", classname=line(f"scaloft-fi.{name}"), name=line(mutant.subject.id))
        if kind:
            follows = dossier.acceptance(mutant) or f"next: {dossier.next_command(mutant)}"
            message = line(f"{dossier.verdict(mutant)}; {follows}")
            told = ET.SubElement(case, kind, message=message)
            told.text = "\n".join(line(f"{step.does}: {step.command}") for step in dossier.steps(mutant))
    suite.set("tests", str(len(mutants)))
    for count, kind in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        suite.set(count, str(kinds.count(kind)))
    return suite


def _kind(dossier: Dossier, mutant: MutantScore) -> str:
    """What stands under the test case; empty for a pass."""
    if not mutant.flown:
        return "error"
    if dossier.acceptance(mutant):
        return "skipped"
    return {Verdict.DETECTED: "", Verdict.NOT_DETECTED: "failure"}.get(mutant.verdict, "skipped")


def _control_kind(control: MutantScore) -> str:
    """The same of a control that does not show itself: it fails where it was tested and nothing is open."""
    if not control.flown:
        return "error"
    verdicts = {control.verdict, control.operability.verdict}
    return "failure" if Verdict.NOT_DETECTED in verdicts and Verdict.UNDECIDED not in verdicts else "skipped"
