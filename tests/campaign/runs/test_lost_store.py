"""A run whose store is lost stops at the next save with a sentence, and leaves no process."""

from __future__ import annotations

import io
import multiprocessing
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import plan
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.merge import merge
from scaloft_fi.campaign.runs.run import run
from scaloft_fi.campaign.store.archive import LOG_NAME, STORE_NAME
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise


def _run(study: Any, flyer: Any, *, jobs: int = 1) -> int:
    planned = plan(
        study.grid, (0, 1), [realise(study.matrix, "LATE-human@3s")], realise(study.matrix, "REVERSE-velcmd")
    )
    quiet = Progress(stream=io.StringIO())
    return run(study, planned, study.folder / "c", RunOptions(jobs), progress=quiet, flyer=flyer).flown


@pytest.mark.parametrize(
    "lose",
    [lambda folder: (folder / STORE_NAME).unlink(), shutil.rmtree, lambda folder: folder.rename(f"{folder}-moved")],
    ids=["the file is removed", "the folder is removed", "the folder is renamed"],
)
def test_a_run_stops_at_the_next_save_and_its_copy_is_a_campaign_that_goes_on(
    study: Any, log: Any, lose: Callable[[Path], object]
) -> None:
    folder, rescued = study.folder / "c", study.folder / "c-rescued"

    def losing(flight: Flight, outcome: Outcome) -> Outcome:
        if len(log.flown) >= 5 and (folder / STORE_NAME).exists():
            with suppress(OSError):  # the other process was faster
                lose(folder)
        return outcome

    with pytest.raises(
        InputError, match=rf"the campaign's store is lost: .* flights is in {rescued}, which --campaign"
    ):
        _run(study, replace(log, change=losing), jobs=2)
    assert multiprocessing.active_children() == []
    flown = len(log.flown)
    assert 5 <= flown < 26
    if folder.exists():
        shutil.rmtree(folder)
    with Store(rescued / STORE_NAME, create=False) as store:
        saved = len(store.flights())
    rescued.rename(folder)
    assert _run(study, log) + saved == 25
    assert (folder / LOG_NAME).exists()


def test_a_store_that_is_lost_after_its_last_save_is_noticed_before_any_table(study: Any, log: Any) -> None:
    _run(study, log)
    planned = plan(study.grid, (0, 1), [], None)

    class Losing(Progress):
        def close(self) -> None:
            (study.folder / "c" / STORE_NAME).unlink()

    with pytest.raises(InputError, match=r"store is lost: outcomes.sqlite was removed or renamed; a copy with its 25"):
        run(study, planned, study.folder / "c", RunOptions(1), progress=Losing(stream=io.StringIO()), flyer=log)


def test_a_merge_into_a_store_that_is_lost_says_where_the_copy_is(
    study: Any, log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    _run(study, log)
    put_all = Store.put_all

    def losing(self: Store, rows: Any) -> None:
        self.path.unlink()
        put_all(self, rows)

    monkeypatch.setattr(Store, "put_all", losing)
    with pytest.raises(InputError, match=r"store is lost: .*; a copy with its 25 flights is in .*/all-rescued"):
        merge(study, study.folder / "all", [study.folder / "c"])
