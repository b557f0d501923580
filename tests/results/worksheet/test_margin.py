"""Margins from stored outcomes alone: what a ladder says, and the least over situations."""

from __future__ import annotations

from pathlib import Path

import pytest
from builders import GRID, campaigns, outcome
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.worksheet.margin import Answer, Margin, Scale, Subject, Tried, lowest, margin_of, margins
from scaloft_fi.results.worksheet.margins import LEGEND, cell_margins, margin_json, margin_tables

MATRIX = load_matrix(Path(__file__).parents[3] / "hazop")
SECONDS = Scale("s", 1, 0.0)
KEYS = [key for key, _ in GRID.points]
HUMAN = "T0O0W0D0H1"
LATE = Subject("LATE-human", "s")

magnitudes = st.lists(st.integers(1, 100).map(lambda n: n / 10), min_size=1, max_size=6, unique=True)


@given(st.lists(st.tuples(st.floats(0.05, 12.0), magnitudes), min_size=1, max_size=6), st.sampled_from([1, -1]))
def test_the_least_threshold_of_all_situations_is_within_the_interval(
    flown: list[tuple[float, list[float]]], sign: int
) -> None:
    scale = Scale("s", sign)

    def margin(threshold: float, tried: list[float]) -> Margin:
        killed = {m: Answer.KILLED if sign * m >= sign * threshold else Answer.SURVIVED for m in tried}
        return margin_of(scale, [Tried(m, answer) for m, answer in killed.items()])

    least = lowest(margin(*entry) for entry in flown)
    true = min((threshold for threshold, _ in flown), key=scale.severity)
    assert least is not None
    assert least.kills is None or scale.severity(true) <= scale.severity(least.kills)
    assert least.survives is None or scale.severity(least.survives) < scale.severity(true)


def flights(*answers: tuple[str, str, dict[str, float]]) -> list[Outcome]:
    """Outcomes of (mutant, situation, violated), with the baselines they need."""
    made = [outcome(situation=key) for key in dict.fromkeys(key for _, key, _ in answers)]
    return [*made, *(outcome(mutant, key, violated=violated) for mutant, key, violated in answers)]


def test_a_ladder_flown_by_any_verb_has_an_interval() -> None:
    told = cell_margins(
        flights(("LATE-human@1s", HUMAN, {}), ("LATE-human@3s", HUMAN, {"SR2": 8.0}), ("LATE-human@5s", HUMAN, {})),
        MATRIX,
    )
    assert told["LATE-human"] == "1-3 s !"


def test_a_default_alone_bounds_from_one_side() -> None:
    assert cell_margins(flights(("LATE-human@3s", HUMAN, {})), MATRIX)["LATE-human"] == "> 3 s"
    assert cell_margins(flights(("LATE-human@3s", HUMAN, {"SR2": 8.0})), MATRIX)["LATE-human"] == "<= 3 s"


def test_two_faults_of_a_cell_each_have_their_own() -> None:
    told = cell_margins(flights(("NO-depth@3s", HUMAN, {}), ("NO-depth@50%", HUMAN, {"SR1": 9.0})), MATRIX)
    assert told["NO-depth"] == "> 3 s; <= 50 %"


def test_faults_without_an_order_say_which_of_them_kill() -> None:
    told = cell_margins(
        flights(
            ("PARTOF-goal@x", HUMAN, {"SR1": 9.0}),
            ("PARTOF-goal@y", HUMAN, {}),
            ("NO-waypoint", HUMAN, {}),
            ("NO-map", HUMAN, {"SR1": 9.0}),
        ),
        MATRIX,
    )
    assert (told["PARTOF-goal"], told["NO-waypoint"], told["NO-map"]) == ("x kills", "survives", "kills")


def test_operability_has_margins_of_its_own() -> None:
    flown = flights(("LATE-goal@1s", HUMAN, {}), ("LATE-goal@3s", HUMAN, {"OP1": 50.0}))
    assert cell_margins(flown, MATRIX)["LATE-goal"] == "> 3 s"
    assert cell_margins(flown, MATRIX, Kind.OPERABILITY)["LATE-goal"] == "1-3 s"


def test_what_no_sample_reached_or_no_sample_differed_in_tells_nothing() -> None:
    clean = [outcome(situation=HUMAN)]
    unreached = outcome("LATE-human@3s", HUMAN, altered=0, carried=0)
    harmless = outcome("LATE-human@3s", HUMAN, altered=0)
    for flown in (unreached, harmless):
        assert cell_margins([*clean, flown], MATRIX)["LATE-human"] == "?"


def test_a_harmless_magnitude_is_a_survival_beside_one_that_kills() -> None:
    flown = flights(("LATE-human@3s", HUMAN, {"SR2": 8.0}))
    told = cell_margins([*flown, outcome("LATE-human@0.5s", HUMAN, altered=0)], MATRIX)
    assert told["LATE-human"] == "0.5-3 s"


def test_where_the_baseline_breaks_what_the_cell_puts_at_risk_nothing_is_told() -> None:
    red = outcome(situation=HUMAN, violated={"SR2": 6.0})
    assert cell_margins([red, outcome("LATE-human@3s", HUMAN)], MATRIX)["LATE-human"] == "?"
    assert cell_margins([red, outcome("LATE-depth@0.4s", HUMAN)], MATRIX)["LATE-depth"] == "> 0.4 s"


@given(campaigns())
def test_margins_do_not_depend_on_the_order_of_outcomes_and_say_nothing_unknown(outcomes: list[Outcome]) -> None:
    assert cell_margins(outcomes, MATRIX) == cell_margins(outcomes[::-1], MATRIX)
    assert set(cell_margins(outcomes, MATRIX)) == {cell.name for cell in MATRIX}
    for listed in margins(outcomes, MATRIX).values():
        for margin in listed:
            killed = {entry.magnitude for entry in margin.tried if entry.answer is Answer.KILLED}
            assert (margin.kills in killed) == bool(killed)
            assert margin.survives not in killed


def test_the_table_names_ends_killer_robustness_and_what_was_flown() -> None:
    found = margins(flights(("LATE-human@1s", HUMAN, {}), ("LATE-human@3s", HUMAN, {"SR2": 8.0})), MATRIX)
    (table,) = margin_tables(found, (), 1)
    assert table.rows == ((HUMAN, "1-3 s", "1 s", "3 s", "SR2", "SR2 0.3 / -0.1", "1/1", "1 3", ""),)
    (entry,) = margin_json(found)
    assert (entry["cell"], entry["least"]["survives"], entry["least"]["kills"]) == ("LATE-human", 1.0, 3.0)


def test_an_infinite_magnitude_is_a_text_in_json() -> None:
    found = margins(flights(("OTHERTHAN-depth@infs", HUMAN, {"SR1": 8.0})), MATRIX)
    (entry,) = margin_json(found)
    assert entry["least"]["kills"] == "inf"


@pytest.mark.parametrize("line", LEGEND)
def test_the_legend_fits_a_terminal(line: str) -> None:
    assert len(line) <= 120
    assert line.isascii()
