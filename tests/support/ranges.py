"""A study whose cruise speed is a range."""

from __future__ import annotations

from pathlib import Path

CRUISE = """
  C:
    title: cruise speed
    category: operational domain, speed
    range:
      set: mission.cruise_mps
      from: 0.4
      to: 1.2
      unit: m/s
      distribution: uniform
      bins: 4
      benign: 0.5
    realised: eventually(speed_mps >= 0.8 * number)
"""


def with_range(folder: Path, axis: str = CRUISE) -> Path:
    """Add an axis to the situations of a study, or of a `sim` folder; returns the folder."""
    path = next(path for path in (folder / "situations.yaml", folder / "sim" / "situations.yaml") if path.exists())
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("\naliases:", f"{axis}\naliases:", 1), encoding="utf-8")
    return folder
