from __future__ import annotations

import pytest

from scaloft_fi import document
from scaloft_fi.errors import InputError
from scaloft_fi.sim.patch import leaves, patched, qualified


@pytest.fixture
def item(tmp_path):
    path = tmp_path / "world.yaml"
    path.write_text("a: {b: 1, c.d: 2}\nlist:\n  - 3\n  - {e: 4}\n")
    return document.load(path)


def write(path, text):
    path.write_text(text)
    return path


def value(tmp_path, text):
    path = tmp_path / "changes.yaml"
    path.write_text(f"\n\n{text}\n")
    return document.load(path)


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("a.b", {"a": {"b": 9, "c.d": 2}, "list": [3, {"e": 4}]}),
        ("a.c.d", {"a": {"b": 1, "c.d": 9}, "list": [3, {"e": 4}]}),
        ("list.0", {"a": {"b": 1, "c.d": 2}, "list": [9, {"e": 4}]}),
        ("list.1.e", {"a": {"b": 1, "c.d": 2}, "list": [3, {"e": 9}]}),
        ("a", {"a": 9, "list": [3, {"e": 4}]}),
    ],
)
def test_one_value_is_replaced_and_the_rest_kept(tmp_path, item, path, found):
    before = item.plain()
    other = value(tmp_path, "1")
    changed = patched({"world": item, "vehicle": other}, {f"world.{path}": value(tmp_path, "9")})
    assert changed["world"].plain() == found
    assert changed["vehicle"] is other
    assert item.plain() == before


def test_a_replaced_value_keeps_the_place_where_it_was_written(tmp_path, item):
    changed = patched({"world": item}, {"world.a.b": value(tmp_path, "9")})["world"]
    assert changed.need("a").need("b").place.endswith("changes.yaml:3")
    assert changed.need("a").need("b").name == "b"


@pytest.mark.parametrize(
    "path", ["world.a.x", "world.x", "world.list.2", "world.list.one", "world.a.b.c", "wrld.a.b", "world"]
)
def test_an_unknown_path_is_refused(tmp_path, item, path):
    with pytest.raises(InputError, match=rf"changes.yaml:3: no path '{path}' in the study"):
        patched({"world": item}, {path: value(tmp_path, "9")})


def test_an_unknown_path_is_refused_with_the_nearest_of_all_documents(tmp_path, item):
    documents = {"world": item, "vehicle": document.load(write(tmp_path / "vehicle.yaml", "mass_kg: 1.5"))}
    with pytest.raises(InputError, match=r"no path 'vehicel.mass_kg' in the study; did you mean 'vehicle.mass_kg'\?"):
        patched(documents, {"vehicel.mass_kg": value(tmp_path, "2")})


def test_leaves_are_all_scalars_by_path(item):
    assert {path: leaf.value for path, leaf in leaves(item)} == {"a.b": 1, "a.c.d": 2, "list.0": 3, "list.1.e": 4}


@pytest.mark.parametrize(
    ("path", "whole"),
    [
        ("light", "world.light"),
        ("mission.cruise_mps", "world.mission.cruise_mps"),
        ("world.light", "world.light"),
        ("vehicle.mass_kg", "vehicle.mass_kg"),
        ("sensors.depth.max_m", "sensors.depth.max_m"),
    ],
)
def test_a_path_without_a_document_is_the_worlds(tmp_path, path, whole):
    assert qualified(path, value(tmp_path, "1")) == whole


def test_a_path_of_the_stack_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"changes.yaml:3: 'stack.goal' belongs to the stack under test; an axis may"):
        qualified("stack.goal", value(tmp_path, "1"))
