"""Every figure of the score's JSON beside what follows from the export by code that shares nothing with it."""

from __future__ import annotations

import gzip
import json
import random
from pathlib import Path
from typing import Any

import recomputation
from builders import AXES, GRID, KINDS, ROSTER, campaigns, outcome
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
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


@st.composite
def seeded(draw: st.DrawFn) -> list[Outcome]:
    """A campaign of several seeds: enough for decisions and REDRAW, with noise, invalid and cut-short flights."""
    chance = random.Random(draw(st.integers(0, 10**6)))
    keys = [key for key, _ in GRID.points[: draw(st.integers(1, 4))]]
    seeds = draw(st.sampled_from([2, 3, 5, 6, 10, 20]))
    rates = {key: chance.choice([0, 0, 0.1, 0.5, 1]) for key in keys}
    outcomes = []
    for mutant in (BASELINE, PLACEBO, *ROSTER.ids):
        for key in keys:
            kill = rates[key] if mutant in (BASELINE, PLACEBO) else chance.choice([0, 0.3, 0.9, 1])
            for seed in range(seeds if mutant == BASELINE else min(seeds, chance.choice([1, 3, 5, 11, 11]))):
                violated = {name: float(chance.randrange(1, 59)) for name in KINDS if chance.random() < kill}
                struck = chance.choice(["", "", "wall", "bar"]) if "SR1" in violated else ""
                if struck:
                    violated = {n: t for n, t in violated.items() if n == "SR1" or t < violated["SR1"]}
                    end = min(violated.values())
                    violated = {n: t for n, t in violated.items() if t == end}
                outcomes.append(
                    outcome(
                        *(mutant, key, seed),
                        violated=violated,
                        struck=struck,
                        altered=chance.choice([0, 5, 5, 5]),
                        invalid=chance.choice(["", *[""] * 20, "the worker died"]),
                        digest=chance.choice(["clean", *["other"] * 5]),
                    )
                )
    return outcomes


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
