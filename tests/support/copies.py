"""Copies of the reference study, for tests that change one."""

from __future__ import annotations

import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("hazop", "mutants", "sim")


def copied(folder: Path, *without: str, parts: tuple[str, ...] = FOLDERS, study: Path = ROOT) -> Path:
    """Copy a study into a folder, without files and folders of these names; returns the folder."""
    for name in parts:
        shutil.copytree(study / name, folder / name, ignore=shutil.ignore_patterns(*without))
    return folder
