"""One row per flight, as JSON or CSV: facts of the simulation only, no clock, host or worker.

Every figure of the score can be recomputed from it, with the study's kinds of requirements and alpha, and from which
mutants `run` asked for with more than one set of seeds.  A mutant's status is what its flight shows beside the baseline
of the same situation and seed, `waiting` where none counts; the verdict on a mutant follows from all flights and the
baselines together.  Beyond status and first safety violation a row has

- `held`: requirements neither violated nor left open by a flight cut short;
- `revealed_by`: safety, then operability requirements that the flight violates and its baseline holds, each earliest
  first;
- `violation_times_s`, `violation_bodies`: per requirement in `violated`, when, and what was struck at that moment;
- `rho_<requirement>`: robustness, in the requirement's unit; null (an empty cell of CSV) where the flight did not put
  it to the test, for its condition never came true and nothing violates it: so in every vacuous reading;
- `triggered`: requirements whose condition came true;
- `realised`: for a baseline, axes whose value came true;
- `carried`, `altered`: samples that crossed the patched seams, and how many were changed there.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Annotated, Any, NamedTuple

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.console import json_text
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import measured_rho
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import JudgedFlight, Status, baseline_status, flights_of
from scaloft_fi.marks import About, Choices
from scaloft_fi.views.output import Columns, ColumnType, Field, Rows, cell, shape_of, type_of, writer_of
from scaloft_fi.views.table import csv_text

FlightRow = dict[str, Any]

WAITING = "waiting"
"""Status of a flight that cannot be judged: the baseline of its situation and seed is not flown, or stale."""

FlightStatus = Annotated[str, Choices(dict.fromkeys(("held", "violated", *Status, WAITING)))]
"""What a flight shows beside its baseline, or `waiting` for it; of a baseline held, violated or invalid."""
_Time = Annotated[float, About("time [s from take-off]")]


class _Flight(NamedTuple):
    """A flight.

    Attributes:
        mutant: `baseline`, `PLACEBO` or the id of a mutant.
        situation: key of the situation.
        seed: seed of the flight.
        status: what the flight shows beside its baseline, or `waiting` for it; of a baseline held, violated or invalid.
        ending: how it ended: landed, struck or timed_out; empty when invalid.
        violated: requirements that it violates.
        infected_at_s: first altered sample [s from take-off]; null: no sample was altered.
        violated_at_s: first safety violation [s from take-off]; null: there is none.
        x: x of the vehicle then [m, world]; null: there is none.
        y: y of the vehicle then [m, world]; null: there is none.
        z: z of the vehicle then [m, world]; null: there is none.
        struck: the body that was struck then; empty for none.
        duration_s: how long it lasted [s].
        digest: SHA-256 over the ground truth.
        held: requirements neither violated nor left open by a flight cut short.
        revealed_by: requirements that it violates and its baseline holds: safety first, each earliest first.
        violation_times_s: for each of `violated`, when.
        violation_bodies: for each of `violated`, the body that was struck at that moment.
        triggered: requirements whose condition came true.
        realised: of a baseline, axes whose value came true.
        carried: samples that crossed the patched seams.
        altered: samples that were changed there.
    """

    mutant: str
    situation: str
    seed: int
    status: FlightStatus
    ending: str
    violated: tuple[str, ...]
    infected_at_s: float | None
    violated_at_s: float | None
    x: float | None
    y: float | None
    z: float | None
    struck: str
    duration_s: float
    digest: str
    held: tuple[str, ...]
    revealed_by: tuple[str, ...]
    violation_times_s: tuple[_Time, ...]
    violation_bodies: tuple[str, ...]
    triggered: tuple[str, ...]
    realised: tuple[str, ...]
    carried: int
    altered: int


_RHO = shape_of(
    float | None,
    "robustness of the requirement, in its own unit; below 0 it is violated; null: the flight does not put it to the "
    "test",
)
EXPORT = Rows(
    "export",
    "1.0",
    _Flight,
    rows="flights",
    about="one row per flight, ordered by mutant, situation and seed",
    named=("rho_", _RHO),
)
"""The columns, of JSON and CSV alike; behind those of `HEAD` stands `rho_REQUIREMENT` for each requirement."""
HEAD = _Flight._fields[:6]


def column_type(name: str) -> ColumnType:
    """The type of a column of the rows.

    >>> column_type("seed").value, column_type("rho_SR1").value
    ('int64', 'float64')
    """
    return type_of(Field(name, (), EXPORT.keys.get(name, _RHO)))


def flight_columns(rows: Sequence[FlightRow], names: Sequence[str]) -> Columns:
    """The rows as typed columns; `names` are those of `columns`."""
    return Columns("Flights", {name: column_type(name) for name in names}, rows)


def export_rows(
    outcomes: Iterable[Outcome], roster: Roster, space: Space, requirements: Sequence[str] = ()
) -> list[FlightRow]:
    """Rows in the order of `ordered`.

    Args:
        outcomes: of a campaign.
        roster: gives the order of the mutants.
        space: gives the order of the situations.
        requirements: names that have a `rho_` column even when no flight was judged by them.
    """
    listed = ordered(outcomes, roster, space)
    names = list(dict.fromkeys([*requirements, *(r.requirement for outcome in listed for r in outcome.readings)]))
    flights = iter(flights_of(listed))
    clean = {(outcome.situation, outcome.seed) for outcome in listed if outcome.mutant == BASELINE}
    return [
        _row(one, None if one.mutant == BASELINE else next(flights), names, (one.situation, one.seed) in clean)
        for one in listed
    ]


def ordered(outcomes: Iterable[Outcome], roster: Roster, space: Space) -> list[Outcome]:
    """Flights by mutant (the baseline first, then PLACEBO, then the catalogue's order), situation, seed."""
    mutant_rank, situation_rank = cache(roster.rank), cache(space.rank)
    return sorted(outcomes, key=lambda o: (mutant_rank(o.mutant), situation_rank(o.situation), o.seed))


def columns(rows: Sequence[FlightRow], requirements: Sequence[str] = ()) -> list[str]:
    """The columns of `rows`; of a campaign without flights those it would have."""
    return list(rows[0] if rows else _named(EXPORT.keys, dict.fromkeys(requirements)))


def _named(row: Mapping[str, Any], rho: Mapping[str, Any]) -> FlightRow:
    """A row with the robustness of each requirement behind the columns of `HEAD`."""
    return {**{name: row[name] for name in HEAD}, **{f"rho_{name}": value for name, value in rho.items()}, **row}


_write = writer_of(_Flight)


def _row(outcome: Outcome, flight: JudgedFlight | None, requirements: Sequence[str], beside: bool) -> FlightRow:
    """A row; `beside` tells whether a baseline of its situation and seed counts."""
    status = flight.status if flight else baseline_status(outcome)
    violated = [reading for reading in outcome.readings if reading.violated]
    struck = {violation.requirement: violation.struck for violation in outcome.violations}
    rho = {reading.requirement: measured_rho(reading) for reading in outcome.readings}
    first = outcome.first_violation
    t_s, x, y, z = (first.t_s, first.x, first.y, first.z) if first else (None,) * 4
    row = _Flight(
        outcome.mutant,
        outcome.situation,
        outcome.seed,
        status if beside or outcome.invalid else WAITING,
        outcome.ending,
        tuple(reading.requirement for reading in violated),
        outcome.infected_at_s,
        t_s,
        x,
        y,
        z,
        first.struck if first else "",
        outcome.duration_s,
        outcome.digest,
        held=tuple(reading.requirement for reading in outcome.readings if not (reading.violated or reading.open)),
        revealed_by=(*flight.revealed, *flight.operability_revealed) if flight else (),
        violation_times_s=tuple(reading.violated_at_s or 0.0 for reading in violated),
        violation_bodies=tuple(struck.get(reading.requirement, "") for reading in violated),
        triggered=tuple(reading.requirement for reading in outcome.readings if reading.triggered),
        realised=tuple(axis for axis, came_true in outcome.realised if came_true),
        carried=outcome.carried,
        altered=outcome.altered,
    )
    return _named(_write(row), {name: rho.get(name) for name in requirements})


def to_json(rows: Sequence[FlightRow]) -> str:
    """A JSON list, one flight a line."""
    return "[\n" + ",\n".join(json_text(row) for row in rows) + "\n]\n" if rows else "[]\n"


def to_csv(rows: Sequence[FlightRow], columns: Sequence[str]) -> str:
    """CSV with the same columns; lists joined by `;`, nothing where there is no value.

    A text that would be a formula in a spreadsheet has a `'` before it: see `spreadsheet_text`.
    """
    return csv_text(columns, ([cell(row[name]) for name in columns] for row in rows))
