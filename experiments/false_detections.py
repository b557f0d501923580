"""Measure how often the verdict detects a fault without effect, and how often a fault with an effect.

    python -m experiments.false_detections [--output FILE]

redraw: seeds of the published baseline pool, judged as a mutant beside ten other seeds of the pool.  planted: synthetic
campaigns of independent flights that violate both requirements at one rate, the same for mutant and pool.  power: a
mutant that violates one requirement at a rate in some of 32 situations in which the pool is steady.  The script flies
nothing, and every arm has its own random stream, so the figures are reproducible.

Bar: in each arm of redraw and planted, at most a share alpha of the draws is detected.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from experiments.flights import outcomes, published
from experiments.pages import blocks, registered, table, write
from scaloft_fi.analysis.detection import ALPHA, LEAST, LOOKS, Pair, Pool, Sample, Spending, detect
from scaloft_fi.analysis.score import redraw
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.study import Study
from scaloft_fi.views.table import counted

SITUATIONS = tuple(f"S{number}" for number in range(32))
NAMES = ("R1", "R2")
RATES = (0.05, 0.1, 0.2, 0.4)
POWER_RATES, POWER_SITUATIONS, NOISES = (0.5, 1.0), (1, 2, 4, 8), (0.0, 0.02)
MUTANT = "a mutant"
GROWN = Spending(ALPHA, frozenset({MUTANT}))
"""The spending of alpha by looks at 1, 3, 5 and 10 seeds."""
SEED = 20252
DRAWS = 2000
"""Of each arm."""


@dataclass(frozen=True)
class Arm:
    """Draws of one kind, and the number of detections among them.

    Attributes:
        kind: redraw, planted or power.
        name: name of the arm, unique within its kind.
        seeds: flights of the mutant in each situation; 0 = a look at each of 1, 3, 5 and 10.
        detected: number of detections among `DRAWS`.
    """

    kind: str
    name: str
    seeds: int
    detected: int

    @property
    def share(self) -> float:
        """Share of the draws that are detected."""
        return self.detected / DRAWS

    @property
    def bounded(self) -> bool:
        """Whether the fault has no effect, so that the bar applies."""
        return self.kind != "power"


def baselines(study: Study) -> list[Outcome]:
    """The published pool."""
    return outcomes(study, (row for row in published() if row["mutant"] == BASELINE))


def redraws(flown: Sequence[Outcome]) -> Iterator[Arm]:
    """Judge baseline seeds as mutants, by safety and by operability requirements."""
    for seeds in LOOKS:
        found = redraw(flown, seeds, ALPHA, DRAWS)
        yield Arm("redraw", "safety", seeds, found.safety.part)
        yield Arm("redraw", "operability", seeds, found.operability.part)


def planted(rate: float, seeds: int) -> Arm:
    """Judge a mutant without effect; every flight violates each requirement at a rate."""
    draw = _stream(1, rate, seeds)
    shape = len(SITUATIONS), len(NAMES)
    number = seeds or LOOKS[-1]
    found = 0
    for _ in range(DRAWS):
        pool = _pool(draw.binomial(LEAST, rate, shape))
        found += _detected(draw.random((*shape, number)) < rate, pool, grown=not seeds)
    return Arm("planted", f"{rate:g}", seeds, found)


def power(rate: float, situations: int, noise: float, seeds: int) -> Arm:
    """Judge a mutant that violates the first requirement at `rate` in some situations, all else at the rate `noise`."""
    draw = _stream(2, rate, situations, noise, seeds)
    rates = np.full((len(SITUATIONS), len(NAMES)), noise)
    rates[:situations, 0] = rate
    found = 0
    for _ in range(DRAWS):
        pool = _pool(draw.binomial(LEAST, noise, rates.shape))
        found += _detected(draw.random((*rates.shape, seeds)) < rates[:, :, None], pool)
    return Arm("power", f"{rate:g} in {counted(situations, 'situation')}, noise {noise:g}", seeds, found)


def _stream(*arm: float) -> np.random.Generator:
    """The random stream of an arm."""
    return np.random.Generator(np.random.PCG64([SEED, *(round(1000 * number) for number in arm)]))


def _pool(violated: NDArray[np.int64]) -> Pool:
    """A pool of ten flights in each situation, without open or vacuous readings."""
    counts = violated.tolist()
    places = itertools.product(enumerate(SITUATIONS), enumerate(NAMES))
    return Pool({(key, n): Pair(key, n, Kind.SAFETY, LEAST, counts[s][r], 0, LEAST) for (s, key), (r, n) in places})


def _detected(violated: NDArray[np.bool_], pool: Pool, *, grown: bool = False) -> bool:
    """The verdict on flights by situation, requirement and seed."""
    by_seed = violated.transpose(0, 2, 1).tolist()
    samples = [
        Sample(key, tuple(tuple(itertools.compress(NAMES, flight)) for flight in flights), infected=True)
        for key, flights in zip(SITUATIONS, by_seed, strict=True)
    ]
    return detect(MUTANT, samples, pool, GROWN if grown else Spending(ALPHA), Kind.SAFETY).detected


def results(study: Study, _jobs: int, _folder: Path) -> str:
    """Judge all arms, and tell."""
    arms = list(redraws(baselines(study)))
    arms += [planted(rate, seeds) for rate in RATES for seeds in (*LOOKS, 0)]
    settings = itertools.product(NOISES, POWER_RATES, POWER_SITUATIONS, LOOKS)
    arms += [power(rate, many, noise, seeds) for noise, rate, many, seeds in settings]
    bounded = [arm for arm in arms if arm.bounded]
    worst, held = max(bounded, key=lambda arm: arm.share), sum(arm.share <= ALPHA for arm in bounded)
    error = 100 * (ALPHA * (1 - ALPHA) / DRAWS) ** 0.5
    parts: list[str | Iterator[str]] = [
        f"""The bar, set before: at most {100 * ALPHA:g} % in every arm whose fault does nothing.  {held} of \
{len(bounded)} arms hold it; the largest share is
{_percent(worst)} ({worst.kind}, {worst.name}).  Independent draws of a share of 1 % have a standard error of \
{error:.2f} percentage points."""
    ]
    for title, heading, kind in SECTIONS:
        parts += [registered("false_detections", heading, "\n\n|"), _table(title, arms, kind)]
    return blocks(*parts)


SECTIONS = (
    ("by", "## Baseline seeds judged as a mutant", "redraw"),
    ("rate", "## Planted rates", "planted"),
    ("rate", "## Power", "power"),
)


def _table(title: str, arms: Sequence[Arm], kind: str) -> Iterator[str]:
    """Arms of one kind: a row for each name, a column for each number of seeds."""
    rows: dict[str, dict[int, str]] = {}
    for arm in arms:
        if arm.kind == kind:
            rows.setdefault(arm.name, {})[arm.seeds] = _percent(arm)
    heads = (counted(seeds, "seed") if seeds else "looks" for seeds in next(iter(rows.values())))
    return table((title, *heads), ((name, *cells.values()) for name, cells in rows.items()))


def _percent(arm: Arm) -> str:
    return f"{100 * arm.share:.2f} %" if arm.bounded else f"{100 * arm.share:.1f} %"


if __name__ == "__main__":
    write(__doc__, "false_detections", results, end="\nThe bar")
