from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded, thrice
from effort import usually
from finding import flies, found, known
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.roster import Roster, plain
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Background, backgrounds
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.sim.found import Find
from scaloft_fi.study import Study
from scaloft_fi.verbs.kills import survivor_table
from scaloft_fi.verbs.survivors import Stage, Survivor, survivors
from scaloft_fi.verbs.verdict import Next

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"
STRONGER = "LATE-human@5s"
LATE_FAULT = Background("person", ("SR2",), stronger=(STRONGER,), laddered=True)


def rho(flight: Outcome, **values: float) -> Outcome:
    """The flight with other robustness."""
    return replace(flight, readings=tuple(replace(r, rho=values.get(r.requirement, r.rho)) for r in flight.readings))


def vacuous(flight: Outcome, requirement: str) -> Outcome:
    """The flight without the requirement's trigger."""
    readings = tuple(replace(r, triggered=0) if r.requirement == requirement else r for r in flight.readings)
    return replace(flight, readings=readings)


def along(flight: Outcome, x_m: float) -> Outcome:
    """The flight on a straight way north, from half of it on `x_m` east of the corridor's middle."""
    signals = {name: [0.0] * 400 for name in TRACK_COLUMNS}
    signals |= {
        "elapsed_s": [i / 20 for i in range(400)],
        "x_m": [0.0] * 200 + [x_m] * 200,
        "y_m": [i / 40 for i in range(400)],
    }
    return replace(flight, track=pack_track(signals))


def survivors_of(
    flights: list[Outcome], backgrounds: Mapping[str, Background], roster: Roster = ROSTER
) -> tuple[Survivor, ...]:
    scored = score(flights, roster, GRID)
    units = {"SR1": "m", "SR2": "share of the limit"}
    return survivors(flights, scored, kill_matrix(scored, ROSTER, GRID), backgrounds, units)


def told(flights: list[Outcome], background: Background = LATE_FAULT, mutant: str = LATE) -> Survivor:
    known = dict.fromkeys([flight.mutant for flight in flights], Background("other"))
    found = survivors_of(flights, {**known, mutant: background})
    return next(survivor for survivor in found if survivor.mutant == mutant)


POOL = pool(HUMAN, NOBODY)


def test_a_detected_mutant_is_no_survivor_even_without_a_kill() -> None:
    assert survivors_of([*POOL, *thrice(LATE, HUMAN, violated={"SR2": 9.0})], {LATE: LATE_FAULT}) == ()
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, seed, violated={"SR2": 9.0} if seed == 1 else {}) for key in keys for seed in range(3)]
    assert survivors_of([*pool(*keys), *spread], {LATE: LATE_FAULT}) == ()


def test_survivors_of_the_worst_class_stand_first_whatever_stage_they_reached() -> None:
    known = dict.fromkeys((LATE, NO, GOAL), Background("other"))
    flights = [*POOL, outcome(NO, HUMAN, altered=0), outcome(LATE, HUMAN, altered=0), *thrice(GOAL, HUMAN)]
    assert [one.mutant for one in survivors_of(flights, known)] == [NO, LATE, GOAL]
    found = survivors_of(flights, known, CLASSED)
    assert [(one.mutant, one.severity) for one in found] == [(GOAL, "injury"), (NO, "delay"), (LATE, None)]
    assert [row[:2] for row in survivor_table(found).rows] == [(GOAL, "injury"), (NO, "delay"), (LATE, "")]


def test_a_mutant_of_which_no_flight_counts_is_to_be_flown_again() -> None:
    found = told([*POOL, outcome(LATE, HUMAN, invalid="the worker died")])
    assert (found.verdict, found.stage, found.next) == (Verdict.NOT_TESTED, Stage.HARNESS, Next.REPEAT)


def test_what_was_declared_beforehand_is_told_with_its_reason() -> None:
    background = replace(LATE_FAULT, expected="the mission is too short")
    found = told([*POOL, outcome(LATE, HUMAN, altered=0)], background)
    assert (found.stage, found.next) == (Stage.INFECT, Next.EXPECTED)
    assert "the mission is too short" in found.why


def test_what_was_declared_and_infects_all_the_same_is_judged_as_any_other() -> None:
    found = told([*POOL, outcome(LATE, HUMAN)], replace(LATE_FAULT, expected="the mission is too short"))
    assert found.next is not Next.EXPECTED


def test_a_seam_that_carries_elsewhere_names_the_situation_to_fly() -> None:
    flights = [*POOL, outcome(LATE, NOBODY, carried=0, altered=0), outcome(NO, HUMAN)]
    listed = survivors_of(flights, {LATE: LATE_FAULT, NO: Background("person", ("SR2",))})
    found = next(survivor for survivor in listed if survivor.mutant == LATE)
    assert (found.stage, found.next) == (Stage.REACH, Next.SITUATION)
    assert f"fly {HUMAN}." in found.why


def test_a_seam_that_carries_nowhere_says_how_much_of_the_grid_is_left() -> None:
    found = told([*POOL, outcome(LATE, NOBODY, carried=0, altered=0)])
    assert "no sample in 1 situation flown; 31 situations of the grid were not flown" in found.why
    whole = [f for key in GRID.point for f in (outcome(BASELINE, key), outcome(LATE, key, carried=0, altered=0))]
    assert "the whole grid was flown: add a situation" in told(whole).why


def test_a_fault_that_changes_nothing_asks_for_a_situation_unless_a_stronger_one_does() -> None:
    weak = [*POOL, outcome(LATE, HUMAN, altered=0), outcome(LATE, NOBODY, carried=0, altered=0)]
    found = told(weak)
    assert (found.stage, found.next) == (Stage.INFECT, Next.SITUATION)
    assert "carries samples in human," in found.why
    found = told([*weak, outcome(STRONGER, HUMAN)])
    assert found.next is Next.MAGNITUDE
    assert STRONGER in found.why


def test_without_a_pool_it_says_what_was_seen_and_which_command_flies_the_pool() -> None:
    found = told([outcome(BASELINE, HUMAN), outcome(LATE, HUMAN, violated={"SR2": 9.0})])
    assert (found.verdict, found.next) == (Verdict.UNDECIDED, Next.POOL)
    assert found.why == (
        "1 flight violates what the baseline of its seed holds. A verdict takes 10 baselines in each situation where "
        f"it infects, and 1 of 1 have fewer: `scaloft-fi run --mutant {LATE}` flies them."
    )
    assert told([outcome(BASELINE, HUMAN), outcome(LATE, HUMAN)]).why.startswith("No flights violate")


def test_what_was_seen_and_not_decided_says_how_many_seeds_would() -> None:
    found = told([*POOL, outcome(LATE, HUMAN, violated={"SR2": 9.0}), outcome(LATE, NOBODY)])
    assert (found.verdict, found.next) == (Verdict.UNDECIDED, Next.SEEDS)
    assert f"1 of 2 flights where SR2 is steady violate it, in {HUMAN}: chance may explain that (p = 0.18" in found.why
    assert f"At that rate 5 seeds would decide: `scaloft-fi run --mutant {LATE} --seeds 5`." in found.why


def test_what_only_a_campaign_of_its_own_would_decide_names_one() -> None:
    once = [outcome(LATE, HUMAN, seed, violated={"SR2": 9.0} if seed == 1 else {}) for seed in range(3)]
    found = told([*POOL, *once])
    assert found.next is Next.SEEDS
    run = f"`scaloft-fi run --campaign ANOTHER --mutant {LATE} --seeds 20`"
    assert f"At that rate 20 seeds in a campaign of its own would decide: {run}." in found.why


def test_too_few_flights_to_decide_are_told_as_such() -> None:
    found = told([*POOL, outcome(LATE, HUMAN)])
    assert (found.verdict, found.next) == (Verdict.UNDECIDED, Next.SEEDS)
    assert "No steady requirement is violated in 1 flight: too few to decide, whatever they do." in found.why
    assert "If every flight violated, 5 seeds would decide" in found.why


def test_what_no_number_of_seeds_would_decide_asks_for_a_situation() -> None:
    rare = [outcome(LATE, HUMAN, seed, violated={"SR2": 9.0} if seed == 1 else {}) for seed in range(20)]
    clean = [outcome(BASELINE, HUMAN, seed) for seed in range(20)]
    found = told([*clean, *rare])
    assert (found.verdict, found.next) == (Verdict.UNDECIDED, Next.SITUATION)
    assert "At that rate no number of seeds up to 50 would decide: add a situation" in found.why


def with_finds(flights: list[Outcome], *finds: Find) -> Survivor:
    scored = score(flights, ROSTER, GRID)
    known_ = {flight.mutant: LATE_FAULT for flight in flights}
    (survivor,) = survivors(flights, scored, kill_matrix(scored, ROSTER, GRID), known_, {}, "mine", known(*finds))
    return survivor


def test_where_a_search_found_a_situation_that_is_to_be_flown_next() -> None:
    for flights in (thrice(LATE, HUMAN), [outcome(LATE, HUMAN)], [outcome(LATE, HUMAN, altered=0)]):
        survivor = with_finds([*POOL, *flights], found(LATE, struck="person"))
        assert (survivor.next, survivor.find) == (Next.FIND, f"shows-{LATE}")
        assert survivor.why.startswith(f"A search found a situation that shows it, shows-{LATE} (human walks, cruise")
        assert survivor.why.endswith(f" `{flies(LATE)}` flies it.")
    assert with_finds([*POOL, *thrice(LATE, HUMAN)], found(NO)).next is Next.MAGNITUDE


def test_a_find_that_was_flown_in_vain_is_told_and_another_one_sought() -> None:
    flights = [*POOL, *(outcome(LATE, HUMAN, seed) for seed in range(6))]
    survivor = with_finds(flights, found(LATE, HUMAN))
    assert (survivor.next, survivor.find) == (Next.MAGNITUDE, "")
    vain = f"shows-{LATE} was flown here with as many seeds, and it is not detected all the same"
    assert survivor.why.endswith(f"{vain}: `scaloft-fi seek {LATE}` seeks another situation.")


def test_a_masked_fault_asks_for_a_larger_one_and_at_the_ladders_end_for_a_situation() -> None:
    masked = [*POOL, *thrice(LATE, HUMAN, digest="clean")]
    assert (told(masked).stage, told(masked).next) == (Stage.PROPAGATE, Next.MAGNITUDE)
    assert f"`scaloft-fi margin {LATE}`" in told(masked).why
    assert "seeds" not in told(masked).why
    assert told(masked, replace(LATE_FAULT, stronger=())).next is Next.SITUATION
    assert "--seeds 5" in told([*POOL, outcome(LATE, HUMAN, digest="clean")]).why


def test_where_nothing_is_steady_a_fault_cannot_show_and_the_states_are_named() -> None:
    red = pool(DARK, red=10, violated={"SR1": 30.0}, struck="bar")
    lit = [f for key in (NOBODY, HUMAN, "T1O0W0D0H0") for f in (*pool(key), outcome(LATE, key, altered=0))]
    found = told([*red, *thrice(LATE, DARK), *lit])
    assert (found.verdict, found.stage, found.next) == (Verdict.NOT_TESTED, Stage.REVEAL, Next.SITUATION)
    assert "It infects in dark, and no safety requirement is steady there" in found.why
    assert "SR1 is red in 1 situation; SR2 is open in 1 situation." in found.why
    assert "mend the unmutated drone" in found.why


def test_where_everything_is_vacuous_no_drone_is_to_be_mended() -> None:
    clean = [vacuous(vacuous(flight, "SR1"), "SR2") for flight in pool(NOBODY)]
    found = told([*clean, *thrice(LATE, NOBODY)])
    assert "SR1 is vacuous in 1 situation" in found.why
    assert "mend" not in found.why


def test_broken_operability_asks_for_an_oracle_where_safety_is_at_risk() -> None:
    flights = [*POOL, *thrice(LATE, HUMAN, violated={"OP1": 60.0}), *thrice(LATE, NOBODY)]
    found = told(flights)
    assert (found.verdict, found.next) == (Verdict.NOT_DETECTED, Next.ORACLE)
    assert "By OP1 it is detected, and killed in 1 of 2 situations where OP1 is steady" in found.why
    assert told(flights, replace(LATE_FAULT, at_risk=("OP1",))).next is Next.OPERABILITY


def test_a_requirement_that_is_not_steady_where_the_fault_infects_asks_for_a_situation() -> None:
    clean = [vacuous(flight, "SR2") for flight in pool(NOBODY)]
    found = told([*clean, *pool(HUMAN), *thrice(LATE, NOBODY)])
    assert (found.verdict, found.next) == (Verdict.NOT_DETECTED, Next.SITUATION)
    assert "SR2, which the cell puts at risk, is vacuous in 1 situation where it infects" in found.why
    assert "it is steady in human" in found.why
    red = told([*pool(HUMAN, red=10, violated={"SR2": 5.0}), *thrice(LATE, HUMAN)])
    assert red.next is Next.SITUATION
    assert "is red in 1 situation where it infects; it is steady nowhere" in red.why


def test_a_dodge_of_a_red_baseline_is_told_as_such() -> None:
    dodge = [outcome(BASELINE, DARK, seed, violated={"SR1": 30.0} if seed else {}) for seed in range(10)]
    found = told([*POOL, *dodge, *thrice(LATE, HUMAN), *thrice(LATE, DARK, violated={"SR1": 30.0})])
    assert found.verdict is Verdict.NOT_DETECTED
    said = "1 flight violates what the baseline of its seed holds, but only where that is not steady: SR1 is red in 1"
    assert said in found.why


def test_a_near_miss_says_how_far_the_margin_fell() -> None:
    first, *others = POOL
    flights = [rho(first, SR1=0.31), *others, *thrice(LATE, HUMAN, NOBODY)]
    flights[-6] = rho(flights[-6], SR1=0.12)
    found = told(flights)
    assert found.next is Next.MAGNITUDE
    assert f"Near miss: SR1 fell from 0.31 to 0.12 m in {HUMAN} (61 % of the margin)." in found.why
    assert found.loss is not None
    assert found.loss.share == pytest.approx(0.19 / 0.31)
    assert told(flights, replace(LATE_FAULT, stronger=())).next is Next.SITUATION


def test_a_margin_that_falls_where_nothing_is_steady_is_no_near_miss() -> None:
    shaky = [outcome(BASELINE, DARK, seed, violated={"SR1": 30.0} if seed > 4 else {}) for seed in range(10)]
    low = [rho(flight, SR1=0.01) for flight in thrice(LATE, DARK)]
    found = told([*POOL, *shaky, *low, *thrice(LATE, HUMAN)])
    assert found.loss is not None
    assert found.loss.share <= 0


def test_far_off_its_path_with_whole_margins_asks_for_an_oracle() -> None:
    first, *others = POOL
    clean = [along(first, 0.0), *others]
    flown = thrice(LATE, HUMAN)
    found = told([*clean, along(flown[0], 0.6), *flown[1:]])
    assert found.next is Next.ORACLE
    assert found.off_path_m == pytest.approx(0.6)
    near = told([*clean, along(flown[0], 0.3), *flown[1:]])
    assert near.next is Next.MAGNITUDE
    assert "at most 0.30 m off its path. No margin fell." in near.why


def test_how_far_a_flight_without_a_trajectory_was_off_its_path_is_not_known() -> None:
    untracked = thrice(LATE, HUMAN)
    for flights in ([*POOL, *untracked], [*POOL, along(untracked[0], 0.3), *untracked[1:]]):
        found = told(flights)
        assert found.off_path_m is None
        assert found.why.startswith("How far the drone flies off its path is not known: no trajectory.")
    on_it = told([along(POOL[0], 0.0), *POOL[1:], along(untracked[0], 0.0), *untracked[1:]])
    assert on_it.off_path_m == 0
    assert on_it.why.startswith("It takes the drone at most 0.00 m off its path.")


@settings(deadline=None, max_examples=usually(25, release=40))
@given(st.one_of(campaigns(), seeded()))
def test_every_mutant_is_detected_or_told_once_in_the_order_of_the_stages(outcomes: list[Outcome]) -> None:
    scored = score(outcomes, ROSTER, GRID)
    matrix = kill_matrix(scored, ROSTER, GRID)
    found = survivors(outcomes, scored, matrix, {row.id: LATE_FAULT for row in matrix.mutants})
    others = {row.id for row in matrix.mutants if row.verdict is not Verdict.DETECTED}
    assert sorted(survivor.mutant for survivor in found) == sorted(others)
    places = [list(Stage).index(survivor.stage) for survivor in found]
    assert places == sorted(places)
    assert all(survivor.why[0].isupper() or survivor.why[0].isdigit() for survivor in found)
    assert all(survivor.why.endswith(".") and "  " not in survivor.why for survivor in found)
    undecided = [survivor for survivor in found if survivor.verdict is Verdict.UNDECIDED]
    assert all("seeds" in survivor.why or "baselines" in survivor.why for survivor in undecided)
    json.dumps(plain(found), allow_nan=False)


def test_the_background_is_what_the_matrix_says() -> None:
    matrix = Study.open().matrix
    found = backgrounds(matrix, [LATE, "NO-speedlimit", "LESS-collision@0.5x", "AFTER-speedlimit"])
    assert found[LATE] == Background("person", ("SR2",), "", ("LATE-human@5s",), laddered=True)
    assert found["NO-speedlimit"].stronger == ()
    assert not found["NO-speedlimit"].laddered
    assert found["LESS-collision@0.5x"].stronger == ("LESS-collision@0.25x",)
    assert "never releases" in found["AFTER-speedlimit"].expected
