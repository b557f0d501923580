"""`scaloft-fi coverage`: how much of the situations a campaign covers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from scaloft_fi.analysis.coverage import SHARES, Coverage, coverage_of
from scaloft_fi.analysis.pool import LEAST, State
from scaloft_fi.judge.space import Space
from scaloft_fi.study import Study
from scaloft_fi.verbs.options import Campaign, verb
from scaloft_fi.verbs.snapshot import Stale, snapshot
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table


class TestCase(NamedTuple):
    """One test case.

    Attributes:
        situation: key of the situation.
        seed: seed of the flight.
    """

    situation: str
    seed: int


@dataclass(frozen=True)
class Choice:
    """One choice.

    Attributes:
        choose: value of --choose, such as `draws:40`.
        seed: value of --choose-seed.
        pool: situations to choose from.
        draws: the test cases, in the order of the choice.
    """

    choose: str
    seed: int
    pool: int
    draws: tuple[TestCase, ...]


@dataclass(frozen=True)
class CampaignCoverage:
    """How much of the situations a campaign covers.

    Attributes:
        coverage: how much of the situations the flights cover.
        choices: how `run --choose` chose situations.
        stale: the stored flights that no longer count and were not flown again.
    """

    coverage: Coverage
    choices: tuple[Choice, ...]
    stale: Stale


COVERAGE = Output("coverage", "1.1", CampaignCoverage, rows="summary")

MEANINGS = {
    State.STEADY: "at least nine tenths of the baseline's flights hold it: it tests a fault",
    State.UNSTEADY: "the baseline holds it or not by chance",
    State.RED: "most of the baseline's flights violate it",
    State.OPEN: "more than a tenth of the baseline's flights end before it is judged",
    State.VACUOUS: "less than half of the baseline's flights trigger it",
    State.UNKNOWN: f"the situation has fewer than {LEAST} baseline flights",
}


def coverage_tables(covered: Coverage, space: Space, choices: Sequence[Choice] = ()) -> tuple[Table, ...]:
    """Every number of the coverage.

    Args:
        covered: the coverage.
        space: the grid.
        choices: how situations were chosen.
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
        cases = [(one.choose, one.seed, len(one.draws), len({case.situation for case in one.draws})) for one in choices]
        tables.append(Table("How situations were chosen", headers, tuple(cases)))
    return tuple(tables)


def _states(covered: Coverage) -> Table:
    rows = tuple((state.value, covered.states[state], meaning) for state, meaning in MEANINGS.items())
    return Table("Safety requirements in the situations flown", ("state", "pairs", "meaning"), rows)


def _t_way(covered: Coverage, axes: int) -> Table:
    rows = tuple(
        (f"{one.strength}-way", str(one.total), *map(str, one.completeness))
        for one in covered.combinations
        if one.strength <= axes
    )
    headers = ("combinations", "covered", *(f"p = {share:g}" for share in SHARES))
    notes = (
        "Covered: value combinations of t axes that were flown, of all that the grid has.",
        "p: (p, t)-completeness: choices of t axes with at least the share p of these covered.",
    )
    return Table("Combinations of axis values", headers, rows, notes)


def coverage(study: Study, campaign: Campaign) -> Answer:
    """How much of the situations a campaign covers, number by number.

    Raises:
        InputError: there is no such campaign, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        space, rulings, remembered, stale = now.study.space, now.rulings, now.choices, now.stale
    covered = coverage_of(rulings.baselines, rulings.draws, space)
    choices = tuple(
        Choice(one.text, one.seed, one.pool, tuple(TestCase(*each) for each in one.draws)) for one in remembered
    )
    return Answer(
        COVERAGE,
        lambda: CampaignCoverage(covered, choices, stale),
        lambda: coverage_tables(covered, space, choices),
        warnings=stale.sentences,
    )


coverage_command = verb(
    "coverage",
    examples=(
        ("Ask how much of the grid was flown, pair by pair", "scaloft-fi coverage"),
        ("Look at another campaign", "scaloft-fi coverage --campaign night"),
        ("Let a script read it", "scaloft-fi coverage --format json"),
    ),
)(coverage)
