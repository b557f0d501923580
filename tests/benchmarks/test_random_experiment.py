from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from builders import GRID, outcome, pool

from experiments import random_faults as experiment
from experiments.flights import flights_of, name_of, published, read
from experiments.pages import registered
from experiments.published_kernels import KERNELS
from experiments.random_faults import (
    FAULTS,
    FLIGHTS,
    POOL,
    SEEDS,
    UNFINISHED,
    Answer,
    Arm,
    Counts,
    answer,
    flown,
    kills_of,
    names_of,
    permuted,
    redrawn,
    useful,
)
from scaloft_fi.analysis.pool import State
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.store.origin import fingerprint
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.study import Study

PLAN = registered("random_faults")
ROOT = Path(__file__).parents[2]
KEYS = tuple(key for key, _ in GRID.points if "D0" in key)[:10]
Told = Mapping[str, Mapping[str, float]]
"""Time of the violation of SR1 by fault and situation."""


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(ROOT)


@pytest.fixture(scope="module")
def hazop(study: Study) -> Arm:
    return experiment.hazop_arm(study)


def arm(told: Told, name: str = "random") -> Arm:
    flights = [
        outcome(fault, key, seed, violated={"SR1": at[key]} if key in at else {})
        for fault, at in told.items()
        for key in KEYS
        for seed in range(SEEDS)
    ]
    return Arm.of(name, [*pool(*KEYS), *flights], told, GRID)


STRIKING = {
    "RANDOM-pose@1": dict.fromkeys(KEYS[:9], 30.0),
    "RANDOM-pose@2": dict.fromkeys(KEYS[:8], 30.0),
    "RANDOM-pose@3": {KEYS[0]: 4.0, KEYS[1]: 30.0},
    "RANDOM-pose@4": dict.fromkeys(KEYS[:8], 20.0),
    "RANDOM-pose@5": {},
}


def test_what_the_plan_says_of_the_default_mutants_is_measured(hazop: Arm) -> None:
    counts = Counts.of(hazop.scores)
    infected, tested = (sum(getattr(score, name) for score in hazop.scores) for name in ("infected", "tested"))
    for told in (
        f"{counts.detected} of {FAULTS} are detected",
        f"{counts.trivial} of these are trivial by the definition below, so {counts.useful} are useful.",
        f"{infected} change a sample, {tested} are put to the test.",
        f"They have {counts.kill_sets} different sets of kills, and {hazop.behaviours} different vectors of digests",
    ):
        assert told in PLAN


def test_the_plan_has_the_numbers_at_which_the_answer_changes(hazop: Arm) -> None:
    own = Counts.of(hazop.scores)
    told = {n: answer(own, replace(own, useful=n))[0] for n in range(FAULTS + 1)}
    better, worse = ([n for n, said in told.items() if said is one] for one in (Answer.BETTER, Answer.WORSE))
    assert (better, worse) == ([*range(len(better))], [*range(worse[0], FAULTS + 1)])
    assert f"at most {better[-1]} random ones beside its {own.useful};" in PLAN
    assert f"and it has fewer: {worse[0]} random ones or more;" in PLAN


def test_the_flights_are_three_seeds_of_each_fault_and_ten_of_the_baseline(study: Study) -> None:
    keys = [situation.key for situation in study.grid.situations]
    names = list(names_of([fault.id for fault in experiment.read_faults()], keys))
    assert len(set(names)) == len(names) == FLIGHTS
    assert f"= {FLIGHTS:,}.\n" in PLAN
    assert sum(name.startswith(f"{BASELINE}/") for name in names) == len(keys) * POOL
    assert len(list(names_of(["a", "b"], keys, draws=1))) == 3


def test_a_fault_is_trivial_if_it_is_killed_nearly_everywhere_or_early() -> None:
    scores = {score.subject.id[-1]: score for score in arm(STRIKING).scores}
    assert [n for n, score in scores.items() if score.detected] == ["1", "2", "3", "4"]
    assert [n for n, score in scores.items() if score.killed_broadly] == ["1"]
    assert [n for n, score in scores.items() if score.killed_early] == ["3"]
    assert [n for n, score in scores.items() if score.trivial] == ["1", "3"]
    assert [n for n, score in scores.items() if useful(score)] == ["2", "4"]
    assert kills_of(scores["5"]) == frozenset()


def test_faults_with_equal_kills_are_one_set_and_equal_flights_one_behaviour() -> None:
    made = arm(STRIKING)
    assert Counts.of(made.scores) == Counts(faults=5, detected=4, trivial=2, useful=2, kill_sets=3)
    assert made.behaviours == 5
    clean = [replace(o, digest="clean") if o.mutant.endswith(("4", "5")) else o for o in made.outcomes]
    assert Arm.of("random", clean, STRIKING, GRID).behaviours == 3


def test_a_flight_whose_harness_failed_is_no_behaviour() -> None:
    told: Told = {"RANDOM-pose@1": {}}
    made = [replace(o, digest="clean") if o.mutant != BASELINE else o for o in arm(told).outcomes]
    made[-1] = replace(made[-1], invalid="it hung", digest="")
    flown_arm = Arm.of("random", made, told, GRID)
    assert flown_arm.behaviours == 0
    assert not flown_arm.acts("RANDOM-pose@1")
    assert flown_arm.invalid == 1


def test_a_random_fault_that_leaves_nothing_to_chance_is_told_to_be_a_default_mutant(study: Study, hazop: Arm) -> None:
    page = flown(hazop, whole(study, hazop, 0), faults_of(study), redraws=1)
    found = int(page.split(" random faults are default mutants too")[0].rpartition(" ")[2])
    patches = {(m.seam, m.operator): m.arguments for m in faults_of(study).values() if m.guideword != "RANDOM"}
    bare = [f for f in experiment.read_faults() if not f.arguments and patches.get((f.seam, f.operator)) == {}]
    assert found >= len(bare) > 0


def test_seeds_beyond_those_of_the_experiment_count_for_nothing() -> None:
    told = {"RANDOM-pose@1": {KEYS[0]: 30.0}}
    more = [outcome("RANDOM-pose@1", KEYS[0], seed, violated={"SR1": 30.0}) for seed in range(SEEDS, 20)]
    more += [outcome(BASELINE, KEYS[0], seed, violated={"SR1": 30.0}) for seed in range(POOL, 50)]
    assert Arm.of("random", [*arm(told).outcomes, *more], told, GRID) == arm(told)


def test_a_seed_drawn_twice_counts_twice() -> None:
    two = [outcome("RANDOM-pose@1", KEYS[0], seed, violated={"SR1": 30.0}) for seed in (0, 1)]
    third = outcome("RANDOM-pose@1", KEYS[0], 2)
    made = Arm.of("random", [*pool(*KEYS), *two, third], ["RANDOM-pose@1"], GRID)
    assert not made.scores[0].detected
    assert made.scored([0, 0, 1], range(POOL))[0].detected
    assert not made.scored([2, 2, 2], range(POOL))[0].seen_in
    again = redrawn(made, made, redraws=20)
    assert again["detected"][0] == again["detected"][1]
    assert set(again["detected"][0]) == {0, 1}


def test_exchanged_labels_tell_different_sets_of_kills_from_equal_ones() -> None:
    varied = [frozenset({(str(n), "SR1")}) for n in range(30)]
    assert permuted(varied, [frozenset()] * 30, permutations=999) == 0.001
    assert permuted(varied, varied, permutations=99) == 1.0
    own = [kills_of(score) for score in arm(STRIKING).scores]
    assert permuted(own, own) == 1.0


def test_more_useful_faults_are_better_only_if_chance_does_not_explain_them() -> None:
    few, some, many = (Counts(FAULTS, n, 0, n, n) for n in (9, 15, 40))
    assert answer(many, few)[0] is Answer.BETTER
    assert answer(few, many)[0] is Answer.WORSE
    assert answer(some, few)[0] is Answer.NO_DIFFERENCE
    assert answer(some, some) == (Answer.NO_DIFFERENCE, 1.0)


def faults_of(study: Study) -> dict[str, Mutant]:
    made = [realise(study.matrix, mutant) for mutant in study.roster.defaults.values()]
    return {mutant.id: mutant for mutant in (*made, *experiment.read_faults())}


def whole(study: Study, hazop: Arm, struck: int) -> Arm:
    """All flights of the random arm, made by hand: of the first `struck` faults the flights of one default mutant."""
    clean = [o for o in hazop.outcomes if o.mutant == BASELINE]
    model = [o for o in hazop.outcomes if o.mutant == "NO-map"]
    still = {(o.situation, o.seed): replace(o, violations=(), altered=3) for o in clean if o.seed < SEEDS}
    faults = experiment.read_faults()
    made = [
        replace(o if number < struck else still[o.situation, o.seed], subject=Subject.of(fault))
        for number, fault in enumerate(faults)
        for o in model
    ]
    return Arm.of("random", [*clean, *made], [fault.id for fault in faults], study.space)


@pytest.mark.parametrize(("struck", "said"), [(0, "better"), (20, "no difference is shown"), (60, "worse")])
def test_the_page_decides_by_the_useful_faults(study: Study, hazop: Arm, struck: int, said: str) -> None:
    page = flown(hazop, whole(study, hazop, struck), faults_of(study), redraws=2)
    assert f"**Rule 1: {said}.**  Useful are 21 of 114 default mutants and {struck} of 114 random faults" in page
    assert "320 of 320 baselines have the digest of the published ones; the pairs" in page
    assert "all have the same state in both pools." in page
    assert f"| detected | 32 | {struck} |" in page
    assert f"| different sets of kills | 17 | {min(struck, 1)} |" in page
    listed = [line.split(" ")[1] for line in page.splitlines() if line.startswith("| RANDOM-")]
    assert listed == [fault.id for fault in experiment.read_faults()]


def test_nothing_is_decided_while_a_flight_is_missing_or_the_pools_differ(study: Study, hazop: Arm) -> None:
    made = whole(study, hazop, 0)
    fewer = replace(made, outcomes=made.outcomes[:-1])
    red = next(o for o in made.outcomes if o.violations and o.violations[0].requirement == "SR1")
    held = next(key for (key, name), state in made.states.items() if (name, state) == ("SR1", State.STEADY))
    hit = [
        replace(o, readings=red.readings) if (o.mutant, o.situation) == (BASELINE, held) else o for o in made.outcomes
    ]
    other = replace(made, outcomes=hit)
    broken = replace(made, outcomes=[replace(made.outcomes[0], invalid="it hung"), *made.outcomes[1:]])
    for unfinished in (fewer, other, broken):
        page = flown(hazop, unfinished, faults_of(study), redraws=1)
        assert UNFINISHED in page
        assert "Rule 1" not in page


def test_a_flight_in_the_file_is_not_flown_again_and_an_invalid_one_is(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def shared(_study: Study, flights: Sequence[Flight], _jobs: int) -> Iterator[Outcome]:
        for number, flight in enumerate(flights):
            if len(asked) == 5:
                raise KeyboardInterrupt
            asked.append(flight.name)
            made = outcome(flight.subject.id, flight.situation.key, flight.seed, digest="x")
            yield replace(made, invalid="it hung" if number == 1 and len(asked) < 5 else "")

    monkeypatch.setattr("experiments.flights.shared", shared)
    path, faults = tmp_path / "flights.jsonl.gz", experiment.read_faults()[:7]
    with pytest.raises(KeyboardInterrupt):
        experiment.fly(study, faults, path, 1, draws=1)
    assert len(read(path)[experiment.ARM]) == 5
    first, asked[:] = list(asked), ["-"] * 6
    assert len(experiment.fly(study, faults, path, 1, draws=1)) == 8
    assert set(first) & set(asked) == {first[1]}
    assert len(asked) == 6 + 8 - 4


@pytest.mark.flight
def test_a_random_fault_flies_with_the_published_baseline_and_shares_it(study: Study, tmp_path: Path) -> None:
    from scaloft_fi.campaign.flights.fly import fly_log

    faults = [fault for fault in experiment.read_faults() if fault.seam == "velcmd"][:2]
    found = experiment.fly(study, faults, tmp_path / "flights.jsonl.gz", 1, draws=1)
    digests = {o.name: o.digest for o in found}
    flights = flights_of(study, {fault.id: fault for fault in faults}, digests)
    assert digests == {flight.name: fly_log(study, flight).digest for flight in flights}
    assert len(set(digests.values())) == 3
    if fingerprint()["numpy kernels"] == KERNELS:
        (clean,) = (o for o in found if o.mutant == BASELINE)
        assert clean.digest in {row["digest"] for row in published() if name_of(row) == clean.name}
