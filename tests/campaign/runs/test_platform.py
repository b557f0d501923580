"""Runs of a campaign whose flights another platform flew: a sample decides whether they count.

Of a stack that does not repeat its bits nothing is shared, and nothing is compared by digest.
The known flight of `doctor` is a published one.
"""

from __future__ import annotations

import csv
import io
import json
import secrets
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from paper_flyer import Whole, made
from running import CONTROL, LATE, MORE, Runs, asked, interrupting, quiet, same

from scaloft_fi.campaign.flights.fly import Batch, Flight
from scaloft_fi.campaign.plan import Plan, plan
from scaloft_fi.campaign.runs import gates
from scaloft_fi.campaign.runs.merge import merge
from scaloft_fi.campaign.runs.run import Report, opened
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.platforms import DECIDES, Platforms, fingerprint, warning_for
from scaloft_fi.campaign.store.store import FlownFlight
from scaloft_fi.campaign.workers import Interrupted
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import PLACEBO_ID, Outcome
from scaloft_fi.judge.status import Status, flights_of
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.study import Study

FLIGHTS = 13

Move = Callable[[str], None]


@pytest.fixture
def move(monkeypatch: pytest.MonkeyPatch) -> Move:
    """Gives this process a platform that differs in the version of numpy."""

    def to(numpy: str) -> None:
        for module in ("runs.run", "store.platforms"):
            monkeypatch.setattr(f"scaloft_fi.campaign.{module}.fingerprint", lambda: {"numpy": numpy})

    to("1")
    return to


def _warning(fly: Runs) -> str:
    with fly.store() as store:
        return warning_for(Platforms(store), current_in(fly.study, store))


def _run(fly: Runs, planned: Plan | None = None, **options: Any) -> tuple[Report, str]:
    stream = io.StringIO()
    return fly(planned, stream=stream, **options), stream.getvalue()


def _moved(log: Any, fly: Runs, move: Move, change: Any = same) -> tuple[Report, int]:
    """Fly a campaign, then change the platform and what is flown; the report, and the flights until then."""
    first, _ = _run(fly)
    move("2")
    log.change = change
    return first, len(log.flown)


def _otherwise(_flight: Flight, outcome: Outcome) -> Outcome:
    """Other bits, the same facts."""
    return replace(outcome, digest=f"{outcome.digest}, last bit other")


def _landless(flight: Flight, outcome: Outcome) -> Outcome:
    """Other bits, and other facts in the flights of mutants."""
    changed = _otherwise(flight, outcome)
    return changed if flight.mutant is None else replace(changed, ending="timed_out")


def _statuses(outcomes: Sequence[Outcome]) -> Counter[str]:
    return Counter(flight.status.value for flight in flights_of(outcomes))


def test_after_a_change_of_platform_a_sample_is_flown_again_and_where_it_agrees_all_flights_count(
    log: Any, fly: Runs, move: Move
):
    first, before = _moved(log, fly, move)
    assert "numpy 2 here, 1 there" in _warning(fly)
    second, said = _run(fly)
    again = log.flown[before:]
    assert second.flown == 0
    assert second.outcomes == first.outcomes
    assert len(again) == gates.BASELINES + gates.MUTANTS == len(set(again))
    assert sum(name.startswith("baseline/") for name in again) == gates.BASELINES
    assert "the platform has changed (numpy 2 here, 1 there); 5 stored flights are flown again" in said
    assert "the stored flights count" in said
    assert _warning(fly) == ""


def test_a_platform_that_agreed_is_not_asked_again(log: Any, fly: Runs, move: Move):
    _moved(log, fly, move)
    _run(fly)
    before = len(log.flown)
    for numpy in ("1", "2"):
        move(numpy)
        assert "platform" not in _run(fly)[1]
    assert len(log.flown) == before


def test_where_only_bits_differ_the_stored_flights_count_and_nothing_else_is_flown(log: Any, fly: Runs, move: Move):
    first, before = _moved(log, fly, move, _otherwise)
    second, said = _run(fly)
    assert (second.flown, second.outcomes, second.mixture) == (0, first.outcomes, "")
    assert len(log.flown) == before + gates.BASELINES + gates.MUTANTS
    assert "the platform has changed (numpy 2 here, 1 there)" in said
    assert "5 of 5 stored flights have other digests on this platform, and all have the same status, ending" in said
    assert _warning(fly) == ""
    assert _run(fly)[1].count("platform") == 0  # the answer is remembered


def test_a_flight_that_is_missing_beside_flights_of_another_platform_has_its_pair_flown_again(
    study: Any, log: Any, fly: Runs, move: Move
):
    first, before = _moved(log, fly, move, _otherwise)
    late, more = (realise(study.matrix, name) for name in (LATE, MORE))
    report, said = _run(fly, plan(study.grid[:1], (0, 1), [late, more], None))
    again = log.flown[before + gates.BASELINES + gates.MUTANTS :]
    assert {name for name in again if "/D0H0/0" in name} == {
        *(outcome.name for outcome in first.outcomes if (outcome.situation, outcome.seed) == ("D0H0", 0)),
        f"{more.id}/D0H0/0",
    }
    assert "stored flights of another platform are flown again" in said
    by_pair: dict[tuple[str, int], set[bool]] = {}
    current = fly.current()
    for outcome in current:
        here = outcome.digest.endswith("last bit other")
        by_pair.setdefault((outcome.situation, outcome.seed), set()).add(here)
    assert by_pair == {(key, 0): {key == "D0H0"} for key in ("D0H0", "D0H1", "D1H0", "D1H1")} | {("D0H0", 1): {True}}
    assert {outcome.name for outcome in first.outcomes} <= {outcome.name for outcome in current}
    assert "flights of one platform and" in _warning(fly)
    assert "of another (numpy" in _warning(fly)
    assert _statuses(report.outcomes)["not_infected"] == 4  # PLACEBO and LATE equal the baseline of their own platform
    assert report.mixture == ""  # all flights of this request come from one platform


def test_a_mutant_is_never_judged_beside_a_baseline_of_another_platform(study: Any, log: Any, fly: Runs, move: Move):
    """Two platforms take turns; each adds a mutant or a seed, and the statuses stay those of one platform."""
    mutants = [realise(study.matrix, name) for name in (LATE, MORE, CONTROL)]
    for number, last in enumerate((1, 2, 3, 3)):
        move(str(number % 2))
        log.change = _otherwise if number % 2 else same
        planned = plan(study.grid[: number + 1], range(number + 1), mutants[:last], None)
        report, _ = _run(fly, planned)
        for _ in range(2):
            again, _ = _run(fly, planned)
            assert (again.flown, again.outcomes) == (0, report.outcomes)
    pairs: dict[tuple[str, int], set[bool]] = {}
    for outcome in report.outcomes:
        pairs.setdefault((outcome.situation, outcome.seed), set()).add(outcome.digest.endswith("other"))
    assert all(len(platforms) == 1 for platforms in pairs.values())
    assert len(set(map(tuple, pairs.values()))) == 2
    assert "each mutant is judged beside a baseline of its own platform" in report.mixture
    move("1")
    log.change = same
    whole = fly(planned, "one")
    assert _statuses(report.outcomes) == _statuses(whole.outcomes)


@pytest.mark.parametrize(("change", "options"), [(_landless, {}), (_otherwise, {"same_platform": True})])
def test_flights_with_other_facts_or_bits_by_the_strict_rule_are_outgrown_with_the_reason_and_flown_again(
    log: Any, fly: Runs, move: Move, change: Any, options: dict[str, bool]
):
    _, before = _moved(log, fly, move, change)
    report, said = _run(fly, **options)
    assert report.flown == FLIGHTS
    assert len(log.flown) == before + gates.BASELINES + gates.MUTANTS + FLIGHTS + 1  # one flight of a run is repeated
    assert f"{FLIGHTS} stored flights of the earlier platform do not count" in said
    assert ("in more than bits: " in said) == (change is _landless)
    assert all(outcome.digest.endswith("last bit other") for outcome in report.outcomes)
    now = fly.held()
    assert len(fly.current()) == FLIGHTS
    assert now.why == {"flown on a platform with other digests: numpy 2 here, 1 there": FLIGHTS}
    assert now.owed == 0
    assert _warning(fly) == ""


def test_the_strict_rule_ends_a_campaign_of_two_platforms(log: Any, fly: Runs, move: Move):
    _moved(log, fly, move, _otherwise)
    _run(fly)
    report, said = _run(fly, same_platform=True)
    assert report.flown == FLIGHTS
    assert f"{FLIGHTS} flights of another platform (numpy 2 here, 1 there) have other digests: they do not" in said


def test_what_is_outgrown_and_not_asked_for_is_not_flown_again(study: Any, log: Any, fly: Runs, move: Move):
    _moved(log, fly, move, _otherwise)
    planned = plan(study.grid[:1], (0,), [realise(study.matrix, CONTROL)], None)
    report, _ = _run(fly, planned, same_platform=True)
    assert report.flown == 3
    assert fly.held().stale == FLIGHTS
    again = {f"{subject}/D0H0/0" for subject in ("baseline", "PLACEBO", CONTROL)}
    assert fly.held().owed == FLIGHTS - len({outcome.name for outcome in report.outcomes} & again)


def test_there_and_back_again_loses_no_flight_and_doubles_none(log: Any, fly: Runs, move: Move):
    _run(fly)
    for numpy, change in (("2", _otherwise), ("1", same)) * 2:
        move(numpy)
        log.change = change
        report, _ = _run(fly, same_platform=True)
        assert report.flown == FLIGHTS
    now = fly.held()
    assert len(fly.current()) == FLIGHTS
    assert sorted(now.why.values()) == [FLIGHTS, FLIGHTS]


def test_flights_that_do_not_count_anyway_are_set_apart_without_a_sample(study: Any, log: Any, fly: Runs, move: Move):
    _, before = _moved(log, fly, move)
    changed = replace(study, inputs={**study.inputs, "sim": "other"})
    report = fly(of=changed)
    assert report.flown == FLIGHTS
    assert len(log.flown) == before + FLIGHTS + 1
    assert fly.current() == ()


def test_a_sample_that_the_harness_cannot_fly_decides_nothing(log: Any, fly: Runs, move: Move):
    _moved(log, fly, move, lambda _flight, outcome: replace(outcome, invalid="no memory"))
    with pytest.raises(GateError, match=r"no stored flight could be flown again: .*: no memory"):
        _run(fly)
    log.change = same
    assert _run(fly)[0].flown == 0


def test_a_sample_that_is_interrupted_decides_nothing(log: Any, fly: Runs, move: Move):
    _moved(log, fly, move, interrupting(lambda _flight: True, digest="other"))
    with pytest.raises(Interrupted):
        _run(fly)
    log.change = same
    assert _run(fly)[0].flown == 0


def test_an_empty_store_takes_the_platform_of_its_first_flight(fly: Runs, move: Move):
    fly.store(create=True).close()
    _run(fly)
    with fly.store() as store:
        assert store.meta() == {"numpy": "1"}


def test_the_sample_is_drawn_by_hash_and_not_by_order():
    stored = [FlownFlight(f"k{n}", "baseline" if n % 2 else LATE, "D0H0", n, 1) for n in range(40)]
    one, other = gates.sample_of(stored, "numpy 2"), gates.sample_of(stored[::-1], "numpy 2")
    assert one == other
    assert {flight.seed for flight in one} != {flight.seed for flight in gates.sample_of(stored, "numpy 3")}
    assert gates.sample_of(stored[:1], "numpy 2") == stored[:1]


SEEDS = tuple(range(10))


@pytest.fixture
def noisy(study: Any) -> Any:
    return replace(study, stack=replace(study.stack, deterministic=False))


def _bits(_flight: Flight, outcome: Outcome) -> Outcome:
    """No flight repeats its bits."""
    return replace(outcome, digest=secrets.token_hex(32))


def _violating_placebo(flight: Flight, outcome: Outcome) -> Outcome:
    """PLACEBO violates SR2 wherever the baseline does not."""
    flown = _bits(flight, outcome)
    if flight.subject.id != PLACEBO_ID or outcome.violations:
        return flown
    kinds = {reading.requirement: reading.kind for reading in flown.readings}
    how = made(flown.subject, flown.situation, flown.seed, kinds, {"SR2": 7.0})
    return replace(flown, readings=how.readings, violations=how.violations)


@pytest.fixture
def fly_noisy(noisy: Any, log: Any) -> Callable[..., Report]:
    """Runs of a stack that does not repeat its bits."""
    log.change = _bits
    return lambda folder="c": Runs(noisy, log)(asked(noisy, range(3)).with_pool(SEEDS), folder)


def test_flights_of_other_bits_pass_the_gates_and_placebo_is_held_against_the_pool(fly_noisy: Any, noisy: Any):
    report = fly_noisy()
    assert len({outcome.digest for outcome in report.outcomes}) == len(report.outcomes)
    assert any(outcome.mutant == PLACEBO_ID for outcome in report.outcomes)


def test_the_same_flights_of_a_deterministic_stack_fail_them(study: Any, log: Any, fly: Runs):
    log.change = _bits
    with pytest.raises(GateError, match="PLACEBO differs from the baseline"):
        fly(asked(study, range(3)).with_pool(SEEDS))


def test_a_placebo_that_the_scores_test_detects_fails_the_gate_with_its_p(log: Any, fly_noisy: Any, noisy: Any):
    log.change = _violating_placebo
    with pytest.raises(GateError, match=r"PLACEBO, which does nothing, is detected by the score's test \(SR2 p = "):
        fly_noisy()


def test_runs_that_are_each_too_small_for_that_test_fail_its_gate_together(log: Any, noisy: Any):
    log.change = _violating_placebo
    campaign = Runs(noisy, log)
    campaign(asked(noisy, (0,)).with_pool(SEEDS))
    for seed in range(1, 4):
        campaign(asked(noisy, (seed,)))
    with pytest.raises(GateError, match="PLACEBO, which does nothing, is detected"):
        campaign(asked(noisy, (4,)))


def test_no_flight_shares_a_baseline(log: Any, noisy: Any, monkeypatch: pytest.MonkeyPatch):
    batches: list[Batch] = []

    def noted(flights: Sequence[Flight]) -> list[Batch]:
        batches.extend(made := [Batch((flight,)) for flight in flights])
        return made

    monkeypatch.setattr("scaloft_fi.campaign.runs.run.in_runs", lambda flights, _runner: noted(flights))
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.together", None)  # calling it would raise
    with opened(noisy, noisy.folder / "c", gates.RunOptions(), progress=quiet(), flyer=log, first=()) as campaign:
        campaign.fly(asked(noisy, range(3)).known)
    assert len(batches) == len(asked(noisy, range(3)).known)
    assert not any(batch.shared for batch in batches)


def test_a_mutant_is_infected_where_taps_altered_samples_whatever_its_bits(fly_noisy: Any, noisy: Any):
    report = fly_noisy()
    for flight in flights_of(report.outcomes):
        if flight.outcome.mutant == PLACEBO_ID:
            assert flight.status is Status.NOT_INFECTED
        elif flight.outcome.altered:
            assert flight.status.infected
            assert flight.status is not Status.MASKED


def test_a_flight_that_never_came_up_is_no_kill_and_one_whose_stack_died_is_the_drones(
    log: Any, fly_noisy: Any, noisy: Any
):
    def change(flight: Flight, outcome: Outcome) -> Outcome:
        if flight.name.startswith("LATE-human@3s/D0H1/0"):
            raise RuntimeError("the stages outside never came up: planner ended with code 1")
        if flight.name.startswith("LATE-human@3s/D0H1/1"):
            return replace(_bits(flight, outcome), stack_error="companion at 3.000 s: planner was ended by SIGKILL")
        return _bits(flight, outcome)

    log.change = change
    by_name = {f.outcome.name: f for f in flights_of(fly_noisy().outcomes)}
    assert by_name["LATE-human@3s/D0H1/0"].status is Status.INVALID
    assert "never came up" in by_name["LATE-human@3s/D0H1/0"].outcome.invalid
    assert by_name["LATE-human@3s/D0H1/1"].status is Status.REVEALED


def test_merged_campaigns_may_hold_the_same_flight_with_other_bits_and_the_first_stays(fly_noisy: Any, noisy: Any):
    first, second = (fly_noisy(name) for name in ("first", "second"))
    assert first.outcomes != second.outcomes
    merged = merge(noisy, noisy.folder / "first", [noisy.folder / "second"])
    assert merged.added == 0
    assert merged.known > 0


def test_after_a_change_of_platform_no_flight_is_flown_again_to_compare(log: Any, fly_noisy: Any, move: Move):
    fly_noisy()
    before = len(log.flown)
    move("2")
    assert fly_noisy().flown == 0
    assert len(log.flown) == before


RESULTS = Path(__file__).parents[3] / "results" / "published"


@dataclass
class Recorded(Whole):
    """A flyer with one outcome."""

    outcome: Outcome

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        return replace(self.outcome, subject=flight.subject, situation=flight.situation.key, seed=flight.seed)


def _fly(monkeypatch: pytest.MonkeyPatch, platform: dict[str, str], **changes: Any) -> str:
    known = gates.published()
    monkeypatch.setattr("scaloft_fi.campaign.store.platforms.fingerprint", lambda: platform)
    study = gates.packaged_study()
    mutant, situation, seed = known.name.split("/")
    assert mutant == "baseline"
    subject = Flight(None, study.grid.situation(situation), int(seed)).subject
    outcome = Outcome(subject, situation, int(seed), ending="landed", digest=known.digest)
    return gates.fly_again(lambda _text: None, Recorded(replace(outcome, **changes)))


def test_the_known_flight_is_the_published_one():
    known = gates.published()
    with (RESULTS / "paper.csv").open(encoding="utf-8") as file:
        row = next(
            row for row in csv.DictReader(file) if f"{row['mutant']}/{row['situation']}/{row['seed']}" == known.name
        )
    assert (row["digest"], row["status"], row["ending"]) == (known.digest, known.facts.status, known.facts.ending)
    assert tuple(row["violated"].split()) == known.facts.violated


def test_its_platform_is_that_of_the_published_campaign_with_the_kernels_that_reproduce_it():
    platform = json.loads((RESULTS / "reference" / "campaign.json").read_text(encoding="utf-8"))["platform"]
    kernels = {f"{package} kernels": "SkylakeX" for package in ("numpy", "scipy")}
    named = {name: value for name, value in platform.items() if name in DECIDES}
    assert gates.published().platform == {**kernels, **named}


def test_what_decides_bits_is_known_of_each_part_of_a_fingerprint():
    assert DECIDES.keys() == fingerprint().keys() == gates.published().platform.keys()


def test_equal_digests_are_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch):
    said = _fly(monkeypatch, {"numpy": "2"})
    assert said == "baseline/T0O0W0D0H1/0 has its published digest on this platform"


def test_other_bits_name_the_platforms_and_are_no_failure(monkeypatch: pytest.MonkeyPatch):
    said = _fly(monkeypatch, {**gates.published().platform, "numpy": "7"}, digest="other")
    assert "has the digest other, not a25e3a7a09ac, and the published status, ending and violations" in said
    assert "published on another platform (numpy 7 here, " in said
    assert "published on this platform" in _fly(monkeypatch, gates.published().platform, digest="other")


def test_other_facts_are_a_failure(monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(GateError, match="other facts: held, struck here, held, landed published"):
        _fly(monkeypatch, {"numpy": "7"}, digest="other", ending="struck")
