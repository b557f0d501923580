from __future__ import annotations

import re
import xml.etree.ElementTree as ET

from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.suite import subsumption
from scaloft_fi.views.picture import png
from scaloft_fi.views.subsumption import dot, draw_subsumption

SVG = "{http://www.w3.org/2000/svg}"
matrices = st.dictionaries(
    st.sampled_from([f"m{n}" for n in range(10)]), st.sets(st.sampled_from("abcde"), max_size=5).map(frozenset)
)
SAMPLE = {"NO-x": "a", "LATE-x@1s": "a", "MORE-y": "abc", "LESS-y": "ab", '<b>"odd" & long</b>' * 3: "d"}


@settings(deadline=None, max_examples=usually(25, release=60))
@given(matrices)
def test_every_kill_set_is_a_box_and_no_two_boxes_overlap(kills: dict[str, frozenset[str]]) -> None:
    graph = subsumption(kills)
    drawn = ET.fromstring(draw_subsumption(graph))
    width, height = float(drawn.get("width", 0)), float(drawn.get("height", 0))
    rects = [r for g in drawn.iter(f"{SVG}g") for r in g.iter(f"{SVG}rect")]
    boxes = [tuple(float(r.get(side, 0)) for side in ("x", "y", "width", "height")) for r in rects]
    assert len(boxes) == len(graph.nodes)
    for number, (x, y, w, h) in enumerate(boxes):
        assert x >= 0
        assert y >= 0
        assert x + w <= width
        assert y + h <= height
        for x2, y2, w2, h2 in boxes[:number]:
            assert x + w <= x2 or x2 + w2 <= x or y + h <= y2 or y2 + h2 <= y


def test_lines_lead_from_the_subsuming_to_the_right() -> None:
    svg = draw_subsumption(subsumption(SAMPLE))
    starts_and_ends = re.findall(r'd="M([\d.]+),[\d.]+C.*?([\d.]+),[\d.]+" fill="none"', svg)
    assert len(starts_and_ends) == 2
    assert all(float(start) < float(end) for start, end in starts_and_ends)


def test_minimal_mutants_have_thick_frames_and_hostile_names_are_text() -> None:
    svg = draw_subsumption(subsumption(SAMPLE))
    assert svg.count('stroke-width="3"') == 2
    assert "<b>" not in svg
    assert png(svg).startswith(b"\x89PNG")


def test_a_node_of_many_mutants_says_how_many_more() -> None:
    svg = draw_subsumption(subsumption({f"m{n}": "a" for n in range(20)}))
    assert ">and 13 more<" in svg


def test_dot_has_every_node_and_edge() -> None:
    text = dot(subsumption(SAMPLE))
    assert text.count(" -> ") == 2
    assert r"NO-x\nLATE-x@1s\nkilled in 1" in text
    assert text.count("penwidth=3") == 2
    assert r"\"odd\"" in text
