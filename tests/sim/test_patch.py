from __future__ import annotations

import pytest

from scaloft_fi import document
from scaloft_fi.errors import InputError
from scaloft_fi.sim.patch import leaves, overridden, patched


@pytest.fixture
def item(tmp_path):
    path = tmp_path / "world.yaml"
    path.write_text("a: {b: 1, c.d: 2}\nlist:\n  - 3\n  - {e: 4}\n")
    return document.load(path)


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
    assert patched(item, path, value(tmp_path, "9")).plain() == found
    assert item.plain() == before


def test_a_replaced_value_keeps_the_place_where_it_was_written(tmp_path, item):
    changed = patched(item, "a.b", value(tmp_path, "9"))
    assert changed.need("a").need("b").place.endswith("changes.yaml:3")
    assert changed.need("a").need("b").name == "b"


@pytest.mark.parametrize("path", ["a.x", "x", "list.2", "list.one", "a.b.c"])
def test_an_unknown_path_is_refused_with_the_nearest(tmp_path, item, path):
    with pytest.raises(InputError, match=rf"changes.yaml:3: no path '{path}' in world.yaml"):
        patched(item, path, value(tmp_path, "9"))


def test_leaves_are_all_scalars_by_path(item):
    assert {path: leaf.value for path, leaf in leaves(item)} == {"a.b": 1, "a.c.d": 2, "list.0": 3, "list.1.e": 4}


def test_overrides_name_their_document_first(item):
    changed = overridden({"world": item}, {"world.a.b": 7.5})
    assert changed["world"].plain()["a"]["b"] == 7.5


@pytest.mark.parametrize("path", ["wrld.a.b", "world", "world.a.x"])
def test_an_override_of_nothing_is_refused(item, path):
    with pytest.raises(InputError, match="override"):
        overridden({"world": item}, {path: 1.0})
