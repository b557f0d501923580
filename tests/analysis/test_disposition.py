"""Accepted survivors: what the file may say, and how a campaign stands beside it."""

from __future__ import annotations

from datetime import date, timedelta
from pathlib import Path

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.disposition import Disposition, Judged, State, draft, judge, load_dispositions, told
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.score import score
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.stack.reference.declaration import REFERENCE

MATRIX = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
KEYS = [key for key, _ in GRID.points]
GOOD = """\
LATE-human:
  status: accepted
  owner: A. Engineer
  reason: walking pace is slow enough there
  expires: 2027-01-31
  situations: [T0O0W0D0H1]
"""
DAY = date(2027, 1, 31)
LATE = Disposition("LATE-human@3s", "A. Engineer", "why", DAY)


def loaded(folder: Path, text: str) -> tuple[Disposition, ...]:
    path = folder / "dispositions.yaml"
    path.write_text(text, encoding="utf-8")
    return load_dispositions(path, MATRIX, KEYS)


def test_a_study_without_the_file_has_accepted_nothing(tmp_path: Path) -> None:
    assert load_dispositions(tmp_path / "dispositions.yaml", MATRIX, KEYS) == ()


def test_a_bare_cell_is_its_default_and_the_place_is_remembered(tmp_path: Path) -> None:
    (only,) = loaded(tmp_path, GOOD)
    assert (only.mutant, only.expires, only.situations) == ("LATE-human@3s", DAY, ("T0O0W0D0H1",))
    assert only.place.endswith("dispositions.yaml:1")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("LATE-human:", "LATE-humna:", "did you mean 'LATE-human'?"),
        ("LATE-human:", "EARLY-collision:", "not meaningful"),
        ("status: accepted", "status: acepted", "status='acepted' is not known; did you mean 'accepted'?"),
        ("owner: A. Engineer", "owner: ''", "owner='' must be a text"),
        ("reason: walking pace is slow enough there", "reason: ' '", "reason=' ' must be a text"),
        ("2027-01-31", "2027-02-30", "expires='2027-02-30' cannot be read: day is out of range"),
        ("2027-01-31", "'2027-02-30'", "must be a date such as 2027-01-31"),
        ("2027-01-31", "''", "must be a date such as 2027-01-31"),
        ("2027-01-31", "31.1.2027", "must be a date such as 2027-01-31"),
        ("T0O0W0D0H1", "T0O0W0D0H2", "did you mean 'T0O0W0D0H"),
        ("[T0O0W0D0H1]", "[]", "must be a list of at least one"),
        ("owner:", "onwer:", "unknown key 'onwer'"),
        ("  situations", "  sitautions", "unknown key 'sitautions'"),
        ("  expires: 2027-01-31\n", "", "lacks the key 'expires'"),
    ],
)
def test_what_it_does_not_understand_it_refuses_with_the_place(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(InputError) as error:
        loaded(tmp_path, GOOD.replace(old, new))
    assert says in str(error.value)
    assert "dispositions.yaml:" in str(error.value)


@pytest.mark.parametrize("again", ["LATE-human", "LATE-human@3s", "LATE-human@3.0s"])
def test_a_mutant_that_stands_twice_is_refused_however_it_is_written(tmp_path: Path, again: str) -> None:
    with pytest.raises(InputError, match=r"twice|stands at"):
        loaded(tmp_path, GOOD + GOOD.replace("LATE-human", again))


def flown(*, killed: bool, keys: tuple[str, ...] = ("T0O0W0D0H1",), seeds: int = 3) -> list[Outcome]:
    violated = {"SR2": 8.0} if killed else {}
    return [
        *pool(*keys),
        *(outcome(LATE.mutant, key, seed, violated=violated) for key in keys for seed in range(seeds)),
    ]


def state(outcomes: list[Outcome], *dispositions: Disposition, today: date | None = DAY) -> list[State]:
    return [entry.state for entry in judge(score(outcomes, ROSTER, GRID), ROSTER, dispositions, today)]


def test_a_survivor_is_open_until_it_is_accepted() -> None:
    assert state(flown(killed=False)) == [State.OPEN]
    assert state(flown(killed=False), LATE) == [State.ACCEPTED]


def test_a_disposition_holds_on_its_last_day_and_not_on_the_next() -> None:
    assert state(flown(killed=False), LATE, today=DAY) == [State.ACCEPTED]
    assert state(flown(killed=False), LATE, today=DAY + timedelta(days=1)) == [State.EXPIRED]


def test_a_survival_in_a_situation_that_is_not_named_is_to_be_looked_at() -> None:
    there = Disposition(LATE.mutant, "me", "why", DAY, ("T0O0W0D0H1",))
    assert state(flown(killed=False), there) == [State.ACCEPTED]
    assert state(flown(killed=False, keys=("T0O0W0D0H1", "T1O0W0D0H1")), there) == [State.UNCOVERED]


def test_an_undecided_mutant_is_a_survivor_whose_verdict_is_told() -> None:
    (entry,) = judge(score(flown(killed=True, seeds=1), ROSTER, GRID), ROSTER, ())
    assert (entry.state, entry.verdict) == (State.OPEN, Verdict.UNDECIDED)
    assert told(entry) == "LATE-human@3s is undecided (tested in T0O0W0D0H1) and not accepted"


def test_a_violation_where_the_unmutated_drone_is_red_neither_detects_nor_survives() -> None:
    red = "T0O0W0D1H1"
    late = [outcome(LATE.mutant, red, seed, violated={"SR2": 8.0}) for seed in range(3)]
    assert state([*pool(red, red=10, violated={"SR1": 20.0, "SR2": 20.0}), *late], LATE) == [State.UNTESTED]


def test_an_accepted_mutant_that_is_detected_is_stale_and_passes() -> None:
    assert state(flown(killed=True), LATE) == [State.STALE]
    assert not State.STALE.fails


def test_a_disposition_of_what_was_not_flown_is_untested_but_expires_all_the_same() -> None:
    assert state([], LATE) == [State.UNTESTED]
    assert state([], LATE, today=DAY + timedelta(days=1)) == [State.EXPIRED]


@given(st.one_of(campaigns(), seeded()), st.booleans())
@settings(deadline=None, max_examples=50)
def test_every_mutant_put_to_the_test_is_detected_or_listed(outcomes: list[Outcome], accepted: bool) -> None:
    scored = score(outcomes, ROSTER, GRID)
    judged = judge(scored, ROSTER, [LATE] if accepted else [], DAY)
    survivors = {entry.mutant for entry in judged if entry.surviving and entry.mutant in ROSTER.defaults.values()}
    detected = {m.subject.id for m in scored.mutants if ROSTER.counts(m.subject) and m.detected}
    assert len(survivors - detected) + len(detected) == scored.tested.part
    assert len({entry.mutant for entry in judged}) == len(judged)
    for entry in judged:
        assert entry.state.fails == (entry.state in (State.OPEN, State.UNCOVERED, State.EXPIRED))


def test_a_draft_is_refused_until_it_is_filled_in_and_then_loads(tmp_path: Path) -> None:
    text = draft([Judged(LATE.mutant, State.OPEN), Judged("NO-human@100%", State.OPEN), Judged("x", State.ACCEPTED)])
    with pytest.raises(InputError, match="owner='' must be a text"):
        loaded(tmp_path, text)
    filled = text.replace('owner: ""', "owner: me").replace('reason: ""', "reason: why")
    entries = loaded(tmp_path, filled.replace('expires: ""', "expires: 2027-01-31"))
    assert [entry.mutant for entry in entries] == [LATE.mutant, "NO-human@100%"]


def test_every_sentence_names_the_mutant_and_what_to_do() -> None:
    known = Disposition(LATE.mutant, "me", "why", DAY, ("D0",), "f.yaml:3")
    for found in State:
        judged = Judged(LATE.mutant, found, ("D0", "D1"), None if found is State.OPEN else known)
        assert LATE.mutant in told(judged)
        assert found is State.OPEN or "f.yaml:3" in told(judged)
