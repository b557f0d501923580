"""What is said of a survivor, and which step is next; the sentences are recorded in `test_survivors.txt`."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded, thrice
from finding import found, known
from hypothesis import given
from hypothesis import strategies as st
from options import as_recorded

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Background, backgrounds
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.sim.grid import Find
from scaloft_fi.study import Study
from scaloft_fi.verbs.kills import survivor_table
from scaloft_fi.verbs.verdict import Stage, Survivor, survivors
from scaloft_fi.views.output import plain

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"
STRONGER = "LATE-human@5s"
WEAK = Background("person", ("SR2",), stronger=(STRONGER,), laddered=True)
LAST = replace(WEAK, stronger=())
EXPECTED = replace(WEAK, expected="the mission is too short")
POOL = pool(HUMAN, NOBODY)


def rho(flight: Outcome, **values: float) -> Outcome:
    """The flight with other robustness."""
    return replace(flight, readings=tuple(replace(r, rho=values.get(r.requirement, r.rho)) for r in flight.readings))


def vacuous(flight: Outcome, *requirements: str) -> Outcome:
    """The flight without the triggers of these requirements."""
    readings = tuple(replace(r, triggered=0) if r.requirement in requirements else r for r in flight.readings)
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
    flights: list[Outcome], known_: Mapping[str, Background], roster: Roster = ROSTER, finds: tuple[Find, ...] = ()
) -> tuple[Survivor, ...]:
    scored = score(flights, roster, GRID)
    units = {"SR1": "m", "SR2": "share of the limit"}
    return survivors(flights, scored, kill_matrix(scored, ROSTER, GRID), known_, units, "mine", known(*finds))


def late(
    flights: list[Outcome], background: Background = WEAK, finds: tuple[Find, ...] = (), **others: Background
) -> Survivor:
    """What is said of LATE-human."""
    known_ = dict.fromkeys([flight.mutant for flight in flights], Background("other"))
    listed = survivors_of(flights, {**known_, NO: others.get("no", Background("other")), LATE: background}, finds=finds)
    return next(survivor for survivor in listed if survivor.mutant == LATE)


def said(survivor: Survivor) -> str:
    """All that is said of a survivor."""
    loss = "" if survivor.loss is None else f"; loss {survivor.loss.share:.3f}"
    off = "" if survivor.off_path_m is None else f"; off its path {survivor.off_path_m:.2f} m"
    find = f"; {survivor.find}" if survivor.find else ""
    return f"{survivor.verdict}, {survivor.stage}, next {survivor.next}{find}{loss}{off}\n{survivor.why}"


def _once(seeds: int) -> list[Outcome]:
    """Flights of which one seed violates."""
    return [outcome(LATE, HUMAN, seed, violated={"SR2": 9.0} if seed == 1 else {}) for seed in range(seeds)]


SEEN, SAME, TESTED = outcome(LATE, HUMAN, violated={"SR2": 9.0}), outcome(LATE, HUMAN, altered=0), thrice(LATE, HUMAN)
ELSEWHERE = outcome(LATE, NOBODY, carried=0, altered=0)
NEAR = [rho(POOL[0], SR1=0.31), *POOL[1:], rho(outcome(LATE, HUMAN), SR1=0.12), *thrice(LATE, HUMAN, NOBODY)[1:]]
STRAIGHT = [along(POOL[0], 0.0), *POOL[1:]]
SHAKY = [outcome(BASELINE, DARK, seed, violated={"SR1": 30.0} if seed > 4 else {}) for seed in range(10)]
LIT = [f for key in (NOBODY, HUMAN, "T1O0W0D0H0") for f in (*pool(key), outcome(LATE, key, altered=0))]
CASES: dict[str, tuple[list[Outcome], dict[str, object]]] = {
    "no flight counts": ([*POOL, outcome(LATE, HUMAN, invalid="the worker died")], {}),
    "expected beforehand": ([*POOL, SAME], {"background": EXPECTED}),
    "expected beforehand, and infects": ([*POOL, outcome(LATE, HUMAN)], {"background": EXPECTED}),
    "its seam carries elsewhere": ([*POOL, ELSEWHERE, outcome(NO, HUMAN)], {"no": Background("person", ("SR2",))}),
    "its seam carries nowhere": ([*POOL, ELSEWHERE], {}),
    "its seam carries nowhere in the whole grid": (
        [f for key in GRID.point for f in (outcome(BASELINE, key), outcome(LATE, key, carried=0, altered=0))],
        {},
    ),
    "changes nothing": ([*POOL, SAME, ELSEWHERE], {}),
    "changes nothing, a stronger one does": ([*POOL, SAME, ELSEWHERE, outcome(STRONGER, HUMAN)], {}),
    "seen without a pool": ([outcome(BASELINE, HUMAN), SEEN], {}),
    "nothing seen without a pool": ([outcome(BASELINE, HUMAN), outcome(LATE, HUMAN)], {}),
    "seen and not decided": ([*POOL, SEEN, outcome(LATE, NOBODY)], {}),
    "only a campaign of its own decides": ([*POOL, *_once(3)], {}),
    "too few flights": ([*POOL, outcome(LATE, HUMAN)], {}),
    "no number of seeds decides": ([*(outcome(BASELINE, HUMAN, seed) for seed in range(20)), *_once(20)], {}),
    "masked": ([*POOL, *thrice(LATE, HUMAN, digest="clean")], {}),
    "masked at the ladder's end": ([*POOL, *thrice(LATE, HUMAN, digest="clean")], {"background": LAST}),
    "masked once": ([*POOL, outcome(LATE, HUMAN, digest="clean")], {}),
    "nothing is steady": ([*pool(DARK, red=10, violated={"SR1": 30.0}, struck="bar"), *thrice(LATE, DARK), *LIT], {}),
    "everything is vacuous": ([*(vacuous(f, "SR1", "SR2") for f in pool(NOBODY)), *thrice(LATE, NOBODY)], {}),
    "operability breaks": ([*POOL, *thrice(LATE, HUMAN, violated={"OP1": 60.0}), *thrice(LATE, NOBODY)], {}),
    "operability breaks, which is at risk": (
        [*POOL, *thrice(LATE, HUMAN, violated={"OP1": 60.0}), *thrice(LATE, NOBODY)],
        {"background": replace(WEAK, at_risk=("OP1",))},
    ),
    "vacuous where it infects": ([*(vacuous(f, "SR2") for f in pool(NOBODY)), *pool(HUMAN), *thrice(LATE, NOBODY)], {}),
    "red where it infects": ([*pool(HUMAN, red=10, violated={"SR2": 5.0}), *TESTED], {}),
    "dodges a red baseline": (
        [
            *(outcome(BASELINE, DARK, seed, violated={"SR1": 30.0} if seed else {}) for seed in range(10)),
            *(*POOL, *TESTED, *thrice(LATE, DARK, violated={"SR1": 30.0})),
        ],
        {},
    ),
    "a near miss": (NEAR, {}),
    "a near miss at the ladder's end": (NEAR, {"background": LAST}),
    "a margin falls where nothing is steady": (
        [*POOL, *SHAKY, *(rho(flight, SR1=0.01) for flight in thrice(LATE, DARK)), *TESTED],
        {},
    ),
    "far off its path": ([*STRAIGHT, along(TESTED[0], 0.6), *TESTED[1:]], {}),
    "near its path": ([*STRAIGHT, along(TESTED[0], 0.3), *TESTED[1:]], {}),
    "on its path": ([*STRAIGHT, along(TESTED[0], 0.0), *TESTED[1:]], {}),
    "without a trajectory": ([*POOL, *TESTED], {}),
    "without a trajectory of the baseline": ([*POOL, along(TESTED[0], 0.3), *TESTED[1:]], {}),
    "has a find, not detected": ([*POOL, *TESTED], {"finds": (found(LATE, struck="person"),)}),
    "has a find, undecided": ([*POOL, outcome(LATE, HUMAN)], {"finds": (found(LATE, struck="person"),)}),
    "has a find, not tested": ([*POOL, SAME], {"finds": (found(LATE, struck="person"),)}),
    "another has a find": ([*POOL, *TESTED], {"finds": (found(NO),)}),
    "its find was flown in vain": (
        [*POOL, *(outcome(LATE, HUMAN, seed) for seed in range(6))],
        {"finds": (found(LATE, HUMAN),)},
    ),
}


def test_what_is_said_of_a_survivor_is_as_recorded():
    as_recorded(__file__, {name: said(late(flights, **how)) for name, (flights, how) in CASES.items()})  # type: ignore[arg-type]


def test_a_detected_mutant_is_no_survivor_even_without_a_kill():
    assert survivors_of([*POOL, *thrice(LATE, HUMAN, violated={"SR2": 9.0})], {LATE: WEAK}) == ()
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, seed, violated={"SR2": 9.0} if seed == 1 else {}) for key in keys for seed in range(3)]
    assert survivors_of([*pool(*keys), *spread], {LATE: WEAK}) == ()


def test_survivors_of_the_worst_class_stand_first_whatever_stage_they_reached():
    known_ = dict.fromkeys((LATE, NO, GOAL), Background("other"))
    flights = [*POOL, outcome(NO, HUMAN, altered=0), SAME, *thrice(GOAL, HUMAN)]
    assert [one.mutant for one in survivors_of(flights, known_)] == [NO, LATE, GOAL]
    listed = survivors_of(flights, known_, CLASSED)
    assert [(one.mutant, one.severity) for one in listed] == [(GOAL, "injury"), (NO, "delay"), (LATE, None)]
    assert [row[:2] for row in survivor_table(listed).rows] == [(GOAL, "injury"), (NO, "delay"), (LATE, "")]
    counts = Counter(one.next.value for one in listed)
    assert survivor_table(listed).notes[-1].startswith("Survivors: 3; next: ")
    assert all(f"{name} {count}" in survivor_table(listed).notes[-1] for name, count in counts.items())


@given(st.one_of(campaigns(), seeded()))
def test_every_mutant_is_detected_or_told_once_in_the_order_of_the_stages(outcomes: list[Outcome]):
    matrix = kill_matrix(score(outcomes, ROSTER, GRID), ROSTER, GRID)
    listed = survivors_of(outcomes, {row.id: WEAK for row in matrix.mutants})
    others = {row.id for row in matrix.mutants if row.verdict is not Verdict.DETECTED}
    assert sorted(survivor.mutant for survivor in listed) == sorted(others)
    places = [list(Stage).index(survivor.stage) for survivor in listed]
    assert places == sorted(places)
    for survivor in listed:
        assert survivor.why[0].isupper() or survivor.why[0].isdigit()
        assert survivor.why.endswith(".")
        assert "  " not in survivor.why
        assert survivor.verdict is not Verdict.UNDECIDED or "seeds" in survivor.why or "baselines" in survivor.why
    json.dumps(plain(listed), allow_nan=False)


@pytest.mark.parametrize(
    ("mutant", "background"),
    [
        (LATE, Background("person", ("SR2",), "", ("LATE-human@5s",), laddered=True)),
        ("LESS-collision@0.5x", ("LESS-collision@0.25x",)),
        ("NO-speedlimit", ()),
    ],
)
def test_the_background_is_what_the_matrix_says(mutant: str, background: object):
    told = backgrounds(Study.open().matrix, [mutant, "AFTER-speedlimit"])
    assert background in (told[mutant], told[mutant].stronger)
    assert "never releases" in told["AFTER-speedlimit"].expected
