"""The map's signs and colours, and the legend that explains them."""

from __future__ import annotations

from collections.abc import Iterable

from scaloft_fi.sim.world import ROLES
from scaloft_fi.views.pictures.picture import FAMILY, text
from scaloft_fi.views.tables.literal import xml

FONT = f"{FAMILY}, Helvetica, Arial, sans-serif"
RAMP = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#a0da39")
"""Viridis without its palest end: even in lightness, safe for colour-blind readers."""
SHADE_MPS = 0.1
"""One colour is a tenth of a metre per second, centred, so that a steady speed keeps one colour."""
INK, FAINT, ROCK, FLOOR = "#22262b", "#6b727b", "#d5d1c9", "#fbfaf7"
THIN = f'stroke="{INK}" stroke-width="1.3"'
HOLES = 'fill-rule="evenodd"'
LINE_STYLE = 'fill="none" stroke-linejoin="round" stroke-linecap="round"'


def body_style(role: str) -> str:
    """How a body of that role is drawn."""
    look = ROLES[role]
    return f'fill="{look.fill}" stroke="{look.stroke}" stroke-width="{look.stroke_px:g}"'


def svg(wide: float, high: float, title: str, parts: Iterable[str], *, font_size: int) -> str:
    """The text of an SVG file `wide` x `high` [px], white behind its parts."""
    box = f'width="{wide:.0f}" height="{high:.0f}" viewBox="0 0 {wide:.0f} {high:.0f}"'
    look = f'font-family="{FONT}" font-size="{font_size}" fill="{INK}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {box} {look} role="img"><title>{xml(title)}</title>'
    return "\n".join([head, '<rect width="100%" height="100%" fill="#ffffff"/>', *parts, "</svg>", ""])


def waypoint(x: float, y: float, radius: float = 9.0) -> str:
    """A dashed ring with a cross."""
    ring = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="none" {THIN} stroke-dasharray="3 2.4"/>'
    return ring + f'<path d="M{x - 4:.1f},{y:.1f}h8M{x:.1f},{y - 4:.1f}v8" {THIN}/>'


def shade(speed_mps: float) -> int:
    """Which colour of `RAMP` a speed has [m/s]."""
    return min(len(RAMP) - 1, round(speed_mps / SHADE_MPS))


def legend(left: float, top: float) -> list[str]:
    """What colours and signs mean, its upper left corner at (left, top) [px]."""
    step = 240.0 / len(RAMP)
    parts = [text(left, top, "speed [m/s]", colour=FAINT, size=12)]
    for i, colour in enumerate(RAMP):
        x = left + i * step
        parts += [f'<rect x="{x:.1f}" y="{top + 9:.1f}" width="{step + 0.5:.1f}" height="10" fill="{colour}"/>']
        label = f"{SHADE_MPS * i:.1f}" + ("+" if i == len(RAMP) - 1 else "")
        parts += [text(x + step / 2, top + 34, label, anchor="middle", colour=FAINT, size=12)]
    return parts + signs(left + 290, top + 15)


def signs(x: float, y: float) -> list[str]:
    """What the signs of bodies and places mean, on a line from (x, y) [px]."""
    parts: list[str] = []
    for name in ("obstacle", "person", "structure"):
        size = 5 if name == "structure" else 12
        parts += [f'<rect x="{x:.1f}" y="{y - size / 2:.1f}" width="{size}" height="{size}" {body_style(name)}/>']
        parts += [text(x + 20, y + 4.5, name, size=12)]
        x += 48 + 7 * len(name)
    parts += [
        waypoint(x + 6, y, 7.0),
        text(x + 20, y + 4.5, "waypoint", size=12),
        text(x + 92, y + 4.5, "H", size=12, weight="bold"),
        text(x + 106, y + 4.5, "home", size=12),
    ]
    return parts
