"""A study whose documents have every key that a loader reads; it is read, never flown."""

from __future__ import annotations

import shutil
from pathlib import Path

from copies import ROOT, copied

OWN = Path(__file__).parent / "every_key_study"
"""What it has of its own; the rest is the reference study's."""


def every_key_study(folder: Path) -> Path:
    """Write the study, and beside its `sim/` folders with `sim/flyer.yaml` and `sim/record.yaml`, which it has not."""
    copied(folder, parts=("hazop", "mutants"))
    (folder / "sim").mkdir()
    for name in ("vehicle", "sensors", "stack", "requirements"):
        shutil.copy(ROOT / "sim" / f"{name}.yaml", folder / "sim")
    shutil.copytree(OWN, folder, dirs_exist_ok=True)
    return folder
