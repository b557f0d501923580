"""Accepted survivors: how a campaign stands beside them."""

from __future__ import annotations

from datetime import date, timedelta

from builders import GRID, ROSTER, campaigns, outcome, pool, seeded
from hypothesis import given, settings
from hypothesis import strategies as st
from options import usually

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Disposition, Standing, judge
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.score import complaint

DAY = date(2027, 1, 31)
LATE = Disposition("LATE-human@3s", "A. Engineer", "why", DAY)


def flown(*, killed: bool, keys: tuple[str, ...] = ("T0O0W0D0H1",), seeds: int = 3) -> list[Outcome]:
    violated = {"SR2": 8.0} if killed else {}
    return [
        *pool(*keys),
        *(outcome(LATE.mutant, key, seed, violated=violated) for key in keys for seed in range(seeds)),
    ]


def state(outcomes: list[Outcome], *dispositions: Disposition, today: date | None = DAY) -> list[Standing]:
    return [entry.state for entry in judge(score(outcomes, ROSTER, GRID), ROSTER, dispositions, today)]


def test_a_survivor_is_open_until_it_is_accepted():
    assert state(flown(killed=False)) == [Standing.OPEN]
    assert state(flown(killed=False), LATE) == [Standing.ACCEPTED]


def test_a_disposition_holds_on_its_last_day_and_not_on_the_next():
    assert state(flown(killed=False), LATE, today=DAY) == [Standing.ACCEPTED]
    assert state(flown(killed=False), LATE, today=DAY + timedelta(days=1)) == [Standing.EXPIRED]


def test_a_survival_in_a_situation_that_is_not_named_is_to_be_looked_at():
    there = Disposition(LATE.mutant, "me", "why", DAY, ("T0O0W0D0H1",))
    assert state(flown(killed=False), there) == [Standing.ACCEPTED]
    assert state(flown(killed=False, keys=("T0O0W0D0H1", "T1O0W0D0H1")), there) == [Standing.UNCOVERED]


def test_an_undecided_mutant_is_a_survivor_whose_verdict_is_told():
    (entry,) = judge(score(flown(killed=True, seeds=1), ROSTER, GRID), ROSTER, ())
    assert (entry.state, entry.verdict) == (Standing.OPEN, Verdict.UNDECIDED)
    assert complaint(entry) == "LATE-human@3s is undecided (tested in T0O0W0D0H1) and not accepted"


def test_a_mutant_whose_flights_all_failed_in_the_harness_counts_is_not_tested_and_holds_the_ratchet():
    failed = [outcome(LATE.mutant, seed=seed, invalid="its worker died") for seed in range(2)]
    scored = score([*pool("T0O0W0D0H0"), *failed], ROSTER, GRID)
    assert [str(each) for each in (scored.mutation_score, scored.exercised)] == ["0/1 = 0 %", "0/3 = 0 %"]
    (entry,) = judge(scored, ROSTER, ())
    assert (entry.state, entry.verdict) == (Standing.OPEN, Verdict.NOT_TESTED)
    assert complaint(entry) == "LATE-human@3s is not tested and not accepted"
    assert state([*pool("T0O0W0D0H0"), *failed], LATE) == [Standing.UNTESTED]


def test_a_violation_where_the_unmutated_drone_is_red_neither_detects_nor_survives():
    red = "T0O0W0D1H1"
    late = [outcome(LATE.mutant, red, seed, violated={"SR2": 8.0}) for seed in range(3)]
    assert state([*pool(red, red=10, violated={"SR1": 20.0, "SR2": 20.0}), *late], LATE) == [Standing.UNTESTED]


def test_an_accepted_mutant_that_is_detected_is_stale_and_passes():
    assert state(flown(killed=True), LATE) == [Standing.STALE]
    assert not Standing.STALE.fails


def test_a_disposition_of_what_was_not_flown_is_untested_but_expires_all_the_same():
    assert state([], LATE) == [Standing.UNTESTED]
    assert state([], LATE, today=DAY + timedelta(days=1)) == [Standing.EXPIRED]


@given(st.one_of(campaigns(), seeded()), st.booleans())
@settings(deadline=None, max_examples=usually(25, release=50))
def test_every_mutant_put_to_the_test_is_detected_or_listed(outcomes: list[Outcome], accepted: bool):
    scored = score(outcomes, ROSTER, GRID)
    judged = judge(scored, ROSTER, [LATE] if accepted else [], DAY)
    survivors = {entry.mutant for entry in judged if entry.surviving and entry.mutant in ROSTER.defaults.values()}
    detected = {m.subject.id for m in scored.mutants if ROSTER.counts(m.subject) and m.detected}
    assert len(survivors - detected) + len(detected) == scored.tested.part
    assert len({entry.mutant for entry in judged}) == len(judged)
    for entry in judged:
        assert entry.state.fails == (entry.state in (Standing.OPEN, Standing.UNCOVERED, Standing.EXPIRED))
