"""The plan of a situation: everything by name, at a scale, whatever the mine."""

from __future__ import annotations

import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from every_key import every_key_study
from jsonschema import Draft202012Validator
from refusal import run

from scaloft_fi.study import Study
from scaloft_fi.verbs.map import MAP, map_of, plan_of
from scaloft_fi.views.picture import FloorPlan, Happens, MapScene, draw_plan

ROOT = Path(__file__).parents[2]
SVG = "{http://www.w3.org/2000/svg}"


def _texts(svg: str) -> list[str]:
    return [element.text or "" for element in ET.fromstring(svg).iter(f"{SVG}text")]


def _drawn(study: Study, key: str) -> str:
    return draw_plan(plan_of(study, study.grid.situation(key)), title=key, subtitle="words")


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(ROOT)


def test_bodies_waypoints_and_facts_stand_by_name(study: Study) -> None:
    texts = _texts(_drawn(study, "T1O1W0D0H1"))
    assert {"bar", "obstacle", "person", "corner (1, 3)", "end (2)", "home (4)", "x [m]", "1 m"} <= set(texts)
    assert "nominal flight 117 s, time limit 195 s" in texts


def test_a_body_that_is_not_there_is_not_drawn(study: Study) -> None:
    texts = _texts(_drawn(study, "T0O0W0D0H0"))
    assert texts.count("person") == 1  # in the legend


def test_a_happening_stands_where_it_starts_and_in_the_list() -> None:
    svg = _drawn(Study.open(ROOT, "wide"), "T1O0W0D2H2C0V0P0B0G0")
    texts = _texts(svg)
    assert "1 lamp: near (0, 3.5) within 0.7 m, for 6 s" in texts
    assert {"1", "2"} <= set(texts)
    assert svg.count('stroke="#7c3aed"') == 2


def test_a_large_mine_fits_the_picture_and_has_a_longer_scale() -> None:
    ring = ((0.0, 0.0), (180.0, 0.0), (180.0, 90.0), (0.0, 90.0))
    walls = tuple(zip(ring, (*ring[1:], ring[0]), strict=True))
    scene = MapScene((ring,), walls, (), ((170.0, 80.0), (10.0, 10.0)), (10.0, 10.0))
    plan = FloorPlan(scene, (("far", (170.0, 80.0)),), (Happens("gust: at 3 s"),), ())
    svg = draw_plan(plan, title="large", subtitle="<b>")
    wide, high = (float(size) for size in re.findall(r'(?:width|height)="(\d+)"', svg)[:2])
    assert wide <= 1300
    assert high <= 1300
    assert {"10 m", "far (1)", "1 gust: at 3 s", "<b>"} <= set(_texts(svg))


def test_a_mine_from_a_mesh_is_drawn(tmp_path: Path) -> None:
    svg = _drawn(Study.open(every_key_study(tmp_path)), "H0A0B0C0D0")
    assert {"crate", "bar", "person", "far (1)"} <= set(_texts(svg))


def test_the_values_fit_the_declared_form() -> None:
    study = Study.open(ROOT, "wide")
    values = MAP.record(map_of(study, study.grid.situation("T1O0W0D2H2C0V0P0B0G0")))
    Draft202012Validator(MAP.schema).validate(values)
    assert values["places"][1] == {"place": "corner", "x_m": 0.0, "y_m": 7.0, "z_m": 1.65}
    low, high = ([values["mine"][f"{end}_{axis}_m"] for axis in "xyz"] for end in ("least", "most"))
    for place in values["places"]:
        assert all(low[i] < place[f"{axis}_m"] < high[i] for i, axis in enumerate("xyz"))


@pytest.mark.parametrize("ending", ["svg", "PNG"])
def test_the_verb_tells_and_draws_without_flying(
    ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / f"map.{ending}"
    assert run("map", "1", "--study", ROOT, "--output", file) == 0
    told = capsys.readouterr()
    assert told.out.startswith("T0O0W0D0H1\n")
    assert told.err == f"map: {file}\n"
    assert file.read_bytes()[:4] in (b"<svg", b"\x89PNG")
    assert not (tmp_path / "results").exists()


def test_a_situation_whose_values_contradict_each_other_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, tmp_path / name)
    world = tmp_path / "sim" / "world.yaml"
    world.write_text(world.read_text().replace("corner: [0.0, 7.0]", "corner: [4.0, 7.0]"))
    assert run("map", "--study", tmp_path) == 2
    assert "must be in the open space of the mine" in capsys.readouterr().err
