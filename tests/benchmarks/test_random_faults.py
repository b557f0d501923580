"""Random faults: the draw, the plan, the rule, the published page."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import pytest
from builders import GRID, outcome, pool

from experiments import PUBLISHED, random_faults
from experiments import random_faults as experiment
from experiments.pages import registered
from experiments.random_draw import GUIDEWORD, Draw
from scaloft_fi.analysis.detection import State
from scaloft_fi.campaign.flights.fly import facts
from scaloft_fi.hazop.matrix import parse
from scaloft_fi.judge.outcome import BASELINE, Subject
from scaloft_fi.mutants.catalogue import catalogue_lines, realise
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.study import Study

pytestmark = pytest.mark.release
"""A page of the past is recomputed before a release."""


def test_the_committed_faults_are_what_the_draw_gives(study: Study):
    drawn = Draw.of(study).faults(random_faults.FAULTS)
    assert experiment.FILE.read_text(encoding="utf-8").splitlines() == list(catalogue_lines(drawn))
    assert experiment.read_faults() == drawn


def test_no_id_is_one_of_the_matrix(study: Study):
    assert GUIDEWORD not in {cell.guideword for cell in study.matrix}
    ids = [fault.id for fault in experiment.read_faults()]
    assert len(set(ids)) == len(ids)
    assert all(str(parse(id_)) == id_ and parse(id_).guideword == GUIDEWORD for id_ in ids)


def test_the_largest_magnitudes_are_those_of_the_plan(study: Study):
    draw = Draw.of(study)
    told = {f"{float(f'{most:.3g}'):g} {unit}" for unit, most in draw.quantities.items() if unit}
    (line,) = re.findall(r"declare \(`quantities`\):\n +(.*);", registered("random_faults"))
    assert set(line.split(", ")) == told
    assert draw.quantities[""] == 1.0


def test_a_tap_can_be_made_of_every_fault(study: Study):
    scenario = study.scenario(study.grid.situations[0])
    known = facts(scenario, study.sim.stack.parameters)
    for fault in experiment.read_faults():
        wire = wire_for(fault, study.stack, contexts(fault.id, scenario.key, 0, known))
        assert wire.listens(fault.seam)
        assert Mutant.from_json(fault.to_json()) == fault


PLAN = registered("random_faults")
KEYS = tuple(key for key, _ in GRID.points if "D0" in key)[:10]
Told = Mapping[str, Mapping[str, float]]
"""Time of the violation of SR1 by fault and situation."""


@pytest.fixture(scope="module")
def hazop(study: Study) -> random_faults.Arm:
    return experiment.hazop_arm(study)


def arm(told: Told, name: str = "random") -> random_faults.Arm:
    flights = [
        outcome(fault, key, seed, violated={"SR1": at[key]} if key in at else {})
        for fault, at in told.items()
        for key in KEYS
        for seed in range(random_faults.SEEDS)
    ]
    return random_faults.Arm.of(name, [*pool(*KEYS), *flights], told, GRID)


STRIKING = {
    "RANDOM-pose@1": dict.fromkeys(KEYS[:9], 30.0),
    "RANDOM-pose@2": dict.fromkeys(KEYS[:8], 30.0),
    "RANDOM-pose@3": {KEYS[0]: 4.0, KEYS[1]: 30.0},
    "RANDOM-pose@4": dict.fromkeys(KEYS[:8], 20.0),
    "RANDOM-pose@5": {},
}


def test_what_the_plan_says_of_the_default_mutants_is_measured(hazop: random_faults.Arm):
    counts = random_faults.Counts.of(hazop.scores)
    infected, tested = (sum(getattr(score, name) for score in hazop.scores) for name in ("infected", "tested"))
    for told in (
        f"{counts.detected} of {random_faults.FAULTS} are detected",
        f"{counts.trivial} of these are trivial by the definition below, so {counts.useful} are useful.",
        f"{infected} change a sample, {tested} are put to the test.",
        f"They have {counts.kill_sets} different sets of kills, and {hazop.behaviours} different vectors of digests",
    ):
        assert told in PLAN


def test_the_plan_has_the_numbers_at_which_the_answer_changes(hazop: random_faults.Arm):
    own = random_faults.Counts.of(hazop.scores)
    told = {n: random_faults.answer(own, replace(own, useful=n))[0] for n in range(random_faults.FAULTS + 1)}
    better, worse = (
        [n for n, said in told.items() if said is one]
        for one in (random_faults.Answer.BETTER, random_faults.Answer.WORSE)
    )
    assert (better, worse) == ([*range(len(better))], [*range(worse[0], random_faults.FAULTS + 1)])
    assert f"at most {better[-1]} random ones beside its {own.useful};" in PLAN
    assert f"and it has fewer: {worse[0]} random ones or more;" in PLAN


def test_the_flights_are_three_seeds_of_each_fault_and_ten_of_the_baseline(study: Study):
    keys = [situation.key for situation in study.grid.situations]
    names = list(random_faults.names_of([fault.id for fault in experiment.read_faults()], keys))
    assert len(set(names)) == len(names) == random_faults.FLIGHTS
    assert f"= {random_faults.FLIGHTS:,}.\n" in PLAN
    assert sum(name.startswith(f"{BASELINE}/") for name in names) == len(keys) * random_faults.POOL


def test_a_fault_is_trivial_if_it_is_killed_nearly_everywhere_or_early():
    scores = {score.subject.id[-1]: score for score in arm(STRIKING).scores}
    assert [n for n, score in scores.items() if score.detected] == ["1", "2", "3", "4"]
    assert [n for n, score in scores.items() if score.killed_broadly] == ["1"]
    assert [n for n, score in scores.items() if score.killed_early] == ["3"]
    assert [n for n, score in scores.items() if score.trivial] == ["1", "3"]
    assert [n for n, score in scores.items() if random_faults.useful(score)] == ["2", "4"]
    assert random_faults.kills_of(scores["5"]) == frozenset()


def faults_of(study: Study) -> dict[str, Mutant]:
    made = [realise(study.matrix, mutant) for mutant in study.roster.defaults.values()]
    return {mutant.id: mutant for mutant in (*made, *experiment.read_faults())}


def whole(study: Study, hazop: random_faults.Arm, struck: int) -> random_faults.Arm:
    """All flights of the random arm, made by hand: of the first `struck` faults the flights of one default mutant."""
    clean = [o for o in hazop.outcomes if o.mutant == BASELINE]
    model = [o for o in hazop.outcomes if o.mutant == "NO-map"]
    still = {(o.situation, o.seed): replace(o, violations=(), altered=3) for o in clean if o.seed < random_faults.SEEDS}
    faults = experiment.read_faults()
    made = [
        replace(o if number < struck else still[o.situation, o.seed], subject=Subject.of(fault))
        for number, fault in enumerate(faults)
        for o in model
    ]
    return random_faults.Arm.of("random", [*clean, *made], [fault.id for fault in faults], study.space)


@pytest.mark.parametrize(("struck", "said"), [(0, "better"), (20, "no difference is shown"), (60, "worse")])
def test_the_page_decides_by_the_useful_faults(study: Study, hazop: random_faults.Arm, struck: int, said: str):
    page = random_faults.flown(hazop, whole(study, hazop, struck), faults_of(study), redraws=2)
    assert f"**Rule 1: {said}.**  Useful are 21 of 114 default mutants and {struck} of 114 random faults" in page
    assert "320 of 320 baselines have the digest of the published ones; the pairs" in page
    assert "all have the same state in both pools." in page
    assert f"| detected | 32 | {struck} |" in page
    assert f"| different sets of kills | 17 | {min(struck, 1)} |" in page
    listed = [line.split(" ")[1] for line in page.splitlines() if line.startswith("| RANDOM-")]
    assert listed == [fault.id for fault in experiment.read_faults()]


def test_nothing_is_decided_while_a_flight_is_missing_or_the_pools_differ(study: Study, hazop: random_faults.Arm):
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
        page = random_faults.flown(hazop, unfinished, faults_of(study), redraws=1)
        assert random_faults.UNFINISHED in page
        assert "Rule 1" not in page


def test_the_published_page_is_that_of_the_published_flights(study: Study):
    """Two minutes of processor time: the seeds are drawn again 200 times."""
    told = (PUBLISHED / "random_faults.md").read_text(encoding="utf-8")
    assert told == registered("random_faults") + experiment.results(study, 1, PUBLISHED)
