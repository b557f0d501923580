"""The experiment on search and chance: its budget, its rule of decision, and the plan on its page."""

from __future__ import annotations

from collections.abc import Iterable

from experiments.search_or_chance.compare import LEVEL, REDRAWS
from experiments.search_or_chance.pairs import STRENGTH
from experiments.search_or_chance.proposers import ARMS, SEARCH
from experiments.search_or_chance.sample import FEWEST, MOST, read_blocks
from scaloft_fi.analysis.detection import ALPHA
from scaloft_fi.campaign.seeking.finds import SEEN_ON
from scaloft_fi.campaign.seeking.proposals import OPENING
from scaloft_fi.campaign.seeking.seek import EACH, GENERATION

BUDGET = 60
"""Flights of a search for each of its mutants; a search is an arm with the mutants of a block."""
FIRST_SEED = 1901
"""Seed of the searches of the first block; each block has the next one."""
SURVIVORS, AT_RISK, WIDE = 82, 66, 19
"""Defaults that the paper's grid does not detect; those of them whose cell names a safety requirement; and how many
of the drawn ones the wide grid detects."""
OPEN = 0.35
"""Share of mutants that something can show, but not the opening, as assumed for what the rule can show."""
POWER = (
    (0.2, 0.4, 0.30, 0.22),
    (0.2, 0.6, 0.79, 0.55),
    (0.2, 0.8, 0.99, 0.86),
    (0.4, 0.6, 0.24, 0.12),
    (0.4, 0.8, 0.74, 0.47),
    (0.4, 0.9, 0.94, 0.71),
)
"""Share of the open mutants that each arm of chance finds, share that the search finds, share of yes where mutants are
found one by one, and where those of a block are found together."""
SIMULATED_S = 55
"""Mean length of what is simulated for a flight [s]: a mutant shares its baseline up to its first altered sample."""
LEFT = 20
"""Flights that a search leaves, about half of what the next situations take."""
SPEED = 80
"""Simulated seconds per processor second."""
PER_HOUR = round(2 * 3_600 * SPEED / SIMULATED_S / SURVIVORS)
"""Flights for each mutant that is not detected, in an hour on two processors."""


def seed_of(block: int) -> int:
    """The seed of the searches of a block, which are numbered from 1."""
    return FIRST_SEED + block - 1


def _row(cells: Iterable[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


_READ = read_blocks()
MUTANTS = sum(map(len, _READ))
OPENING_FLIGHTS = sum(OPENING * (1 + len(block)) for block in _READ)
"""Flights of the opening, of all blocks; the arms share them."""
ASKED = len(ARMS) * BUDGET * MUTANTS
"""Flights that the arms may ask for."""
FLOWN = ASKED - (len(ARMS) - 1) * OPENING_FLIGHTS
"""Most of them that are different."""


def _minutes(flights: int) -> float:
    return flights * SIMULATED_S / SPEED / 60


_BLOCKS = "\n".join(_row((n, seed_of(n), ", ".join(block))) for n, block in enumerate(_READ, 1))
_POWER = "\n".join(_row(f"{100 * share:.0f} %" for share in row) for row in POWER)
PLAN = f"""# Does search beat chance?

Question, arms, mutants and rule were written down, and committed without the section *Flown*, before the searches were
flown.  Made by `python -m experiments.search_or_chance`.

**The question.**  `scaloft-fi seek` lets robustness guide what is flown next.  Does it newly detect more mutants than
situations that are chosen without looking at flights, at equal flights, confirmation included?

**What is known already.**  No arm of chance was flown on these mutants.  `seek` was tried on some of them while it was
built, with other seeds; its settings came before this plan.  Optuna was chosen after toy problems, where it needed
fewer trials than random draws.  The wide grid, whose situations were chosen by hand and by an array, detects {WIDE} of
the {MUTANTS} mutants below: many of them are easy.  The script was tried with other seeds on NO-human, NO-goal,
LATE-human and LATE-depth, which are not among them; `seek` with seed 7 on 20 survivors, in eight situations of its
opening, and with seed 0 on all 82, in sixteen: these showed LATE-depth and 14 others, ten of them below.  The first
search of `found.md`, with seed 0, whose opening is another one, showed 46 of the 82, 23 of them below.

## Arms

All arms run the same code, `seek` without shrinking, in `sim/grids/search.yaml`.  Only what proposes the situations
after the opening differs:

- **{SEARCH}**: TPE for each mutant, told how near each situation of the block came to showing it.
- **random**: a level of each axis with equal probability; a free axis is off its benign value with probability 1/3.
  Then half of its numbers are at an end of its range, as in `seek`'s opening; the others are drawn from its
  distribution.
- **low-discrepancy**: a Sobol sequence over the same draws, scrambled by the seed.
- **{STRENGTH}-way**: covering arrays, one after the other, with all pairs of levels and of bins of the free axes.  A
  free axis has three bins of equal probability, two of them benign; in the third its number is drawn as in **random**.

The mutants of a block have one parameter and are sought together: each situation that is proposed is flown for all of
them that are not found yet.  `seek` asks TPE for {EACH} situations for each of these mutants, and at least {GENERATION}
in all; an arm of chance takes as many from one list for the block.

**The opening is common to all arms**: the {OPENING} situations with which `seek` always begins.  It is flown once, and
what it shows counts in every arm.  A shorter one would not tell the arms apart earlier: TPE draws at random until it
knows {OPENING} situations.

The rest is `seek`'s: three seeds of the search ({SEEN_ON[0]} to {SEEN_ON[-1]}), then seeds from 0 on beside ten
baselines, the j-th candidate at {ALPHA:g} x 2^-j; no knife edges; a find is tried on the block's other mutants.  So an
arm falsely detects a mutant with a chance of at most {ALPHA:g}.

## Mutants and flights

- **Mutants**: of the {SURVIVORS} defaults that the paper's grid does not detect (three seeds, pool of ten) those
  {AT_RISK} whose cell names a safety requirement; of each parameter with at least {FEWEST} of them up to {MOST}, drawn
  by key (`sample.py`, `blocks.txt`): {MUTANTS} mutants in {len(_READ)} blocks.
- **Flights**: each arm has {BUDGET} for each mutant of a block, as `seek` counts them: each different flight that it
  asked for, baselines, tries and confirmation included, once; the opening takes about half.  Found mutants leave theirs
  to the others of the block.  A search ends where its next flights do not all fit.
- **Seeds**: a block has one seed, for opening, TPE, lists.  Noise is keyed by situation and seed of the flight.
- **Time**: {ASKED:,} flights, at most {FLOWN:,} of them different.  At {SIMULATED_S} simulated s each and {SPEED}
  simulated s per processor second that is at most {_minutes(FLOWN):.0f} minutes of processor time, and about \
{_minutes(FLOWN - len(ARMS) * len(_READ) * LEFT):.0f} if a search
  leaves {LEFT} flights; the arrays take some 7.

| block | seed | mutants |
|---|---|---|
{_BLOCKS}

## Rule

1. Counted is how many mutants an arm *newly detects* within its flights: confirmed as said above.  If what proposes
   makes no difference, each of the {len(ARMS)} counts of a block might as well be `seek`'s, whatever other blocks have.
   p is the exact, two-sided chance that `seek`'s total is then as far from its mean.
   **Yes**, search beats chance, if p is at most {LEVEL:g} and `seek` detects more than each of the three others;
   **no, chance finds more**, if p is at most {LEVEL:g} and `seek` detects fewer than they do on average;
   else **no difference is shown**, which does not say that there is none.
2. The same test with `seek` and one other arm, Holm over the three, says which of them it differs from at {LEVEL:g}.
3. Blocks, with their mutants and seeds, are drawn again {REDRAWS:,} times with replacement; the middle nine tenths of
   the differences are shown.
4. The rule is decided only if all searches were flown with this budget, and all arms of a block found the same in the
   opening.  A flight whose harness fails is told of, and counts as `seek` counts it.

What the rule can show, if {100 * OPEN:.0f} % of the mutants ({OPEN * MUTANTS:.0f} of {MUTANTS}) can be found, but not \
in the opening:

| each arm of chance finds of these | `seek` finds | yes, if they are found one by one | yes, if a block's are found \
together |
|---|---|---|---|
{_POWER}

So a difference of seven mutants is shown in about half to three quarters of the cases, and one of three is mostly
missed.  {BUDGET} flights for each mutant are few: an hour on two processors has about {PER_HOUR} for each of the \
{SURVIVORS}.

Reported besides, and deciding nothing: how many are detected after how many flights; how often a situation proposed
after the opening shows a mutant that was flown there, with the first seed of the search, which does not depend on how
flights are counted; candidates.  All arms, blocks and mutants are reported, whatever they show.
"""
