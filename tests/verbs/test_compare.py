"""`scaloft-fi compare`: what only one of two campaigns shows, as text, data and a page, and the flights that differ."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given
from paper_flyer import Paper, made
from printed import Call, of_form, sentence, told_by
from studies import copied

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Facts
from scaloft_fi.study import Study
from scaloft_fi.verbs.campaigns import Difference, FlightDifferences, differences_of, differences_table


class Cured(Paper):
    """The flyer whose drone obeys the speed limit in spite of a late person."""

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        flown = super().__call__(study, flight)
        if flight.subject.guideword != "LATE":
            return flown
        kinds = {requirement.name: requirement.kind for requirement in study.requirements}
        harmless = made(flown.subject, flown.situation, flown.seed, kinds, {}, digest=flown.digest)
        return replace(flown, readings=harmless.readings, violations=())


@pytest.fixture
def two(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[str, str]:
    """A campaign in which LATE-human is detected, and one of a drone that it does not harm."""
    words = ("--mutant", "LATE-human", "--situation", "T?O?W0D0H1", "--seeds", "3", "--quiet", "--campaign")
    names = f"{tmp_path}/old", f"{tmp_path}/new"
    told_by(call("run", *words, names[0], campaign=False))
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", Cured)
    told_by(call("run", *words, names[1], campaign=False))
    return names


def test_a_lost_fault_is_told_as_text_and_data_and_fails_a_pipeline_that_asks(call: Call, two: tuple[str, str]):
    old, new = two
    text = told_by(call("compare", old, new, campaign=False))
    assert "LATE-human@3s" in text
    assert "1 lost, 0 gained, 0 unsure of 1 fault that both flew." in text
    told = of_form("compare", told_by(call("compare", old, new, "--format", "json", campaign=False)))
    assert (told["lost"], told["gained"], told["unsure"], told["flights"]) == ([M], [], [], None)
    assert told["agreement"] == {"same": {"part": 0, "whole": 1}, "kappa": 0.0}
    failed = call("compare", old, new, "--fail-on-lost", campaign=False)
    assert failed.exit_code == 3
    assert failed.stderr.endswith(f"lost: {M}\n")


def test_a_gained_fault_and_an_equal_campaign_fail_no_pipeline(call: Call, two: tuple[str, str]):
    old, new = two
    for names in ((new, old), (old, old)):
        assert call("compare", *names, "--fail-on-lost", campaign=False).exit_code == 0


def test_an_unsure_fault_fails_no_pipeline(call: Call, two: tuple[str, str], tmp_path: Path):
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet", "--campaign", f"{tmp_path}/one")
    told_by(call("run", *words, campaign=False))  # one flight, by the drone that the fault does not harm
    done = call("compare", two[0], f"{tmp_path}/one", "--fail-on-lost", "--format", "json", campaign=False)
    assert (done.exit_code, json.loads(done.stdout)["unsure"]) == (0, [M])


def test_the_page_has_both_matrices_with_a_sign_for_each_verdict_and_fetches_nothing(
    call: Call, two: tuple[str, str], tmp_path: Path
):
    told_by(call("compare", *two, "--output", f"{tmp_path}/both.html", campaign=False))
    page = (tmp_path / "both.html").read_text()
    assert page.count("<table>") == 2
    assert f'aria-label="{M}: detected, firm; lost">&#9679;<' in page
    assert f'aria-label="{M}: not detected; lost">&#8211;<' in page
    assert "http" not in page
    assert "<script" not in page
    refused = call("compare", *two, "--output", f"{tmp_path}/both.pdf", campaign=False)
    assert refused.exit_code == 2
    assert ".html" in refused.stderr


def test_campaigns_of_two_studies_are_compared_each_with_its_own(call: Call, two: tuple[str, str], tmp_path: Path):
    second = copied(tmp_path / "b", "found.yaml")
    (second / "sim" / "world.yaml").write_text(
        (second / "sim" / "world.yaml").read_text().replace("cruise_mps: 0.5", "cruise_mps: 0.6")
    )
    words = ("--mutant", "LATE-human", "--situation", "T?O?W0D0H1", "--seeds", "3", "--quiet", "--campaign", "b")
    told_by(call("run", *words, study=second, campaign=False))
    named = str(second / "results" / "campaigns" / "b")
    told = of_form("compare", told_by(call("compare", two[0], named, "--format", "json", campaign=False)))
    assert told["lost"] == [M]


def test_a_campaign_that_a_change_made_stale_is_compared_as_it_was_flown(
    call: Call, tmp_path: Path, two: tuple[str, str]
):
    changed = copied(tmp_path / "changed", "found.yaml")
    world = changed / "sim" / "world.yaml"
    world.write_text(world.read_text().replace("cruise_mps: 0.5", "cruise_mps: 0.6"))
    done = call("compare", *two, "--format", "json", study=changed, campaign=False)
    assert of_form("compare", told_by(done))["lost"] == [M]
    assert done.stderr.count("no flight is of the study as it is now, so all are compared as they were flown") == 2


def test_only_campaigns_of_one_grid_are_compared(call: Call, two: tuple[str, str], tmp_path: Path):
    wide = ("--grid", "wide", "--choose", "first:1", "--mutant", "LATE-human", "--quiet", "--campaign", f"{tmp_path}/w")
    told_by(call("run", *wide, campaign=False))
    refused = call("compare", two[0], f"{tmp_path}/w", campaign=False)
    assert "only campaigns of one grid have the same situations" in sentence(refused)


def test_with_flights_the_flights_that_differ_are_listed_and_the_old_verb_names_the_new_one(
    call: Call, two: tuple[str, str]
):
    old, new = two
    told = of_form("compare", told_by(call("compare", old, new, "--flights", "--format", "json", campaign=False)))
    assert {one["mutant"] for one in told["flights"]["differences"]} == {M}
    assert "0 differ" in told_by(call("compare", old, old, "--flights", campaign=False)).replace("\n", " ")
    diff = call("diff", old, new, campaign=False)
    assert diff.stdout == told_by(call("compare", old, new, "--flights", campaign=False))
    assert "`compare --flights`" in diff.stderr


M = "LATE-human@3s"


def _compare(first: list[Outcome], second: list[Outcome]) -> FlightDifferences:
    return differences_of(("old", "new"), first, second, ROSTER, GRID)


def test_another_status_is_a_difference():
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    assert compared.same == 1
    first, second = Facts("revealed", "landed", ("SR2",)), Facts("survived", "landed", ())
    assert compared.differences == (Difference(M, "T0O0W0D0H0", 0, first, second),)


def test_another_ending_is_a_difference():
    (difference,) = _compare([outcome()], [replace(outcome(), ending="struck")]).differences
    assert (str(difference.first), str(difference.second)) == ("held, landed", "held, struck")


def test_other_bits_with_the_same_status_are_only_counted():
    compared = _compare([outcome(), outcome(M, digest="a")], [outcome(), outcome(M, digest="b")])
    assert (compared.same, compared.other_bits, compared.differences) == (1, 1, ())


def test_a_flight_that_one_of_them_lacks_is_a_difference():
    (difference,) = _compare([outcome(), outcome(M)], [outcome()]).differences
    assert (difference.mutant, difference.second) == (M, None)


def test_the_table_names_both_campaigns():
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    table = differences_table(compared)
    assert table.headers[3:] == ("old", "new")
    assert table.rows == ((M, "T0O0W0D0H0", 0, "revealed SR2, landed", "survived, landed"),)
    assert "1 flights are the same bit for bit" in table.notes[0]


@given(campaigns())
def test_a_campaign_does_not_differ_from_itself(outcomes: list[Outcome]):
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    assert _compare(once, once[::-1]) == FlightDifferences("old", "new", len(once), 0, ())
