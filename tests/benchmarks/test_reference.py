"""Every file of `results/published/reference/` is what today's code makes of the published record."""

from __future__ import annotations

import io
import re
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from openpyxl import load_workbook

from experiments import reference
from experiments.reference import RECORD, REFERENCE
from scaloft_fi.campaign.store.archive import MANIFEST, OUTCOMES
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, pack_track
from scaloft_fi.sim.log import FAR_M
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.dossier import outcome_file
from scaloft_fi.verbs.snapshot import snapshot

MOST_BYTES = 15_000_000
AGAIN = "python -m experiments.reference makes it again"


@cache
def made() -> dict[str, bytes]:
    return reference.pages()


def content(name: str, file: bytes) -> object:
    """What a file says; the bytes of a workbook depend on the version of openpyxl."""
    if not name.endswith(".xlsx"):
        return file
    book = load_workbook(io.BytesIO(file))
    return {sheet.title: list(sheet.iter_rows(values_only=True)) for sheet in book}


def differing(folder: Path) -> list[str]:
    """The files that differ from what is made of the record, or that nothing makes."""
    there = {path.name: path.read_bytes() for path in folder.iterdir() if path.name not in RECORD}
    pages = made()
    return [
        name
        for name in sorted(there.keys() | pages.keys())
        if name not in there or name not in pages or content(name, there[name]) != content(name, pages[name])
    ]


@pytest.mark.release
def test_every_published_file_is_made_again_from_the_record():
    assert differing(REFERENCE) == [], AGAIN
    assert {path.name for path in REFERENCE.iterdir()} >= set(RECORD)


def test_the_folder_stays_small():
    assert sum(path.stat().st_size for path in REFERENCE.iterdir()) < MOST_BYTES


@pytest.mark.parametrize("name", RECORD)
def test_a_hand_edit_of_the_record_is_found(tmp_path: Path, name: str):
    copy = shutil.copytree(REFERENCE, tmp_path / "reference")
    edited = bytearray((copy / name).read_bytes())
    edited[edited.index(b"Linux") if name == MANIFEST else len(edited) // 2] ^= 1
    (copy / name).write_bytes(edited)
    if name == MANIFEST:
        status = reference.call("status", "--campaign", str(copy), "--study", str(reference.ROOT), "--format", "json")
        (cited,) = re.findall(rb"[0-9a-f]{64}", (REFERENCE / "status.md").read_bytes())
        assert cited not in status
    else:
        with pytest.raises(InputError, match=f"{name} is not what was archived"):
            _read_whole(copy)


def _read_whole(folder: Path) -> None:
    with snapshot(Study.open(reference.ROOT), str(folder)) as now:
        now.with_tracks(now.outcomes, lambda one: (one.mutant, one.seed) == ("baseline", 0))


def test_the_columns_that_follow_from_others_are_those_of_todays_code():
    with snapshot(Study.open(reference.ROOT), str(REFERENCE)) as now:
        again = outcome_file(now.outcomes, now.study)
    assert pyarrow.parquet.read_table(io.BytesIO(again)).equals(pyarrow.parquet.read_table(REFERENCE / OUTCOMES))


def test_a_published_trajectory_has_every_second_sample_in_steps_of_two_centimetres():
    moments = [number / 20 for number in range(41)]
    signals = dict.fromkeys(TRACK_COLUMNS, np.full(41, 0.123)) | {"elapsed_s": np.array(moments)}
    signals["person_sight_m"] = np.full(41, FAR_M)
    width = len(TRACK_COLUMNS)
    values = reference.thin(pack_track(signals))
    rows = [dict(zip(TRACK_COLUMNS, values[at : at + width], strict=True)) for at in range(0, len(values), width)]
    assert [row["elapsed_s"] for row in rows] == pytest.approx([0.0, 0.4, 0.8, 1.2, 1.6, 2.0])
    assert {round(row["x_m"], 6) for row in rows} == {0.12}
    assert {row["person_sight_m"] for row in rows} == {FAR_M}
