"""The flights of a campaign for the page, one compressed pack a situation: records, then tracks."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from scaloft_fi.report.tracks import Whole, coded, quantised, quantum, shared, thinned
from scaloft_fi.results.flights import Flight, flight_of
from scaloft_fi.results.outcome import BASELINE, PLACEBO, Outcome
from scaloft_fi.results.status import baseline_status
from scaloft_fi.results.track import TRACK_COLUMNS, unpack_track

EVERYTHING = 1 << 30
"""More seeds than there are."""
NONE = -1
DEFLATE = 6
"""Level of compression: 9 takes seven times as long for 3 % less."""


@dataclass(frozen=True)
class Detail:
    """How much of the tracks goes into the page.

    Attributes:
        every: one row stands for so many.
        coarse: so many times the finest step of positions, speeds and distances.
        seeds: of so many of the lowest seeds the mutants' tracks are kept; `EVERYTHING` for all.
        says: the sentence that the page prints.
    """

    every: int
    coarse: int
    seeds: int
    says: str


SMALL = "to keep the page small; replay makes the rest."
DETAILS = (
    Detail(1, 1, EVERYTHING, "Tracks: every flight, 5 Hz, in steps of 0.01 m and 0.01 m/s."),
    Detail(1, 2, EVERYTHING, f"Tracks: every flight, 5 Hz, in steps of 0.02 m and 0.02 m/s {SMALL}"),
    Detail(2, 2, EVERYTHING, f"Tracks: every flight, 2.5 Hz, in steps of 0.02 m and 0.02 m/s {SMALL}"),
    Detail(2, 2, 1, f"Tracks: 2.5 Hz, steps of 0.02 m, of mutants with the lowest seed only, {SMALL}"),
    Detail(5, 2, 1, f"Tracks: 1 Hz, steps of 0.02 m, of mutants with the lowest seed only, {SMALL}"),
    Detail(1, 1, 0, f"Tracks: of baselines only, {SMALL}"),
)
"""From the most to the least; the page takes the first that fits."""


def packs(outcomes: Iterable[Outcome], requirements: Sequence[str], detail: Detail, every: int = 1) -> dict[str, str]:
    """By situation the base64 text of its deflated flights; PLACEBO, which is its baseline, is left out.

    Args:
        outcomes: of the campaign.
        requirements: names, in the order of the readings.
        detail: how much of the tracks is kept.
        every: only every so many-th situation is packed, to learn how large all would be.
    """
    by_situation: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.mutant != PLACEBO:
            by_situation.setdefault(outcome.situation, []).append(outcome)
    seeds = sorted({outcome.seed for listed in by_situation.values() for outcome in listed})
    kept = set(seeds[: detail.seeds])
    chosen = list(by_situation.items())[::every]
    return {key: _pack(listed, requirements, detail, kept) for key, listed in chosen}


def columns(detail: Detail) -> list[dict[str, Any]]:
    """The columns of the tracks with the step of each."""
    return [{"name": column, "quantum": quantum(column, detail.coarse)} for column in TRACK_COLUMNS]


def _pack(outcomes: Sequence[Outcome], requirements: Sequence[str], detail: Detail, seeds: set[int]) -> str:
    """A length (4 bytes, little endian), so many bytes of JSON, the tracks' bytes one after the other; deflated.

    Flights with one digest share a track; a track is told by its rows, how many of the first are another's, and whose.
    """
    ordered = sorted(outcomes, key=lambda o: (o.seed, o.mutant != BASELINE, o.mutant))
    baselines = {outcome.seed: outcome for outcome in ordered if outcome.mutant == BASELINE}
    clean: dict[int, tuple[int, Whole]] = {}
    places: dict[str, int] = {}
    tracks: list[list[int]] = []
    body: list[bytes] = []
    records = []
    for outcome in ordered:
        place = places.get(outcome.digest) if outcome.digest else None
        if place is None and outcome.track and (outcome.mutant == BASELINE or outcome.seed in seeds):
            kept = rows_of(outcome.track)
            if not kept:
                records.append(record(outcome, baselines.get(outcome.seed), requirements) | {"track": None})
                continue
            rows = quantised(thinned(kept, detail.every), TRACK_COLUMNS, detail.coarse)
            base, base_rows = clean.get(outcome.seed, (NONE, rows[:0]))
            same = shared(rows, base_rows)
            place = len(tracks)
            places[outcome.digest] = place
            tracks.append([len(rows), same, base if same else NONE])
            body.append(coded(rows, same))
            if outcome.mutant == BASELINE:
                clean[outcome.seed] = place, rows
        records.append(record(outcome, baselines.get(outcome.seed), requirements) | {"track": place})
    text = json.dumps({"flights": records, "tracks": tracks}, separators=(",", ":"), allow_nan=False).encode()
    return base64.b64encode(zlib.compress(struct.pack("<I", len(text)) + text + b"".join(body), DEFLATE)).decode()


def rows_of(track: bytes) -> list[tuple[float, ...]]:
    """The rows of a track; none where time does not rise, as when an earlier version kept other columns."""
    rows = unpack_track(track)
    whole = all(len(row) == len(TRACK_COLUMNS) for row in rows[-1:])
    return rows if whole and all(one[0] < next_[0] for one, next_ in pairwise(rows)) else []


def record(outcome: Outcome, baseline: Outcome | None, requirements: Sequence[str]) -> dict[str, Any]:
    """What the page tells of one flight beside its track."""
    flight = flight_of(outcome, baseline) if outcome.mutant != BASELINE else None
    readings = {reading.requirement: reading for reading in outcome.readings}
    return {
        "mutant": outcome.mutant,
        "seed": outcome.seed,
        "status": flight.status.value if flight else baseline_status(outcome),
        "eligible": flight.eligible if flight else False,
        **_kills(flight),
        "ending": outcome.ending,
        "invalid": outcome.invalid,
        "duration_s": _short(outcome.duration_s),
        "infected_at_s": _short(outcome.infected_at_s),
        "carried": outcome.carried,
        "altered": outcome.altered,
        "struck": outcome.struck,
        "stack_error": outcome.stack_error,
        "readings": [
            [_short(r.rho, 4), _short(r.violated_at_s), r.verdict.value, r.triggered]
            if (r := readings.get(n))
            else None
            for n in requirements
        ],
        "violations": [
            [v.requirement, *(_short(value) for value in (v.t_s, v.x, v.y, v.z)), v.struck] for v in outcome.violations
        ],
    }


def _kills(flight: Flight | None) -> Mapping[str, Any]:
    if flight is None:
        return {}
    return {"kills": list(flight.kills), "operability_kills": list(flight.operability_kills)}


def _short(value: float | None, digits: int = 3) -> float | None:
    return None if value is None else round(value, digits)
