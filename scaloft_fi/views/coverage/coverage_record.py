"""The situation coverage as plain JSON values, as `coverage` and `score` print it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.analysis.coverage import SHARES, STRENGTHS, Coverage, coverage_json
from scaloft_fi.analysis.pool import State
from scaloft_fi.campaign.runs.request import Remembered
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import by_name, count, listing, ratio, record, text
from scaloft_fi.views.stale import KEYS as STALE

SHAPE = record(
    "how much of the situations the flights cover",
    {
        "situations": ratio("distinct situations flown, of the grid"),
        "draws": count("test cases flown: a situation with a seed each"),
        "pool": count("those of them in which the baseline alone was flown, to decide by"),
        "t_way": record(
            "by the number of axes t, the combinations of values of t axes that were flown, of all",
            {str(strength): ratio(f"combinations of values of {strength} axes") for strength in STRENGTHS},
        ),
        "complete": record(
            "by the number of axes t, the choices of t axes of which at least a share of the combinations was flown",
            {
                str(strength): record(
                    f"choices of {strength} axes, by that share (0..1)",
                    {f"{share:g}": ratio(f"choices with {share:.0%} or more, of all") for share in SHARES},
                )
                for strength in STRENGTHS
            },
        ),
        "realised": ratio("situations whose every value came true in a baseline flight, of the grid"),
        "realised_by_axis": by_name(
            "by axis", ratio("situations where its value came true in a baseline flight, of those with such a flight")
        ),
        "steady": ratio("safety pairs that put a fault to the test, of those with ten baseline flights"),
        "states": record(
            "safety pairs (a situation flown, a safety requirement) by what the baseline pool says of them",
            {state.value: count(f"pairs that are {state.value}") for state in State},
        ),
        "requirements": by_name(
            "by requirement",
            ratio("situations where a baseline flight put it to the test, of those with such a flight"),
        ),
    },
)
COVERAGE = Output(
    "coverage",
    "1.1",
    "how much of the situations a campaign covers",
    {
        "coverage": SHAPE,
        "choices": listing(
            "how `run --choose` chose situations",
            record(
                "one choice",
                {
                    "choose": text("value of --choose, such as `draws:40`"),
                    "seed": count("value of --choose-seed"),
                    "pool": count("situations to choose from"),
                    "draws": listing(
                        "the test cases, in the order of the choice",
                        record(
                            "one test case",
                            {"situation": text("key of the situation"), "seed": count("seed of the flight")},
                        ),
                    ),
                },
            ),
        ),
        **STALE,
    },
    rows="summary",
)


def coverage_record(covered: Coverage) -> dict[str, Any]:
    """Plain JSON values of `SHAPE`."""
    values = coverage_json(covered)
    complete = {strength: one["complete"] for strength, one in values["t_way"].items()}
    t_way = {strength: {"part": one["part"], "whole": one["whole"]} for strength, one in values["t_way"].items()}
    return values | {"t_way": t_way, "complete": complete}


def coverage_values(covered: Coverage, choices: Sequence[Remembered]) -> dict[str, Any]:
    """Plain JSON values of the form `COVERAGE`."""
    return {"coverage": coverage_record(covered), "choices": [_choice(one) for one in choices]}


def _choice(one: Remembered) -> dict[str, Any]:
    draws = [{"situation": situation, "seed": seed} for situation, seed in one.draws]
    return {"choose": one.text, "seed": one.seed, "pool": one.pool, "draws": draws}
