from __future__ import annotations

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded
from click import unstyle
from finding import found, known
from hypothesis import given, settings
from hypothesis import strategies as st
from options import as_recorded

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Background
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.verbs.first_screen import MANY_SHOWN, SHOWN, answers, first_screen, screen_text
from scaloft_fi.verbs.verdict import MOST_NAMED, command
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


def screen(
    outcomes: list[Outcome], *, whole: bool = False, roster: Roster = ROSTER, finds: KnownFinds = NO_FINDS
) -> tuple[Table, ...]:
    known_ = {GOAL: Background("goal", stronger=("MORE-goal@1m",), laddered=True)}
    scored = score(outcomes, roster, GRID)
    return first_screen(scored, roster, GRID, coverage(outcomes, GRID), known_.get, whole=whole, finds=finds)


KEYS = [key for key, _ in GRID.points[:8]]
RED = {
    f"{name} is red in {red} of 3": [
        *(flight for key in HUMAN[:red] for flight in pool(key, red=10, violated={name: 9.0})),
        *pool(*HUMAN[red:]),
    ]
    for name, red in (("SR2", 1), ("SR2", 2), ("OP1", 2))
}
SCREENS = {
    "whole": screen(CAMPAIGN),
    "without a pool": screen([one for one in CAMPAIGN if one.mutant != BASELINE or one.seed == 0]),
    "one fault, not detected": screen([*pool(*HUMAN), *(outcome(GOAL, key) for key in HUMAN)]),
    "one fault, without effect": screen([*pool(*HUMAN), *(outcome(GOAL, key, altered=0) for key in HUMAN)]),
    "detected without a kill": screen(
        [*pool(*KEYS), *(outcome(LATE, k, s, violated={"SR2": 9.0} if s == 1 else {}) for k in KEYS for s in range(3))]
    ),
    "undecided, one flies the same to the bit": screen(
        [*pool(*HUMAN), outcome(LATE, HUMAN[0], digest="clean"), outcome(NO, HUMAN[0], violated={"SR1": 14.0})]
    ),
    **{name: screen(flights) for name, flights in RED.items()},
    "classes of severity": screen(
        [*pool(*HUMAN), *(outcome(id_, key) for id_ in (NO, LATE, GOAL) for key in HUMAN)], roster=CLASSED
    ),
    "a control that was flown once": screen(
        [outcome(), outcome("REVERSE-human", NOBODY, violated={"SR1": 5.0}, struck="wall")]
    ),
    "a control that changes nothing": screen([*pool(*HUMAN), *(outcome("REVERSE-human", key) for key in HUMAN)]),
    "a magnitude that does not count": screen(
        [*CAMPAIGN, *(outcome("LATE-human@1s", key, violated={"SR2": 12.0}) for key in HUMAN)]
    ),
    "finds": screen(CAMPAIGN, finds=known(found(GOAL, struck="person"), found(NO))),
    "a find, but no pool": screen(
        [one for one in CAMPAIGN if one.mutant != BASELINE or one.seed == 0], finds=known(found(GOAL))
    ),
}


def test_a_screen_is_as_recorded():
    as_recorded(__file__, {name: screen_text(tables) for name, tables in SCREENS.items()})
    assert "%" not in "".join(str(answer) for _, answer in SCREENS["without a pool"][0].rows).replace(NO, "")


def test_a_campaign_of_another_name_is_named_in_the_command():
    told = answers(score(CAMPAIGN, ROSTER, GRID), ROSTER, "mine")
    assert "scaloft-fi run --campaign mine " in told[-1].text


def many(count: int) -> list[Outcome]:
    ids = [f"LATE-{parameter}@{n}s" for parameter in ("human", "depth") for n in range(count // 2)]
    return [*pool(*HUMAN), *(outcome(id_, key) for id_ in ids for key in HUMAN)]


def test_a_command_names_every_mutant_that_it_flies_unless_they_are_all_that_a_run_flies_anyway():
    open_ = [*pool(*HUMAN, seeds=9), *many(MOST_NAMED + 2)[10 * len(HUMAN) :]]
    scored = score(open_, ROSTER, GRID)
    ids = [mutant.subject.id for mutant in scored.mutants]
    assert len(ids) > MOST_NAMED
    flies = command("default", scored.mutants, 3, ROSTER.defaults.values())
    assert flies == f"scaloft-fi run {' '.join(f'--mutant {id_}' for id_ in ids)} --seeds 3"
    assert command("default", scored.mutants, 3, ids) == "scaloft-fi run --seeds 3"


def test_of_many_mutants_a_group_shows_its_first_and_says_where_the_rest_is():
    _, group, _ = screen(many(MANY_SHOWN + 2))
    assert len(group.rows) == SHOWN
    assert group.notes[0] == f"... and {MANY_SHOWN + 2 - SHOWN} more: `scaloft-fi score --all`"
    _, group, _ = screen(many(MANY_SHOWN + 2), whole=True)
    assert len(group.rows) == MANY_SHOWN + 2


@pytest.mark.parametrize("whole", [False, True])
@settings(deadline=None, max_examples=25)
@given(outcomes=st.one_of(campaigns(), seeded()))
def test_the_screen_of_every_campaign_fits_its_width_and_is_plain(whole: bool, outcomes: list[Outcome]):
    shown = screen(outcomes, whole=whole)
    assert "\x1b" not in screen_text(shown)
    for columns in (60, 80, 100, 160):
        lines = screen_text(shown, width=columns).splitlines()
        assert max(len(line) for line in lines if not line.strip().startswith("`")) <= columns


def test_a_terminal_has_names_titles_verdicts_and_commands_marked_and_the_same_words():
    text = screen_text(screen(CAMPAIGN), width=80, marked=True)
    assert "\x1b[1mShown\x1b[0m  " in text
    assert "\x1b[32m\x1b[1mDetected: 1\x1b[0m\x1b[0m\n" in text
    assert "\x1b[31m\x1b[1mNot detected: 1\x1b[0m\x1b[0m\n" in text
    assert "\x1b[36m`scaloft-fi run " in text
    assert unstyle(text) == screen_text(screen(CAMPAIGN), width=80, marked=False)
