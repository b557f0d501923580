"""The experiment on real bugs: its flights, and the plan on its page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from experiments.bugs.bug import Bug
from experiments.bugs.coupling import DRAWS, RELABELLINGS
from experiments.bugs.registry import BUGS, DROPPED, SOUGHT

SEEDS = tuple(range(3))
SITUATIONS = 32
TOGETHER = 3
"""Size of the small sets that are drawn besides single situations."""
LEVEL = 0.05
REFERENCE = "reference"
"""Arm of the flights of the reference stack."""
FLIGHTS = (len(BUGS) + 1) * SITUATIONS * len(SEEDS)


def names_of(situations: Iterable[str]) -> Iterator[str]:
    """Yield the names of a bug's flights: it is the baseline of a stack of its own."""
    yield from (f"baseline/{key}/{seed}" for key in situations for seed in SEEDS)


def _row(bug: Bug) -> str:
    number = bug.thread.rsplit("/", 1)[1]
    thread = f"[{bug.project} {number}]({bug.thread})"
    return f"| {bug.key} | {thread} | {bug.cell} | {bug.wrong} | {bug.fix} ({bug.fixed_by}) | {bug.written} |"


_DROPPED = "\n".join(f"- {name}: {why}." for name, why in DROPPED.items())
PLAN = f"""# Do mutants stand for bugs?

Question, bugs, flights and rules were written down, and committed without the section *Flown*, before the bugs were
flown in the grid.  Made by `python -m experiments.bugs`.

**The question.**  Do the situations that kill the mutant of a cell detect a real bug of that kind more often
than random situations do?  (Just et al. 2014 call this coupling.)

**What is known already.**  The kills of the published campaign.  Of the bugs one flight each, in T0O0W0D0H1 with seed
0, once they were written: SR1 was violated by mavros-838 and px4-6647 (the same flight, bit for bit, SR2 too), by
crazyflie-760 and by px4-5062, SR2 by px4-11764; px4-23047 and px4-20308 flew as the reference stack; the others
violated no safety requirement.  No defect was changed after these flights.  The script was tried in T0O0W0D0H0, and the
tests fly px4-11840 in T0O0W0D0H1; what these flights violate was not looked at.

## Bugs

{len(BUGS)} bugs, each a stack of its own: the reference stack with one stage that has the defect (`experiments/bugs/`).
With the defect off the same code flies bit for bit as the reference stack; the tests fly it.  The first \
{len(BUGS) - SOUGHT} are of a
list of threads that read like cells, collected before this experiment; the last {SOUGHT} were looked for besides, in
cells whose mutant has kills, because most cells of the first have none.  A bug's cell was chosen by what the thread
says, before the bug flew.

| bug | thread | cell | wrong | fix | in the copy |
|---|---|---|---|---|---|
{chr(10).join(map(_row, BUGS))}

Looked up and left out:

{_DROPPED}

Where a thread gives no number (crazyflie-760, avoidance-357) the number is an assumption, named in the module of the
bug.  The limit of this evidence: the bugs were rewritten from their threads for another stack, with the mutants in
sight.

## Flights

{len(BUGS)} bugs and the reference stack x {SITUATIONS} situations of the paper x {len(SEEDS)} seeds \
({SEEDS[0]} to {SEEDS[-1]}) = {FLIGHTS:,}.
Kills and verdicts of mutants are those of `reference/outcomes.parquet`; the pool is its first ten baseline seeds.

Amended before any of these flights: the reference stack is flown beside the bugs.  A flight of a bug *differs* if its
digest is not that of the reference stack's flight on the same machine.  The published digests were to serve for this,
which asks for a processor with AVX-512: on others the last bits of every flight are different.

## Rules

1. A set of situations *detects* a bug if the score's own test does, restricted to that set: the exact stratified test
   against the pool, three seeds, alpha 0.01, Holm over SR1 and SR2, the gate of one tenth.  One situation can detect
   alone: three violations of three beside none of ten have p = 0.0070.
2. The *killing* situations of a bug are those in which its cell's default mutant is killed in the published campaign.
   A bug whose cell has none stands *apart*: it is reported, and no rule counts it.
3. *Random situations* are drawn from those with a steady safety requirement, the only ones that put a fault to the
   test; from all {SITUATIONS} the comparison is easier, and is reported beside it.
4. The *excess* of a bug is the share of its killing situations that detect it, each alone, less that share of all
   situations of rule 3.  One situation and not the whole set is compared, because whole sets hardly can differ: eight
   random situations of {SITUATIONS} miss all of eight given ones with a probability of 7 % only.
5. A bug is *coupled* if its excess is positive and the chance that as many random situations hold as many that detect
   it (hypergeometric) is at most {LEVEL:g}.  A bug that no situation detects, or every one, is called so: it cannot
   couple.
6. Counted bugs whose flights are all bit-identical share one vote.
7. **The answer** is yes if the mean excess over the bugs that do not stand apart is positive with p at most {LEVEL:g}.
   p is that of a permutation test: {RELABELLINGS:,} keyed draws permute the names of the situations in all killing sets
   at once, so that the sets keep their sizes and what they have in common.  Else the answer is that these bugs do not
   show it.

Reported besides, and deciding nothing: sets of {TOGETHER} and of as many as the killing situations, by the share that
detects (all sets, or {DRAWS:,} keyed draws); the excess over the killing sets of other parameters' mutants, which asks
whether the cell matters or only that something is killed there; verdicts over all {SITUATIONS} situations.  All bugs
are reported, whatever they show.
"""
