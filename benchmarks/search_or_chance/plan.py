"""The experiment on search and chance: its blocks, its budget, its rule of decision, and the plan on its page."""

from __future__ import annotations

from collections.abc import Iterable

from scaloft_fi.analysis.scoring.detection import ALPHA
from scaloft_fi.campaign.runs.seeking.flights import SEEN_ON
from scaloft_fi.campaign.runs.seeking.proposals import GENERATION, OPENING
from search_or_chance.compare import LEVEL, REDRAWS
from search_or_chance.pairs import STRENGTH
from search_or_chance.proposers import ARMS, SEARCH
from search_or_chance.sample import BLOCKS, TOGETHER, read_blocks

MUTANTS = BLOCKS * TOGETHER
BUDGET = 210
"""Flights of a search: of an arm with the mutants of a block."""
FIRST_SEED = 1801
"""Seed of the searches of the first block; each block has the next one."""
SURVIVORS, AT_RISK, WIDE = 82, 66, 19
"""Defaults that the paper's grid does not detect; those of them whose cell names a safety requirement; and how many
of the drawn ones the wide grid detects."""
OPEN = 0.35
"""Share of mutants that neither the opening shows nor nothing can show, as assumed for what the rule can show."""
POWER = (
    (0.2, 0.4, 0.25),
    (0.2, 0.6, 0.71),
    (0.2, 0.8, 0.96),
    (0.4, 0.6, 0.18),
    (0.4, 0.8, 0.64),
    (0.4, 0.9, 0.86),
)
"""Share of the open mutants that each arm of chance finds, share that the search finds, share of yes."""
SIMULATED_S = 70
"""Mean length of a flight [s, simulated]."""
FLOWN = 6_100
"""Flights without those that arms share."""
SPEED = 100
"""Simulated seconds per processor second."""
PER_HOUR = round(2 * 3_600 * SPEED / SIMULATED_S / SURVIVORS)
"""Flights for each mutant that is not detected, in an hour on two processors."""


def seed_of(block: int) -> int:
    """The seed of the searches of a block, which are numbered from 1."""
    return FIRST_SEED + block - 1


def _row(cells: Iterable[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


_BLOCKS = "\n".join(_row((n, seed_of(n), ", ".join(block))) for n, block in enumerate(read_blocks(), 1))
_POWER = "\n".join(_row(f"{100 * share:.0f} %" for share in row) for row in POWER)
PLAN = f"""# Does search beat chance?

Question, arms, mutants and rule were written down, and committed without the section *Flown*, before the searches were
flown.  Made by `python benchmarks/search_or_chance`.

**The question.**  `scaloft-fi seek` lets robustness guide what is flown next.  Does it newly detect more mutants than
situations that are chosen without looking at flights, at equal flights, confirmation included?

**What is known already.**  No arm of chance was flown on these mutants.  `seek` was tried on some of them while it was
built, with other seeds; its settings (generations of {GENERATION}, an opening of {OPENING}) came before this plan.
Optuna was chosen after toy problems, where it needed fewer trials than random draws.  The wide grid, whose situations
were chosen by hand and by an array, detects {WIDE} of the {MUTANTS} mutants below: many of them are easy.  To measure \
time,
14 situations of another seed were flown with the baseline and LATE-depth, which two of them showed.  To test the script
it was flown with another seed and with NO-human and NO-goal, which are not among the mutants, and with eight baselines
of the first block's opening.  These flights were longer than expected, so the budget was cut from 240 flights; nothing
else was changed because of them.

## Arms

All arms run the same code, `seek` without shrinking, in `sim/grids/search.yaml`.  Only what proposes the next
situation differs:

- **{SEARCH}**: TPE, told how near each situation came to showing the mutant.
- **random**: a level of each axis with equal probability; a free axis is off its benign value with probability 1/3,
  then at random in its range.
- **low-discrepancy**: a Sobol sequence over the same draws, scrambled by the seed.
- **{STRENGTH}-way**: covering arrays, one after the other, with all pairs of levels and of bins of the free axes.  A
  free axis has three bins of equal probability, two of them benign, so that it is off about as often as in random
  draws; inside its bin a number is random.

All arms begin with the same {OPENING} random situations, with which `seek` begins.  What they show says nothing of any
arm: it counts in all of them, and is flown once.  From then on an arm of chance proposes the same situations to all
mutants of a block, which share the baselines there; TPE proposes to each mutant its own, and pays for their baselines.

The rest is `seek`'s: generations of {GENERATION} in turns; the baseline first, the mutant only where the baseline holds
a requirement with room; three seeds of the search ({SEEN_ON[0]} to {SEEN_ON[-1]}), then seeds from 0 on beside ten
baselines, the j-th candidate at {ALPHA:g} x 2^-j; no knife edges; a find is tried on the block's other mutants.  So an
arm falsely detects a mutant with a chance of at most {ALPHA:g}.

## Mutants and flights

- **Mutants**: of the {SURVIVORS} defaults that the paper's grid does not detect (three seeds, pool of ten) those
  {AT_RISK} whose cell names a safety requirement; the matrix holds the others for a matter of operability.  A keyed, \
systematic
  sample of {MUTANTS} along the parameters is dealt into {BLOCKS} blocks of {TOGETHER}, so that a block has different \
parameters
  (`sample.py`, `blocks.txt`).
- **Flights**: each arm has {BUDGET} flights for each block, as `seek` counts them: each different flight that it asked
  for, baselines, tries and confirmation included, once.  Found mutants leave theirs to the others of the block.
- **Seeds**: each block has a seed of its own for the opening, TPE, the Sobol sequence and the arrays.  No mutant is in
  two blocks: for the same flights, new mutants say more than old ones with new seeds.  Noise is keyed by situation and
  seed, so situations of different blocks have different noise although the numbers of the seeds are the same.
- **Time**: {len(ARMS)} arms x {BLOCKS} blocks x {BUDGET} flights = {len(ARMS) * BLOCKS * BUDGET:,}, about {FLOWN:,} of
  them different ones.  At {SIMULATED_S} simulated s each and {SPEED} simulated s per processor second that is \
{FLOWN * SIMULATED_S / SPEED / 60:.0f}
  minutes of processor time, and some 5 for TPE and arrays.

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

What the rule can show: if {100 * OPEN:.0f} % of the mutants ({OPEN * MUTANTS:.0f} of {MUTANTS}) can be found, but not \
in the opening, and each of
them is found or not by itself,

| each arm of chance finds of these | `seek` finds | the answer is yes in |
|---|---|---|
{_POWER}

So a difference of six of the {MUTANTS} mutants is shown more often than not, and one of three is mostly missed.  Two \
limits: if
more mutants were sought at once, they would share the baselines of chance, which would have more situations for its
flights; and {BUDGET // TOGETHER} flights for each mutant are few: an hour on two processors has about {PER_HOUR} for \
each of the {SURVIVORS}.

Reported besides, and deciding nothing: how many are detected after how many flights; the share of the situations
proposed after the opening that show the mutant with the first seed of the search, which does not depend on how flights
are counted; candidates.  All arms, blocks and mutants are reported, whatever they show.
"""
