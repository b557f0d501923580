from __future__ import annotations

import csv
import io
import json

import pytest
from builders import GRID, ROSTER, campaigns, outcome
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.scoring.baseline import findings, holds_somewhere, tallies
from scaloft_fi.results.scoring.grouping import By, groups
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.scoring.redraw import NO_PAIRS
from scaloft_fi.results.scoring.score import score
from scaloft_fi.results.scoring.tables import DECIDED, MANY, ONE_SEED, SHORT, score_tables
from scaloft_fi.results.telling.table import WIDTH, Format, Table, render

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN, NOBODY, DARK = "T0O0W0D0H1", "T0O0W0D0H0", "T1O0W0D1H0"

CAMPAIGN = [
    outcome(BASELINE, HUMAN),
    outcome(BASELINE, NOBODY),
    outcome(BASELINE, DARK, violated={"SR1": 30.0}, struck="bar"),
    outcome(PLACEBO, HUMAN, altered=0),
    outcome(LATE, HUMAN, violated={"SR2": 12.35}),
    outcome(LATE, NOBODY, carried=0, altered=0),
    outcome(NO, HUMAN, violated={"SR2": 11.0, "SR1": 14.0}, struck="person"),
    outcome(GOAL, HUMAN),
    outcome(GOAL, NOBODY, violated={"OP1": 60.0}),
]


def test_the_tables_say_kills_requirement_time_and_condition() -> None:
    text = render(score_tables(CAMPAIGN, ROSTER, GRID), Format.TABLE)
    (row,) = [
        line for line in (" ".join(raw.split()) for raw in text.splitlines()) if line.startswith(f"{LATE} killed")
    ]
    assert row == f"{LATE} killed 1/1 [21, 100] 1/2 SR2 1/1 12.3 s human"
    assert "mutation score  2/3 = 67 % [21, 94]" in text
    assert "T1O0W0D1H0   1/1 = 100 % [21, 100]  SR1" in text
    assert "distinct situations  3/32 = 9 %" in text


def test_the_highest_rung_stands_first_and_a_long_condition_below() -> None:
    tables = {table.title: table for table in score_tables(CAMPAIGN, ROSTER, GRID)}
    assert [row[0] for row in tables["Mutants"].rows] == [NO, LATE, GOAL]
    corners = [key for key, _ in GRID.points if key in ("T0O0W1D1H0", "T1O0W0D0H1", "T0O1W0D0H0")]
    more = [outcome(m, key, violated={"SR1": 9.0} if m == LATE else {}) for key in corners for m in (BASELINE, LATE)]
    tables = {table.title: table for table in score_tables([*CAMPAIGN, *more], ROSTER, GRID)}
    (row,) = tables["Killed where"].rows
    assert (row[0], len(str(row[1])) > SHORT) == (LATE, True)


def test_of_many_mutants_the_rungs_are_summed_by_parameter() -> None:
    ids = [f"LATE-{parameter}@{n}s" for parameter in ("human", "depth") for n in range(MANY)]
    flown = [outcome(BASELINE, HUMAN), outcome(PLACEBO, HUMAN, altered=0), *(outcome(id_, HUMAN) for id_ in ids)]
    (table,) = [t for t in score_tables(flown, ROSTER, GRID) if t.title.startswith("Where the faults stopped")]
    assert [(row[0], row[-1]) for row in table.rows] == [(PLACEBO, 1), ("human", MANY), ("depth", MANY), ("all", 49)]


def test_the_false_kills_name_their_population_or_why_there_are_none() -> None:
    one = score_tables(CAMPAIGN, ROSTER, GRID)[1]
    assert (one.rows[0][1], NO_PAIRS in one.notes[0]) == ("0/0 = n/a", True)
    pool = [outcome(BASELINE, HUMAN, s, violated={"SR1": 9.0} if s == 5 else {}, digest=str(s)) for s in range(6)]
    flown = [outcome(LATE, HUMAN, s, violated={"SR2": 12.0}) for s in range(6)]
    table = score_tables([*pool, *flown], ROSTER, GRID)[1]
    assert [row[1] for row in table.rows] == ["5/30 = 17 %", "1 of 6", "0/2 = 0 %"]
    assert all(row[2] for row in table.rows)


def test_several_seeds_print_the_rule_that_decides() -> None:
    flown = [
        outcome(name, HUMAN, s, violated={"SR2": 9.0} if name == LATE else {})
        for s in range(10)
        for name in (BASELINE, LATE)
    ]
    ratios, _, table = score_tables(flown, ROSTER, GRID)[:3]
    assert [row[1] for row in ratios.rows if row[0] == "decided score"] == ["1/1 = 100 % [21, 100]"]
    assert (table.headers[-2], table.rows[0][-2], DECIDED in table.notes) == ("decided", "1+0", True)


def test_the_note_on_one_seed_is_printed_once() -> None:
    assert render(score_tables(CAMPAIGN, ROSTER, GRID, By.AXIS), Format.TABLE).count(ONE_SEED) == 1


def test_one_seed_says_that_it_decides_nothing() -> None:
    assert ONE_SEED in render(score_tables(CAMPAIGN, ROSTER, GRID), Format.MARKDOWN)
    more = [outcome(BASELINE, HUMAN, 1), outcome(LATE, HUMAN, 1, violated={"SR2": 12.0})]
    text = render(score_tables([*CAMPAIGN, *more], ROSTER, GRID), Format.MARKDOWN)
    assert ONE_SEED not in text
    assert "| decided" in text


@pytest.mark.parametrize("by", [None, *By])
@settings(deadline=None, max_examples=15)
@given(outcomes=campaigns())
def test_every_table_of_every_campaign_fits_a_terminal(by: By | None, outcomes: list[Outcome]) -> None:
    text = render(score_tables(outcomes, ROSTER, GRID, by), Format.TABLE)
    assert max(len(line) for line in text.splitlines()) <= WIDTH


@pytest.mark.parametrize("how", Format)
def test_every_format_names_every_mutant(how: Format) -> None:
    text = render(score_tables(CAMPAIGN, ROSTER, GRID), how)
    assert text.endswith("\n")
    assert all(mutant.replace("%", "\\%" * (how is Format.LATEX) or "%") in text for mutant in (LATE, NO, GOAL))


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
    rows = tuple((f"row {n}", "w" * 60, "four words of text", "a, " * (20 if n == 9 else 3)) for n in range(10))
    lines = render([Table("T", ("name", "word", "text", "list"), rows)], Format.TABLE).splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert sum("four words of text" in line for line in lines) == 10
    assert len(lines) < 4 + 10 + 4


def parts(by: By) -> dict[str, tuple[Ratio, Ratio]]:
    found = score(CAMPAIGN, ROSTER, GRID)
    return {group.name: (group.killed, group.flown) for group in groups(found, by, ROSTER, GRID)}


def test_the_score_by_guideword_and_by_parameter_is_of_mutants() -> None:
    assert parts(By.GUIDEWORD) == {
        "NO": (Ratio(1, 1), Ratio(1, 1)),
        "LATE": (Ratio(1, 1), Ratio(1, 1)),
        "MORE": (Ratio(0, 1), Ratio(0, 1)),
    }
    assert parts(By.PARAMETER) == {"human": (Ratio(2, 2), Ratio(2, 2)), "goal": (Ratio(0, 1), Ratio(0, 1))}


def test_the_score_by_requirement_counts_a_mutant_for_each_that_kills_it() -> None:
    killed = {name: ratio for name, (ratio, _) in parts(By.REQUIREMENT).items()}
    assert killed == {"SR1": Ratio(1, 3), "SR2": Ratio(2, 3), "OP1": Ratio(1, 3)}


def test_the_score_by_situation_and_by_axis_is_of_mutants_in_situations() -> None:
    assert parts(By.SITUATION) == {NOBODY: (Ratio(0, 1), Ratio(0, 2)), HUMAN: (Ratio(2, 3), Ratio(2, 3))}
    axis = parts(By.AXIS)
    assert len(axis) == 10
    assert axis["H = human"] == (Ratio(2, 3), Ratio(2, 3))
    assert axis["H = nobody"] == (Ratio(0, 1), Ratio(0, 2))


@given(campaigns(), st.sampled_from([By.GUIDEWORD, By.PARAMETER]))
def test_the_parts_of_the_score_sum_to_the_score(outcomes: list[Outcome], by: By) -> None:
    found = score(outcomes, ROSTER, GRID)
    listed = groups(found, by, ROSTER, GRID)
    assert sum(group.killed.part for group in listed) == found.mutation_score.part
    assert sum(group.killed.whole for group in listed) == found.mutation_score.whole
    assert sum(group.flown.whole for group in listed) == found.strict_score.whole


def test_the_baselines_findings_name_the_first_violation_and_what_stayed_open() -> None:
    flown = [*CAMPAIGN, outcome(BASELINE, DARK, 1, violated={"SR1": 28.0}, struck="bar"), outcome(BASELINE, DARK, 2)]
    (_, _, dark) = findings(flown, GRID)
    assert (dark.situation, dark.flown, dark.red, dark.violated) == (DARK, 3, 2, ("SR1",))
    assert dark.open == ("SR2", "SR2-literal", "OP1")
    assert dark.first is not None
    assert (dark.first[0].t_s, dark.first[1]) == (28.0, 1)


def test_a_study_whose_every_baseline_is_red_or_cut_short_can_reveal_nothing() -> None:
    assert holds_somewhere(CAMPAIGN)
    assert not holds_somewhere([CAMPAIGN[2]])
    assert not holds_somewhere([])


def test_each_requirement_is_tallied_over_the_baseline_flights() -> None:
    first, *_, last = tallies(CAMPAIGN)
    assert (first.requirement, dict(first.verdicts), first.least_rho) == (
        "SR1",
        {"violated": 1, "open": 0, "vacuous": 0, "held": 2},
        -0.1,
    )
    assert (last.requirement, dict(last.verdicts)["open"], last.triggered) == ("OP1", 1, 3)


@given(campaigns())
def test_the_verdicts_on_a_requirement_sum_to_the_baseline_flights(outcomes: list[Outcome]) -> None:
    baselines = sum(o.mutant == BASELINE and not o.invalid for o in outcomes)
    assert all(sum(count for _, count in tally.verdicts) == baselines for tally in tallies(outcomes))
