"""Coverage against kills as one picture: kills, coverage, and kill sets beside those of random situations, over k."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

from experiments.coverage_against_kills.curves import Curve, Curves
from scaloft_fi.views.picture import FAINT, FONT, INK, text

WIDTH, HEIGHT, LEFT, TOP, GAP, LINE = 330.0, 260.0, 62.0, 108.0, 76.0, 19.0

AREAS = (
    "Expected values at equal k; areas: 5 to 95 % of random orders (left), 95 % over redrawn campaigns (right).  "
    "Mutants that are killed in the same situations have one kill set."
)
LOOKS = {
    "random": ("#000000", "", ""),
    "draws": ("#6b727b", "2 4", ""),
    "lexicographic": ("#d55e00", "7 3 2 3", ""),
    "greedy": ("#009e73", "9 3", ""),
    "2-way": ("#0072b2", "", "circle"),
    "3-way": ("#cc79a7", "", "square"),
    "4-way": ("#e69f00", "", "triangle"),
    "oracle": ("#000000", "1 3", ""),
}
"""Colour (Okabe and Ito, told apart by colour-blind readers), dashes and end mark: no two differ by colour alone."""


@dataclass(frozen=True)
class Panel:
    """A diagram over k = 1 to `last`.  left: of its frame [px]; low, high: the values at its lower and upper edge."""

    left: float
    last: int
    low: float
    high: float

    def x(self, k: float) -> float:
        """Where k is [px]."""
        return self.left + (k - 1) / max(1, self.last - 1) * WIDTH

    def y(self, value: float) -> float:
        """Where a value is [px]."""
        return TOP + (self.high - value) / (self.high - self.low) * HEIGHT

    def points(self, values: Sequence[float]) -> str:
        """The values at k = 1, 2, ... as a `points` attribute."""
        return " ".join(f"{self.x(k):.1f},{self.y(value):.1f}" for k, value in enumerate(values, start=1))

    def between(self, low: Sequence[float], high: Sequence[float], colour: str) -> str:
        """The area between two curves."""
        back = self.points(low).split()[::-1]
        return f'<polygon points="{self.points(high)} {" ".join(back)}" fill="{colour}" fill-opacity="0.16"/>'

    def frame(self, title: str, step: float, unit: str = "") -> Iterator[str]:
        """Title, axes and their numbers."""
        yield text(self.left, TOP - 14, title, weight="bold", size=14)
        value = self.low
        while value <= self.high + 1e-9:
            y = self.y(value)
            strong = abs(value) < 1e-9
            yield f'<path d="M{self.left:.1f},{y:.1f}h{WIDTH:.1f}" stroke="{INK if strong else "#d9dce0"}"/>'
            yield text(self.left - 8, y + 4, f"{value:g}{unit}", anchor="end", colour=FAINT, size=12)
            value += step
        every = next(n for n in (1, 2, 4, 5, 8, 10, 20, 50, 100, 10**6) if self.last / n <= 9)
        for k in sorted({1, *range(every, self.last + 1, every)}):
            yield text(self.x(k), TOP + HEIGHT + 18, str(k), anchor="middle", colour=FAINT, size=12)
        yield text(self.left + WIDTH / 2, TOP + HEIGHT + 38, "situations k", anchor="middle", colour=FAINT, size=12)


def curve_picture(found: Curves, *, strength: int = 2) -> str:
    """The curves as the text of an SVG file.

    Args:
        found: the curves.
        strength: the t of the coverage that is shown.
    """
    last = len(found.trial.situations)
    shown = [curve for curve in found.curves if curve.id in LOOKS]
    told = [curve for curve in shown if curve.distinct and not curve.oracle]
    banded = [curve.distinct for curve in told if curve.distinct and curve.id != "lexicographic"]
    lows = [value for curve in told if curve.distinct for value in curve.distinct.mean]
    highs = [*lows, *(value for band in banded for value in band.high)]
    lows += [value for band in banded for value in band.low]
    most = max(1.0, *(max(curve.kills.mean) for curve in shown))
    steps = _step(most)
    spread = _step(max([1.0, *highs]) - min([-1.0, *lows]))
    lefts = [LEFT + number * (WIDTH + GAP) for number in range(3)]
    kills = Panel(lefts[0], last, 0.0, _up(most, steps))
    share = Panel(lefts[1], last, 0.0, 100.0)
    more = Panel(lefts[2], last, -_up(-min([-1.0, *lows]), spread), _up(max([1.0, *highs]), spread))
    rows = (len(shown) + 2) // 2
    wide, high = lefts[2] + WIDTH + 30, TOP + HEIGHT + 66 + rows * LINE + 22
    title = f"Coverage against kills: {len(found.trial.mutants)} mutants, {last} situations"
    box = f'width="{wide:.0f}" height="{high:.0f}" viewBox="0 0 {wide:.0f} {high:.0f}" role="img"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {box} font-family="{FONT}" font-size="13" fill="{INK}">',
        f"<title>{escape(title)}</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        text(LEFT - 40, 34, title, size=20, weight="bold"),
        text(LEFT - 40, 58, AREAS),
        *kills.frame("mutants killed", steps),
        *share.frame(f"{strength}-way combinations covered", 20.0, " %"),
        *more.frame("kill sets more than by k random situations", spread),
        kills.between(found.spread.low, found.spread.high, "#000000"),
        *_lines(kills, shown, lambda curve: curve.kills.mean),
        *_lines(share, shown, lambda curve: [100 * one for one in dict(curve.t_way).get(strength, ())]),
    ]
    parts += [
        more.between(curve.distinct.low, curve.distinct.high, LOOKS[curve.id][0])
        for curve in told
        if curve.distinct in banded
    ]
    parts += _lines(more, told, lambda curve: curve.distinct.mean if curve.distinct else ())
    parts += _legend(shown, TOP + HEIGHT + 66)
    return "\n".join([*parts, "</svg>", ""])


def _lines(panel: Panel, shown: Sequence[Curve], values: Callable[[Curve], Sequence[float]]) -> Iterator[str]:
    for curve in shown:
        colour, dashes, mark = LOOKS[curve.id]
        heights = values(curve)
        if heights:
            yield _line(panel.points(heights), colour, dashes)
            yield _mark(panel.x(len(heights)), panel.y(heights[-1]), colour, mark)


def _line(points: str, colour: str, dashes: str) -> str:
    style = f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.8" stroke-linejoin="round"{style}/>'
    )


def _mark(x: float, y: float, colour: str, mark: str) -> str:
    shapes = {
        "circle": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5"',
        "square": f'<rect x="{x - 4:.1f}" y="{y - 4:.1f}" width="8" height="8"',
        "triangle": f'<path d="M{x:.1f},{y - 5:.1f}l5,9h-10z"',
    }
    return f'{shapes[mark]} fill="{colour}" stroke="#ffffff"/>' if mark else ""


def _legend(shown: Sequence[Curve], top: float) -> Iterator[str]:
    """Names and meanings in two columns."""
    rows = (len(shown) + 1) // 2
    for number, curve in enumerate(shown):
        colour, dashes, mark = LOOKS[curve.id]
        x, y = LEFT - 40 + number // rows * 590, top + number % rows * LINE
        yield _line(f"{x:.1f},{y:.1f} {x + 34:.1f},{y:.1f}", colour, dashes)
        yield _mark(x + 34, y, colour, mark)
        yield text(x + 46, y + 4.5, f"{curve.name}: {curve.about}", size=12)


def _step(span: float) -> float:
    """A round distance of grid lines that gives about six of them."""
    power = 1.0
    while span / power > 60:
        power *= 10
    return next(step * power for step in (0.5, 1.0, 2.0, 5.0, 10.0) if span / (step * power) <= 7)


def _up(value: float, step: float) -> float:
    """The next multiple of a step from `value` on."""
    return -(-value // step) * step
