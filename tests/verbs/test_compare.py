"""Two campaigns held against each other."""

from __future__ import annotations

from dataclasses import replace

from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Facts
from scaloft_fi.verbs.diff import Comparison, Difference, compare, comparison_table

M = "LATE-human@3s"


def _compare(first: list[Outcome], second: list[Outcome]) -> Comparison:
    return compare(first, second, ROSTER, GRID)


def test_another_status_is_a_difference() -> None:
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    assert compared.same == 1
    first, second = Facts("revealed", "landed", ("SR2",)), Facts("survived", "landed", ())
    assert compared.differences == (Difference(M, "T0O0W0D0H0", 0, first, second),)


def test_another_ending_is_a_difference() -> None:
    (difference,) = _compare([outcome()], [replace(outcome(), ending="struck")]).differences
    assert (str(difference.first), str(difference.second)) == ("held, landed", "held, struck")


def test_other_bits_with_the_same_status_are_only_counted() -> None:
    compared = _compare([outcome(), outcome(M, digest="a")], [outcome(), outcome(M, digest="b")])
    assert (compared.same, compared.other_bits, compared.differences) == (1, 1, ())


def test_a_flight_that_one_of_them_lacks_is_a_difference() -> None:
    (difference,) = _compare([outcome(), outcome(M)], [outcome()]).differences
    assert (difference.mutant, difference.second) == (M, None)


def test_the_table_names_both_campaigns() -> None:
    compared = _compare([outcome(), outcome(M, violated={"SR2": 5.0})], [outcome(), outcome(M)])
    table = comparison_table(compared, "old", "new")
    assert table.headers[3:] == ("old", "new")
    assert table.rows == ((M, "T0O0W0D0H0", 0, "revealed SR2, landed", "survived, landed"),)
    assert "1 flights are the same bit for bit" in table.notes[0]


@given(campaigns())
def test_a_campaign_does_not_differ_from_itself(outcomes: list[Outcome]) -> None:
    once = list({outcome.name: outcome for outcome in outcomes}.values())
    assert _compare(once, once[::-1]) == Comparison(len(once), 0, ())
