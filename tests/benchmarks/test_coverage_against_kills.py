from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from builders import outcome, pool
from grids import FIVE, keys_of
from published_flights import PUBLISHED, ROOT, outcomes

import experiments.coverage_against_kills as experiment
from experiments.coverage_against_kills import LOOKS, curve_picture, curve_tables, predict
from experiments.coverage_curves import Curves, Trial, curves, trial
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import score_of
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study
from scaloft_fi.views.picture import png
from scaloft_fi.views.table import Format, render

SVG = "{http://www.w3.org/2000/svg}"


def curves_of(kills: np.ndarray) -> Curves:
    return curves(Trial(FIVE, tuple(keys_of(FIVE)), ("m",) * len(kills), ("p",) * len(kills), kills))


@pytest.fixture(scope="module")
def drawn() -> Curves:
    return curves_of(np.random.default_rng(3).random((40, 32)) < 0.1)


def test_every_strategy_is_named_in_text_and_drawn(drawn: Curves) -> None:
    root = ElementTree.fromstring(curve_picture(drawn))
    texts = [element.text for element in root.iter(f"{SVG}text")]
    for curve in drawn.curves:
        assert f"{curve.name}: {curve.about}" in texts
        colour = LOOKS[curve.id][0]
        lines = [line for line in root.iter(f"{SVG}polyline") if line.get("stroke") == colour]
        assert any(len(line.get("points").split()) == len(curve.kills.mean) for line in lines)


def test_no_two_strategies_differ_by_colour_alone() -> None:
    shapes = [(dashes, mark) for _, dashes, mark in LOOKS.values()]
    assert len(set(shapes)) == len(shapes)


@pytest.mark.parametrize("kills", [np.zeros((1, 32), bool), np.ones((3, 32), bool), np.eye(32, dtype=bool)])
def test_whatever_was_killed_stays_within_the_picture(kills: np.ndarray) -> None:
    root = ElementTree.fromstring(curve_picture(curves_of(kills)))
    wide, high = float(root.get("width")), float(root.get("height"))
    for line in [*root.iter(f"{SVG}polyline"), *root.iter(f"{SVG}polygon")]:
        for point in line.get("points").split():
            x, y = map(float, point.split(","))
            assert 0 <= x <= wide
            assert 90 <= y <= high


def test_it_becomes_a_png(drawn: Curves) -> None:
    assert png(curve_picture(drawn), 1.0)[:4] == b"\x89PNG"


KEYS = ("T0O0W0D0H0", "T0O0W0D0H1")


def holding(monkeypatch: pytest.MonkeyPatch, outcomes: Sequence[Outcome]) -> None:
    @contextmanager
    def snapshot(study: Study, campaign: str) -> Iterator[SimpleNamespace]:
        yield SimpleNamespace(rulings=rulings_of(outcomes), spending=Spending())

    monkeypatch.setattr(experiment, "snapshot", snapshot)


def test_it_writes_the_tables_and_the_picture(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    holding(monkeypatch, [*pool(*KEYS), *(outcome("LATE-human@3s", key, violated={"SR2": 8.0}) for key in KEYS)])
    experiment.main(["--output", str(tmp_path)])
    text = (tmp_path / "coverage_against_kills.md").read_text(encoding="utf-8")
    assert "Does coverage predict kills beyond the number of situations?" in text or "Nothing follows" in text
    assert (tmp_path / "coverage_against_kills.svg").read_text(encoding="utf-8").startswith("<svg")


def test_a_campaign_without_default_mutants_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    holding(monkeypatch, [*pool(*KEYS), outcome("LATE-human@1s", KEYS[0])])
    with pytest.raises(InputError, match="needs default mutants of credible cells: none was flown"):
        experiment.pages(Study.open(ROOT), "any")


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
