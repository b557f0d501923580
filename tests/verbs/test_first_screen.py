from __future__ import annotations

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded
from click import unstyle
from finding import flies, found, known
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Background
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.verbs.first_screen import MANY_SHOWN, SHOWN, WITH_FIND, first_screen, screen_text
from scaloft_fi.verbs.verdict import MOST_NAMED, answers, command
from scaloft_fi.views.table import Table

LATE, NO, GOAL = "LATE-human@3s", "NO-human@100%", "MORE-goal@0.6m"
HUMAN = ["T0O0W0D0H1", "T0O1W0D0H1", "T1O0W0D0H1"]
NOBODY = "T0O0W0D0H0"

CAMPAIGN = [
    *pool(*HUMAN),
    *pool(NOBODY, vacuous=("SR2",)),
    outcome(PLACEBO_ID, HUMAN[0], altered=0),
    *(outcome(LATE, key, violated={"SR2": 12.35}) for key in HUMAN),
    outcome(LATE, NOBODY, carried=0, altered=0),
    outcome(NO, HUMAN[0], violated={"SR1": 14.0}, struck="person"),
    *(outcome(GOAL, key) for key in (*HUMAN, NOBODY)),
    *(outcome("REVERSE-human", key, violated={"OP1": 60.0}) for key in HUMAN),
]


def screen(outcomes: list[Outcome], *, whole: bool = False, roster: Roster = ROSTER) -> tuple[Table, ...]:
    known = {GOAL: Background("goal", stronger=("MORE-goal@1m",), laddered=True)}
    return first_screen(score(outcomes, roster, GRID), roster, GRID, coverage(outcomes, GRID), known.get, whole=whole)


def told(outcomes: list[Outcome]) -> dict[str, str]:
    return {answer.name: answer.text for answer in answers(score(outcomes, ROSTER, GRID), ROSTER)}


def test_the_answers_say_how_many_how_sure_and_what_next() -> None:
    said = told(CAMPAIGN)
    assert said["Shown"] == (
        "1 of 3 faults (33 %) would have been shown by your safety requirements, firm by the pool alone."
    )
    assert said["Not shown"].startswith("1 put to the test, and nothing was seen; 1 undecided")
    assert said["How sure"].startswith(
        "If none of the 3 faults put to the test had any effect, 0.03 at most would still"
    )
    assert "1 seed beside 10 baseline flights a situation" in said["How sure"]
    assert said["What next"] == "`scaloft-fi run --mutant NO-human@100% --seeds 5` would decide 1 of the 1 undecided."


def test_of_one_fault_put_to_the_test_a_probability_is_told_and_of_none_nothing() -> None:
    said = told([*pool(*HUMAN), *(outcome(GOAL, key) for key in HUMAN)])["How sure"]
    assert said.startswith("A fault without effect would be called shown with a probability of 0.01 at most.")
    idle = told([*pool(*HUMAN), *(outcome(GOAL, key, altered=0) for key in HUMAN)])["How sure"]
    assert idle.startswith("No fault was put to the test")


def test_a_fault_that_flies_as_the_baseline_everywhere_is_told_apart_from_the_survivors() -> None:
    said = told([*pool(*HUMAN), *(outcome(GOAL, key, altered=0) for key in HUMAN)])["Not shown"]
    assert said == "1 without effect here: every flight equals the baseline's to the bit."


def test_a_command_names_every_mutant_that_it_flies_unless_they_are_all_that_a_run_flies_anyway() -> None:
    open_ = [*pool(*HUMAN, seeds=9), *many(MOST_NAMED + 2)[10 * len(HUMAN) :]]
    scored = score(open_, ROSTER, GRID)
    ids = [mutant.subject.id for mutant in scored.mutants]
    assert len(ids) > MOST_NAMED
    flies = command("default", scored.mutants, 3, ROSTER.defaults.values())
    assert flies == f"scaloft-fi run {' '.join(f'--mutant {id_}' for id_ in ids)} --seeds 3"
    assert command("default", scored.mutants, 3, ids) == "scaloft-fi run --seeds 3"


def test_without_a_pool_the_answers_have_counts_and_the_command_and_no_percentage() -> None:
    said = told([one for one in CAMPAIGN if one.mutant != BASELINE or one.seed == 0])
    assert "%" not in "".join(said.values()).replace(NO, "")
    assert "2 of 3 faults violated a safety requirement in a flight whose own baseline held it" in said["Shown"]
    assert said["What next"].startswith(
        "`scaloft-fi run --mutant NO-human@100% --mutant LATE-human@3s --mutant MORE-goal"
    )
    assert "flies the baseline pool" in said["What next"]


def test_a_campaign_of_another_name_is_named_in_the_command() -> None:
    found = answers(score(CAMPAIGN, ROSTER, GRID), ROSTER, "mine")
    assert "scaloft-fi run --campaign mine " in found[-1].text


def test_a_detected_mutant_without_a_kill_says_so() -> None:
    keys = [key for key, _ in GRID.points[:8]]
    spread = [outcome(LATE, key, seed, violated={"SR2": 9.0} if seed == 1 else {}) for key in keys for seed in range(3)]
    _, group, _ = screen([*pool(*keys), *spread])
    assert group.records()[0]["killed in"] == "no kill"


def test_an_undecided_fault_that_flies_the_same_to_the_bit_is_told_apart_and_asks_for_no_seeds() -> None:
    same = [*pool(*HUMAN), outcome(LATE, HUMAN[0], digest="clean"), outcome(NO, HUMAN[0], violated={"SR1": 14.0})]
    tables = {table.title: table for table in screen(same)}
    rows = {row["mutant"]: row for row in tables["Undecided: 2; 1 flies the same to the bit"].records()}
    assert (rows[LATE]["effect"], rows[LATE]["next"]) == ("flies the same to the bit", "another situation")
    assert rows[NO]["next"] == "--seeds 5"


@pytest.mark.parametrize("name", ["SR2", "OP1"])
def test_a_requirement_that_is_red_in_most_situations_is_named_with_what_to_do(name: str) -> None:
    def line(red: int) -> str:
        flights = [flight for key in HUMAN[:red] for flight in pool(key, red=10, violated={name: 9.0})]
        *_, last = screen([*flights, *pool(*HUMAN[red:])])
        return str(last.rows[1][1])

    assert f"{name} is red in 2 of 3 situations" in line(2)
    assert f"Mend the drone or {name}; `scaloft-fi score --all` names the situations." in line(2)
    assert "Mend" not in line(1)


def test_survivors_of_the_worst_class_stand_first_with_their_class() -> None:
    flown = [*pool(*HUMAN), *(outcome(id_, key) for id_ in (NO, LATE, GOAL) for key in HUMAN)]
    group = next(table for table in screen(flown, roster=CLASSED) if table.title.startswith("Not detected"))
    assert [row[:2] for row in group.rows] == [(GOAL, "injury"), (NO, "delay"), (LATE, "")]
    plain = next(table for table in screen(flown) if table.title.startswith("Not detected"))
    assert [row[0] for row in plain.rows] == [NO, LATE, GOAL]
    assert "severity" not in plain.headers


def test_a_control_that_was_flown_once_says_what_it_violates() -> None:
    canary = outcome("REVERSE-human", NOBODY, violated={"SR1": 5.0}, struck="wall")
    tables = {table.title: table for table in screen([outcome(), canary])}
    group = tables["Controls, in no ratio: 1 of 1 show that faults reach the drone"]
    assert group.rows == (("REVERSE-human", "SR1 in 1 flight", "flies otherwise"),)


def test_a_control_that_changes_nothing_does_not_show_that_faults_reach_the_drone() -> None:
    silent = [outcome("REVERSE-human", key) for key in HUMAN]
    tables = {table.title: table for table in screen([*pool(*HUMAN), *silent])}
    group = tables["Controls, in no ratio: 0 of 1 show that faults reach the drone"]
    assert group.rows == (("REVERSE-human", "nothing", "flies otherwise"),)


def test_the_last_lines_tell_coverage_and_the_unmutated_drone() -> None:
    *_, last = screen(CAMPAIGN)
    assert [name for name, _ in last.rows] == ["Situations", "Unmutated drone"]
    assert str(last.rows[0][1]).startswith("4/32 flown, 2-way ")
    assert last.rows[1][1] == "of 4 situations with a pool it holds steadily SR1 in 4, SR2 in 3 (1 vacuous)."


def test_a_fault_with_a_find_is_told_to_fly_it_in_its_row_and_what_next_gives_the_command() -> None:
    finds = known(found(GOAL, struck="person"), found(NO))
    tables = first_screen(
        score(CAMPAIGN, ROSTER, GRID), ROSTER, GRID, coverage(CAMPAIGN, GRID), lambda _: None, finds=finds
    )
    rows = {row[0]: row[-1] for table in tables for row in table.rows}
    assert (rows[GOAL], rows[NO]) == ("fly its find", "fly its find")
    assert " ".join(" ".join(WITH_FIND).split()) in " ".join(screen_text(tables).split())
    told_ = f"`{flies(NO)}` flies the situation that a search found for it: human walks, cruise speed 0.8 m/s (violates"
    assert tables[0].rows[-1][1] == f"{told_} SR2).  1 more fault has a find: `scaloft-fi kills --show survivors`."
    (alone,) = [
        answer.text
        for answer in answers(score(CAMPAIGN, ROSTER, GRID), ROSTER, "mine", known(found(GOAL, struck="person")))
        if answer.name == "What next"
    ]
    assert alone.endswith("human walks, cruise speed 0.8 m/s (violates SR2 and strikes person).")


def test_a_pool_that_is_missing_comes_before_finds() -> None:
    few = [one for one in CAMPAIGN if one.mutant != BASELINE or one.seed == 0]
    said = answers(score(few, ROSTER, GRID), ROSTER, "default", known(found(GOAL)))[-1].text
    assert "flies the baseline pool" in said


def many(count: int) -> list[Outcome]:
    ids = [f"LATE-{parameter}@{n}s" for parameter in ("human", "depth") for n in range(count // 2)]
    return [*pool(*HUMAN), *(outcome(id_, key) for id_ in ids for key in HUMAN)]


def test_of_many_mutants_a_group_shows_its_first_and_says_where_the_rest_is() -> None:
    _, group, _ = screen(many(MANY_SHOWN + 2))
    assert len(group.rows) == SHOWN
    assert group.notes[0] == f"... and {MANY_SHOWN + 2 - SHOWN} more: `scaloft-fi score --all`"
    _, group, _ = screen(many(MANY_SHOWN + 2), whole=True)
    assert len(group.rows) == MANY_SHOWN + 2


def test_the_answers_count_defaults_and_the_groups_say_how_many_count() -> None:
    ladder = [outcome("LATE-human@1s", key, violated={"SR2": 12.0}) for key in HUMAN]
    titles = [table.title for table in screen([*CAMPAIGN, *ladder])]
    assert "Detected: 2, of which 1 count in the score" in titles
    assert told([*CAMPAIGN, *ladder])["Shown"].startswith("1 of 3 faults")


@pytest.mark.parametrize("whole", [False, True])
@settings(deadline=None, max_examples=25)
@given(outcomes=st.one_of(campaigns(), seeded()))
def test_the_screen_of_every_campaign_fits_its_width_and_is_plain(whole: bool, outcomes: list[Outcome]) -> None:
    shown = screen(outcomes, whole=whole)
    assert "\x1b" not in screen_text(shown)
    for columns in (60, 80, 100, 160):
        lines = screen_text(shown, width=columns).splitlines()
        assert max(len(line) for line in lines if not line.strip().startswith("`")) <= columns


def test_a_terminal_has_names_titles_verdicts_and_commands_marked_and_the_same_words() -> None:
    text = screen_text(screen(CAMPAIGN), width=80, marked=True)
    assert "\x1b[1mShown\x1b[0m  " in text
    assert "\x1b[32m\x1b[1mDetected: 1\x1b[0m\x1b[0m\n" in text
    assert "\x1b[31m\x1b[1mNot detected: 1\x1b[0m\x1b[0m\n" in text
    assert "\x1b[36m`scaloft-fi run " in text
    assert unstyle(text) == screen_text(screen(CAMPAIGN), width=80, marked=False)
