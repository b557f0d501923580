"""The whole matrix on two drones: the study of the second one, its record, and the page that both records make."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments import PUBLISHED, ROOT
from experiments.documented import DOCUMENTED
from experiments.pages import registered
from experiments.two_drones import COMPARISON, NAME, SECOND, results, second_study
from scaloft_fi.campaign.store.archive import study_files
from scaloft_fi.study import Study


@pytest.fixture(scope="module")
def second(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return second_study(tmp_path_factory.mktemp("second") / "study")


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


def test_the_record_has_the_study_of_the_second_drone(second: Study):
    assert {path.relative_to(second.folder).as_posix() for path in study_files(second.folder)} == {
        path.relative_to(SECOND).as_posix() for path in study_files(SECOND)
    }
    for path in study_files(second.folder):
        archived = SECOND / path.relative_to(second.folder)
        if path.name in ("stack.yaml", "world.yaml"):
            assert archived.read_bytes() == path.read_bytes()


@pytest.mark.release
def test_the_page_and_the_comparison_are_what_the_two_records_make():
    text, page = results(Study.open(ROOT))
    assert registered(NAME) + text == (PUBLISHED / f"{NAME}.md").read_text(encoding="utf-8")
    assert page == COMPARISON.read_text(encoding="utf-8")


def test_the_folder_of_the_second_drone_stays_small():
    assert sum(path.stat().st_size for path in Path(SECOND).rglob("*") if path.is_file()) < 15_000_000
