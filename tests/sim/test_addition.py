from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError
from scaloft_fi.sim.patch import added


@pytest.fixture
def documents(tmp_path: Path) -> dict[str, Item]:
    (tmp_path / "world.yaml").write_text("light: 0.9\nbodies:\n  bar: {present: true}\n")
    (tmp_path / "vehicle.yaml").write_text("mass_kg: 1.5\n")
    return {name: load(tmp_path / f"{name}.yaml") for name in ("world", "vehicle")}


def additions(tmp_path: Path, text: str) -> Item:
    (tmp_path / "wide.yaml").write_text(text)
    return load(tmp_path / "wide.yaml")


def test_new_entries_join_the_old_ones_and_keep_their_own_place(tmp_path: Path, documents: dict[str, Item]) -> None:
    more = additions(tmp_path, "world:\n  bodies:\n    belt: {present: false}\n  signals: [charge]\n")
    world = added(documents, more)["world"]
    bodies = {"bar": {"present": True}, "belt": {"present": False}}
    assert world.plain() == {"light": 0.9, "bodies": bodies, "signals": ["charge"]}
    entries = world.need("bodies").mapping()
    assert entries["bar"].place == f"{tmp_path / 'world.yaml'}:3"
    assert entries["belt"].place == f"{tmp_path / 'wide.yaml'}:3"
    assert documents["world"].plain() == {"light": 0.9, "bodies": {"bar": {"present": True}}}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("world: {light: 0.1}", "world.light exists already; an axis changes it with `set`"),
        ("world:\n  bodies:\n    bar: {present: false}", "world.bodies.bar.present exists already"),
        ("world: {bodies: {bar: 3}}", "world.bodies.bar exists already"),
        ("wrld: {light: 0.1}", "no document 'wrld' to add to; did you mean 'world'?"),
        ("stack: {name: mine}", "no document 'stack' to add to"),
        ("world: 3", "world=3 must be a mapping of keys to values"),
    ],
)
def test_what_exists_or_belongs_elsewhere_is_refused_with_its_place(
    tmp_path: Path, documents: dict[str, Item], text: str, sentence: str
) -> None:
    with pytest.raises(InputError) as refused:
        added(documents, additions(tmp_path, text))
    assert str(refused.value).startswith(f"{tmp_path / 'wide.yaml'}:")
    assert sentence in str(refused.value)
