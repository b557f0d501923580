"""Pictures of made-up flights, graphs and plans of studies: well-formed, escaped, at one scale."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from options import usually
from printed import STUDY, run
from studies import copied, edit_in, every_key_study

from scaloft_fi.analysis.kill_matrix import subsumption
from scaloft_fi.study import Study
from scaloft_fi.verbs.kills import dot, draw_subsumption
from scaloft_fi.verbs.situations import MAP, map_of, plan_of
from scaloft_fi.views.picture import (
    RAMP,
    BodyOutline,
    FloorPlan,
    Frame,
    Happens,
    MapScene,
    Mark,
    Track,
    draw,
    draw_plan,
    hull,
    png,
    rings,
    shade,
)

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


def test_a_map_names_flight_note_axes_and_events():
    texts = _texts(draw(SCENE, [TRACK], title="LATE-human@3s in T0, seed 0", subtitle="light"))
    title = "LATE-human@3s in T0, seed 0"
    assert {title, "light", "baseline", "touched down", "x [m]", "y [m]", "SR2 violated", "1.00 s"} <= set(texts)


def test_text_is_escaped():
    nasty = replace(TRACK, title='<script>"&', marks=(Mark(0.5, (0, 0), "a < b & c", "#57534e"),))
    svg = draw(SCENE, [nasty], title="<b>&</b>")
    assert "<script" not in svg
    assert {'<script>"&', "<b>&</b>", "a < b & c"} <= set(_texts(svg))


def test_two_flights_stand_side_by_side_at_one_scale():
    far = replace(TRACK, points=tuple((x, y - 3) for x, y in TRACK.points))
    drawn = ET.fromstring(draw(SCENE, [TRACK, far], title="t"))
    panels = [clip[0].attrib for clip in drawn.iter(f"{SVG}clipPath")]
    assert all(panels[0][side] == panels[1][side] for side in ("width", "height"))
    assert float(panels[1]["x"]) > float(panels[0]["x"]) + float(panels[0]["width"])


def test_a_steady_speed_keeps_one_colour():
    assert {shade(0.2 + noise) for noise in (-0.03, 0.0, 0.03)} == {2}
    assert shade(9.0) == len(RAMP) - 1


def test_more_events_than_fit_are_counted_one_sample_is_enough_and_nothing_is_refused():
    many = replace(TRACK, marks=tuple(Mark(i, (0, i / 5), "flag", "#b45309") for i in range(14)))
    assert "and 4 more" in _texts(draw(SCENE, [many], title="t"))
    ET.fromstring(draw(SCENE, [replace(TRACK, points=((0.0, 0.0),), speeds_mps=(0.0,))], title="t"))
    with pytest.raises(ValueError, match="at least one track"):
        draw(SCENE, [], title="t")


def test_a_png_has_text_without_any_font_of_the_machine():
    box = '<svg xmlns="http://www.w3.org/2000/svg" width="60" height="20" font-family="sans-serif">'
    assert png(f"{box}</svg>").startswith(b"\x89PNG")
    assert png(f'{box}<text y="15">Map</text></svg>') != png(f"{box}</svg>")


@given(st.floats(-50, 50), st.floats(-50, 50))
def test_north_is_up_and_east_is_right(x: float, y: float):
    frame = Frame(-60, 60, -60, 60, 10, 20, 8.0)
    left, top = frame.pixel((x, y))
    assert frame.pixel((x + 1, y)) == pytest.approx((left + 8, top))
    assert frame.pixel((x, y + 1)) == pytest.approx((left, top - 8))


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=30))
def test_a_hull_has_every_point_on_its_left(points: list[tuple[int, int]]):
    corners = hull(points)
    assert set(corners) <= set(points)
    for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
        assert all((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0 for p in points)


@given(st.permutations(range(8)), st.lists(st.booleans(), min_size=8, max_size=8))
def test_an_outline_is_found_in_whatever_order_its_segments_come(order: list[int], turned: list[bool]):
    corners = [(math.cos(i), math.sin(i)) for i in (k * math.tau / 8 for k in range(8))]
    segments = [(corners[i], corners[(i + 1) % 8]) for i in order]
    found = rings([(b, a) if turn else (a, b) for (a, b), turn in zip(segments, turned, strict=True)])
    assert [sorted(ring) for ring in found] == [sorted(corners)]


matrices = st.dictionaries(
    st.sampled_from([f"m{n}" for n in range(10)]), st.sets(st.sampled_from("abcde"), max_size=5).map(frozenset)
)
SAMPLE = {"NO-x": "a", "LATE-x@1s": "a", "MORE-y": "abc", "LESS-y": "ab", '<b>"odd" & long</b>' * 3: "d"}


@settings(deadline=None, max_examples=usually(25, release=60))
@given(matrices)
def test_every_kill_set_is_a_box_and_no_two_boxes_overlap(kills: dict[str, frozenset[str]]):
    graph = subsumption(kills)
    drawn = ET.fromstring(draw_subsumption(graph))
    width, height = float(drawn.get("width", 0)), float(drawn.get("height", 0))
    rects = [r for g in drawn.iter(f"{SVG}g") for r in g.iter(f"{SVG}rect")]
    boxes = [tuple(float(r.get(side, 0)) for side in ("x", "y", "width", "height")) for r in rects]
    assert len(boxes) == len(graph.nodes)
    for number, (x, y, w, h) in enumerate(boxes):
        assert 0 <= x <= x + w <= width
        assert 0 <= y <= y + h <= height
        for x2, y2, w2, h2 in boxes[:number]:
            assert x + w <= x2 or x2 + w2 <= x or y + h <= y2 or y2 + h2 <= y


def test_lines_lead_from_the_subsuming_to_the_right():
    svg = draw_subsumption(subsumption(SAMPLE))
    starts_and_ends = re.findall(r'd="M([\d.]+),[\d.]+C.*?([\d.]+),[\d.]+" fill="none"', svg)
    assert len(starts_and_ends) == 2
    assert all(float(start) < float(end) for start, end in starts_and_ends)


def test_minimal_mutants_have_thick_frames_hostile_names_are_text_and_many_names_are_counted():
    svg = draw_subsumption(subsumption(SAMPLE))
    assert svg.count('stroke-width="3"') == 2
    assert "<b>" not in svg
    assert png(svg).startswith(b"\x89PNG")
    assert ">and 13 more<" in draw_subsumption(subsumption({f"m{n}": "a" for n in range(20)}))


def test_dot_has_every_node_and_edge():
    text = dot(subsumption(SAMPLE))
    assert text.count(" -> ") == 2
    assert r"NO-x\nLATE-x@1s\nkilled in 1" in text
    assert text.count("penwidth=3") == 2
    assert r"\"odd\"" in text


def _drawn(study: Study, key: str) -> str:
    return draw_plan(plan_of(study, study.grid.situation(key)), title=key, subtitle="words")


def test_bodies_waypoints_and_facts_stand_by_name(study: Study):
    texts = _texts(_drawn(study, "T1O1W0D0H1"))
    assert {"bar", "obstacle", "person", "corner (1, 3)", "end (2)", "home (4)", "x [m]", "1 m"} <= set(texts)
    assert "nominal flight 117 s, time limit 195 s" in texts


def test_a_body_that_is_not_there_is_not_drawn(study: Study):
    texts = _texts(_drawn(study, "T0O0W0D0H0"))
    assert texts.count("person") == 1  # in the legend


def test_a_happening_stands_where_it_starts_and_in_the_list():
    svg = _drawn(Study.open(STUDY, "wide"), "T1O0W0D2H2C0V0P0B0G0")
    texts = _texts(svg)
    assert "1 lamp: near (0, 3.5) within 0.7 m, for 6 s" in texts
    assert {"1", "2"} <= set(texts)
    assert svg.count('stroke="#7c3aed"') == 2


def test_a_large_mine_fits_the_picture_and_has_a_longer_scale():
    ring = ((0.0, 0.0), (180.0, 0.0), (180.0, 90.0), (0.0, 90.0))
    walls = tuple(zip(ring, (*ring[1:], ring[0]), strict=True))
    scene = MapScene((ring,), walls, (), ((170.0, 80.0), (10.0, 10.0)), (10.0, 10.0))
    plan = FloorPlan(scene, (("far", (170.0, 80.0)),), (Happens("gust: at 3 s"),), ())
    svg = draw_plan(plan, title="large", subtitle="<b>")
    wide, high = (float(size) for size in re.findall(r'(?:width|height)="(\d+)"', svg)[:2])
    assert wide <= 1300
    assert high <= 1300
    assert {"10 m", "far (1)", "1 gust: at 3 s", "<b>"} <= set(_texts(svg))


def test_a_mine_from_a_mesh_is_drawn(tmp_path: Path):
    svg = _drawn(Study.open(every_key_study(tmp_path)), "H0A0B0C0D0")
    assert {"crate", "bar", "person", "far (1)"} <= set(_texts(svg))


def test_the_values_fit_the_declared_form():
    study = Study.open(STUDY, "wide")
    values = MAP.record(map_of(study, study.grid.situation("T1O0W0D2H2C0V0P0B0G0")))
    Draft202012Validator(MAP.schema).validate(values)
    assert values["places"][1] == {"place": "corner", "x_m": 0.0, "y_m": 7.0, "z_m": 1.65}
    low, high = ([values["mine"][f"{end}_{axis}_m"] for axis in "xyz"] for end in ("least", "most"))
    for place in values["places"]:
        assert all(low[i] < place[f"{axis}_m"] < high[i] for i, axis in enumerate("xyz"))


@pytest.mark.parametrize("ending", ["svg", "PNG"])
def test_the_verb_tells_and_draws_without_flying(ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = tmp_path / f"map.{ending}"
    assert run("map", "1", "--study", STUDY, "--output", file) == 0
    told = capsys.readouterr()
    assert told.out.startswith("T0O0W0D0H1\n")
    assert told.err == f"map: {file}\n"
    assert file.read_bytes()[:4] in (b"<svg", b"\x89PNG")
    assert not (tmp_path / "results").exists()


def test_a_situation_whose_values_contradict_each_other_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    copied(tmp_path)
    edit_in(tmp_path / "sim" / "world.yaml", "corner: [0.0, 7.0]", "corner: [4.0, 7.0]")
    assert run("map", "--study", tmp_path) == 2
    assert "must be in the open space of the mine" in capsys.readouterr().err
