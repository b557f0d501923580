"""The Karnaugh map as a picture: states by words and hatching, each term of the condition an outline of its own."""

from __future__ import annotations

from html import escape
from itertools import groupby

from scaloft_fi.analysis.kills.karnaugh import Block, KarnaughMap
from scaloft_fi.analysis.kills.kill_matrix import NOT_FLOWN, Entry, Row
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.judge.status import Status
from scaloft_fi.views.pictures.picture import text
from scaloft_fi.views.pictures.symbols import FAINT, FONT, INK

CELL_W, CELL_H = 92.0, 54.0
STRIP_W, STRIP_H = 92.0, 22.0
MARGIN, TOP = 24.0, 84.0
LINE = 20.0
INSETS = (3.5, 6.2, 8.9, 11.6, 14.3, 17.0)
LONGEST_WORD = 15

OUTLINES = (
    ("#b5179e", ""),
    ("#1d4ed8", "9 4"),
    ("#b45309", "3 3"),
    ("#0f766e", "12 3 3 3"),
    ("#7c3aed", "5 7"),
    ("#334155", "16 4"),
)
"""Colour and dashes of an outline; the letter beside it says the same without either."""

KILLED, SEEN = "killed", "seen"
"""What a situation with a kill is called, and one where some flight violates a steady requirement without one."""
FILLS = {
    KILLED: (INK, "#ffffff", ""),
    SEEN: ("#d6d3d1", INK, ""),
    Status.REVEALED.value: ("#ffffff", INK, "cross"),
    Status.SURVIVED.value: ("#ffffff", INK, ""),
    Status.MASKED.value: ("#ffffff", INK, "dots"),
    Status.NOT_INFECTED.value: ("#ffffff", INK, "rising"),
    Status.NOT_REACHED.value: ("#ffffff", INK, "falling"),
    Status.BASELINE_RED.value: ("#ffffff", INK, "cross"),
    Status.INVALID.value: ("#e7e5e4", INK, ""),
    NOT_FLOWN: ("#e7e5e4", FAINT, ""),
}
"""Per state, `killed` or `seen` the fill, the ink and the hatching."""

_TILES = {
    "dots": '<circle cx="4" cy="4" r="1.1" fill="#9ca3af"/>',
    "rising": '<path d="M0,8L8,0" stroke="#c3c7cd"/>',
    "falling": '<path d="M0,0L8,8" stroke="#8b929b"/>',
    "cross": '<path d="M0,0L8,8M0,8L8,0" stroke="#c2694f"/>',
}
PATTERNS = "\n".join(
    [
        "<defs>",
        *(
            f'<pattern id="{name}" width="8" height="8" patternUnits="userSpaceOnUse">{tile}</pattern>'
            for name, tile in _TILES.items()
        ),
        "</defs>",
    ]
)
"""The hatchings, by name."""


def draw_karnaugh(space: Space, found: KarnaughMap, row: Row) -> str:
    """The map as the text of an SVG file."""
    left = MARGIN + STRIP_W * len(found.down)
    top = TOP + STRIP_H * len(found.across)
    width = left + CELL_W * len(found.columns) + MARGIN
    below = top + CELL_H * len(found.rows) + 44
    letters = [_letter(number) for number in range(len(found.blocks))]
    height = below + LINE * max(len(found.blocks), 1) + 6
    title = f"Where {found.mutant} is killed"
    box = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {box} font-family="{FONT}" font-size="13" fill="{INK}" role="img">',
        f"<title>{escape(title)}: {escape(found.condition or 'nowhere')}</title>",
        PATTERNS,
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        text(MARGIN, 34, title, size=20, weight="bold"),
        text(MARGIN, 58, _reading(found), colour=FAINT, size=13),
    ]
    parts += _strips(space, found, left, top)
    entries = {entry.situation: entry for entry in row.entries}
    for r, keys in enumerate(found.keys):
        for c, key in enumerate(keys):
            parts += _cell(left + c * CELL_W, top + r * CELL_H, key, entries.get(key or ""))
    for number, block in enumerate(found.blocks):
        parts += _outline(found, block, number, left, top)
    if not found.blocks:
        parts.append(text(MARGIN, below, "Killed nowhere.", size=14))
    for number, block in enumerate(found.blocks):
        y = below + number * LINE
        colour, dashes = OUTLINES[number % len(OUTLINES)]
        parts.append(_path(f"M{MARGIN:.1f},{y - 4.5:.1f}h34", colour, dashes))
        parts.append(text(MARGIN + 44, y, f"{letters[number]}:", size=14, weight="bold"))
        parts.append(text(MARGIN + 66, y, block.words, size=14))
    return "\n".join([*parts, "</svg>", ""])


def _letter(number: int) -> str:
    """A, B, ... Z, then A1, B1.

    >>> _letter(1), _letter(27)
    ('B', 'B1')
    """
    return chr(ord("A") + number % 26) + (str(number // 26) if number >= 26 else "")


def _strips(space: Space, found: KarnaughMap, left: float, top: float) -> list[str]:
    """Per axis a strip of its values, runs joined; the benign value white, others tinted."""
    parts = []
    for place, axis in enumerate(found.across):
        y = top - STRIP_H * (len(found.across) - place)
        for start, length, value in _runs(found.columns, place):
            parts += _tag(space, axis, value, left + start * CELL_W, y, length * CELL_W, STRIP_H)
        parts.append(
            text(left - 8, y + STRIP_H / 2 + 4.5, space.axes[axis][:LONGEST_WORD], anchor="end", weight="bold")
        )
    for place, axis in enumerate(found.down):
        x = left - STRIP_W * (len(found.down) - place)
        for start, length, value in _runs(found.rows, place):
            parts += _tag(space, axis, value, x, top + start * CELL_H, STRIP_W, length * CELL_H)
        name = space.axes[axis][:LONGEST_WORD]
        parts.append(text(x + STRIP_W / 2, top + CELL_H * len(found.rows) + 15, name, anchor="middle", weight="bold"))
    return parts


def _runs(side: tuple[Point, ...], place: int) -> list[tuple[int, int, str]]:
    """(start, length, value) of equal neighbouring values of an axis along a side."""
    found, start = [], 0
    for value, members in groupby(point[place] for point in side):
        length = len(list(members))
        found.append((start, length, value))
        start += length
    return found


def _tag(space: Space, axis: int, value: str, x: float, y: float, width: float, height: float) -> list[str]:
    words = space.word(axis, value)
    fill = "#ffffff" if value == space.values[axis][0] else "#dbe0e6"
    rect = f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" fill="{fill}" stroke="{FAINT}"/>'
    label = text(x + width / 2, y + height / 2 + 4.5, _short(words), anchor="middle", size=12)
    return ["<g>", f"<title>{escape(space.axes[axis])}: {escape(words)}</title>", rect, label, "</g>"]


def _short(words: str) -> str:
    return words if len(words) <= LONGEST_WORD else words[: LONGEST_WORD - 3] + "..."


def _cell(x: float, y: float, key: str | None, entry: Entry | None) -> list[str]:
    box = f'x="{x:.1f}" y="{y:.1f}" width="{CELL_W:.1f}" height="{CELL_H:.1f}"'
    if key is None or entry is None:
        return [f'<rect {box} fill="#f5f5f4" stroke="{FAINT}" stroke-dasharray="2 3"/>']
    told = KILLED if entry.kills else SEEN if entry.seen else entry.state
    fill, ink, hatch = FILLS[told]
    words, names = told.replace("_", " "), entry.kills or entry.seen
    violated = dict(entry.violated)
    count = f"{max(violated[name] for name in names)} of {entry.flown}" if names and entry.flown > 1 else ""
    by = ", ".join(f"{name} violated in {violated[name]} of {entry.flown} flights" for name in names)
    spared = "" if entry.tested or not entry.infected else "no safety requirement is steady here"
    about = ", ".join(filter(None, (f"{key}: {words}", by, spared)))
    parts = ["<g>", f"<title>{escape(about)}</title>", f'<rect {box} fill="{fill}" stroke="{FAINT}"/>']
    middle = y + CELL_H / 2
    if hatch:
        parts.append(f'<rect {box} fill="url(#{hatch})"/>')
        wide = 6.4 * len(words) + 6
        plate = f'x="{x + (CELL_W - wide) / 2:.1f}" y="{middle - 10:.1f}" width="{wide:.1f}" height="19"'
        parts.append(f'<rect {plate} rx="3" fill="{fill}"/>')
    weight = "bold" if entry.kills else ""
    up = 3 if count else -4.5
    parts.append(text(x + CELL_W / 2, middle - up, words, anchor="middle", colour=ink, size=12, weight=weight))
    if count:
        parts.append(text(x + CELL_W / 2, middle + 13, count, anchor="middle", colour=ink, size=11))
    return [*parts, "</g>"]


def _reading(found: KarnaughMap) -> str:
    """How the map is read."""
    meet = _cyclic(found.rows) and _cyclic(found.columns)
    return "Karnaugh map: neighbours differ on one axis" + (", opposite edges meet." if meet else ".")


def _cyclic(side: tuple[Point, ...]) -> bool:
    """Whether the last place of a side is a neighbour of the first."""
    return sum(a != b for a, b in zip(side[0], side[-1], strict=True)) <= 1


def _outline(found: KarnaughMap, block: Block, number: int, left: float, top: float) -> list[str]:
    """Around each part of the block; open where it goes on at the opposite edge."""
    inset = INSETS[number % len(INSETS)]
    colour, dashes = OUTLINES[number % len(OUTLINES)]
    rows, columns = ({place[side] for place in block.places} for side in (0, 1))
    lines = []
    for r, c in sorted(block.places):
        north, south = (_shut(r, step, rows, found.rows) for step in (-1, 1))
        west, east = (_shut(c, step, columns, found.columns) for step in (-1, 1))
        x0, x1 = left + c * CELL_W + inset * west, left + (c + 1) * CELL_W - inset * east
        y0, y1 = top + r * CELL_H + inset * north, top + (r + 1) * CELL_H - inset * south
        lines += [f"M{x0:.1f},{y:.1f}H{x1:.1f}" for y, shut in ((y0, north), (y1, south)) if shut]
        lines += [f"M{x:.1f},{y0:.1f}V{y1:.1f}" for x, shut in ((x0, west), (x1, east)) if shut]
    r, c = min(block.places)
    label_x, label_y = left + c * CELL_W + 5 + 12 * (number % 6), top + r * CELL_H + 15
    halo = 'stroke="#ffffff" stroke-width="3" paint-order="stroke"'
    letter = text(label_x, label_y, _letter(number), colour=colour, size=12, weight="bold")
    return [_path("".join(lines), colour, dashes), letter.replace("<text ", f"<text {halo} ", 1)]


def _shut(place: int, step: int, taken: set[int], side: tuple[Point, ...]) -> bool:
    """Whether a block, `taken` along a side, ends between a place and the next; all of a side has both ends shut."""
    beyond = place + step
    if 0 <= beyond < len(side):
        return beyond not in taken
    return not _cyclic(side) or len(taken) == len(side) or beyond % len(side) not in taken


def _path(data: str, colour: str, dashes: str) -> str:
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    halo = f'<path d="{data}" fill="none" stroke="#ffffff" stroke-width="4.4"/>'
    return f'{halo}<path d="{data}" fill="none" stroke="{colour}" stroke-width="2.4"{dashed}/>'
