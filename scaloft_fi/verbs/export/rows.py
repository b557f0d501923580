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

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.console import json_text
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import measured_rho
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import JudgedFlight, Status, baseline_status, flights_of
from scaloft_fi.views.output import Columns, ColumnType, Rows, count, listing, number, optional, text, texts
from scaloft_fi.views.table import csv_text

FlightRow = dict[str, Any]

WAITING = "waiting"
"""Status of a flight that cannot be judged: the baseline of its situation and seed is not flown, or stale."""

EXPORT = Rows(
    "export",
    "1.0",
    "one row per flight, ordered by mutant, situation and seed",
    {
        "mutant": text("`baseline`, `PLACEBO` or the id of a mutant"),
        "situation": text("key of the situation"),
        "seed": count("seed of the flight"),
        "status": text(
            "what the flight shows beside its baseline, or `waiting` for it; of a baseline held, violated or invalid",
            dict.fromkeys(("held", "violated", *(status.value for status in Status), WAITING)),
        ),
        "ending": text("how it ended: landed, struck or timed_out; empty when invalid"),
        "violated": texts("requirements that it violates"),
        "infected_at_s": optional(number("first altered sample", "s from take-off"), "no sample was altered"),
        "violated_at_s": optional(number("first safety violation", "s from take-off"), "there is none"),
        **{axis: optional(number(f"{axis} of the vehicle then", "m, world"), "there is none") for axis in "xyz"},
        "struck": text("the body that was struck then; empty for none"),
        "duration_s": number("how long it lasted", "s"),
        "digest": text("SHA-256 over the ground truth"),
        "held": texts("requirements neither violated nor left open by a flight cut short"),
        "revealed_by": texts("requirements that it violates and its baseline holds: safety first, each earliest first"),
        "violation_times_s": listing("for each of `violated`, when", number("time", "s from take-off")),
        "violation_bodies": texts("for each of `violated`, the body that was struck at that moment"),
        "triggered": texts("requirements whose condition came true"),
        "realised": texts("of a baseline, axes whose value came true"),
        "carried": count("samples that crossed the patched seams"),
        "altered": count("samples that were changed there"),
    },
    rows="flights",
    named=(
        "rho_",
        optional(
            number("robustness of the requirement, in its own unit; below 0 it is violated"),
            "the flight does not put it to the test",
        ),
    ),
)
"""The columns, of JSON and CSV alike; beside them stands `rho_REQUIREMENT` for each requirement of the study."""
HEAD = ("mutant", "situation", "seed", "status", "ending", "violated")
TAIL = ("infected_at_s", "violated_at_s", "x", "y", "z", "struck", "duration_s", "digest")
BASIS = (
    *("held", "revealed_by", "violation_times_s", "violation_bodies", "triggered", "realised", "carried", "altered"),
)
"""What else every figure of the score follows from."""
WHOLE = frozenset({"seed", "carried", "altered"})
TEXTS = frozenset({"mutant", "situation", "status", "ending", "struck", "digest"})
LISTS_OF_TEXTS = frozenset({"violated", "held", "revealed_by", "violation_bodies", "triggered", "realised"})
LISTS_OF_NUMBERS = frozenset({"violation_times_s"})
"""Columns by type; every other one is a number."""


def column_type(name: str) -> ColumnType:
    """The type of a column of the rows.

    >>> column_type("seed").value, column_type("rho_SR1").value
    ('int64', 'float64')
    """
    for names, kind in (
        (WHOLE, ColumnType.WHOLE),
        (TEXTS, ColumnType.TEXT),
        (LISTS_OF_TEXTS, ColumnType.TEXTS),
        (LISTS_OF_NUMBERS, ColumnType.NUMBERS),
    ):
        if name in names:
            return kind
    return ColumnType.NUMBER


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
    rows = [_row(o, None if o.mutant == BASELINE else next(flights), names) for o in listed]
    for row, outcome in zip(rows, listed, strict=True):
        if not outcome.invalid and (outcome.situation, outcome.seed) not in clean:
            row["status"] = WAITING
    return rows


def ordered(outcomes: Iterable[Outcome], roster: Roster, space: Space) -> list[Outcome]:
    """Flights by mutant (the baseline first, then PLACEBO, then the catalogue's order), situation, seed."""
    mutant_rank, situation_rank = cache(roster.rank), cache(space.rank)
    return sorted(outcomes, key=lambda o: (mutant_rank(o.mutant), situation_rank(o.situation), o.seed))


def columns(rows: Sequence[FlightRow], requirements: Sequence[str] = ()) -> list[str]:
    """The columns of `rows`; of a campaign without flights those it would have."""
    return list(rows[0]) if rows else [*HEAD, *(f"rho_{name}" for name in requirements), *TAIL, *BASIS]


def _row(outcome: Outcome, flight: JudgedFlight | None, requirements: Sequence[str]) -> FlightRow:
    revealed_by: tuple[str, ...] = ()
    if flight is None:
        status = baseline_status(outcome)
    else:
        status, revealed_by = flight.status.value, flight.revealed + flight.operability_revealed
    violated = [reading for reading in outcome.readings if reading.violated]
    struck = {violation.requirement: violation.struck for violation in outcome.violations}
    rho = {reading.requirement: measured_rho(reading) for reading in outcome.readings}
    first = outcome.first_violation
    return {
        "mutant": outcome.mutant,
        "situation": outcome.situation,
        "seed": outcome.seed,
        "status": status,
        "ending": outcome.ending,
        "violated": [reading.requirement for reading in violated],
        **{f"rho_{name}": rho.get(name) for name in requirements},
        "infected_at_s": outcome.infected_at_s,
        "violated_at_s": first.t_s if first else None,
        "x": first.x if first else None,
        "y": first.y if first else None,
        "z": first.z if first else None,
        "struck": first.struck if first else "",
        "duration_s": outcome.duration_s,
        "digest": outcome.digest,
        "held": [reading.requirement for reading in outcome.readings if not (reading.violated or reading.open)],
        "revealed_by": list(revealed_by),
        "violation_times_s": [reading.violated_at_s for reading in violated],
        "violation_bodies": [struck.get(reading.requirement, "") for reading in violated],
        "triggered": [reading.requirement for reading in outcome.readings if reading.triggered],
        "realised": [axis for axis, came_true in outcome.realised if came_true],
        "carried": outcome.carried,
        "altered": outcome.altered,
    }


def to_json(rows: Sequence[FlightRow]) -> str:
    """A JSON list, one flight a line."""
    return "[\n" + ",\n".join(json_text(row) for row in rows) + "\n]\n" if rows else "[]\n"


def to_csv(rows: Sequence[FlightRow], columns: Sequence[str]) -> str:
    """CSV with the same columns; lists joined by `;`, nothing where there is no value.

    A text that would be a formula in a spreadsheet has a `'` before it: see `spreadsheet_text`.
    """
    return csv_text(columns, ([_in_csv(row[name]) for name in columns] for row in rows))


def _in_csv(value: Any) -> Any:
    return ";".join(map(str, value)) if isinstance(value, list) else value
