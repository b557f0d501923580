"""The grid of a campaign, and its folder: a name, or a path that the system accepts."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.store.archive import STORE_NAME, campaign_folder
from scaloft_fi.campaign.store.flown_grid import remember_grid, study_of, study_of_all, with_grid
from scaloft_fi.campaign.store.held import Keys
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[3]


def planned(folder: Path, grid: str | None) -> str:
    """A campaign over a grid, with one planned flight; returns its name."""
    study = Study.open(ROOT, grid)
    with Store(folder / STORE_NAME) as store:
        remember_grid(store, study)
        store.plan([Keys(study).planned(Flight(None, study.grid.situations[0], 0))])
    return str(folder)


def test_a_campaign_opens_the_study_with_the_grid_over_which_it_was_flown(tmp_path: Path) -> None:
    wide, paper = planned(tmp_path / "wide", "wide"), planned(tmp_path / "paper", None)
    assert study_of(ROOT, wide).grid_name == "wide"
    assert study_of(ROOT, wide, "wide").grid_name == "wide"
    assert study_of(ROOT, paper).grid_name is None
    assert study_of(ROOT, paper, "paper").grid_name is None


def test_a_campaign_that_does_not_exist_has_the_grid_that_the_user_names(tmp_path: Path) -> None:
    assert study_of(ROOT, str(tmp_path / "none")).grid_name is None
    assert study_of(ROOT, str(tmp_path / "none"), "wide").grid_name == "wide"
    (tmp_path / "empty").mkdir()
    Store(tmp_path / "empty" / STORE_NAME).close()
    assert study_of(ROOT, str(tmp_path / "empty"), "wide").grid_name == "wide"


def test_a_campaign_takes_no_flights_of_another_grid(tmp_path: Path) -> None:
    wide, paper = planned(tmp_path / "wide", "wide"), planned(tmp_path / "paper", None)
    with pytest.raises(InputError, match=r"^--grid=paper: campaign .* was flown over grid 'wide'; name another"):
        study_of(ROOT, wide, "paper")
    with pytest.raises(InputError, match=r"^--grid=wide: campaign .* was flown over grid 'paper'; name another"):
        study_of(ROOT, paper, "wide")


def test_campaigns_are_joined_and_compared_over_one_grid_only(tmp_path: Path) -> None:
    wide, paper = planned(tmp_path / "wide", "wide"), planned(tmp_path / "paper", None)
    new = str(tmp_path / "new")
    assert study_of_all(ROOT, [wide, new]).grid_name == "wide"
    assert study_of_all(ROOT, [paper, new]).grid_name is None
    with pytest.raises(InputError, match=r"over grid 'wide', and .* over 'paper'; only campaigns of one grid"):
        study_of_all(ROOT, [paper, wide])


def test_a_record_that_is_no_name_is_refused(tmp_path: Path) -> None:
    with Store(tmp_path / "c" / STORE_NAME) as store:
        store.set_notes({"grid flown": "[1]"})
    with pytest.raises(InputError, match="must be a record of `run`"):
        study_of(ROOT, str(tmp_path / "c"))


@pytest.mark.parametrize("name", ["../../secret", "", "wid", ".hidden"])
def test_a_record_of_a_grid_that_the_study_lacks_is_one_sentence(tmp_path: Path, name: str) -> None:
    with Store(tmp_path / "c" / STORE_NAME) as store:
        store.set_notes({"grid flown": json.dumps(name)})
        with pytest.raises(InputError, match=r"was flown over grid '.*', which the study lacks"):
            with_grid(Study.open(ROOT), store)


@pytest.mark.parametrize("name", ["~nosuchuser/a", "/" + "a" * 300, "a/b\0", "a" * 256, "é" * 128, "..", " ", "a\0"])
def test_a_name_that_the_system_refuses_is_refused_in_a_sentence(tmp_path, name):
    with pytest.raises(InputError, match=r"^--campaign: name=.* must be the (path|name) of a folder"):
        campaign_folder(Study(tmp_path), name)


def test_a_name_stands_for_a_folder_of_the_results_and_a_path_for_itself(tmp_path):
    assert campaign_folder(Study(tmp_path), "a" * 255).parent == tmp_path / "results" / "campaigns"
    assert campaign_folder(Study(tmp_path), f"{tmp_path}/new") == tmp_path / "new"
