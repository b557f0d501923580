"""`scaloft-fi coverage`: how much of the situations a campaign covers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scaloft_fi.analysis.coverage import SHARES, STRENGTHS, Coverage, coverage_json, coverage_of
from scaloft_fi.analysis.pool import LEAST, State
from scaloft_fi.campaign.runs.request import Remembered
from scaloft_fi.judge.space import Space
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import answer, campaign_option, format_option, study_option, tables_option
from scaloft_fi.verbs.snapshot import STALE, snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, by_name, count, listing, ratio, record, text
from scaloft_fi.views.table import Table

COVERED = record(
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
        "coverage": COVERED,
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
    """Plain JSON values of `COVERED`."""
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


MEANINGS = {
    State.STEADY: "at least nine tenths of the baseline's flights hold it: it tests a fault",
    State.UNSTEADY: "the baseline holds it or not by chance",
    State.RED: "most of the baseline's flights violate it",
    State.OPEN: "more than a tenth of the baseline's flights end before it is judged",
    State.VACUOUS: "less than half of the baseline's flights trigger it",
    State.UNKNOWN: f"the situation has fewer than {LEAST} baseline flights",
}


def coverage_tables(
    covered: Coverage, space: Space, choices: Sequence[tuple[str, int, int, int]] = ()
) -> tuple[Table, ...]:
    """Every number of the coverage.

    Args:
        covered: the coverage.
        space: the grid.
        choices: per choice that was made its text, seed, test cases and distinct situations.
    """
    rows = [
        ("distinct situations", str(covered.situations), "situations of the grid"),
        ("draws", str(covered.draws), "test cases: situations flown, each seed anew"),
        *([("pool", str(covered.pool), "of these draws, the baseline's alone, to decide by")] if covered.pool else []),
        ("realised", str(covered.realised), "situations whose every value came true in a baseline flight"),
        ("steady pairs", str(covered.steady), "situation x safety requirement, where the baseline has a pool"),
    ]
    rows += [
        (f"realised {axis}", str(ratio), "flown situations where the value on that axis came true")
        for axis, ratio in covered.by_axis
    ]
    rows += [
        (f"triggered {name}", str(ratio), "flown situations where it was triggered and judged")
        for name, ratio in covered.requirements
    ]
    tables = [
        Table("Situation coverage", ("coverage", "part/whole", "of"), tuple(rows)),
        _states(covered),
        _t_way(covered, len(space.axes)),
    ]
    if choices:
        headers = ("--choose", "--choose-seed", "test cases", "distinct situations")
        tables.append(Table("How situations were chosen", headers, tuple(choices)))
    return tuple(tables)


def _states(covered: Coverage) -> Table:
    rows = tuple((state.value, covered.states[state], meaning) for state, meaning in MEANINGS.items())
    return Table("Safety requirements in the situations flown", ("state", "pairs", "meaning"), rows)


def _t_way(covered: Coverage, axes: int) -> Table:
    rows = tuple(
        (f"{one.strength}-way", str(one.total), *(str(one.complete(share)) for share in SHARES))
        for one in covered.combinations
        if one.strength <= axes
    )
    headers = ("combinations", "covered", *(f"p = {share:g}" for share in SHARES))
    notes = (
        "Covered: value combinations of t axes that were flown, of all that the grid has.",
        "p: (p, t)-completeness: choices of t axes with at least the share p of these covered.",
    )
    return Table("Combinations of axis values", headers, rows, notes)


def coverage(study: Study, campaign: str) -> Answer:
    """How much of the situations a campaign covers, number by number.

    Raises:
        InputError: there is no such campaign, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        space, rulings, choices, stale = now.study.space, now.rulings, now.choices, now.stale
    covered = coverage_of(rulings.baselines, rulings.draws, space)
    made = [(one.text, one.seed, len(one.draws), len({key for key, _ in one.draws})) for one in choices]
    return Answer(
        COVERAGE,
        lambda: coverage_values(covered, choices) | stale.values,
        lambda: coverage_tables(covered, space, made),
        warnings=stale.sentences,
    )


@verb(
    "coverage",
    examples=(
        ("Ask how much of the grid was flown, pair by pair", "scaloft-fi coverage"),
        ("Look at another campaign", "scaloft-fi coverage --campaign night"),
        ("Let a script read it", "scaloft-fi coverage --format json"),
    ),
)
@study_option
@campaign_option
@format_option
@tables_option
def coverage_command(study_folder: Path | None, campaign: str, style: str, tables_folder: Path | None) -> None:
    """Print the coverage of a campaign's situations, number by number."""
    answer(coverage(Study.open(study_folder), campaign), style, tables_folder)
