"""Does situation coverage predict kills?  Ways to choose situations, compared on the flights of a campaign.

Every way to choose k situations is compared with k random ones: what they cover, how many mutants and how many
different sets of kills they meet.  `experiments.reference` writes the page and the picture beside the others of the
reference campaign.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from experiments import coverage_curves
from experiments.coverage_curves import ARRAYS, ORDERS, RESAMPLES, Band, Curve, Curves, Trial
from scaloft_fi.analysis.score import score_of
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.views.picture import FAINT, FONT, INK, text
from scaloft_fi.views.table import Format, Table, counted, render

FEW_SEEDS = 5
"""Below, the sets of seeds that may come out of a draw are too few for more than a rough interval."""


@dataclass(frozen=True)
class Correlation:
    """Kendall's tau-b of t-way coverage against mutants killed, over random suites.

    Attributes:
        strength: t.
        within: among suites of k = 1, 2, ... situations; None where either number is the same for all of them.
        pooled: over suites of all sizes together: it is high because both grow with the size.
    """

    strength: int
    within: tuple[float | None, ...]
    pooled: float | None

    @property
    def median(self) -> float | None:
        """Of the tau within one size."""
        found = [tau for tau in self.within if tau is not None]
        return float(np.median(found)) if found else None


@dataclass(frozen=True)
class Prediction:
    """What one campaign says about coverage as a predictor.

    Attributes:
        correlations: one per strength.
        sub_cubes: per t, the mutants killed exactly where t axes have certain values: for these, kills at k random
            situations are t-way coverage; None: mutants whose kills are no such block.
        answer: sentences.
    """

    correlations: tuple[Correlation, ...]
    sub_cubes: tuple[tuple[int | None, int], ...]
    answer: tuple[str, ...]


def predict(found: Curves) -> Prediction:
    """Judge a campaign's curves."""
    correlations = correlate(found.trial)
    cubes = _sub_cubes(found.trial)
    return Prediction(correlations, cubes, _answer(found, correlations, cubes))


def correlate(trial: Trial) -> tuple[Correlation, ...]:
    """Kendall's tau-b over the first k situations of random orders, within each k and pooled.

    Within a size only, because size is what both follow (Inozemtseva and Holmes, ICSE 2014); the pooled value is there
    to show how much that is (Simpson's paradox).
    """
    situations = len(trial.situations)
    positions = coverage_curves.random_orders(situations, ORDERS, "correlation")
    killed = coverage_curves.at_sizes(trial.kills, positions)
    found = []
    for strength, combinations, _ in trial.followed:
        covered = coverage_curves.at_sizes(combinations, positions)
        within = tuple(_tau(covered[:, k], killed[:, k]) for k in range(situations))
        found.append(Correlation(strength, within, _tau(covered.ravel(), killed.ravel())))
    return tuple(found)


def _tau(one: np.ndarray, other: np.ndarray) -> float | None:
    from scipy.stats import kendalltau

    if len(set(one.tolist())) < 2 or len(set(other.tolist())) < 2:
        return None
    return float(kendalltau(one, other).statistic)


def _sub_cubes(trial: Trial) -> tuple[tuple[int | None, int], ...]:
    """Over the killed mutants; none at all where the trial lacks a part of the grid, as a block may end outside."""
    if len(trial.situations) < len(trial.space.points):
        return ()
    keys = np.array(trial.situations)
    counts = Counter(coverage_curves.sub_cube(trial.space, keys[row].tolist()) for row in trial.kills if row.any())
    return tuple((t, counts[t]) for t in (*range(len(trial.space.axes) + 1), None) if counts[t])


def _answer(
    found: Curves, correlations: tuple[Correlation, ...], cubes: tuple[tuple[int | None, int], ...]
) -> tuple[str, ...]:
    """Sentences; the last one is the verdict, with what it rests on."""
    trial = found.trial
    size, sets = len(trial.situations), len(trial.kill_sets)
    mutants, places = counted(len(trial.mutants), "default mutant"), counted(size, "situation")
    flown = f"{mutants} of this matrix, flown in the same {places}, have {counted(len(trial.seeds), 'seed')} in common"
    said = [
        f"{flown}; {trial.killed} of them are killed, in {counted(sets, 'different set')} of situations (kill sets)."
    ]
    if trial.unkilled:
        said.append(f"Detected, but killed in no situation and so in no curve: {', '.join(trial.unkilled)}.")
    if not trial.killed or size < 2:
        return (
            *said,
            "Nothing follows about coverage: that needs kills, and so a baseline pool, and situations to choose from.",
        )
    random = found.curve("random")
    arrays = [(strength, curve) for strength in ARRAYS for curve in found.curves if curve.id == f"{strength}-way"]
    said.append(
        "Mutants killed in the same situations share a kill set, which counts once; in parentheses, each mutant."
    )
    said += [_array(strength, curve, random, sets) for strength, curve in arrays]
    said += [_whole(found.curve(name)) for name in ("greedy", "lexicographic")]
    said += [_correlation(one) for one in correlations if one.strength == 2]
    if cubes:
        blocks = sum(count for t, count in cubes if t is not None)
        said.append(
            f"The kills of {blocks} of {trial.killed} mutants are a block of the grid, fixed by t axes: for those the "
            "chance of a kill by k random situations is the expected t-way coverage, by identity."
        )
    return (*said, f"{_verdict(arrays, sets)}  {_carried(trial)}")


def _array(strength: int, curve: Curve, random: Curve, sets: int) -> str:
    k = len(curve.kill_sets.mean)
    covered = dict(curve.t_way).get(strength, (0.0,))[-1]
    by_chance = dict(random.t_way).get(strength, (0.0,) * k)[k - 1]
    worth = f", as many as {curve.matched:.1f} random ones" if curve.matched is not None else ""
    return (
        f"A {strength}-way covering array of {k} situations has {100 * covered:.0f} % of the {strength}-way "
        f"combinations, {k} random situations {100 * by_chance:.0f} %; it meets {curve.kill_sets.mean[-1]:.1f} of "
        f"{counted(sets, 'kill set')} against {random.kill_sets.mean[k - 1]:.1f}{worth}: {_both(curve, k)}."
    )


def _whole(curve: Curve) -> str:
    at = [k for k in (4, 8, 16) if k < len(curve.kill_sets.mean)]
    return f"Kill sets more than in random order, {curve.name}: {', '.join(f'{_both(curve, k)} at {k}' for k in at)}."


def _both(curve: Curve, k: int) -> str:
    return f"{interval(curve.distinct, k)} (mutants {interval(curve.difference, k)})"


def _correlation(one: Correlation) -> str:
    if one.median is None or one.pooled is None:
        return f"Kendall's tau of {one.strength}-way coverage and kills has no value here."
    inside = [tau for tau in one.within if tau is not None]
    return (
        f"Kendall's tau of {one.strength}-way coverage and mutants killed is {one.pooled:.2f} over random suites of "
        f"all sizes together, and {min(inside):.2f} to {max(inside):.2f} (median {one.median:.2f}) among suites of one "
        "size: what lies between is the size of the suites."
    )


def _verdict(arrays: list[tuple[int, Curve]], sets: int) -> str:
    """By whether the intervals of the arrays' differences to random, as they are printed, contain 0."""
    said = "Does coverage predict kills beyond the number of situations?  "
    told = [(t, curve.distinct, len(curve.distinct.mean)) for t, curve in arrays]
    if not told:
        return said + "Not judged: there is no covering array to compare."
    more = sum(round(band.low[-1], 1) > 0 for _, band, _ in told)
    fewer = sum(round(band.high[-1], 1) < 0 for _, band, _ in told)
    some = more or fewer
    meet = f"{some} of {counted(len(told), 'covering array')} meet{'s' * (some == 1)}"
    beside = "kill sets than as many random situations"
    if more and fewer:
        answer = f"Not in one direction: {meet} more {beside}, {fewer} fewer"
    elif some:
        answer = f"Here yes: {meet} more {beside}" if more else f"No: {meet} fewer {beside}"
    else:
        answer = f"Not shown here: {meet} more {beside}, or fewer"
    listed = ", ".join(f"{t}-way with {k} {interval(band, k)}" for t, band, k in told)
    return f"{said}{answer} ({listed}; {counted(sets, 'kill set')} in all)."


def _carried(trial: Trial) -> str:
    """What was sampled, and so what the figures carry."""
    sampled = "the mutants of this matrix within their parameter (or its kill sets)"
    situations = len(trial.situations)
    if trial.seed_sets:
        said = (
            f"The 95 % intervals resample {len(trial.seeds)} seeds and {sampled}: the figures carry to other seeds"
            f"{', roughly as there are so few,' if len(trial.seeds) < FEW_SEEDS else ''} and to mutants like these."
        )
    else:
        said = (
            f"The 95 % intervals resample {sampled}, but no seeds, as the mutants have "
            f"{'only one' if trial.seeds else 'none'} in common: the figures carry to mutants like these, and nothing "
            f"follows beyond {'this seed' if trial.seeds and not trial.more_seeds else 'the seeds flown'}."
        )
    census = (
        f"the {situations} situations are the whole grid, a census and no sample"
        if situations == len(trial.space.points)
        else f"the {situations} situations are those that were flown, no sample of others"
    )
    return f"{said}  They do not carry to another grid or another drone: this is one of each, and {census}."


def interval(band: Band, k: int) -> str:
    """A difference at k situations with its interval."""
    return f"{band.mean[k - 1]:+z.1f} [{band.low[k - 1]:+z.1f}, {band.high[k - 1]:+z.1f}]"


SHOWN = (1, 2, 4, 6, 8, 10, 16, 24, 32)
"""Sizes k in the tables."""
COMPARED = (4, 8, 16)
"""Those at which orders are compared with random order; an array at its own size."""


def curve_tables(found: Curves, prediction: Prediction) -> tuple[Table, ...]:
    """What a person reads: the answer, kills and coverage at k, differences to random, whole orders, correlations."""
    trial = found.trial
    sizes = (*(k for k in SHOWN if k < (every := len(trial.situations))), every)
    answer = Table("Coverage against kills", ("finding",), tuple((sentence,) for sentence in prediction.answer))
    kills = Table(
        "Mutants killed by k situations",
        ("strategy", *(f"k={k}" for k in sizes)),
        tuple((curve.name, *_at(curve.kills.mean, sizes, "{:.1f}")) for curve in found.curves),
        (
            f"Expected kills of {len(trial.mutants)} default mutants in {len(trial.situations)} situations.",
            *(f"{curve.name}: {curve.about}." for curve in found.curves),
            *(f"{name} is missing: {reason}." for name, reason in found.missing),
            *([f"Left out, not flown in all of these situations: {', '.join(trial.left_out)}."] * bool(trial.left_out)),
        ),
    )
    covered = tuple(
        (curve.name, f"{strength}-way", *_at([100 * share for share in shares], sizes, "{:.1f}"))
        for curve in found.curves
        for strength, shares in curve.t_way
    )
    heads = [f"k={k}" for k in sizes]
    coverage = Table("Combinations covered by k situations [%]", ("strategy", "combinations", *heads), covered)
    within = tuple(
        (f"{one.strength}-way", *_at(one.within, sizes, "{:.2f}"), *_at([one.pooled], (1,), "{:.2f}"))
        for one in prediction.correlations
    )
    notes = (
        "Kendall's tau-b of coverage and mutants killed over random suites of k situations.",
        "n/a: all suites of that size cover, or kill, the same number.",
        "Pooled over all sizes it measures the size of the suites: shown beside the others, not to be used.",
    )
    correlations = Table("Coverage and kills within one size", ("coverage", *heads, "pooled"), within, notes)
    return (answer, _differences(found), kills, coverage, _orders(found), correlations)


def _differences(found: Curves) -> Table:
    rows = []
    for curve in found.compared:
        size = len(curve.kills.mean)
        for k in [k for k in COMPARED if k < size] if curve.matched is None else [size]:
            sets, mutants = f"{curve.kill_sets.mean[k - 1]:.1f}", f"{curve.kills.mean[k - 1]:.1f}"
            rows.append((curve.name, k, sets, interval(curve.distinct, k), mutants, interval(curve.difference, k)))
    trial = found.trial
    seeds = "Seeds are not resampled."
    if trial.seed_sets:
        seeds = (
            f"Each is judged by the seeds that come out of {len(trial.seeds)} draws, mostly fewer than were flown, so "
            "intervals need not be centred."
        )
    notes = [
        "More: than as many random situations, paired.  Kill sets: mutants with equal kill sets count once.",
        f"In brackets 95 % intervals over {RESAMPLES} redrawn campaigns.",
        seeds,
        "Mutants are resampled within their parameter, kill sets among each other.",
    ]
    if trial.more_seeds:
        notes.append("Seeds that only some of the mutants were flown with are not resampled.")
    headers = ("strategy", "k", "kill sets", "more kill sets", "mutants", "more mutants")
    return Table("Compared with k random situations", headers, tuple(rows), tuple(notes))


def _orders(found: Curves) -> Table:
    never = len(found.trial.mutants) - found.trial.killed
    rows = []
    for curve in found.curves:
        apfd, *_ = _at([curve.apfd], (1,), "{:.3f}")
        rows.append((curve.name, apfd, f"{curve.area:.3f}", f"{curve.random_area:.3f}", len(curve.kills.mean)))
    notes = (
        f"APFD (average percentage of faults detected) leaves out the {never} mutants killed in no situation.",
        "It has a value for orders of all situations only.",
        "Area: mean share of all mutants killed at k = 1 to the last; compare it with the random area.",
    )
    return Table("Orders as a whole", ("strategy", "APFD", "area", "random area", "last k"), tuple(rows), notes)


def _at(values: Sequence[float | None], sizes: tuple[int, ...], shape: str) -> list[str]:
    told = ["n/a" if value is None else shape.format(value) for value in values]
    return ["" if k > len(told) else told[k - 1] for k in sizes]


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

    def between(self, band: Band, colour: str) -> str:
        """The area of an interval."""
        back = self.points(band.low).split()[::-1]
        return f'<polygon points="{self.points(band.high)} {" ".join(back)}" fill="{colour}" fill-opacity="0.16"/>'

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


STRENGTH = 2
"""The t of the coverage that the picture shows."""


def curve_picture(found: Curves) -> str:
    """The curves as the text of an SVG file."""
    last = len(found.trial.situations)
    shown, told = found.curves, found.compared
    banded = [curve for curve in told if curve.id != "lexicographic"]
    values = [-1.0, 1.0, *(value for curve in told for value in curve.distinct.mean)]
    values += [value for curve in banded for value in (*curve.distinct.low, *curve.distinct.high)]
    most = max(1.0, *(max(curve.kills.mean) for curve in shown))
    steps, spread = _step(most), _step(max(values) - min(values))
    lefts = [LEFT + number * (WIDTH + GAP) for number in range(3)]
    kills = Panel(lefts[0], last, 0.0, _up(most, steps))
    share = Panel(lefts[1], last, 0.0, 100.0)
    more = Panel(lefts[2], last, -_up(-min(values), spread), _up(max(values), spread))
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
        *share.frame(f"{STRENGTH}-way combinations covered", 20.0, " %"),
        *more.frame("kill sets more than by k random situations", spread),
        kills.between(found.spread, "#000000"),
        *_lines(kills, shown, lambda curve: curve.kills.mean),
        *_lines(share, shown, lambda curve: [100 * one for one in dict(curve.t_way).get(STRENGTH, ())]),
        *(more.between(curve.distinct, LOOKS[curve.id][0]) for curve in banded),
        *_lines(more, told, lambda curve: curve.distinct.mean),
        *_legend(shown, TOP + HEIGHT + 66),
    ]
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


NAME = "coverage_against_kills"


def pages(study: Study, campaign: str) -> dict[str, str]:
    """By file name the tables (Markdown) and the picture (SVG) of a campaign.

    Raises:
        InputError: there is no campaign, or no default mutant was flown in it.
    """
    with snapshot(study, campaign) as now:
        rulings, spending = now.rulings, now.spending
    scored = score_of(rulings, study.roster, study.space, spending)
    flown = coverage_curves.trial(scored, rulings, study.roster, study.space, spending)
    if flown is None:
        raise InputError("coverage against kills needs default mutants of credible cells: none was flown")
    followed = coverage_curves.curves(flown)
    tables = render(curve_tables(followed, predict(followed)), Format.MARKDOWN)
    return {f"{NAME}.md": tables, f"{NAME}.svg": curve_picture(followed)}
