"""Every figure of the score's JSON beside what follows from the export by code that shares nothing with it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import recomputation
from builders import AXES, GRID, KINDS, ROSTER, campaigns, seeded
from hypothesis import given, settings
from published_flights import ROOT, Row, outcomes, rows

from experiments.flights import read
from scaloft_fi.analysis.detection import State
from scaloft_fi.analysis.score import Score, score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.dossier import columns, export_rows, to_csv
from scaloft_fi.verbs.score import SCORE, ScoredFlights

FLOWN = Path(__file__).parents[1] / "support" / "three_situations_ten_seeds.jsonl.gz"


def same(found: Any, expected: Any, place: str = "score") -> None:
    """Equal, floats but for rounding; redraws, times, looks and classes are not recomputed."""
    if isinstance(expected, dict):
        assert found.keys() - {"redraw", "first", "decided_at", "severity"} == expected.keys(), place
        for key in expected:
            same(found[key], expected[key], f"{place}.{key}")
    elif isinstance(expected, list):
        assert len(found) == len(expected), place
        for number, entry in enumerate(expected):
            same(found[number], entry, f"{place}[{number}]")
    elif isinstance(expected, float):
        assert abs(found - expected) < 1e-9, (place, found, expected)
    else:
        assert found == expected, (place, found, expected)


def compare(outcomes: list[Outcome]) -> dict[str, Any]:
    scored = score(outcomes, ROSTER, GRID)
    study = SimpleNamespace(space=GRID, requirements=())
    found = SCORE.record(ScoredFlights(study, "default", rulings_of(outcomes), scored))
    rows = export_rows(outcomes, ROSTER, GRID, list(KINDS))
    expected = recomputation.score(
        to_csv((row.values() for row in rows), columns(rows, list(KINDS))),
        kinds={name: kind.value for name, kind in KINDS.items()},
        axes={key: dict(zip(AXES, point, strict=True)) for key, point in GRID.points},
        defaults=set(ROSTER.defaults.values()),
        controls=set(ROSTER.controls),
    )
    order = [key for key, _ in GRID.points]
    assert found.pop("version") == SCORE.version
    assert not any(found.pop(name) for name in ("accepted", "groups", "noise", "looks", "unflown"))
    assert found.pop("stale")["flights"] == 0
    assert found["ratios"].pop("without_accepted") == found["ratios"]["mutation_score"]  # nobody accepted any
    found["pairs"].sort(key=lambda pair: order.index(pair["situation"]))
    same(found, expected)
    return found


@given(campaigns())
def test_every_figure_of_the_score_follows_from_the_export(outcomes: list[Outcome]):
    compare(outcomes)


@given(seeded())
def test_every_verdict_follows_from_the_export(outcomes: list[Outcome]):
    compare(outcomes)


def test_every_figure_of_flights_in_the_simulator_follows_from_their_export():
    """The baseline, PLACEBO and three mutants of the reference study, 3 situations, 10 seeds, without trajectories."""
    found = compare(list(read(FLOWN)["flown"].values()))
    assert [(mutant["id"], mutant["verdict"], mutant["kill_rate"]) for mutant in found["mutants"]] == [
        ("LATE-human@3s", "detected", {"part": 2, "whole": 2}),
        ("AFTER-clock@5frames", "undecided", {"part": 0, "whole": 2}),
        ("UNINTENDED-collision@20s", "undecided", {"part": 0, "whole": 2}),
    ]


def test_the_comparison_sees_every_verdict_and_every_state():
    """Campaigns drawn as above have all of them: none is compared in vain."""
    seen: set[str] = set()

    @settings(deadline=None, max_examples=80, derandomize=True, database=None)
    @given(seeded())
    def look(outcomes: list[Outcome]) -> None:
        found = compare(outcomes)
        seen.update(mutant["verdict"] for mutant in found["mutants"])
        seen.update(pair["state"] for pair in found["pairs"])
        seen.update(mutant["firm"] for mutant in found["mutants"] if mutant["firm"])
        seen.update("kill" for mutant in found["mutants"] if mutant["kills"])
        seen.update("operability kill" for mutant in found["mutants"] if mutant["operability"]["kills"])

    look()
    verdicts = {"detected", "undecided", "not_detected", "not_tested"}
    states = {"steady", "unsteady", "red", "open", "vacuous", "unknown"}
    firm = {"firm", "hangs_on_a_seed", "too_few_seeds"}  # with one seed: see the published flights
    assert seen == verdicts | states | firm | {"kill", "operability kill"}


STUDY = Study.open(ROOT)


@cache
def scored(seeds: tuple[int, ...], pool: tuple[int, ...]) -> Score:
    """The score of these seeds of the mutants beside these of the baseline and the mutants' own."""
    return score(
        (one for one in outcomes() if one.seed in seeds or (one.mutant == BASELINE and one.seed in pool)),
        STUDY.roster,
        STUDY.space,
    )


def detected(found: Score) -> set[str]:
    return {m.subject.id for m in found.mutants if m.detected and STUDY.roster.counts(m.subject)}


EVERY, ALL = tuple(range(50)), (0, 1, 2)


def test_thirty_six_of_114_faults_are_detected_with_three_seeds_beside_fifty():
    found = scored(ALL, EVERY)
    assert (found.mutation_score.part, found.mutation_score.whole) == (36, 114)
    assert (found.operability.part, found.tested.part) == (31, 106)


def test_thirty_two_are_detected_with_three_seeds_beside_the_first_ten_and_all_are_among_the_thirty_six():
    ten = detected(scored(ALL, tuple(range(10))))
    assert len(ten) == 32
    assert ten < detected(scored(ALL, EVERY))


def test_thirty_of_the_thirty_six_are_firm_and_the_others_are_those_without_a_kill():
    found = scored(ALL, EVERY)
    assert (found.firm.part, found.firm.whole) == (30, 114)
    assert [m.subject.id for m in found.counted if m.detected and not m.firm] == list(found.without_kill)
    assert scored(ALL, tuple(range(10))).firm.part == 30


def test_the_thirty_six_are_made_of_32_behaviours_eleven_are_trivial_and_ten_defaults_have_no_effect():
    found = scored(ALL, EVERY)
    assert (len(found.behaviours), len(found.trivial), len(found.without_effect)) == (32, 11, 10)
    assert {mutant.acted.whole for mutant in found.without_effect} == {96}


@pytest.mark.parametrize("seed", ALL)
@pytest.mark.parametrize("first", [0, 10, 20, 30, 40])
def test_one_seed_beside_any_ten_detects_29_or_30_and_none_that_the_whole_campaign_does_not(seed: int, first: int):
    found = detected(scored((seed,), tuple(range(first, first + 10))))
    assert len(found) in (29, 30)
    assert found <= detected(scored(ALL, EVERY))


def test_no_lucky_dodge_of_the_dark_bar_contributes_a_kill():
    found = scored(ALL, EVERY)
    for key in ("T1O1W1D1H0", "T1O1W1D1H1"):
        assert found.pool.states[key, "SR1"] is State.RED
        revealed = [m for m in found.mutants for r in m.results if r.situation == key and r.status.value == "revealed"]
        assert len(revealed) > 50
    for mutant in (*found.mutants, *found.controls):
        for kill in (*mutant.kills, *mutant.operability_kills):
            assert found.pool.states[kill.situation, kill.requirement] is State.STEADY


def test_late_human_is_killed_by_sr2_in_eight_of_eight():
    (late,) = (m for m in scored(ALL, EVERY).mutants if m.subject.id == "LATE-human@3s")
    assert {name: ratio.short for name, ratio in late.requirements} == {"SR2": "8/8"}


def test_every_control_shows_itself_by_safety_or_operability():
    controls = scored(ALL, EVERY).controls
    assert len(controls) == 11
    assert sum(control.detected for control in controls) == 7
    assert all(control.detected or control.operability.detected for control in controls)


def _recomputed(seeds: Iterable[int], pool: Sequence[int]) -> dict[str, str]:
    """The detected defaults, each with what is firm, in whole numbers by code that shares nothing with the package."""
    names, alpha = ["SR1", "SR2"], Fraction(1, 100)
    kinds = {name: kind.value for name, kind in KINDS.items()}
    counted = [row | {"counts": True} for row in rows()]
    clean = [r for r in counted if r["mutant"] == "baseline" and (r["seed"] in pool or r["seed"] in seeds)]
    table = {(pair["situation"], pair["requirement"]): pair for pair in recomputation.pairs(clean, kinds)}
    found = {}
    for mutant in STUDY.roster.defaults.values():
        flights: dict[str, list[Row]] = {}
        for row in counted:
            if row["mutant"] == mutant and row["seed"] in seeds:
                flights.setdefault(str(row["situation"]), []).append(row)
        acts = {key for key, some in flights.items() if any(row["altered"] for row in some)}
        if recomputation.verdict(flights, acts, table, names, alpha)["verdict"] == "detected":
            found[mutant] = recomputation.firm(flights, acts, clean, table, names, alpha)
    return found


def test_the_detected_are_those_of_an_independent_recomputation_from_the_export():
    for seeds, pool in ((ALL, EVERY), ((2,), tuple(range(10)))):
        found = scored(seeds, pool)
        assert _recomputed(seeds, pool) == {m.subject.id: m.firmness for m in found.counted if m.detected}
