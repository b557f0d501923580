"""Every figure of the score's JSON beside what follows from the export by code that shares nothing with it."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import recomputation
from builders import AXES, GRID, KINDS, ROSTER, campaigns, seeded
from hypothesis import given, settings

from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.record import from_json
from scaloft_fi.results.scoring.baseline import findings
from scaloft_fi.results.scoring.score import score
from scaloft_fi.results.scoring.score_record import score_json
from scaloft_fi.results.situations.coverage import coverage
from scaloft_fi.results.telling.export import export_rows, to_csv

FLOWN = Path(__file__).with_name("three_situations_ten_seeds.jsonl.gz")


def same(found: Any, expected: Any, place: str = "score") -> None:
    """Equal, floats but for rounding; what `found` says in words is not compared."""
    if isinstance(expected, dict):
        assert found.keys() - {"population", "reason"} == expected.keys(), place
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
    violated = [(finding.situation, finding.violated) for finding in findings(outcomes, GRID)]
    found = score_json(score(outcomes, ROSTER, GRID), coverage(outcomes, GRID), violated)
    expected = recomputation.score(
        to_csv(export_rows(outcomes, ROSTER, GRID, list(KINDS)), list(KINDS)),
        kinds={name: kind.value for name, kind in KINDS.items()},
        axes={key: dict(zip(AXES, point, strict=True)) for key, point in GRID.points},
        defaults=set(ROSTER.defaults.values()),
        controls=set(ROSTER.controls),
    )
    same(found, expected)
    return found


@settings(deadline=None, max_examples=200)
@given(campaigns())
def test_every_figure_of_the_score_follows_from_the_export(outcomes: list[Outcome]) -> None:
    compare(outcomes)


@settings(deadline=None, max_examples=120)
@given(seeded())
def test_every_decision_and_every_false_kill_follows_from_the_export(outcomes: list[Outcome]) -> None:
    compare(outcomes)


def test_every_figure_of_flights_in_the_simulator_follows_from_their_export() -> None:
    """The baseline, PLACEBO and three mutants of the reference study, 3 situations, 10 seeds, without trajectories."""
    lines = gzip.decompress(FLOWN.read_bytes()).splitlines()
    found = compare([from_json(json.loads(line)) for line in lines])
    assert [(mutant["id"], mutant["decisions"]["killed"]) for mutant in found["mutants"]] == [
        ("LATE-human@3s", 2),
        ("AFTER-clock@5frames", 0),
        ("UNINTENDED-collision@20s", 0),
    ]


def test_the_comparison_sees_decisions_and_false_kills() -> None:
    """Of campaigns drawn as above, some are killed, some survive, some redraw a kill: none is compared in vain."""
    seen: set[str] = set()

    @settings(deadline=None, max_examples=60, derandomize=True, database=None)
    @given(seeded())
    def look(outcomes: list[Outcome]) -> None:
        found = compare(outcomes)
        for mutant in found["mutants"]:
            seen.update(word for word in ("killed", "survived", "undecided") if mutant["decisions"][word])
        seen.update(["redraw"] * (found["redraw"]["rate"]["part"] > 0))
        seen.update(["left out"] * (found["redraw"]["decided"]["whole"] > 0))

    look()
    assert seen == {"killed", "survived", "undecided", "redraw", "left out"}
