from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.pool import findings, tallies
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import By, groups, score
from scaloft_fi.console import PIPED
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.verbs.first_screen import MANY_ROWS, tables_behind
from scaloft_fi.views.table import Format, Table, render

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN = ["T0O0W0D0H1", "T0O1W0D0H1", "T1O0W0D0H1"]
NOBODY, DARK = "T0O0W0D0H0", "T1O0W0D1H0"

CAMPAIGN = [
    *pool(*HUMAN),
    *pool(NOBODY, vacuous=("SR2",)),
    *pool(DARK, red=9, violated={"SR1": 30.0}, struck="bar"),
    outcome(PLACEBO_ID, HUMAN[0], altered=0),
    *(outcome(LATE, key, violated={"SR2": 12.35}) for key in HUMAN),
    outcome(LATE, NOBODY, carried=0, altered=0),
    *(outcome(NO, key, violated={"SR1": 14.0}, struck="person") for key in HUMAN),
    *(outcome(GOAL, key) for key in HUMAN),
    outcome(GOAL, DARK, violated={"SR1": 20.0}, struck="wall"),
]


def tables(outcomes: list[Outcome], by: By | None = None) -> dict[str, Table]:
    rulings, scored = rulings_of(outcomes), score(outcomes, ROSTER, GRID)
    found = tables_behind(scored, rulings, coverage(outcomes, GRID), GRID, by)
    return {table.title: table for table in found}


def test_the_ratios_name_their_population_and_the_false_detections_expected() -> None:
    table = tables(CAMPAIGN)["Mutation score"]
    assert table.rows[3][:2] == ("mutation score", "2/3 = 67 %")
    assert all(row[2] for row in table.rows)
    assert table.rows[4][0] == "firm"
    assert "0.03 at most" in table.notes[0]
    assert table.notes[1].startswith("No redraws:")


def test_the_pairs_that_put_no_fault_to_the_test_say_why() -> None:
    table = tables(CAMPAIGN)["Pairs that put no fault to the test"]
    assert [row[:4] for row in table.rows] == [
        (NOBODY, "SR2", "vacuous", "0/10"),
        (DARK, "OP1", "open", "0/10"),
        (DARK, "SR1", "red", "9/10"),
        (DARK, "SR2", "open", "0/10"),
    ]


def test_of_many_mutants_the_stages_are_summed_by_parameter() -> None:
    ids = [f"LATE-{parameter}@{n}s" for parameter in ("human", "depth") for n in range(MANY_ROWS)]
    flown = [outcome(), outcome(PLACEBO_ID, altered=0), *(outcome(id_) for id_ in ids)]
    table = tables(flown)["Where the faults stopped (flights)"]
    assert [(row[0], row[-1]) for row in table.rows] == [
        (PLACEBO_ID, 1),
        ("human", MANY_ROWS),
        ("depth", MANY_ROWS),
        ("all", 49),
    ]


@pytest.mark.parametrize("by", [None, *By])
@settings(deadline=None, max_examples=15)
@given(outcomes=st.one_of(campaigns(), seeded()))
def test_every_table_of_every_campaign_fits_a_terminal(by: By | None, outcomes: list[Outcome]) -> None:
    text = render(list(tables(outcomes, by).values()), Format.TABLE)
    assert max(len(line) for line in text.splitlines()) <= PIPED


def test_json_and_csv_hold_the_cells() -> None:
    table = Table("T", ("a", "b"), (("x", 1), ("y, z", None)), ("note",))
    assert json.loads(render([table], Format.JSON)) == [
        {"title": "T", "rows": [{"a": "x", "b": 1}, {"a": "y, z", "b": None}], "notes": ["note"]}
    ]
    lines = render([table], Format.CSV).splitlines()
    assert lines[0] == "# T"
    assert list(csv.reader(io.StringIO("\n".join(lines[1:])))) == [["a", "b"], ["x", "1"], ["y, z", ""]]


def test_a_table_too_wide_narrows_the_column_that_costs_the_fewest_lines() -> None:
    """Each row has four words of text; only the last has a long list, which is what wraps."""
    rows = tuple((f"row {n}", "w" * 40, "four words of text", "a, " * (20 if n == 9 else 3)) for n in range(10))
    lines = render([Table("T", ("name", "word", "text", "list"), rows)], Format.TABLE).splitlines()
    assert max(map(len, lines)) <= PIPED
    assert sum("four words of text" in line for line in lines) == 10
    assert len(lines) < 4 + 10 + 4


def parts(by: By) -> dict[str, tuple[Ratio, Ratio]]:
    found = score(CAMPAIGN, ROSTER, GRID)
    return {group.name: (group.tested, group.flown) for group in groups(found, by, GRID)}


def test_the_score_by_guideword_and_by_parameter_is_of_detected_mutants() -> None:
    assert parts(By.GUIDEWORD) == {
        "NO": (Ratio(1, 1), Ratio(1, 1)),
        "LATE": (Ratio(1, 1), Ratio(1, 1)),
        "MORE": (Ratio(0, 1), Ratio(0, 1)),
    }
    assert parts(By.PARAMETER) == {"human": (Ratio(2, 2), Ratio(2, 2)), "goal": (Ratio(0, 1), Ratio(0, 1))}


def test_the_score_by_requirement_counts_a_mutant_for_each_that_detects_it() -> None:
    found = {name: ratio for name, (ratio, _) in parts(By.REQUIREMENT).items()}
    assert found == {"SR1": Ratio(1, 3), "SR2": Ratio(1, 3), "OP1": Ratio(0, 3)}


def test_the_score_by_situation_and_by_axis_is_of_kills() -> None:
    found = parts(By.SITUATION)
    assert found[HUMAN[0]] == (Ratio(2, 3), Ratio(2, 3))
    assert found[DARK] == (Ratio(0, 0), Ratio(0, 1))
    axis = parts(By.AXIS)
    assert len(axis) == 10
    assert axis["H = human"] == (Ratio(6, 9), Ratio(6, 9))
    assert axis["H = nobody"] == (Ratio(0, 0), Ratio(0, 2))


def test_the_score_by_severity_has_the_worst_class_first_and_what_has_no_class_last() -> None:
    found = groups(score(CAMPAIGN, CLASSED, GRID), By.SEVERITY, GRID)
    assert [(group.name, group.tested) for group in found] == [
        ("injury", Ratio(0, 1)),
        ("delay", Ratio(1, 1)),
        ("no class", Ratio(1, 1)),
    ]


@given(st.one_of(campaigns(), seeded()))
@settings(deadline=None, max_examples=20)
def test_severity_enters_no_ratio_and_no_verdict(outcomes: list[Outcome]) -> None:
    plain, classed = score(outcomes, ROSTER, GRID), score(outcomes, CLASSED, GRID)
    assert [replace(mutant, severity=None) for mutant in classed.mutants] == list(plain.mutants)
    bare = {"mutants": (), "counted": (), "controls": (), "placebo": None}
    assert replace(classed, **bare) == replace(plain, **bare)


@given(st.one_of(campaigns(), seeded()), st.sampled_from([By.GUIDEWORD, By.PARAMETER, By.SEVERITY]))
@settings(deadline=None)
def test_the_parts_of_the_score_sum_to_the_score(outcomes: list[Outcome], by: By) -> None:
    found = score(outcomes, CLASSED, GRID)
    listed = groups(found, by, GRID)
    assert sum(group.tested.part for group in listed) == found.mutation_score.part
    assert sum(group.tested.whole for group in listed) == found.tested.part
    assert sum(group.flown.whole for group in listed) == found.tested.whole


def test_the_baselines_findings_name_the_first_violation_and_what_stayed_open() -> None:
    flown = [
        outcome(BASELINE, DARK, 0, violated={"SR1": 30.0}, struck="bar"),
        outcome(BASELINE, DARK, 1, violated={"SR1": 28.0}, struck="bar"),
        outcome(BASELINE, DARK, 2),
    ]
    (dark,) = findings(flown, GRID)
    assert (dark.situation, dark.flown, dark.red, dark.violated) == (DARK, 3, 2, ("SR1",))
    assert dark.open == ("SR2", "SR2-literal", "OP1")
    assert dark.first is not None
    assert (dark.first[0].t_s, dark.first[1]) == (28.0, 1)


def test_each_requirement_is_tallied_over_the_baseline_flights() -> None:
    clean = [outcome(), outcome(BASELINE, DARK, violated={"SR1": 30.0}, struck="bar")]
    first, *_, last = tallies(clean)
    assert (first.requirement, dict(first.compliances), first.least_rho) == (
        "SR1",
        {"violated": 1, "open": 0, "vacuous": 0, "held": 1},
        -0.1,
    )
    assert (last.requirement, dict(last.compliances)["open"], last.triggered) == ("OP1", 1, 2)


@given(campaigns())
def test_the_verdicts_on_a_requirement_sum_to_the_baseline_flights(outcomes: list[Outcome]) -> None:
    baselines = sum(o.mutant == BASELINE and not o.invalid for o in outcomes)
    assert all(sum(count for _, count in tally.compliances) == baselines for tally in tallies(outcomes))
