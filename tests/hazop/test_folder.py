from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.hazop import load
from scaloft_fi.hazop.load import FOLDERS, find_study


def study(path: Path) -> Path:
    for name in FOLDERS:
        (path / name).mkdir(parents=True)
    return path


def test_the_nearest_study_upwards_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = study(tmp_path / "mine")
    (here / "results" / "deep").mkdir(parents=True)
    monkeypatch.chdir(here / "results" / "deep")
    assert find_study() == here


def test_outside_a_study_the_packaged_one_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packaged = study(tmp_path / "package" / "_study")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setattr(load, "_PACKAGE", tmp_path / "package")
    assert find_study() == packaged


def test_without_a_packaged_one_the_study_beside_the_package_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkout = study(tmp_path / "checkout")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setattr(load, "_PACKAGE", checkout / "scaloft_fi")
    assert find_study() == checkout


def test_no_study_anywhere_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(load, "_PACKAGE", tmp_path / "scaloft_fi")
    with pytest.raises(InputError, match=r"no study in .* name one with --study"):
        find_study()


def test_a_named_folder_that_is_no_study_says_what_it_lacks(tmp_path: Path) -> None:
    (tmp_path / "hazop").mkdir()
    with pytest.raises(InputError, match=r"must be a folder with hazop/, mutants/ and sim/; it lacks mutants/, sim/"):
        find_study(tmp_path)
    with pytest.raises(InputError, match="it lacks hazop/, mutants/, sim/"):
        find_study(tmp_path / "nowhere")


def test_a_named_study_is_taken_as_it_was_named(tmp_path: Path) -> None:
    assert find_study(str(study(tmp_path / "mine"))) == tmp_path / "mine"
