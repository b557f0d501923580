"""What is said of a verdict and what to do next; the sentences are recorded in `test_verdict.txt`."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import GRID, ROSTER, campaigns, outcome, pool, seeded, thrice
from finding import flies as command
from finding import found, known
from hypothesis import given
from hypothesis import strategies as st
from options import as_recorded
from papers import STUDY
from printed import run

from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.score import MutantScore, Score, score
from scaloft_fi.analysis.survivor import Background
from scaloft_fi.hazop.load import named_study
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.sim.grid import Again
from scaloft_fi.verbs import verdict
from scaloft_fi.verbs.first_screen import short_step

LATE, NO = "LATE-human@3s", "NO-human@100%"
HERE, THERE, RED = "T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1"
RED_POOL = pool(RED, red=10, violated={"SR1": 20.0, "SR2": 20.0})
WEAK, LAST = Background("person", ("SR2",), stronger=("LATE-human@5s",), laddered=True), Background("person", ("SR2",))
FIND = found(LATE)


def scored(*flights: Outcome) -> Score:
    return score(flights, ROSTER, GRID, Spending())


def flown(
    situation: str = HERE, seeds: int = 3, violating: int = 0, name: str = "SR2", *, masked: bool = False, **how: Any
) -> list[Outcome]:
    """Flights of the mutant, the first of which violate a requirement."""
    return [
        outcome(
            *(LATE, situation, seed),
            violated={name: 9.0} if seed < violating else {},
            digest="clean" if masked else None,
            **how,
        )
        for seed in range(seeds)
    ]


SIX = [key for key, _ in GRID.points[:6]]
CASES = {
    "killed in one of two situations": [*pool(HERE, THERE), *flown(HERE, violating=3), *flown(THERE)],
    "detected without a kill": [*pool(*SIX), *(flight for key in SIX for flight in flown(key, violating=1))],
    "seen once": [*pool(HERE), *flown(seeds=1, violating=1)],
    "seen in four of ten": [*pool(HERE), *flown(seeds=10, violating=4)],
    "flown once": [*pool(HERE), *flown(seeds=1)],
    "flown thrice": [*pool(HERE), *flown()],
    "too few baselines, seen": [*pool(HERE, seeds=3), *flown(violating=2)],
    "too few baselines": [*pool(HERE, seeds=3), *flown()],
    "too few baselines elsewhere": [*pool(HERE), *pool(THERE, seeds=3), *flown(HERE), *flown(THERE)],
    "flies the same": [*pool(HERE), *flown(masked=True)],
    "violates where the baseline is red": [*pool(HERE), *RED_POOL, *flown(), *flown(RED, violating=3)],
    "infects where the baseline is red": [*RED_POOL, *flown(RED)],
    "changes nothing": [*pool(HERE), *flown(altered=0)],
    "carries nothing": [*pool(HERE), *flown(altered=0, carried=0)],
    "fails": [*pool(HERE), *flown(invalid="the worker died")],
    "breaks operability": [*pool(HERE), *flown(violating=3, name="OP1")],
}


def test_a_verdict_and_its_next_command_are_as_recorded():
    told = {}
    for name, flights in CASES.items():
        found_ = scored(*flights)
        next_ = verdict.next_command(found_.mutants[0], found_.lacking, "mine", GRID)
        told[name] = f"{verdict.verdict(found_.mutants[0], found_.lacking)}\n{next_}"
    again = replace(FIND.shows[LATE], again=Again(100_000, 0.0001, 9, 10, 30, 30, 29))
    told["a find"] = verdict.facts(found(LATE, struck="person"), LATE)
    told["a find that was replicated"] = verdict.facts(replace(FIND, shows={LATE: again}), LATE)
    as_recorded(__file__, told)


@given(
    st.one_of(campaigns(), seeded()),
    st.sampled_from([WEAK, LAST, Background("person", ("OP1",)), Background("person", expected="declared")]),
)
def test_every_line_begins_with_the_verdict_and_every_screen_asks_for_the_same_next_step(
    outcomes: list[Outcome], background: Background
):
    found_ = scored(*outcomes)
    for mutant in (*found_.mutants, *found_.controls):
        said = verdict.verdict(mutant, found_.lacking)
        undecided = mutant.verdict is Verdict.UNDECIDED
        assert said == f"{mutant.verdict.words}: {verdict.why(mutant, found_.lacking)}"
        assert ("would decide" in said) == bool(verdict.would_decide(mutant, found_.lacking)) == undecided
        assert ("killed" in said) == bool(mutant.kills)
        assert verdict.next_command(mutant, found_.lacking, "c", GRID).startswith("scaloft-fi ")
    whole = score(outcomes, ROSTER, GRID)
    known_ = dict.fromkeys([flight.mutant for flight in outcomes], background)
    mutants = {mutant.subject.id: mutant for mutant in whole.mutants}
    for survivor in verdict.survivors(outcomes, whole, kill_matrix(whole, ROSTER, GRID), known_, {}):
        steps = verdict.advice(mutants[survivor.mutant], whole, background).steps
        assert survivor.next in steps
        assert short_step(mutants[survivor.mutant], steps, background)
        runs = verdict.next_command(mutants[survivor.mutant], whole.lacking, "c", GRID).startswith("scaloft-fi run")
        assert runs == (survivor.next in (verdict.Next.POOL, verdict.Next.SEEDS))


def test_more_seeds_are_not_asked_of_a_fault_that_flies_the_same_to_the_bit():
    same = scored(*pool(THERE), outcome(LATE, THERE, digest="clean"))
    assert same.mutants[0].safety.needed
    for background, step in ((WEAK, verdict.Next.MAGNITUDE), (LAST, verdict.Next.SITUATION)):
        assert verdict.advice(same.mutants[0], same, background).steps == (step,)


def late(*flights: Outcome) -> MutantScore:
    return next(mutant for mutant in scored(*pool(THERE), *flights).mutants if mutant.subject.id == LATE)


def test_the_find_of_a_mutant_that_is_not_detected_is_to_be_flown_before_any_seeds():
    for flights in ([outcome(LATE, THERE)], thrice(LATE, THERE), [outcome(LATE, THERE, altered=0)]):
        assert verdict.next_find(late(*flights), known(found(NO), FIND)) == FIND
        assert verdict.next_command(late(*flights), (), "mine", GRID, known(FIND)) == command(LATE)
    assert verdict.next_find(late(*thrice(LATE, THERE, violated={"SR2": 7.0})), known(FIND)) is None
    assert verdict.next_find(late(outcome(LATE, THERE, invalid="the worker died")), known(FIND)) is None
    assert verdict.next_find(late(*thrice(LATE, THERE)), known(found(NO))) is None


def test_a_find_that_was_flown_here_with_as_many_seeds_is_not_flown_again():
    here, few = found(LATE, THERE), [outcome(LATE, THERE, seed) for seed in range(5)]
    enough = [*few, outcome(LATE, THERE, 5)]
    assert (verdict.next_find(late(*few), known(here)), verdict.flown_in_vain(late(*few), known(here))) == (here, ())
    assert (verdict.next_find(late(*enough), known(here)), verdict.flown_in_vain(late(*enough), known(here))) == (
        None,
        (here,),
    )
    other = found(NO, others=(LATE,))
    assert verdict.next_find(late(*enough), known(here, other)) == other


def test_the_command_names_grid_mutant_situation_and_seeds_and_the_campaign_over_that_grid():
    finds = known(FIND)
    assert (
        verdict.flies(FIND, LATE, finds, "default") == verdict.flies(FIND, LATE, finds, "mine", "wide") == command(LATE)
    )
    assert verdict.flies(FIND, LATE, finds, "paper+found", "paper+found") == command(LATE)
    assert verdict.flies(FIND, LATE, finds, "mine", "paper+found") == command(LATE, campaign="mine")
    named = replace(FIND, name="a person's walk")
    assert "--situation 'a person'\"'\"'s walk' --seeds 6" in verdict.flies(named, LATE, finds, "default")


def test_a_command_names_the_study_as_the_user_did_where_another_would_be_found(
    copy: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(copy.parent)
    for folder, option in ((Path(copy.name), f" --study {copy.name}"), (copy, f" --study {copy}"), (None, "")):
        with named_study(folder):
            assert verdict.in_campaign("default") == option
            assert verdict.in_campaign("wide") == f"{option} --campaign wide"
        assert verdict.in_campaign("default") == ""
    monkeypatch.chdir(copy)
    with named_study(copy):
        assert verdict.in_campaign("default") == ""


def test_the_next_step_can_be_pasted_where_the_user_stands(
    copy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(copy.parent)
    campaign = Path(STUDY) / "tests" / "support" / "campaigns" / "paper.zip"
    assert run("score", "--study", copy.name, "--campaign", campaign, "--all") == 0
    said = re.sub(r"\s*\\?\s+", " ", capsys.readouterr().out)
    commands = re.findall(r"`(scaloft-fi [^`]*)`", said)
    assert commands
    bare = [command for command in commands if f" --study {copy.name}" not in command]
    assert bare == []
