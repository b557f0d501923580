"""mission_log.json: the campaign in the keys of the published log; every violation has a unique id.

The published log counts test cases; here a test case is a pair of situation and seed, for any subject.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.console import json_text
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Space
from scaloft_fi.sim.situation import Situation


def violation_id(outcome: Outcome, violation: Violation) -> str:
    """Id such as `SR1:LATE-human@3s/T1O0W0D0H1/0`; the part after the colon is the argument of `replay`.

    The id is unique, because a flight has one first violation of a requirement, and does not depend on time.
    """
    return f"{violation.requirement}:{outcome.name}"


def mission_log(
    outcomes: Iterable[Outcome], roster: Roster, space: Space, planned: int | None = None
) -> dict[str, Any]:
    """The log as plain JSON values.

    Args:
        outcomes: outcomes of a campaign.
        roster: gives the order of the mutants.
        space: the grid.
        planned: number of planned test cases; None = size of the grid times the flown seeds.
    """
    valid = [outcome for outcome in outcomes if not outcome.invalid]
    listed = sorted(valid, key=lambda o: (roster.rank(o.mutant), space.rank(o.situation), o.seed))
    draws = sorted({(o.situation, o.seed) for o in listed}, key=lambda draw: (space.rank(draw[0]), draw[1]))
    situations = {situation for situation, _ in draws}
    seeds = {seed for _, seed in draws}
    safety = [_entry(o, v) for o in listed for v in o.violations if v.kind is Kind.SAFETY]
    return {
        "total_test_cases": planned if planned is not None else len(space.points) * max(1, len(seeds)),
        "generated_test_cases": len(draws),
        "generated_situations": [_situation(space, key, seed) for key, seed in draws],
        "safety_violation_ids": [entry["id"] for entry in safety],
        "violations": safety,
        "operability_violations": [_entry(o, v) for o in listed for v in o.violations if v.kind is Kind.OPERABILITY],
        "coverage": {
            "distinct_situations": {
                "part": len({space.point[key] for key in situations if key in space.point}),
                "whole": len(space.points),
            },
            "draws": len(draws),
        },
    }


def _situation(space: Space, key: str, seed: int) -> dict[str, Any]:
    """`type` and `parameters` as in the published log: the values that are not benign, and the value on each axis."""
    point = space.point.get(key, ())
    words = space.words_of(key) if point else ()
    unusual = [words[axis] for axis, value in enumerate(point) if value != space.values[axis][0]]
    drawn = Situation.parse(key) if point and key not in space.order else None
    parameters = dict(zip(space.axes, point, strict=False)) | (dict(drawn.numbers) if drawn else {})
    return {"type": "+".join(unusual) or "none", "parameters": parameters, "situation": key, "seed": seed}


def _entry(outcome: Outcome, violation: Violation) -> dict[str, Any]:
    return {
        "id": violation_id(outcome, violation),
        "requirement": violation.requirement,
        "t_s": violation.t_s,
        "position": [violation.x, violation.y, violation.z],
        "struck": violation.struck,
        "mutant": outcome.mutant,
        "situation": outcome.situation,
        "seed": outcome.seed,
    }


def to_json(log: dict[str, Any]) -> str:
    """The text of the file."""
    return json_text(log, indent=2) + "\n"
