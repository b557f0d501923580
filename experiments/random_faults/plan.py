"""The experiment on random faults: its flights, its rule of decision, and the plan on its page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import comb
from typing import NamedTuple

from scaloft_fi.analysis.score import EARLY_S
from scaloft_fi.judge.outcome import BASELINE

FAULTS = 114
"""As many random faults as there are default mutants of credible cells."""
SEEDS, POOL = 3, 10
"""Seeds of a fault, and of the unmutated drone, in each situation."""
SITUATIONS = 32
FLIGHTS = SITUATIONS * (SEEDS * FAULTS + POOL)
LEVEL = 0.05
"""Two-sided p at which the arms differ."""
REDRAWS = 200
"""How often the seeds are drawn again."""
PERMUTATIONS = 10_000


class Known(NamedTuple):
    """What the published flights say of the default mutants, with three seeds and a pool of ten."""

    infected: int = 111
    tested: int = 106
    detected: int = 32
    trivial: int = 11
    kill_sets: int = 17
    behaviours: int = 98

    @property
    def useful(self) -> int:
        """Detected and not trivial."""
        return self.detected - self.trivial


KNOWN = Known()


def names_of(faults: Sequence[str], situations: Sequence[str], draws: int | None = None) -> Iterator[str]:
    """Yield the names of the flights: of the first `draws` draws of seed and situation, or of all."""
    pairs = [(seed, key) for seed in range(POOL) for key in situations]
    for seed, key in pairs[:draws]:
        for subject in (BASELINE, *(faults if seed < SEEDS else ())):
            yield f"{subject}/{key}/{seed}"


def fisher(one: int, of_one: int, other: int, of_other: int) -> float:
    """Two-sided p of Fisher's exact test: all tables with these margins that are no more probable than this one.

    >>> round(fisher(3, 3, 0, 3), 6), fisher(2, 4, 2, 4)
    (0.1, 1.0)
    """
    total = one + other
    ways = {k: comb(of_one, k) * comb(of_other, total - k) for k in range(total + 1)}
    return sum(own for own in ways.values() if own <= ways[one]) / sum(ways.values())


def decided(known: int) -> tuple[int, int]:
    """The most random faults at which HAZOP's `known` are significantly more, and the least at which they are fewer."""
    fewer = [n for n in range(known) if fisher(known, FAULTS, n, FAULTS) <= LEVEL]
    more = [n for n in range(known, FAULTS + 1) if fisher(known, FAULTS, n, FAULTS) <= LEVEL]
    return max(fewer), min(more)


MOST, LEAST = decided(KNOWN.useful)
SIMULATED_S = 508_000
"""Of the default mutants and their pool in the published flights [s, simulated]."""
SPEED = 125
"""Simulated seconds per processor second."""

LARGEST = "126 s, 11.5 m, 27.6 m/s2, 25.2 m/s, 3.14 rad, 21.9 rad/s, 360 deg, 10.3 N, 16.8 V, 4 EV"
"""The largest magnitudes, as the page tells them."""

PLAN = f"""# Random faults beside the faults of the deviation matrix

Question, faults, definitions and rule were written down, and committed without the section *Flown*, before
the random faults were flown; to test the script they were flown in one situation with one seed,
where 83 changed a sample, 50 the flight, and 4 struck something; nothing below was changed because of it.  Made by
`python -m experiments.random_faults`.

**The question.**  A HAZOP study asks experts for credible deviations.  Does that choose better faults to test with than
a draw at random from the same seams with the same operators?

**What is known already.**  The default mutants have been flown and published: this is no blind test for their arm.
With three seeds and a pool of ten {KNOWN.detected} of {FAULTS} are detected (36 with a pool of 50).
{KNOWN.trivial} of these are trivial by the definition below, so {KNOWN.useful} are useful.
{KNOWN.infected} change a sample, {KNOWN.tested} are put to the test.
They have {KNOWN.kill_sets} different sets of kills, and {KNOWN.behaviours} different vectors of digests besides that \
of the baseline.
The definition of *trivial* came with the question, before these figures were computed; the rule was chosen after it.
The drawn faults were read, and the rule for their times was changed once, before any of them was flown.  Operators, and
the seams themselves, were made for cells of the matrix: random faults use a vocabulary that HAZOP wrote, so a
difference is what the choice of seam, operator, magnitude and time adds, and no more.

## Arms and flights

- **HAZOP**: the default mutant of each of the {FAULTS} credible cells.  They are not flown again:
  seeds 0 to {SEEDS - 1}, and the first {POOL} of the pool, in `results/published/reference/outcomes.parquet`.
- **Random**: the {FAULTS} faults of `experiments/random_faults/faults.jsonl`, drawn by `draw.py` there from named
  streams of random numbers; a fault that was drawn before is drawn anew.
  - *Seam*: each of the stack's with equal probability.  *Operator*: each that fits the seam's message.
  - *Arguments*: a declared range within the largest magnitude of its unit (a share, an angle in degrees) uniformly.
    Factors log-uniformly from 1/1000 to 1000; a number with two positive bounds log-uniformly between them; any other
    magnitude log-uniformly over the three decades up to the largest of its unit, of either sign where
    allowed.  The largest follow from what mine, vehicle, sensors and stack declare (`quantities.py`):
    {LARGEST};
    1 for plain numbers, the seam's rate for rates.
  - *Time*, where the operator takes one: uniform over the shortest nominal mission; else from take-off to the end.
  - No ladder, default or cell of the matrix enters.  Three decades and equal probabilities are assumptions.
- **Flights**: {SITUATIONS} situations of the paper's grid x ({SEEDS} seeds x {FAULTS} faults + {POOL} baselines) = \
{FLIGHTS:,}.
- **Time**: a fault shares its baseline up to its first altered sample.  The default mutants and their pool took
  {SIMULATED_S:,} simulated s, or {round(SIMULATED_S / SPEED / 60)} minutes of processor time at {SPEED} simulated s \
per processor second.

## Definitions

- *Detected*: the verdict of the score, by its own functions: the exact stratified test against the pool, Holm over SR1
  and SR2, alpha 0.01.  Safety requirements only.  A *kill* is a steady pair of situation and requirement in which most
  flights of a detected fault violate.
- *Trivial*: detected, and killed in at least nine tenths of the situations that put it to the test (steady, and the
  fault changes a sample there), or with a kill whose earliest violation comes within {EARLY_S:g} s of take-off.
- *Useful*: detected and not trivial.
- *Distinct*: the different sets of kills among the detected, the empty set not counted; and the different vectors of
  digests over all flights of a fault, the baseline's not counted.

## Rule

1. The arms are compared by the number of *useful* faults: Fisher's exact test, two-sided, of {FAULTS} each.
   HAZOP is **better** if p is at most {LEVEL:g} and it has more: at most {MOST} random ones beside its {KNOWN.useful};
   **worse** if p is at most {LEVEL:g} and it has fewer: {LEAST} random ones or more;
   else **no difference is shown**, which does not say that there is none: the test sees about a factor of two.
2. Beside it, deciding nothing: the same test for the detected faults and for the trivial of the detected; a permutation
   test ({PERMUTATIONS:,} exchanges of the arms' labels) for the different sets of kills.
3. Seeds are drawn again {REDRAWS} times with replacement, for faults and pool, the same ones in both arms; the
   middle nine tenths of each number are shown.  Seeds that come twice make the test less strict, so these are
   spreads, no limits.
4. The rule is decided only if every flight was flown, and each pair of situation and safety requirement has the same
   state (steady, unsteady, red, vacuous, open) in the pools of both arms.  Amended before any of these flights: equal
   digests of the baselines were asked for, and these depend on how the processor's kernels round.  A flight whose
   harness fails is told of and counts as the score counts it; a stack that raises an error is a fact about the drone,
   and the faults that make it do so are counted.

Both arms are reported, and every fault, whatever they show.
"""
