"""The whole matrix on two drones: the study of the second one, its record, and the page that both records make."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments import PUBLISHED, ROOT
from experiments.documented import DOCUMENTED
from experiments.pages import registered
from experiments.two_drones import COMPARISON, NAME, SECOND, results
from scaloft_fi.campaign.store.archive import study_files
from scaloft_fi.study import Study

CHANGES = {
    "sim/stack.yaml": {
        "  law: turning ": "  law: published ",
        "  accel_mps2: 1.5              #": "  accel_mps2: 3.0              #",
    },
    "sim/world.yaml": {"  cruise_mps: 0.5\n": "  cruise_mps: 1.8\n"},
}
"""What the study of the second drone changes in the files of the reference study."""


@pytest.fixture(scope="module")
def second() -> Study:
    return Study.open(SECOND)


def test_the_second_drone_differs_from_the_reference_drone_in_what_was_frozen_alone(second: Study):
    reference, changed = Study.open(ROOT), {}
    for name in ("stack", "world", "vehicle", "sensors"):
        one, two = (study.grid.documents.get(name) or study.sim.stack.document for study in (reference, second))
        changed |= {f"{name}.{path}": value for path, value in _differing(one.plain(), two.plain())}
    assert changed == dict(DOCUMENTED)
    assert [m.to_json() for m in reference.catalogue] == [m.to_json() for m in second.catalogue]


def _differing(one: object, two: object, path: str = "") -> list[tuple[str, object]]:
    if isinstance(one, dict) and isinstance(two, dict):
        assert one.keys() == two.keys()
        return [found for key in one for found in _differing(one[key], two[key], f"{path}.{key}".lstrip("."))]
    return [] if one == two else [(path, two)]


def test_the_record_has_the_study_of_the_second_drone():
    copied = [path for path in study_files(ROOT) if path.suffix != ".md" and path.name != "found.yaml"]
    assert {path.relative_to(SECOND) for path in study_files(SECOND)} == {path.relative_to(ROOT) for path in copied}
    for name, changes in CHANGES.items():
        text = (ROOT / name).read_text(encoding="utf-8")
        for old, new in changes.items():
            assert text.count(old) == 1
            text = text.replace(old, new)
        assert (SECOND / name).read_text(encoding="utf-8") == text


@pytest.mark.release
def test_the_page_and_the_comparison_are_what_the_two_records_make():
    text, page = results(Study.open(ROOT))
    assert registered(NAME) + text == (PUBLISHED / f"{NAME}.md").read_text(encoding="utf-8")
    assert page == COMPARISON.read_text(encoding="utf-8")


def test_the_folder_of_the_second_drone_stays_small():
    assert sum(path.stat().st_size for path in Path(SECOND).rglob("*") if path.is_file()) < 15_000_000
