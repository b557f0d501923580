"""A study whose documents have every key that a loader reads; it is read, never flown."""

from __future__ import annotations

import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OWN = Path(__file__).parent / "every_key_study"
"""What it has of its own; the rest is the reference study's."""


def every_key_study(folder: Path) -> Path:
    """Write the study, and beside its `sim/` folders with `sim/flyer.yaml` and `sim/record.yaml`, which it has not."""
    for name in ("hazop", "mutants"):
        shutil.copytree(ROOT / name, folder / name)
    (folder / "sim").mkdir()
    for name in ("vehicle", "sensors", "stack", "requirements"):
        shutil.copy(ROOT / "sim" / f"{name}.yaml", folder / "sim")
    shutil.copytree(OWN, folder, dirs_exist_ok=True)
    return folder
