from __future__ import annotations

import shlex

from builders import outcome, pool
from dossiers import dossier, dossiers
from effort import usually
from finding import flies, found, known
from hypothesis import given, settings
from junitparser import Error, Failure, JUnitXml, Skipped

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.console import line
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.ci import junit
from scaloft_fi.verbs.export.dossier import Dossier

HERE = "T0O0W0D0H0"
CONTROL = "REVERSE-human"


def read(text: str) -> dict[str, dict[str, list[type]]]:
    """Per suite and test case the kinds of its results, as a reader of JUnit files sees them."""
    return {
        suite.name: {case.name: [type(result) for result in case.result] for case in suite}
        for suite in JUnitXml.fromstring(text.encode())
    }


def kinds(mutant: MutantScore) -> list[type]:
    if not mutant.flown:
        return [Error]
    return {Verdict.DETECTED: [], Verdict.NOT_DETECTED: [Failure]}.get(mutant.verdict, [Skipped])


def controls(*flights: Outcome) -> dict[str, list[type]]:
    return read(junit(dossier([*pool(HERE), *flights])))["controls"]


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_a_detected_mutant_passes_one_that_is_not_fails_the_rest_is_skipped_or_an_error(dossier: Dossier) -> None:
    suites = read(junit(dossier))
    for mutant in dossier.score.mutants:
        assert suites[mutant.subject.parameter][mutant.subject.id] == kinds(mutant)
    assert set(suites.get("controls", {})) == {control.subject.id for control in dossier.score.controls}


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_the_counts_are_those_of_the_cases(dossier: Dossier) -> None:
    whole = JUnitXml.fromstring(junit(dossier).encode())
    said = (whole.tests, whole.failures, whole.errors, whole.skipped)
    whole.update_statistics()
    assert said == (whole.tests, whole.failures, whole.errors, whole.skipped)


@settings(deadline=None, max_examples=usually(25, release=50))
@given(dossiers())
def test_every_case_that_does_not_pass_carries_the_replay_and_the_next_step(dossier: Dossier) -> None:
    flown = {outcome.name for outcome in dossier.outcomes}
    scores = {mutant.subject.id: mutant for mutant in (*dossier.score.mutants, *dossier.score.controls)}
    for suite in JUnitXml.fromstring(junit(dossier).encode()):
        for case in suite:
            for result in case.result:
                first, *_ = (shlex.split(told.partition(": ")[2]) for told in result.text.splitlines())
                assert first[:2] == ["scaloft-fi", "replay"]
                assert first[2] in flown
                assert first[2].startswith(f"{case.name}/")
                assert line(f"; next: {dossier.next_command(scores[case.name])}") in result.message


def test_the_flight_to_fly_again_is_the_one_that_says_most() -> None:
    flights = [outcome("LATE-human@3s", HERE, seed, violated={"SR2": 7.0} if seed == 1 else {}) for seed in range(3)]
    ((case,),) = JUnitXml.fromstring(junit(dossier([*pool(HERE), *flights])).encode())
    (skipped,) = case.result
    assert f"scaloft-fi replay LATE-human@3s/{HERE}/1 " in skipped.text


def test_what_is_skipped_names_the_reason_and_the_next_command() -> None:
    text = junit(dossier([*pool(HERE), outcome("LATE-human@3s", HERE, violated={"SR2": 7.0})]))
    ((case,),) = JUnitXml.fromstring(text.encode())
    (skipped,) = case.result
    assert skipped.message.startswith("undecided: it violates SR2 in 1 of 1 situation that tests it")
    assert "; next: scaloft-fi run --campaign " in skipped.message


def test_a_find_is_told_beside_a_failure_and_instead_of_seeds() -> None:
    late, no = "LATE-human@3s", "NO-human@100%"
    flights = [*pool(HERE), *(outcome(late, HERE, seed) for seed in range(3)), outcome(no, HERE)]
    text = junit(dossier(flights, known(found(late), found(no))))
    results = {case.name: case.result[0] for suite in JUnitXml.fromstring(text.encode()) for case in suite}
    assert {id_: type(result) for id_, result in results.items()} == {late: Failure, no: Skipped}
    assert all(result.message.endswith(f"; next: {flies(id_)}") for id_, result in results.items())


def test_a_control_that_is_detected_by_operability_alone_passes() -> None:
    assert controls(*(outcome(CONTROL, HERE, seed, violated={"OP1": 9.0}) for seed in range(3))) == {CONTROL: []}


def test_a_control_that_was_flown_once_passes_when_that_flight_is_told_from_its_baseline() -> None:
    assert controls(outcome(CONTROL, HERE, violated={"SR2": 9.0})) == {CONTROL: []}
    assert controls(outcome(CONTROL, HERE, violated={"OP1": 9.0})) == {CONTROL: []}
    assert controls(outcome(CONTROL, HERE)) == {CONTROL: [Skipped]}


def test_a_control_that_shows_nothing_where_it_was_tested_fails() -> None:
    assert controls(*(outcome(CONTROL, HERE, seed) for seed in range(3))) == {CONTROL: [Failure]}


def test_what_xml_cannot_carry_is_spelled_out() -> None:
    flights = [*pool(HERE), *(outcome("LATE-human@\x003s", HERE, seed) for seed in range(3))]
    assert read(junit(dossier(flights)))["human"] == {"LATE-human@\\x003s": [Failure]}
