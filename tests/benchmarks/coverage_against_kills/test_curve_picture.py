from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from grids import FIVE, keys_of

from experiments.coverage_against_kills.curve_picture import LOOKS, curve_picture
from experiments.coverage_against_kills.curves import Curves, curves
from experiments.coverage_against_kills.trial import Trial
from scaloft_fi.views.picture import png

SVG = "{http://www.w3.org/2000/svg}"


def found(kills: np.ndarray) -> Curves:
    return curves(Trial(FIVE, tuple(keys_of(FIVE)), ("m",) * len(kills), ("p",) * len(kills), kills))


@pytest.fixture(scope="module")
def drawn() -> Curves:
    return found(np.random.default_rng(3).random((40, 32)) < 0.1)


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
    root = ElementTree.fromstring(curve_picture(found(kills)))
    wide, high = float(root.get("width")), float(root.get("height"))
    for line in [*root.iter(f"{SVG}polyline"), *root.iter(f"{SVG}polygon")]:
        for point in line.get("points").split():
            x, y = map(float, point.split(","))
            assert 0 <= x <= wide
            assert 90 <= y <= high


def test_it_becomes_a_png(drawn: Curves) -> None:
    assert png(curve_picture(drawn), 1.0)[:4] == b"\x89PNG"
