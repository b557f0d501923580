"""One row per flight, as JSON or CSV: facts of the simulation only, no clock, host or worker."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from scaloft_fi.results.outcome import BASELINE, Outcome
from scaloft_fi.results.roster import Roster
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import baseline_status, baselines_of, flight_of

Row = dict[str, Any]

HEAD = ("mutant", "situation", "seed", "status", "ending", "violated")
TAIL = ("infected_at_s", "violated_at_s", "x", "y", "z", "struck", "duration_s", "digest")


def export_rows(
    outcomes: Iterable[Outcome], roster: Roster, space: Space, requirements: Sequence[str] = ()
) -> list[Row]:
    """Rows ordered by mutant (the baseline first, then PLACEBO, then the catalogue's order), situation, seed.

    Args:
        outcomes: of a campaign.
        roster: gives the order of the mutants.
        space: gives the order of the situations.
        requirements: names that have a `rho_` column even when no flight was judged by them.
    """
    listed = sorted(outcomes, key=lambda o: (roster.rank(o.mutant), space.rank(o.situation), o.seed))
    baselines = baselines_of(listed)
    names = list(dict.fromkeys([*requirements, *(r.requirement for outcome in listed for r in outcome.readings)]))
    return [_row(outcome, baselines, names) for outcome in listed]


def columns(rows: Sequence[Row], requirements: Sequence[str] = ()) -> list[str]:
    """The columns of `rows`; of a campaign without flights those it would have."""
    return list(rows[0]) if rows else [*HEAD, *(f"rho_{name}" for name in requirements), *TAIL]


def _row(outcome: Outcome, baselines: Mapping[tuple[str, int], Outcome], requirements: Sequence[str]) -> Row:
    if outcome.mutant == BASELINE:
        status = baseline_status(outcome)
    else:
        status = flight_of(outcome, baselines.get((outcome.situation, outcome.seed))).status.value
    rho = {reading.requirement: reading.rho for reading in outcome.readings}
    first = outcome.first_violation
    return {
        "mutant": outcome.mutant,
        "situation": outcome.situation,
        "seed": outcome.seed,
        "status": status,
        "ending": outcome.ending,
        "violated": [reading.requirement for reading in outcome.readings if reading.violated],
        **{f"rho_{name}": rho.get(name) for name in requirements},
        "infected_at_s": outcome.infected_at_s,
        "violated_at_s": first.t_s if first else None,
        "x": first.x if first else None,
        "y": first.y if first else None,
        "z": first.z if first else None,
        "struck": first.struck if first else "",
        "duration_s": outcome.duration_s,
        "digest": outcome.digest,
    }


def to_json(rows: Sequence[Row]) -> str:
    """A JSON list, one flight a line."""
    return "[\n" + ",\n".join(json.dumps(row, allow_nan=False) for row in rows) + "\n]\n" if rows else "[]\n"


def to_csv(rows: Sequence[Row], requirements: Sequence[str] = ()) -> str:
    """CSV with the same columns; lists joined by `;`, nothing where there is no value."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows, requirements), lineterminator="\n")
    writer.writeheader()
    writer.writerows(
        {key: ";".join(value) if isinstance(value, list) else value for key, value in row.items()} for row in rows
    )
    return text.getvalue()
