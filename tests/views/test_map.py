"""Maps drawn from made-up flights: well-formed, escaped, at one scale."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.views.picture import RAMP, BodyOutline, Frame, MapScene, Mark, Track, draw, hull, png, rings, shade

SVG = "{http://www.w3.org/2000/svg}"
SQUARE = ((-2.0, -1.0), (2.0, -1.0), (2.0, 5.0), (-2.0, 5.0))
SCENE = MapScene(
    floor=(SQUARE,),
    walls=tuple(zip(SQUARE, (*SQUARE[1:], SQUARE[0]), strict=True)),
    bodies=(BodyOutline("person", ((0.0, 2.0), (0.5, 2.0), (0.2, 2.4))),),
    waypoints=((0.0, 4.0), (0.0, 0.0)),
    home=(0.0, 0.0),
)
TRACK = Track(
    title="baseline",
    note="touched down",
    points=tuple((0.3 * math.sin(i / 20), i / 20) for i in range(80)),
    speeds_mps=tuple(0.5 if i < 40 else 0.2 for i in range(80)),
    marks=(Mark(1.0, (0.1, 1.0), "SR2 violated", "#c1121f"),),
)


def _texts(svg: str) -> list[str]:
    return [element.text or "" for element in ET.fromstring(svg).iter(f"{SVG}text")]


def test_a_map_names_flight_note_axes_and_events() -> None:
    texts = _texts(draw(SCENE, [TRACK], title="LATE-human@3s in T0, seed 0", subtitle="light"))
    for wanted in (
        "LATE-human@3s in T0, seed 0",
        "light",
        "baseline",
        "touched down",
        "x [m]",
        "y [m]",
        "SR2 violated",
    ):
        assert wanted in texts
    assert "1.00 s" in texts


def test_text_is_escaped() -> None:
    nasty = replace(TRACK, title='<script>"&', marks=(Mark(0.5, (0, 0), "a < b & c", "#57534e"),))
    svg = draw(SCENE, [nasty], title="<b>&</b>")
    assert "<script" not in svg
    assert {'<script>"&', "<b>&</b>", "a < b & c"} <= set(_texts(svg))


def test_two_flights_stand_side_by_side_at_one_scale() -> None:
    far = replace(TRACK, points=tuple((x, y - 3) for x, y in TRACK.points))
    drawn = ET.fromstring(draw(SCENE, [TRACK, far], title="t"))
    panels = [clip[0].attrib for clip in drawn.iter(f"{SVG}clipPath")]
    assert panels[0]["width"] == panels[1]["width"]
    assert panels[0]["height"] == panels[1]["height"]
    assert float(panels[1]["x"]) > float(panels[0]["x"]) + float(panels[0]["width"])


def test_a_steady_speed_keeps_one_colour() -> None:
    assert {shade(0.2 + noise) for noise in (-0.03, 0.0, 0.03)} == {2}
    assert shade(9.0) == len(RAMP) - 1


def test_more_events_than_fit_are_counted() -> None:
    many = replace(TRACK, marks=tuple(Mark(i, (0, i / 5), "flag", "#b45309") for i in range(14)))
    assert "and 4 more" in _texts(draw(SCENE, [many], title="t"))


def test_a_map_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one track"):
        draw(SCENE, [], title="t")


def test_a_flight_of_one_sample_can_be_drawn() -> None:
    ET.fromstring(draw(SCENE, [replace(TRACK, points=((0.0, 0.0),), speeds_mps=(0.0,))], title="t"))


def test_a_png_has_text_without_any_font_of_the_machine() -> None:
    box = '<svg xmlns="http://www.w3.org/2000/svg" width="60" height="20" font-family="sans-serif">'
    assert png(f"{box}</svg>").startswith(b"\x89PNG")
    assert png(f'{box}<text y="15">Map</text></svg>') != png(f"{box}</svg>")


@given(st.floats(-50, 50), st.floats(-50, 50))
def test_north_is_up_and_east_is_right(x: float, y: float) -> None:
    frame = Frame(-60, 60, -60, 60, 10, 20, 8.0)
    left, top = frame.pixel((x, y))
    assert frame.pixel((x + 1, y)) == pytest.approx((left + 8, top))
    assert frame.pixel((x, y + 1)) == pytest.approx((left, top - 8))


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=30))
def test_a_hull_has_every_point_on_its_left(points: list[tuple[int, int]]) -> None:
    corners = hull(points)
    assert set(corners) <= set(points)
    for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
        assert all((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0 for p in points)


@given(st.permutations(range(8)), st.lists(st.booleans(), min_size=8, max_size=8))
def test_an_outline_is_found_in_whatever_order_its_segments_come(order: list[int], turned: list[bool]) -> None:
    corners = [(math.cos(i), math.sin(i)) for i in (k * math.tau / 8 for k in range(8))]
    segments = [(corners[i], corners[(i + 1) % 8]) for i in order]
    found = rings([(b, a) if turn else (a, b) for (a, b), turn in zip(segments, turned, strict=True)])
    assert [sorted(ring) for ring in found] == [sorted(corners)]
