"""Flights of the experiments: published ones, those of a study with changed numbers, and those kept in a file."""

from __future__ import annotations

import gzip
import json
import multiprocessing
import sys
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow.parquet

from experiments import PUBLISHED
from scaloft_fi.analysis.detection import ALPHA, Pool, Spending
from scaloft_fi.analysis.score import MutantScore, mutant_score
from scaloft_fi.campaign.flights.fly import Flight, fly_log, judged
from scaloft_fi.campaign.flights.physics import Physics
from scaloft_fi.campaign.plan import alone, together
from scaloft_fi.campaign.store.archive import STORE_NAME, outcome_of, subject_of
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.workers import Local
from scaloft_fi.judge.outcome import BASELINE, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Situations, rulings_of
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.output import write_whole
from scaloft_fi.sim.grid import Grid
from scaloft_fi.sim.load import SimConfig, load
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.study import Study

Row = Mapping[str, Any]
GRIDS = {"paper": PUBLISHED / "reference" / "outcomes.parquet", "wide": PUBLISHED / "wide_outcomes.parquet"}
"""The published flights by grid."""
SOON_S = 1.0
"""A mutant that leaves its baseline earlier does not share it [s from take-off]."""


def published(grid: str = "paper") -> list[Row]:
    """The rows of the export of a grid's flights."""
    return rows_of(GRIDS[grid])


def name_of(row: Row) -> str:
    """`MUTANT/SITUATION/SEED`."""
    return f"{row['mutant']}/{row['situation']}/{row['seed']}"


def names_of(subjects: Iterable[str], situations: Iterable[str], seeds: Iterable[int]) -> list[str]:
    """The names of the flights of all subjects in all situations with all seeds, seed by seed."""
    return [f"{subject}/{key}/{seed}" for seed, key, subject in product(seeds, situations, subjects)]


def own_s(row: Row) -> float:
    """Cost of a mutant's flight: the part that does not share its baseline [s, simulated]."""
    if row["mutant"] == "PLACEBO":
        return float(row["duration_s"])
    if not row["altered"]:
        return 0.0
    return float(row["duration_s"] - (row["infected_at_s"] if row["infected_at_s"] >= SOON_S else 0.0))


def counted(rows: Iterable[Row], mutants: Collection[str], seeds: Collection[int], pool: Collection[int]) -> list[Row]:
    """The rows of these mutants with these seeds, and of the baseline with the seeds of the pool."""
    of = {**dict.fromkeys(mutants, seeds), BASELINE: pool}
    return [row for row in rows if row["seed"] in of.get(row["mutant"], ())]


def stored(study: Study, folder: Path) -> dict[str, Outcome]:
    """The flights of a campaign of the study by name; none where it was not flown."""
    if not (folder / STORE_NAME).exists():
        return {}
    with Store(folder / STORE_NAME, create=False) as store:
        return {outcome.name: outcome for outcome in current_in(study, store)}


def rows_of(path: Path) -> list[Row]:
    """The rows of a file."""
    return list(pyarrow.parquet.read_table(path).to_pylist())


def outcomes(study: Study, rows: Iterable[Row]) -> list[Outcome]:
    """The flights of the rows, without trajectories; an export has no places of violations either."""
    kinds, axes = {requirement.name: requirement.kind for requirement in study.requirements}, study.space.axes
    return [outcome_of({**_lacking(row), **row}, subject_of(row["mutant"]), kinds, axes) for row in rows]


def _lacking(row: Row) -> Row:
    """What an export does not have of a flight that counts."""
    places = dict.fromkeys(("violation_x", "violation_y", "violation_z"), [0.0] * len(row["violated"]))
    texts = dict.fromkeys(("invalid", "ended_by", "stack_error", "perceived_digest"), "")
    return {**places, **texts, "episodes": [1] * len(row["triggered"])}


def holds(flight: Outcome, requirements: Iterable[str]) -> bool:
    """Whether a flight counts and holds each of these requirements to its end."""
    readings = [flight.reading(name) for name in requirements]
    return not flight.invalid and all(one is not None and not (one.violated or one.open) for one in readings)


@dataclass(frozen=True)
class Scored:
    """The flights of an arm, scored beside its own pool.

    Attributes:
        outcomes: of its flights, by name.
        space: the grid.
        mutants: ids, in the order of the page.
    """

    outcomes: Mapping[str, Outcome]
    space: Space
    mutants: Sequence[str]

    @cached_property
    def valid(self) -> tuple[Outcome, ...]:
        """The flights that count."""
        return tuple(one for one in self.outcomes.values() if not one.invalid)

    @cached_property
    def pool(self) -> Pool:
        """The pool of the arm."""
        return Pool.of(self.valid)

    @cached_property
    def rulings(self) -> Mapping[Subject, Situations]:
        """The flights of each mutant beside their baselines."""
        return rulings_of(self.outcomes.values()).mutants

    @cached_property
    def scores(self) -> Mapping[str, MutantScore]:
        """The score of each mutant that was flown, by its id."""
        flown = self.rulings.items()
        made = {one.id: mutant_score(one, own, self.space, self.pool, Spending(ALPHA)) for one, own in flown}
        return {mutant: made[mutant] for mutant in self.mutants if mutant in made}


# Fly the study with changed numbers, for scripts that test the effect of an assumption.
#
# `flown` flies each flight whole and yields its outcome and its log; `shared` flies many flights as a campaign does.


@dataclass(frozen=True)
class Varied(Study):
    """A study with changed numbers.

    Attributes:
        overrides: pairs of a dotted path, as in `sim/sources.yaml`, and a value.
    """

    overrides: tuple[tuple[str, float | str], ...] = ()

    @cached_property
    def sim(self) -> SimConfig:
        """Mine, vehicle, sensors, stack and situations with the changed numbers."""
        return load(self.folder / "sim", dict(self.overrides))

    @cached_property
    def grid(self) -> Grid:
        """The situations with the changed numbers."""
        return self.sim.grid


class Beside(NamedTuple):
    """A baseline and its mutants in one situation with one seed, with changed numbers of the study.

    overrides: changed numbers by their path in `sim/sources.yaml`.
    """

    folder: Path
    overrides: Mapping[str, float]
    situation: str
    seed: int
    mutants: tuple[str, ...] = ()


def flown(beside: Beside) -> Iterator[tuple[Outcome, FlightLog]]:
    """Yield outcome and log of the baseline, then of the mutants.

    Raises:
        ScaloftError: the study cannot be flown with these numbers.
    """
    study = Varied(Study.open(beside.folder).folder, overrides=tuple(beside.overrides.items()))
    situation = study.grid.situation(beside.situation)
    for mutant in (None, *(realise(study.matrix, mutant_id) for mutant_id in beside.mutants)):
        flight = Flight(mutant, situation, beside.seed)
        log = fly_log(study, flight)
        yield judged(study, flight, log), log


def shared(study: Study, flights: Sequence[Flight], jobs: int) -> Iterator[Outcome]:
    """Yield the outcomes of flights in any order; mutants share the beginning of their baseline, as in a campaign.

    Args:
        study: the study, which may be `Varied`.
        flights: the flights.
        jobs: number of processes.

    Raises:
        ScaloftError: the study cannot be flown.
    """
    say = partial(print, file=sys.stderr, flush=True)
    with Local(jobs).workers(study, Physics(), stop=lambda: False, say=say) as workers:
        if study.stack.forks:
            yield from workers.map(together(flights, lambda flight: study.expected_s(flight.situation), jobs))
        else:
            yield from workers.map(alone(flights))


def flown_draws(besides: Iterable[Beside], jobs: int) -> list[list[Outcome]]:
    """The outcomes of each draw, the baseline first; `jobs` processes fly."""
    with multiprocessing.Pool(jobs) as pool:
        return pool.map(_outcomes, list(besides), chunksize=1)


def _outcomes(beside: Beside) -> list[Outcome]:
    return [outcome for outcome, _ in flown(beside)]


# The flights of an experiment in a file: one line of JSON for each outcome, with the arm that it belongs to.

Flights = dict[str, dict[str, Outcome]]
"""Outcomes by arm and by name of the flight."""
SAVE_S = 10.0
"""Greatest time between two writes of the file [s, wall]."""


def read(path: Path) -> Flights:
    """The flights of a file; none if there is no file."""
    flights: Flights = {}
    for row in read_lines(path):
        outcome = _outcome(row)
        flights.setdefault(row["arm"], {})[outcome.name] = outcome
    return flights


def read_lines(path: Path) -> list[dict[str, Any]]:
    """The rows of a compressed file of JSON, one a line; none if there is no file."""
    if not path.exists():
        return []
    with gzip.open(path, "rt", encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def write_lines(path: Path, rows: Iterable[Row]) -> None:
    """Write such a file anew, whole or not at all; equal rows give equal bytes."""
    text = "".join(f"{json.dumps(row, allow_nan=False)}\n" for row in rows)
    write_whole(path, gzip.compress(text.encode(), mtime=0))


def write(path: Path, flights: Mapping[str, Mapping[str, Outcome]]) -> None:
    """Write the file anew, whole or not at all; equal flights give equal bytes, whatever their order."""
    rows = [_row(arm, outcome) for arm, outcomes in flights.items() for outcome in outcomes.values()]
    write_lines(path, sorted(rows, key=json.dumps))


def _row(arm: str, outcome: Outcome) -> Row:
    row = asdict(outcome)
    place = {"arm": arm, "situation": row.pop("situation"), "seed": row.pop("seed")}
    del row["track"], row["perceived_digest"]
    return {**place, **row}


def _outcome(row: Mapping[str, Any]) -> Outcome:
    made = {
        "subject": Subject(**row["subject"]),
        "readings": tuple(Reading(**{**reading, "kind": Kind(reading["kind"])}) for reading in row["readings"]),
        "violations": tuple(Violation(**{**entry, "kind": Kind(entry["kind"])}) for entry in row["violations"]),
        "realised": tuple((axis, came_true) for axis, came_true in row["realised"]),
    }
    return Outcome(**{**{name: value for name, value in row.items() if name != "arm"}, **made})


def complete(path: Path, kept: Flights, arm: str, study: Study, planned: Iterable[Flight], jobs: int) -> None:
    """Fly the planned flights of an arm that are not kept or whose harness failed, and keep them in the file.

    Args:
        path: the file.
        kept: its flights; the new flights are added.
        arm: name of the arm.
        study: the study of the arm.
        planned: all flights of the arm.
        jobs: number of processes.
    """
    own = kept.setdefault(arm, {})
    wanted = [flight for flight in planned if flight.name not in own or own[flight.name].invalid]
    if not wanted:
        return
    print(f"{arm}: {len(wanted)} flights", file=sys.stderr, flush=True)
    saved_s = time.monotonic()
    try:
        for outcome in shared(study, wanted, jobs):
            own[outcome.name] = outcome
            if time.monotonic() - saved_s >= SAVE_S:
                write(path, kept)
                saved_s = time.monotonic()
    finally:
        write(path, kept)


def fly_arms(path: Path, jobs: int, arms: Mapping[str, tuple[Study, Iterable[Mutant], Iterable[str]]]) -> Flights:
    """Fly what is missing in the file of flights; returns all flights of the file.

    Args:
        path: the file.
        jobs: number of processes.
        arms: by name of an arm its study, the mutants among its flights, and the names of these flights.
    """
    kept = read(path)
    for arm, (study, mutants, names) in arms.items():
        by_id = {mutant.id: mutant for mutant in mutants}
        complete(path, kept, arm, study, flights_of(study, by_id, names), jobs)
    return kept


def flights_of(study: Study, mutants: Mapping[str, Mutant], names: Iterable[str]) -> list[Flight]:
    """The flights of these names, `MUTANT/SITUATION/SEED`; `mutants` has the mutants among them by id."""
    parts = (name.split("/") for name in names)
    return [
        Flight(None if mutant == BASELINE else mutants[mutant], study.grid.situation(key), int(seed))
        for mutant, key, seed in parts
    ]
