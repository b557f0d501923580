"""Studies and grids with a range."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from builders import GRID

from scaloft_fi.document import Item
from scaloft_fi.sim.situation import Range, Shape

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


def with_range(folder: Path, axis: str = CRUISE, *, first: bool = False) -> Path:
    """Add an axis to the situations of a study, or of a `sim` folder, as the last or the first; returns the folder."""
    path = next(path for path in (folder / "situations.yaml", folder / "sim" / "situations.yaml") if path.exists())
    text = path.read_text(encoding="utf-8")
    old, new = ("axes:\n", f"axes:{axis}") if first else ("\naliases:", f"{axis}\naliases:")
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return folder


UNIT = Range(
    path="world.light",
    low=0.0,
    high=1.0,
    unit="lx",
    benign=0.25,
    shape=Shape.UNIFORM,
    bins=2,
    item=Item(Path("situations.yaml"), 1, "set", "light"),
)
RANGED = replace(GRID, ranges=(("H", UNIT),))
"""The paper's grid with an axis H that draws numbers from 0 to 0.5 (0) and 0.5 to 1 (1)."""


def drawn(key: str, share: float) -> str:
    """A situation of `RANGED` with a number drawn from its bin of H."""
    return f"{key}={UNIT.draw(int(key[-1]), share):g}"
