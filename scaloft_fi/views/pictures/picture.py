"""Drawing by hand: from world metres to SVG text, and from SVG to PNG with the one font that travels along."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.views.tables.literal import xml

Point = tuple[float, float]

FONTS = Path(__file__).parent / "fonts"
FAMILY = "Scaloft Map"


@dataclass(frozen=True)
class Frame:
    """From world metres to picture pixels.

    Attributes:
        x0, x1, y0, y1: the part of the world that is shown [m].
        left, top: where its upper left corner is in the picture [px].
        scale: pixels a metre.
    """

    x0: float
    x1: float
    y0: float
    y1: float
    left: float
    top: float
    scale: float

    @property
    def width(self) -> float:
        """Of the picture [px]."""
        return (self.x1 - self.x0) * self.scale

    @property
    def height(self) -> float:
        """Of the picture [px]."""
        return (self.y1 - self.y0) * self.scale

    def pixel(self, point: Point) -> Point:
        """Where `point` [m, world] is in the picture [px]."""
        return self.left + (point[0] - self.x0) * self.scale, self.top + (self.y1 - point[1]) * self.scale

    def at(self, point: Point) -> str:
        """The same as the text `x,y`."""
        x, y = self.pixel(point)
        return f"{x:.1f},{y:.1f}"

    def all(self, points: Iterable[Point]) -> str:
        """Several points as the text of a `points` attribute."""
        return " ".join(self.at(point) for point in points)


def text(
    x: float,
    y: float,
    words: str,
    *,
    anchor: str = "",
    colour: str = "",
    size: int = 0,
    weight: str = "",
    turn: float = 0.0,
) -> str:
    """An SVG text element at (x, y) [px], escaped."""
    looks = (("text-anchor", anchor), ("fill", colour), ("font-size", size), ("font-weight", weight))
    style = "".join(f' {key}="{value}"' for key, value in looks if value)
    turned = f' transform="rotate({turn:g} {x:.1f} {y:.1f})"' if turn else ""
    return f'<text x="{x:.1f}" y="{y:.1f}"{style}{turned}>{xml(words)}</text>'


def png(svg: str, zoom: float = 2.0) -> bytes:
    """The picture of an SVG text, with no font but our own, so that every machine draws the same."""
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=svg,
            zoom=zoom,
            skip_system_fonts=True,
            font_files=[str(FONTS / "map-regular.ttf"), str(FONTS / "map-bold.ttf")],
            font_family=FAMILY,
            sans_serif_family=FAMILY,
        )
    )
