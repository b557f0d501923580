"""The wide grid: which mutants may move its choices, which judge it, and the plan on its page."""

from __future__ import annotations

from collections.abc import Mapping

from scaloft_fi.streams import key_words

PARAMETERS = ("goal", "collision", "pose", "waypoint", "battery")
"""The parameters of which the paper's grid shows least."""

PLAN = f"""# The wide grid beside the paper's grid

Made by `python -m experiments.wide`.  Question, halves and rules were written before a mutant was flown in the wide
grid, but the history of the repository does not show it: plan, grid and flights first appear in one commit.

**The question.**  The paper's grid is static and slow: 32 situations, one speed, two lights, a person who stands.  Do
situations with other speeds, lights, obstacles, persons, with wind, drift and a low battery show faults that the
paper's grid does not show, at no more than twice its flying?

**What is known already.**  This is no blind test.  An audit flew the survivors of the paper's grid once in five new
situations (light 0.15, cruise 1.0 m/s, an obstacle behind the corner, a waypoint 0.45 m from the wall, a battery at
0.18), and saw nine of them killed in at least three of four seeds.  The axes of the wide grid include four of these
five changes, so the audit's mutants of both halves had a part in naming axes.  They had none in choosing values.

## Halves

The default mutants of all credible cells, in the order of their parameters, are dealt in turn to the *choosing* and the
*judging* half; within a parameter a keyed stream orders them.  The choosing half may be flown to choose axes, values,
constraints and strength of the array.  No mutant of the judging half is flown outside the paper's grid before the file
of the wide grid is committed; afterwards that file does not change.

## Rules

1. A mutant is *detected* by a grid if the score says so: three seeds, a baseline pool of ten seeds in each situation
   where it acts, alpha 0.01, the exact stratified test with Holm over SR1 and SR2.  Safety requirements only.
2. The two grids are compared on the judging half: how many each detects, and both together.  The result of the choosing
   half is shown beside it and is called selected.
3. The wide grid's flying is the simulated time of its campaign, over that of the paper's grid with the same seeds.
4. For {", ".join(PARAMETERS)} the page names what each grid detects over both halves, and where that is no more than
   before it says what stops the others.
5. Baselines that violate a requirement in the wide grid are listed; the values of the axes were chosen so that the
   unmutated drone mostly holds SR1 and SR2, and nothing of the stack was changed.

All of it is reported, whatever it shows.
"""

AGAIN = """## Told again

The rules above take ten of the twenty baseline seeds that were flown, and the choosing half had one seed of three.  An
audit of the published flights found that seeds 0-9 are a lucky pool.  These rules were committed, in a commit of their
own, before the two missing seeds of the choosing half were flown.

1. The choosing half is flown with seeds 1 and 2 in the same 43 situations, so that both halves have three seeds.  Its
   first seed was known, and its verdicts were; it stays the *selected* half.
2. The headline is the verdict with all twenty baseline seeds as the pool: *detected*, and beside it *firm*: detected
   still when any one seed is left out of the mutant's three and, separately, any one out of the twenty.  Pair states
   and the gate's allowance stay those of the full pool.
3. Beside it stand, for both halves: the pool of seeds 0-9 (what was published), the pool of seeds 10-19, and the mean
   and range over 300 pools of ten drawn at random, the same in every situation.
4. Named are the mutants whose verdict changes between seeds 0-9 and all twenty, the pairs that are steady in seeds 0-9
   and not in all twenty, and the situations where the unmutated drone violates OP1 in more than one flight of ten.
5. The paper's grid stands beside it by the same rules: three seeds, its first twenty baseline seeds.
"""


def halves(defaults: Mapping[str, str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The choosing and the judging half.

    Args:
        defaults: the default mutant of each credible cell, by the cell's name such as `LATE-human`.

    >>> halves({"NO-a": "NO-a", "MORE-a": "MORE-a@1", "NO-b": "NO-b"})
    (('MORE-a@1', 'NO-b'), ('NO-a',))
    """
    ordered = sorted(defaults.items(), key=lambda entry: (entry[0].split("-")[1], key_words("wide half", entry[1])))
    dealt = [mutant for _, mutant in ordered]
    return tuple(dealt[0::2]), tuple(dealt[1::2])
