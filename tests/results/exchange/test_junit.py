from __future__ import annotations

from builders import outcome
from dossiers import dossier, dossiers
from hypothesis import given
from junitparser import Error, Failure, JUnitXml, Skipped

from scaloft_fi.results.exchange.dossier import Dossier
from scaloft_fi.results.exchange.junit import junit
from scaloft_fi.results.scoring.score import MutantScore
from scaloft_fi.results.status import Status


def read(text: str) -> dict[str, dict[str, list[type]]]:
    """Per suite and test case the kinds of its results, as a reader of JUnit files sees them."""
    return {
        suite.name: {case.name: [type(result) for result in case.result] for case in suite}
        for suite in JUnitXml.fromstring(text.encode())
    }


def kinds(mutant: MutantScore) -> list[type]:
    if mutant.kill_rate.whole:
        return [] if mutant.kill_rate.part else [Failure]
    return [Error] if mutant.status is Status.INVALID else [Skipped]


@given(dossiers())
def test_a_survivor_fails_a_killed_mutant_passes_the_rest_is_skipped_or_an_error(dossier: Dossier) -> None:
    suites = read(junit(dossier))
    for mutant in dossier.score.mutants:
        assert suites[mutant.subject.parameter][mutant.subject.id] == kinds(mutant)
    assert set(suites.get("controls", {})) == {control.subject.id for control in dossier.score.controls}


@given(dossiers())
def test_the_counts_are_those_of_the_cases(dossier: Dossier) -> None:
    whole = JUnitXml.fromstring(junit(dossier).encode())
    said = (whole.tests, whole.failures, whole.errors, whole.skipped)
    whole.update_statistics()
    assert said == (whole.tests, whole.failures, whole.errors, whole.skipped)


def test_a_control_that_breaks_operability_alone_passes() -> None:
    flights = [outcome(), outcome("REVERSE-human", violated={"OP1": 9.0})]
    assert read(junit(dossier(flights))) == {"controls": {"REVERSE-human": []}}
    assert read(junit(dossier([outcome(), outcome("REVERSE-human", digest="x")])))["controls"] == {
        "REVERSE-human": [Failure]
    }


def test_what_xml_cannot_carry_is_replaced() -> None:
    assert read(junit(dossier([outcome(), outcome("LATE-human@\x003s", digest="x")])))["human"] == {
        "LATE-human@\ufffd3s": [Failure]
    }
