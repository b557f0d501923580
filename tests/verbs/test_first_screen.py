from __future__ import annotations

import re
from dataclasses import replace

import pytest
from builders import CLASSED, GRID, ROSTER, campaigns, outcome, pool, seeded
from click import unstyle
from finding import found, known
from hypothesis import given, settings
from hypothesis import strategies as st
from options import as_recorded
from processes import printed
from published_flights import ROOT

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import score
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.output import PIPED
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import NO_FINDS, KnownFinds, Study
from scaloft_fi.verbs.first_screen import LEGEND, MOST_ROWS, Screen, pair_table
from scaloft_fi.verbs.verdict import MOST_NAMED, command

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


def screen(outcomes: list[Outcome], *, roster: Roster = ROSTER, finds: KnownFinds = NO_FINDS) -> Screen:
    study = Study.open(ROOT)
    vars(study).update(roster=roster, space=GRID, finds=finds)
    return Screen(study, score(outcomes, roster, GRID), coverage(outcomes, GRID))


MATRIX = load_matrix(ROOT / "hazop", REFERENCE.by_name)
KEYS = [key for key, _ in GRID.points[:8]]
RED = {
    f"{name} is red in {red} of 3": [
        *(flight for key in HUMAN[:red] for flight in pool(key, red=10, violated={name: 9.0})),
        *pool(*HUMAN[red:]),
    ]
    for name, red in (("SR2", 1), ("SR2", 2), ("OP1", 2))
}
SCREENS = {
    "everything": screen(CAMPAIGN),
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
    "classes": screen(
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
    "one fault with a find, in a part of the grid": screen(
        [*pool(*HUMAN), *(outcome(NO, key, violated={"SR1": 14.0}) for key in HUMAN[:1])], finds=known(found(NO))
    ),
    "every flight of one failed in the harness": screen(
        [*CAMPAIGN[:-7], *(outcome(GOAL, key, invalid="its worker died") for key in HUMAN)]
    ),
    "a find, but no pool": screen(
        [one for one in CAMPAIGN if one.mutant != BASELINE or one.seed == 0], finds=known(found(GOAL))
    ),
}


def test_a_screen_is_as_recorded():
    whole = {f"{name}, with --all": SCREENS[name].text(whole=True) for name in ("everything", "finds", "classes")}
    as_recorded(__file__, {name: one.text(whole=False) for name, one in SCREENS.items()} | whole)
    assert "%" not in "".join(answer for _, answer in SCREENS["without a pool"].answers.rows).replace(NO, "")


def test_without_a_pool_a_control_that_struck_the_wall_strikes_it():
    flown = [outcome("REVERSE-human", NOBODY, violated={"SR1": 5.0}, struck="wall")]
    ((_, _, effect),) = screen([outcome(situation=NOBODY), *flown]).tables[1].rows
    assert effect == "strikes wall"


def test_of_the_pairs_that_are_steady_only_those_with_a_pool_are_counted():
    lines = [
        note
        for flown in ([outcome()], pool(*HUMAN))
        for note in pair_table(score(flown, ROSTER, GRID).pool, GRID).notes
    ]
    assert [line.partition(" of the pairs")[0] for line in lines if "with a pool" in line] == [
        "0/0 = n/a",
        "9/9 = 100 %",
    ]


def test_a_campaign_of_another_name_is_named_in_the_command():
    told = replace(screen(CAMPAIGN), campaign="mine").answers
    assert "scaloft-fi run --campaign mine " in told.rows[-1][1]


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


def test_of_many_mutants_the_first_are_shown_and_the_rest_stands_under_all():
    text = screen(many(MOST_ROWS + 2)).text(whole=False)
    assert text.count("\nLATE-") == MOST_ROWS
    assert "... and 2 more." in text
    assert screen(many(MOST_ROWS + 2)).text(whole=True).count("\nLATE-") == MOST_ROWS + 2
    assert "`scaloft-fi score --all`" in text


CELLS = [cell.default_id for cell in MATRIX if cell.status is CellStatus.CREDIBLE][: MOST_ROWS + 2]
SEVERAL = screen([*pool(*HUMAN), *(outcome(id_, HUMAN[0]) for id_ in CELLS)], roster=Roster.of(MATRIX, CELLS))


def test_many_cells_are_shown_as_the_signs_of_the_matrix_with_a_legend_of_the_signs_that_are_there():
    lines = SEVERAL.text(whole=False, width=100).splitlines()
    assert [line.split() for line in lines if line.startswith("human ")] == [["human", *"?" * 10]]
    assert "? undecided" in lines
    assert "●" not in "".join(lines)


@pytest.mark.parametrize("name", SCREENS)
def test_a_screen_has_15_lines_for_one_mutant_and_30_for_many(name: str):
    one = SCREENS[name]
    assert len(one.text(whole=False, width=PIPED).splitlines()) <= (15 if len(one.scored.mutants) < 2 else 30)


def test_the_screen_of_the_published_campaign_has_30_lines_whose_commands_open_it(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.chdir(ROOT)
    told = printed("-m", "scaloft_fi", "score", "--campaign", "results/published/reference")
    assert "`scaloft-fi kills --campaign results/published/reference --show survivors`" in told
    assert "speedlimit ●" in told
    assert len(told.splitlines()) <= 30


@pytest.mark.parametrize("name", SCREENS)
@pytest.mark.parametrize("whole", [False, True])
def test_the_legend_explains_only_words_that_stand_in_the_tables(name: str, whole: bool):
    text = SCREENS[name].text(whole=whole, width=1000)
    told = [word for word in LEGEND if f"{word}: " in text]
    cells = {cell for line in text.splitlines() if ": " not in line for cell in re.split(r"  +", line)}
    assert [word for word in told if not any(cell == word or cell.startswith(f"{word} ") for cell in cells)] == []


@pytest.mark.parametrize("whole", [False, True])
@settings(deadline=None, max_examples=25)
@given(outcomes=st.one_of(campaigns(), seeded()))
def test_the_screen_of_every_campaign_fits_its_width_and_is_plain(whole: bool, outcomes: list[Outcome]):
    shown = screen(outcomes)
    for columns in (60, 80, 100, 160):
        text = shown.text(whole=whole, width=columns)
        assert "\x1b" not in text
        assert max(len(line) for line in text.splitlines() if not line.strip().startswith("`")) <= columns


def test_a_terminal_has_names_titles_verdicts_signs_and_commands_marked_and_the_same_words():
    shown = screen(CAMPAIGN)
    text = shown.text(whole=True, width=80, marked=True)
    assert "\x1b[1mShown\x1b[0m  " in text
    assert "\x1b[32m\x1b[1mDetected: 1\x1b[0m\x1b[0m\n" in text
    assert "\x1b[31m\x1b[1mNot detected: 1\x1b[0m\x1b[0m\n" in text
    assert "\x1b[36m`scaloft-fi run " in text
    assert "\x1b[32mdetected\x1b[0m" in shown.text(whole=False, marked=True)
    assert "\x1b[33m?\x1b[0m undecided" in SEVERAL.text(whole=False, marked=True)
    for one, whole in ((shown, True), (shown, False), (SEVERAL, False)):
        assert unstyle(one.text(whole=whole, marked=True)) == one.text(whole=whole, marked=False)
