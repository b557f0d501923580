from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from experiments import PUBLISHED, ROOT, wide
from experiments import search_arms as arms
from experiments import search_or_chance as experiment
from experiments.flights import published, read
from experiments.pages import registered
from experiments.search_or_chance import BUDGET, UNFINISHED, Answer, Evidence, answer, flown, share, totals
from scaloft_fi.campaign.seeking.seek import OPENING
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.sim.grid import Evidence as Shown
from scaloft_fi.streams import generator
from scaloft_fi.study import Study

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""

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
BLOCKS = arms.read_blocks()
SIZES = [len(block) for block in BLOCKS]
MUTANTS = sum(SIZES)
EVIDENCE = Shown("SR1", 1, 0.001, 0.005, 4, 4, "wall", 10, 10, 0.2, 0.01, 10)


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(ROOT, experiment.GRID)


@pytest.fixture(scope="module")
def survivors_at_risk() -> tuple[list[str], list[str]]:
    """The survivors, and those of them that are at risk."""
    plain = Study.open(ROOT)
    found = arms.survivors(plain, published())
    return found, arms.at_risk(plain, found)


def test_the_committed_blocks_are_what_the_draw_gives(study: Study, survivors_at_risk: tuple[list[str], list[str]]):
    lines = [" ".join(block) for block in arms.blocks_of(study, survivors_at_risk[1])]
    assert arms.FILE.read_text(encoding="utf-8").splitlines() == lines


def test_a_block_has_survivors_at_risk_of_one_parameter_and_every_parameter_with_two_has_one(
    study: Study, survivors_at_risk: tuple[list[str], list[str]]
):
    found, chosen = survivors_at_risk
    assert (len(found), len(chosen)) == (SURVIVORS, AT_RISK)
    number = Counter(realise(study.matrix, id_).parameter for id_ in chosen)
    parameters = [{realise(study.matrix, id_).parameter for id_ in block} for block in BLOCKS]
    wanted = [({parameter}, min(all_, arms.MOST)) for parameter, all_ in number.items() if all_ >= arms.FEWEST]
    assert list(zip(parameters, SIZES, strict=True)) == wanted
    drawn = [mutant for block in BLOCKS for mutant in block]
    assert len(set(drawn)) == len(drawn) == MUTANTS
    assert set(drawn) <= set(chosen)


def test_the_plan_counts_the_mutants_that_the_wide_grid_detects():
    """As they were known when the plan was written: the choosing half with one seed."""
    study = Study.open(ROOT, "wide")
    choosing, _ = wide.halves(study.roster.defaults)
    known = [row for row in published("wide") if row["mutant"] not in choosing or row["seed"] == 0]
    detected = wide.side(study, known).detected
    assert len(detected) == 64
    assert sum(mutant in detected for block in BLOCKS for mutant in block) == WIDE


def power(
    sizes: Sequence[int], open_: float, chance: float, search: float, *, together: bool, draws: int = 1_000
) -> float:
    """How often rule 1 answers yes.

    Args:
        sizes: mutants of each block.
        open_: share of the mutants that something can show, but not the opening.
        chance: share of these that each of three arms of chance finds.
        search: share of these that the search finds.
        together: whether an arm finds all of these in a block or none; else it finds each by itself.
        draws: experiments that are drawn.
    """
    rng = generator("search or chance", "power", open_, chance, search, together)
    finds = np.array([search, chance, chance, chance])
    left = rng.binomial(np.array(sizes)[:, None], open_, size=(draws, len(sizes), 1))
    found = left * rng.binomial(1, finds, size=(draws, len(sizes), 4)) if together else rng.binomial(left, finds)
    return share(answer(one)[0] is Answer.BETTER for one in found.tolist())


def test_the_plan_says_what_the_rule_can_show():
    for chance, search, *yes in POWER[::2]:
        shown = [power(SIZES, OPEN, chance, search, together=together) for together in (False, True)]
        assert shown == pytest.approx(yes, abs=0.0051)


def test_the_plan_counts_its_flights_and_lists_its_blocks():
    plan = registered("search_or_chance")
    asked = len(arms.ARMS) * BUDGET * MUTANTS
    different = asked - (len(arms.ARMS) - 1) * sum(OPENING * (1 + size) for size in SIZES)
    assert f"{asked:,} flights, at most {different:,} of them different." in plan
    assert f": {MUTANTS} mutants in {len(BLOCKS)} blocks." in plan
    assert all(f"| {n} | {arms.seed_of(n)} | {', '.join(block)} |\n" in plan for n, block in enumerate(BLOCKS, 1))
    for chance, found, *yes in POWER:
        assert f"| {100 * chance:.0f} % | {100 * found:.0f} % | {100 * yes[0]:.0f} % | {100 * yes[1]:.0f} % |" in plan


def test_the_published_page_is_what_the_published_files_give():
    kept = Evidence(
        BLOCKS, arms.read_searches(PUBLISHED / experiment.SEARCHES), read(PUBLISHED / experiment.FLIGHTS)["all arms"]
    )
    page = (PUBLISHED / "search_or_chance.md").read_text(encoding="utf-8")
    assert page == registered("search_or_chance") + flown(kept)


def test_the_answer_needs_more_than_chance_and_more_than_each_arm():
    better, worse = [(3, 1, 1, 1)] * 6, [(0, 2, 2, 1)] * 6
    assert answer(better)[0] is Answer.BETTER
    assert answer(worse)[0] is Answer.WORSE
    assert answer(better[:2])[0] is Answer.NO_DIFFERENCE
    one_as_good = [(3, 3, 0, 0)] * 8
    assert answer(one_as_good)[0] is Answer.NO_DIFFERENCE
    assert answer(one_as_good)[1] < 0.05
    assert answer([(1, 1, 1, 1)] * 8) == (Answer.NO_DIFFERENCE, 1.0)
    assert totals(better) == [18, 6, 6, 6]


def search(block: int, arm: str, found: int, opening: str = "o", **more: int) -> arms.Search:
    """A search that finds so many mutants, the first of them in the opening."""
    sought = tuple(
        arms.Sought(mutant, opening if n == 0 else "later", 20 + n, EVIDENCE, 1)
        if n < found
        else arms.Sought(mutant, "", 0, None, 0)
        for n, mutant in enumerate(BLOCKS[block - 1])
    )
    seed, budget = more.get("seed", arms.seed_of(block)), more.get("budget", BUDGET * len(sought))
    return arms.Search(block, arm, seed, budget, 200, sought, (opening,), ("later",))


def evidence(found: Mapping[str, int], **flights: Outcome) -> Evidence:
    every = range(1, len(BLOCKS) + 1)
    return Evidence(BLOCKS, [search(block, arm, found[arm]) for block in every for arm in arms.ARMS], flights)


@pytest.mark.parametrize(("own", "said"), [(3, Answer.BETTER), (2, Answer.NO_DIFFERENCE), (1, Answer.WORSE)])
def test_the_page_decides_by_the_mutants_that_are_newly_detected(own: int, said: Answer):
    page = flown(evidence({**dict.fromkeys(arms.ARMS, 2), arms.SEARCH: own}), redraws=20)
    assert f"**Rule 1: {said.value}.**  `seek` newly detects {12 * own} of {MUTANTS} mutants; random 24" in page
    assert "| `seek` beside | more mutants | blocks drawn again | p (Holm) |" in page
    assert f"| random | {12 * (own - 2)} | {12 * (own - 2):+} to {12 * (own - 2):+} |" in page
    assert "| - by situations of the opening | 12 | 12 | 12 | 12 |" in page
    assert page.count("20: SR1 4/4") == 12 * len(arms.ARMS)


def test_nothing_is_decided_while_a_search_is_missing_or_the_openings_differ():
    whole = evidence(dict.fromkeys(arms.ARMS, 2))
    assert whole.complete
    first, *others = whole.searches
    for unfinished in (
        others,
        [search(1, arms.SEARCH, 2, budget=60), *others],
        [search(1, arms.SEARCH, 2, seed=1), *others],
        [search(1, arms.SEARCH, 0), *others],
        [replace(first, sought=first.sought[::-1]), *others],
    ):
        page = flown(replace(whole, searches=unfinished), redraws=5)
        assert UNFINISHED in page
        assert "Rule 1" not in page
