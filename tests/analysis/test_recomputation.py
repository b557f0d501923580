"""Every figure of the score's JSON beside what follows from the export by code that shares nothing with it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import recomputation
from builders import AXES, GRID, KINDS, ROSTER, campaigns, seeded
from hypothesis import given, settings

from experiments.flights import read
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import rulings_of
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
    found = SCORE.record(ScoredFlights(SimpleNamespace(space=GRID), "default", rulings_of(outcomes), scored))
    rows = export_rows(outcomes, ROSTER, GRID, list(KINDS))
    expected = recomputation.score(
        to_csv(rows, columns(rows, list(KINDS))),
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
