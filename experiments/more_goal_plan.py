"""The experiment on MORE-goal: its arms, the flights of each arm, and the plan on its page."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

from experiments.operating_point import CRUISE, LIGHT, NO_TURN
from scaloft_fi.analysis.detection import ALPHA
from scaloft_fi.judge.outcome import BASELINE

CRUISES_MPS = (0.5, 1.0, 1.2)
MUTANTS = ("MORE-goal@0.3m", "MORE-goal@0.6m", "MORE-goal@1m", "MORE-goal@3m")
"""The ladder of the cell."""
SUBJECTS = (BASELINE, *MUTANTS)
SEEDS = tuple(range(10))
DRAWS = len(LIGHT) * len(SEEDS)


class Arm(NamedTuple):
    """An arm: whether the planner turns before it moves, and the cruise speed [m/s]."""

    turns_first: bool
    cruise_mps: float

    @property
    def name(self) -> str:
        """As the page and the file of flights name it."""
        return f"{'turning first' if self.turns_first else 'not turning first'}, {self.cruise_mps:g} m/s"

    @property
    def overrides(self) -> tuple[tuple[str, float], ...]:
        """The changed numbers of the study."""
        return ((CRUISE, self.cruise_mps), *(() if self.turns_first else NO_TURN.items()))


ARMS = tuple(Arm(turns_first, cruise_mps) for turns_first in (True, False) for cruise_mps in CRUISES_MPS)
AS_IT_IS, NOT_TURNING = Arm(turns_first=True, cruise_mps=0.5), Arm(turns_first=False, cruise_mps=0.5)
"""The study as it is, and the same without turning first: the two arms of the rule for the stack."""
FLIGHTS = len(ARMS) * len(SUBJECTS) * DRAWS


def names_of(draws: int = DRAWS) -> Iterator[str]:
    """Yield the names of an arm's flights: of its first draws, in the order of their seeds."""
    for seed, key in itertools.islice(itertools.product(SEEDS, LIGHT), draws):
        yield from (f"{subject}/{key}/{seed}" for subject in SUBJECTS)


TESTS = len(ARMS) * len(MUTANTS)
STRICT = ALPHA / TESTS
"""What p is compared with where all arms and magnitudes together decide."""
SIMULATED_S = 246
"""Length of a draw at 0.5 m/s, from the 48 light draws of `paper.csv`: the baseline, and each mutant from its first
altered sample on [s, simulated]."""
SPEED = 125
"""Simulated seconds per processor second."""
_MOST_S = len(ARMS) * DRAWS * SIMULATED_S

PLAN = f"""# MORE-goal, with and without turning first, at three speeds

Questions, arms and rules were written down, and committed without the section *Flown*, before these flights were flown.
Made by `python -m experiments.more_goal`.

**The question.**  The paper raised the goal threshold, by an amount that it does not state, and saw its drone collide
before the next waypoint (SR1).  In the reference study no magnitude of MORE-goal does so.  Two assumptions may hide it:
the planner slows down where the way is off the camera's axis and turns on the spot from 0.5 rad on, and the mission
flies at 0.5 m/s.  Is MORE-goal shown if either is changed, and what do the changes do to the unmutated drone?

**What is known already.**  This is no blind test.  In `operating_point.md`, without turning first at 0.5 m/s, SR1
reveals MORE-goal@1m in 8 of 8 turning missions without a person (wall near (-1.9, 9.0) m), @3m in 2, @0.6m in none;
30 of 32 light baselines hold SR1, and 0 of 16 with a person hold SR2.  At a cruise of 1.0 m/s 16 of 16 light baselines
hold SR1 and SR2, at 1.2 m/s 14.  With turning first at 0.5 m/s `paper_table.md` has 0 of 4 magnitudes detected.  An
earlier look without a plan, with turning first, saw no strike in 252 further flights at 0.5 and 1.0 m/s, and at 1.2 m/s
2 of 8 with 2 m and with 3 m.  Flights of these looks are among those below; without turning first seeds 2 to 9 are new.
So rule 2 probably finds MORE-goal@1m without turning first, and rule 4 probably keeps the stack.

## Arms and flights

- **Arms**, {len(ARMS)}: turning first, as the stack has it, or not
  (`{"`, `".join(NO_TURN)}` above any angle); a cruise speed
  (`{CRUISE}`) of {", ".join(f"{speed:g}" for speed in CRUISES_MPS)} m/s.  Nothing else is changed.  Once the drone \
detects a person it flies at
  0.2 m/s to the end in every arm; OP1's time limit follows from the cruise speed.
- **Flights**: {len(ARMS)} arms x {len(SUBJECTS)} subjects (the baseline, {", ".join(MUTANTS)})
  x {len(LIGHT)} light situations x {len(SEEDS)} seeds ({SEEDS[0]} to {SEEDS[-1]}) = {FLIGHTS:,}; an arm has {DRAWS} \
draws of situation and seed.
- **Time**: a mutant shares its baseline up to its first altered sample, with the digest of a whole flight.  A draw
  takes {SIMULATED_S} simulated s at 0.5 m/s and less at higher speeds: in all at most about {round(_MOST_S, -3):,} \
simulated s, or
  {round(_MOST_S / SPEED / 60)} minutes of processor time at {SPEED} simulated s per processor second.

## Counted, in each arm

- **Baselines**: how many of the {DRAWS} hold SR1, SR2 and OP1 (neither violated nor cut short before the end), without
  and with a person; what they strike.
- **Mutants**: the verdict of the score, by its own functions: the exact stratified test against the arm's own ten-seed
  pool in each situation, in pairs that are neither vacuous nor open and with the gate of one tenth; Holm over SR1 and
  SR2.
- **Violations**: flights that violate SR1 or SR2 in each situation; in steady pairs when, where and what was struck.

## Rules

1. A magnitude is *detected* in an arm if the score says so: p, adjusted by Holm over SR1 and SR2, is at most {ALPHA:g}.
2. MORE-goal is *shown* by a magnitude in an arm if that p is at most {ALPHA:g} / {TESTS} = {STRICT:.2g}: Bonferroni
   over {len(ARMS)} arms x {len(MUTANTS)} magnitudes, so that chance alone shows MORE-goal somewhere with a \
probability of at most {ALPHA:g}.
   With a pool that holds, nine violations of ten flights in one situation are enough, or six in each of two, or two in
   each of six.  It is shown *as the paper saw it* only by SR1.
3. Turning first *masks* a magnitude at a speed if SR1 shows it without turning first (rule 2), and with turning first
   SR1 does not even detect it (rule 1).
4. The reference stack may change only if, without turning first at 0.5 m/s, the baselines hold each of SR1, SR2 and OP1
   in at least as many of the {DRAWS} draws as with it.  No flight of a mutant enters this rule.  If it fails, the stack
   stays as it is, whatever rules 1 to 3 say, and this page is named beside the paper's row.

All arms are reported, whatever they show.
"""
