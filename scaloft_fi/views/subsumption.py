"""The subsumption graph as a picture: minimal mutants on the left, what they subsume in layers to the right."""

from __future__ import annotations

from itertools import pairwise

from scaloft_fi.analysis.suite import Node, Subsumption
from scaloft_fi.console import printable
from scaloft_fi.views.picture import FAINT, INK, svg, text
from scaloft_fi.views.table import xml

MARGIN, TOP = 24.0, 92.0
LINE, PAD = 16.0, 8.0
GAP_X, GAP_Y = 72.0, 14.0
CHAR_W = 7.9
"""Widest a letter of the font is on average at size 12 [px]."""
MOST_LINES, LONGEST_NAME = 8, 34
SWEEPS = 4


Box = tuple[float, float, float, float]
"""Left, top, width, height [px]."""
Slot = tuple[int, int, int]
"""What takes a place in a layer: (layer, node, -1), or (layer, above, below) where an edge passes through."""


def draw_subsumption(graph: Subsumption, *, title: str = "What subsumes what") -> str:
    """The graph as the text of an SVG file: layers from left to right (Sugiyama, Tagawa and Toda, 1981)."""
    boxes, wide, high = _places(graph)
    wide = max(wide, 620.0)
    sets = f"{len(graph.nodes)} kill sets, {len(graph.minimal)} minimal (thick frames)"
    parts = [
        text(MARGIN, 34, title, size=20, weight="bold"),
        text(MARGIN, 56, f"{graph.killed} killed mutants, {sets}.", colour=FAINT, size=13),
        text(MARGIN, 74, "What kills a mutant kills those its lines lead to, on the right.", colour=FAINT, size=13),
    ]
    parts += [_edge([boxes[slot] for slot in _way(graph, *edge)]) for edge in graph.edges]
    for node in graph.nodes:
        parts += _box(node, boxes[node.layer, node.node, -1], thick=node.minimal)
    return svg(wide, high, title, parts, font_size=12)


def _way(graph: Subsumption, above: int, below: int) -> list[Slot]:
    """The slots of an edge: of the node above, of the layers between that it passes through, of the node below."""
    first, last = graph.nodes[above].layer, graph.nodes[below].layer
    return [(first, above, -1), *((layer, above, below) for layer in range(first + 1, last)), (last, below, -1)]


def _places(graph: Subsumption) -> tuple[dict[Slot, Box], float, float]:
    """Where everything is, and the size of the picture [px]."""
    layers = _ordered(graph)
    lines = {slot: _lines(graph.nodes[slot[1]]) for members in layers for slot in members if slot[2] < 0}
    heights = {slot: 2 * PAD + LINE * len(lines[slot]) - 4 if slot in lines else 4.0 for own in layers for slot in own}
    tall = [sum(heights[slot] for slot in members) + GAP_Y * (len(members) - 1) for members in layers]
    high = max(tall, default=0.0)
    boxes: dict[Slot, Box] = {}
    x = MARGIN
    for members, own in zip(layers, tall, strict=True):
        width = 2 * PAD + CHAR_W * max(len(line) for slot in members for line in lines.get(slot, ()))
        y = TOP + (high - own) / 2
        for slot in members:
            boxes[slot] = (x, y, width, heights[slot])
            y += heights[slot] + GAP_Y
        x += width + GAP_X
    return boxes, x - GAP_X + MARGIN, TOP + high + MARGIN


def dot(graph: Subsumption) -> str:
    """The graph in the DOT language of Graphviz."""

    def quoted(words: str) -> str:
        return '"' + printable(words).replace("\\", "\\\\").replace('"', '\\"') + '"'

    lines = ["digraph subsumption {", "  rankdir=LR; node [shape=box];"]
    for node in graph.nodes:
        label = quoted("\n".join([*node.mutants, f"killed in {len(node.kills)}"])).replace("\n", "\\n")
        lines.append(f"  n{node.node} [label={label}{', penwidth=3' if node.minimal else ''}];")
    lines += [f"  n{above} -> n{below};" for above, below in graph.edges]
    return "\n".join([*lines, "}", ""])


def _ordered(graph: Subsumption) -> list[list[Slot]]:
    """The layers, each sorted by the mean place of its slots' neighbours, again and again, so that few lines cross."""
    layers: list[list[Slot]] = [[] for _ in {node.layer for node in graph.nodes}]
    for node in graph.nodes:
        layers[node.layer].append((node.layer, node.node, -1))
    near: dict[Slot, list[Slot]] = {slot: [] for members in layers for slot in members}
    for edge in graph.edges:
        way = _way(graph, *edge)
        for slot in way[1:-1]:
            layers[slot[0]].append(slot)
        for slot, following in pairwise(way):
            near.setdefault(slot, []).append(following)
            near.setdefault(following, []).append(slot)
    for _ in range(SWEEPS):
        for members in layers:
            at = {slot: (number + 0.5) / len(each) for each in layers for number, slot in enumerate(each)}
            middle = {s: sum(at[n] for n in near[s]) / len(near[s]) if near[s] else at[s] for s in members}
            members.sort(key=lambda slot: (middle[slot], slot))
    return layers


def _lines(node: Node) -> list[str]:
    kept = node.mutants if len(node.mutants) <= MOST_LINES else node.mutants[: MOST_LINES - 1]
    names = [name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 3] + "..." for name in kept]
    rest = len(node.mutants) - len(kept)
    return [*names, *([f"and {rest} more"] if rest else []), f"killed in {len(node.kills)}"]


def _edge(way: list[Box]) -> str:
    """A line from the right of the first box through the empty ones to an arrow at the left of the last."""
    x, y = way[0][0] + way[0][2], _middle(way[0])
    data = f"M{x:.1f},{y:.1f}"
    for number, box in enumerate(way[1:], start=1):
        last = number == len(way) - 1
        end, level = box[0] - 6 * last, _middle(box)
        bend = (end - x) / 2
        data += f"C{x + bend:.1f},{y:.1f} {end - bend:.1f},{level:.1f} {end:.1f},{level:.1f}"
        x, y = (end, level) if last else (box[0] + box[2], level)
        data += "" if last else f"H{x:.1f}"
    head = f"M{x + 6:.1f},{y:.1f}l-8,-4v8z"
    return f'<path d="{data}" fill="none" stroke="#8b929b" stroke-width="1.2"/><path d="{head}" fill="#8b929b"/>'


def _middle(box: Box) -> float:
    return box[1] + box[3] / 2


def _box(node: Node, box: Box, *, thick: bool) -> list[str]:
    x, y, width, height = box
    frame = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" rx="4"'
    parts = [
        "<g>",
        f"<title>{xml(', '.join(node.mutants))}: killed in {xml(', '.join(sorted(node.kills)))}</title>",
        f'<rect {frame} fill="#ffffff" stroke="{INK}" stroke-width="{3 if thick else 1}"/>',
    ]
    lines = _lines(node)
    for number, words in enumerate(lines):
        last = number == len(lines) - 1
        parts.append(text(x + PAD, y + PAD + LINE * number + 10, words, colour=FAINT if last else "", size=12))
    return [*parts, "</g>"]
