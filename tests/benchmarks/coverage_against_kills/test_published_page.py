"""The published page of coverage against kills, made again from the published flights."""

from __future__ import annotations

from functools import cache

from published_flights import PUBLISHED, ROOT, outcomes

from experiments.coverage_against_kills.curve_picture import curve_picture
from experiments.coverage_against_kills.curve_tables import curve_tables
from experiments.coverage_against_kills.curves import Curves, curves
from experiments.coverage_against_kills.prediction import predict
from experiments.coverage_against_kills.trial import trial
from scaloft_fi.analysis.score import score_of
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study
from scaloft_fi.views.table import Format, render


@cache
def followed() -> Curves:
    study, rulings = Study.open(ROOT), rulings_of(outcomes())
    scored = score_of(rulings, study.roster, study.space)
    flown = trial(scored, rulings, study.roster, study.space)
    assert flown is not None
    return curves(flown)


def test_the_published_tables_are_those_of_the_published_flights() -> None:
    tables = render(curve_tables(followed(), predict(followed())), Format.MARKDOWN)
    assert tables == (PUBLISHED / "coverage_against_kills.md").read_text(encoding="utf-8")


def test_the_published_picture_is_that_of_the_published_flights() -> None:
    assert curve_picture(followed()) == (PUBLISHED / "coverage_against_kills.svg").read_text(encoding="utf-8")


def test_the_two_way_array_meets_nearly_one_kill_set_more_than_random_situations() -> None:
    random, array = followed().curve("random"), followed().curve("2-way")
    assert random is not None
    assert array is not None
    assert [round(value, 1) for value in (array.kill_sets.mean[-1], random.kill_sets.mean[5])] == [13.6, 12.7]
    four = followed().curve("4-way")
    assert four is not None
    assert [round(curve.distinct.mean[-1], 1) for curve in (array, four) if curve.distinct] == [0.9, -0.2]
