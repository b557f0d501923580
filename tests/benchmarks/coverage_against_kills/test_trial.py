from __future__ import annotations

from itertools import combinations

from builders import GRID, ROSTER, outcome, pool, seeded
from hypothesis import given, settings

from experiments.coverage_against_kills.curves import curves
from experiments.coverage_against_kills.prediction import predict
from experiments.coverage_against_kills.trial import Trial, trial
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import rulings_of

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
KEYS = [key for key, _ in GRID.points]


def made(outcomes: list[Outcome]) -> Trial | None:
    return trial(score(outcomes, ROSTER, GRID), rulings_of(outcomes), ROSTER, GRID)


def flown(mutant: str, situations: list[str], killing: list[str], seeds: int = 1) -> list[Outcome]:
    return [
        outcome(mutant, key, seed, violated={"SR1": 5.0} if key in killing else {}, digest=mutant)
        for key in situations
        for seed in range(seeds)
    ]


def test_the_trial_takes_the_default_mutants_that_were_flown_together() -> None:
    outcomes = pool(*KEYS[:8])
    outcomes += flown(LATE, KEYS[:6], KEYS[:3]) + flown(NO, KEYS[:6], KEYS[2:6])
    outcomes += flown(GOAL, KEYS[6:8], []) + flown("LATE-human@1s", KEYS[:8], KEYS[:8]) + flown("PLACEBO", KEYS[:8], [])
    found = made(outcomes)
    assert found.situations == tuple(KEYS[:6])
    assert (found.mutants, found.parameters, found.left_out) == ((NO, LATE), ("human", "human"), (GOAL,))
    assert found.kills.astype(int).tolist() == [[0, 0, 1, 1, 1, 1], [1, 1, 1, 0, 0, 0]]
    assert (found.killed, len(found.kill_sets), found.unkilled) == (2, 2, ())
    assert made([]) is None


def test_nothing_dies_in_a_red_situation_nor_of_what_is_not_detected() -> None:
    outcomes = pool(*KEYS[:4]) + pool(KEYS[4], red=9, violated={"SR1": 30.0})
    outcomes += flown(LATE, KEYS[:5], KEYS[:5]) + flown(NO, KEYS[:5], KEYS[:1])
    assert made(outcomes).kills.astype(int).tolist() == [[0, 0, 0, 0, 0], [1, 1, 1, 1, 0]]


def test_a_mutant_that_is_detected_without_a_kill_is_named() -> None:
    # one of three flights in each of many situations: too often for chance, most flights nowhere
    outcomes = pool(*KEYS[:12], seeds=30)
    outcomes += [
        outcome(LATE, key, seed, violated={"SR1": 5.0} if seed == 0 else {}) for key in KEYS[:12] for seed in range(3)
    ]
    found = made(outcomes)
    assert (found.unkilled, found.killed) == ((LATE,), 0)
    assert any(LATE in sentence for sentence in predict(curves(found)).answer)


def test_a_campaign_of_one_seed_has_no_seeds_to_resample_and_says_so() -> None:
    found = made(pool(*KEYS[:6]) + flown(LATE, KEYS[:6], KEYS[:3]))
    assert (found.seeds, found.seed_sets) == ((0,), ())
    said = predict(curves(found)).answer[-1]
    assert "only one in common" in said
    assert "nothing follows beyond this seed" in said


def test_seeds_that_only_some_mutants_flew_stand() -> None:
    outcomes = pool(*KEYS[:6]) + flown(LATE, KEYS[:6], KEYS[:3], seeds=3) + flown(NO, KEYS[:6], KEYS[:4], seeds=2)
    found = made(outcomes)
    assert (found.seeds, found.more_seeds) == ((0, 1), (2,))
    assert [one.seeds for one in found.seed_sets] == [(0,), (1,), (0, 1)]
    assert (found.seed_sets[-1].kills == found.kills).all()


def test_seeds_are_judged_anew_with_the_alpha_that_the_campaign_spends() -> None:
    # one situation and three seeds: p = 0.0070, enough where alpha is spent once, not where it is spent by looks
    outcomes = pool(*KEYS[:2]) + flown(LATE, KEYS[:2], KEYS[:1], seeds=3)
    for spending, killed in ((Spending(), 1), (Spending(grown=frozenset({LATE})), 0)):
        scored = score(outcomes, ROSTER, GRID, spending)
        found = trial(scored, rulings_of(outcomes), ROSTER, GRID, spending)
        assert [found.kills.sum(), found.seed_sets[-1].kills.sum()] == [killed, killed]


@settings(max_examples=10, deadline=None)
@given(seeded())
def test_the_kills_of_some_seeds_are_those_of_a_campaign_flown_with_these_beside_the_whole_pool(
    outcomes: list[Outcome],
) -> None:
    found = made(outcomes)
    if found is None:
        return
    shared = set(found.seeds)
    if 1 < len(shared) < 7:
        subsets = [set(some) for size in range(1, len(shared) + 1) for some in combinations(sorted(shared), size)]
        assert [set(one.seeds) for one in found.seed_sets] == subsets
    for one in found.seed_sets:
        some = [o for o in outcomes if o.subject.id == BASELINE or o.seed in one.seeds or o.seed not in shared]
        again = {mutant.subject.id: mutant.killing for mutant in score(some, ROSTER, GRID).mutants}
        assert one.kills.tolist() == [[key in again.get(id_, ()) for key in found.situations] for id_ in found.mutants]
