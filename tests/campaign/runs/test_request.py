"""Situations that a request chooses; sequential looks: whole rounds, decided by the outcomes alone."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import with_range
from hypothesis import given
from hypothesis import strategies as st
from options import cases
from running import LATE, MORE, Runs, asked, interrupting, red, same
from studies import copied

from scaloft_fi.analysis.coverage import t_way
from scaloft_fi.analysis.detection import LOOKS, Look, Verdict
from scaloft_fi.analysis.score import score
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.progress import Silence
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.request import Choice, choose_situations, remember_choice, run_looks
from scaloft_fi.campaign.runs.run import Report
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import remembered
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers import Interrupted
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.study import Study
from scaloft_fi.verbs.score import look_table

STUDY = Study.open(Path(__file__).parents[3])
GRID, SPACE = STUDY.grid, STUDY.space


def chosen(text: str, seeds: tuple[int, ...] = (0,), seed: int = 0, pool: tuple[str, ...] = ()) -> Choice:
    return choose_situations(text, GRID.select(pool), seeds, seed, SPACE)


def keys(choice: Choice) -> list[str]:
    return [situation.key for situation in choice.situations]


def test_all_is_every_situation_with_every_seed():
    assert chosen("all", (0, 1)).draws == tuple((s, n) for s in GRID.situations for n in (0, 1))


def test_first_are_the_first_of_the_grid():
    assert keys(chosen("first:3")) == ["T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H0"]


@given(st.integers(1, 32), st.integers(0, 5))
def test_random_situations_are_distinct_and_a_larger_choice_has_the_smaller_one(count: int, seed: int):
    some = keys(chosen(f"random:{count}", seed=seed))
    assert len(set(some)) == count
    assert keys(chosen("random:32", seed=seed))[:count] == some


def test_random_situations_and_draws_favour_none():
    random = Counter(key for seed in range(400) for key in keys(chosen("random:8", seed=seed)))
    draws = Counter(situation.key for seed in range(100) for situation, _ in chosen("draws:32", seed=seed).draws)
    for counted in (random, draws):
        # 3,200 and 100 each expected; 5 standard deviations of the binomial
        assert set(counted) == set(SPACE.point)
        assert max(abs(count - 100) for count in counted.values()) < 50


@given(st.integers(1, 80), st.integers(0, 3), st.integers(0, 9))
def test_a_repeated_draw_takes_the_next_seed(count: int, seed: int, first: int):
    draws = chosen(f"draws:{count}", (first,), seed).draws
    assert len(draws) == len(set(draws)) == count
    for situation in {situation for situation, _ in draws}:
        seeds = [number for other, number in draws if other == situation]
        assert seeds == list(range(first, first + len(seeds)))


@pytest.mark.parametrize(("share", "distinct"), [("50%", 16), ("90%", 29), ("100%", 32), ("2.5%", 1)])
def test_draws_stop_when_the_share_is_drawn(share: str, distinct: int):
    choice = chosen(f"draws:{share}")
    assert len(choice.situations) == distinct
    assert choice.draws == chosen(f"draws:{len(choice.draws)}").draws
    assert len(chosen(f"draws:{len(choice.draws) - 1}").situations) < distinct if len(choice.draws) > 1 else True


def test_a_share_is_exact():
    # as floating-point numbers 55 % of 20 would be a little more than 11
    assert len(choose_situations("draws:55%", GRID.situations[:20], (0,), 0, SPACE).situations) == 11


def test_on_average_as_many_draws_are_distinct_as_the_closed_form_says():
    mean = sum(len(chosen("draws:23", seed=seed).situations) for seed in range(300)) / 300
    assert mean == pytest.approx(32 * (1 - (31 / 32) ** 23), abs=0.5)  # 16.6: the paper's 23 draws


@pytest.mark.parametrize(("text", "size"), [("1-way", 2), ("2-way", 6), ("3-way", 10), ("4-way", 16), ("5-way", 32)])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_covering_arrays_of_the_reference_study_are_the_smallest(text: str, size: int, seed: int):
    some = keys(chosen(text, seed=seed))
    assert len(some) == size
    assert t_way(some, SPACE, int(text[0])).total.value == 1.0


def test_a_choice_is_made_among_the_situations_asked_for():
    pool = ("T1*",)
    for text in ("2-way", "random:5", "draws:20", "first:2"):
        assert all(key.startswith("T1") for key in keys(chosen(text, pool=pool)))
    assert len(keys(chosen("2-way", pool=pool))) == 5  # the smallest for the four axes left


@cases("text", "sentence")
def test_a_choice_that_cannot_be_is_refused(text: str, sentence: str):
    with pytest.raises(InputError, match=f"--choose='{text}' .*{sentence}"):
        chosen(text)


@pytest.fixture(scope="module")
def ranged(tmp_path_factory: pytest.TempPathFactory) -> Study:
    return Study.open(with_range(copied(tmp_path_factory.mktemp("ranged"))))


@pytest.mark.parametrize("how", ["random", "draws", "sobol"])
def test_drawn_numbers_are_the_same_for_a_seed_and_follow_the_range(ranged: Study, how: str):
    grid = ranged.grid

    def of(count: int, seed: int = 0) -> list[str]:
        return [s.key for s, _ in choose_situations(f"{how}:{count}", grid.situations, (0,), seed, ranged.space).draws]

    keys = of(100)
    assert keys[:30] == of(30)
    assert keys[:30] != of(30, seed=1)
    drawn = [grid.situation(key) for key in keys]  # each number lies in its bin
    assert len(set(keys)) == 100
    numbers = sorted(dict(situation.numbers)["C"] for situation in drawn)
    # the largest distance between the empirical and the uniform distribution; Kolmogorov: 0.163 at 1 %
    gap = max(abs((place + 0.5) / 100 - (number - 0.4) / 0.8) for place, number in enumerate(numbers))
    assert gap < (0.03 if how == "sobol" else 0.17)


def test_a_low_discrepancy_choice_spreads_over_every_axis(ranged: Study):
    for count in (8, 32, 64):
        some = choose_situations(f"sobol:{count}", ranged.grid.situations, (0,), 0, ranged.space).situations
        for axis, values in zip(ranged.space.axes, ranged.space.values, strict=True):
            times = Counter(situation[axis] for situation in some)
            assert {times[int(value)] for value in values} == {count // len(values)}


def test_a_low_discrepancy_choice_keeps_to_the_situations_asked_for(ranged: Study):
    grid, space = ranged.grid, ranged.space
    pool = grid.select(["T1O0*C1", "T0O0W0*C3"])
    some = choose_situations("sobol:40", pool, (0,), 0, space).situations
    assert {situation.point for situation in some} == set(pool)
    assert len(keys(chosen("sobol:32"))) == 32
    with pytest.raises(InputError, match="must ask for at most 32"):
        chosen("sobol:33")
    narrow = grid.select(["T1O0W0D0H0C1=0.7"])
    with pytest.raises(InputError, match=r"must name none, as in 'T1O0W0D0H0C1=0\.7'"):
        choose_situations("sobol:2", narrow, (0,), 0, space)
    assert choose_situations("random:1", narrow, (0,), 0, space).situations == narrow


def test_draws_take_one_seed():
    with pytest.raises(InputError, match="gives each draw a seed of its own"):
        chosen("draws:5", (0, 1))


def test_the_choices_of_a_campaign_are_remembered_once_each(tmp_path: Path):
    first, second = chosen("draws:7"), chosen("2-way", (0, 1), seed=3)
    for choice in (first, second, first, chosen("all")):
        remember_choice(STUDY, tmp_path, choice)
    with Store(tmp_path / STORE_NAME, create=False) as store:
        assert store.meta() == {}
        found = remembered(store)
    assert [(one.text, one.seed, one.pool) for one in found] == [("2-way", 3, 32), ("draws:7", 0, 32)]
    assert found[1].draws == tuple((situation.key, number) for situation, number in first.draws)


def test_that_all_are_flown_is_no_choice_to_remember(tmp_path: Path):
    remember_choice(STUDY, tmp_path / "none", chosen("all"))
    assert not (tmp_path / "none").exists()


def _looks(fly: Runs, folder: str = "c", **options: Any) -> tuple[Report, tuple[Look, ...]]:
    planned = asked(fly.study, names=(LATE, MORE)).with_pool()
    return run_looks(fly.study, planned, fly.folder(folder), RunOptions(**options), progress=Silence(), flyer=fly.log)


def _seeds(report: Report, mutant: str, situation: str) -> set[int]:
    return {o.seed for o in report.outcomes if (o.mutant, o.situation) == (mutant, situation)}


def test_only_undecided_mutants_fly_on_each_look_with_a_quarter_of_alpha(fly: Runs):
    """LATE violates SR2 in one situation that tests it: p is 0.18, 0.0070 and 0.0007 with 1, 3 and 5 seeds."""
    report, looks = _looks(fly)
    assert [(look.seeds, look.mutants) for look in looks] == [*zip(LOOKS, (2, 1, 1), strict=False)]
    assert [look.undecided for look in looks] == [1, 1, 0]
    assert looks[0].not_detected == looks[2].detected == 1
    assert (_seeds(report, LATE, "D0H1"), _seeds(report, MORE, "D0H1")) == (set(range(5)), {0})
    assert _seeds(report, "baseline", "D0H1") == set(range(10)), "the pool is the same at every look"
    flown = {(o.situation, o.seed) for o in report.outcomes if o.mutant in (LATE, MORE)}
    assert flown <= {(o.situation, o.seed) for o in report.outcomes if o.mutant == "PLACEBO"}
    first = look_table(looks).records()[0]
    assert (first["seeds"], first["mutants"], first["flights"]) == (1, 2, 8)
    assert (first["undecided"], first["not detected"]) == (1, 1)
    scored = score(report.outcomes, fly.study.roster, fly.study.space, report.spending)
    told = {one.subject.id: one for one in scored.mutants}
    assert {name: one.verdict for name, one in told.items()} == {LATE: Verdict.DETECTED, MORE: Verdict.NOT_DETECTED}
    assert (told[LATE].safety.seeds, told[LATE].safety.share) == (5, 0.0025)


def test_a_mutant_flies_on_only_where_the_pool_has_a_steady_pair(log: Any, fly: Runs):
    log.change = lambda flight, outcome: red(outcome) if flight.name.startswith("baseline/D1H1") else outcome
    report, _ = _looks(fly)
    assert _seeds(report, LATE, "D1H1") == {0}
    assert _seeds(report, LATE, "D0H1") == set(range(5))


@pytest.mark.parametrize("options", [{"jobs": 2}, {"jobs": 1, "share": False}])
def test_neither_jobs_nor_sharing_changes_anything(fly: Runs, options: dict[str, Any]):
    one, looks = _looks(fly)
    other, again = _looks(fly, "other", **options)
    assert again == looks
    assert fly.export(other.outcomes) == fly.export(one.outcomes)


@pytest.mark.parametrize("at", [f"{MORE}/D0H1/0", f"{LATE}/D0H1/4", "PLACEBO/D1H0/3", "baseline/D1H1/7"])
def test_an_interruption_and_a_resumption_change_nothing(log: Any, fly: Runs, at: str):
    undisturbed, looks = _looks(fly, "undisturbed")

    log.change = interrupting(lambda flight: flight.name == at)
    with pytest.raises(Interrupted, match="flights are saved"):
        _looks(fly)
    log.change = same
    resumed, again = _looks(fly)
    assert again == looks
    assert fly.export(resumed.outcomes) == fly.export(undisturbed.outcomes)


def test_baselines_of_another_campaign_decide_too(study: Any, log: Any):
    own = asked(study, canary="")
    clean = [log(study, Flight(None, situation, seed)) for situation in study.grid for seed in range(50)]
    reds = [replace(red(outcome), violations=()) for outcome in clean]
    fates = []
    for number, others in enumerate(([], clean, reds)):
        _, looks = run_looks(study, own, study.folder / str(number), others=others, progress=Silence(), flyer=log)
        fates.append((len(looks), looks[-1].undecided, looks[-1].detected, looks[-1].not_tested))
    assert fates[0] == (1, 1, 0, 0)  # nothing is steady without a pool, so nothing flies on
    assert fates[1] == (2, 0, 1, 0)
    assert fates[2] == (1, 0, 0, 1)


def test_the_gates_are_held(log: Any, fly: Runs):
    log.change = lambda f, outcome: replace(outcome, digest="other") if f.subject.id == "PLACEBO" else outcome
    with pytest.raises(GateError, match="PLACEBO differs"):
        _looks(fly)
