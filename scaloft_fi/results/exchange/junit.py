"""The campaign as JUnit XML for CI: a test is a mutant, and passes when the mutant is killed.

A survivor fails, what could not be judged is skipped with the reason, what the harness failed at is an error.  Controls
have a suite of their own.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from scaloft_fi.results.exchange.dossier import Dossier, lives, verdict
from scaloft_fi.results.scoring.score import MutantScore
from scaloft_fi.results.status import Status

_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What no XML 1.0 document may hold."""


def junit(dossier: Dossier) -> str:
    """The XML document."""
    root = ET.Element("testsuites", name=_text(f"scaloft-fi {dossier.campaign}"))
    suites: dict[str, list[MutantScore]] = {}
    for mutant in dossier.score.mutants:
        suites.setdefault(mutant.subject.parameter, []).append(mutant)
    for name, mutants in suites.items():
        root.append(_suite(name, mutants))
    if dossier.score.controls:
        root.append(_suite("controls", dossier.score.controls, controls=True))
    for count in ("tests", "failures", "errors", "skipped"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in root)))
    ET.indent(root)
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{ET.tostring(root, encoding='unicode')}\n"


def _suite(name: str, mutants: Sequence[MutantScore], *, controls: bool = False) -> ET.Element:
    suite = ET.Element("testsuite", name=_text(name))
    for mutant in mutants:
        case = ET.SubElement(suite, "testcase", classname=_text(f"scaloft-fi.{name}"), name=_text(mutant.subject.id))
        # a control may show itself by operability too
        kind = "" if controls and mutant.operability.part else _kind(mutant)
        if kind:
            ET.SubElement(case, kind, message=_text(verdict(mutant)))
    suite.set("tests", str(len(mutants)))
    for count, kind in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        suite.set(count, str(len(suite.findall(f"testcase/{kind}"))))
    return suite


def _kind(mutant: MutantScore) -> str:
    """What stands under the test case; empty for a pass."""
    if mutant.killed:
        return ""
    if lives(mutant):
        return "failure"
    return "error" if mutant.status is Status.INVALID else "skipped"


def _text(text: str) -> str:
    """`text` with what XML cannot carry replaced."""
    return _ILLEGAL.sub("\ufffd", text)
