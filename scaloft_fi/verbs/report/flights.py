"""The flights of a campaign for the page, one compressed pack a situation: records, tracks, and what stands there.

A track is rows, one value a column.  Each value is divided by its column's quantum and rounded.  The rows at the start
that equal the baseline's are only counted.  Of the rest each column is written by itself, value minus the value of the
row before, modulo 2^16, zigzag coded (0, -1, 1, -2 ... -> 0, 1, 2, 3 ...): first all low bytes, then all high bytes,
which are nearly always zero.  Deflate then makes less than two bytes of a row of seven columns.
"""

from __future__ import annotations

import base64
import json
import math
import shlex
import struct
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, TRACK, TRACK_COLUMNS, TRACK_EVERY, Outcome, unpack_track
from scaloft_fi.judge.status import baseline_status, flight_of
from scaloft_fi.output import all_printable
from scaloft_fi.registry import grouped
from scaloft_fi.sim.grid import Break, Find
from scaloft_fi.sim.log import FAR_M, SAMPLE_HZ
from scaloft_fi.sim.world import World
from scaloft_fi.study import KnownFinds, Study
from scaloft_fi.verbs.seek import belief, place
from scaloft_fi.verbs.verdict import flies, words
from scaloft_fi.views.output import by_field
from scaloft_fi.views.picture import scene_of
from scaloft_fi.views.table import ranges

Whole = NDArray[np.int32]
"""A track as whole numbers, (T, columns)."""

TIME, TIME_QUANTUM = "elapsed_s", 0.05
"""The log runs at 20 Hz, so 0.05 s is exact."""
QUANTUM = 0.01
"""One centimetre, one centimetre per second: half a pixel of the page's map."""
PLACES = ("x_m", "y_m", "z_m")
"""Columns in which a large value is a place; in every other length `FAR_M` says that there was nothing to measure."""
FAR = 2**15 - 1
"""Stands for what was not there to be measured."""
WORD = 2**16


def quantum(column: str, coarse: int = 1) -> float:
    """The step of a column, in the column's unit; `coarse` widens every step but that of time."""
    return TIME_QUANTUM if column == TIME else QUANTUM * coarse


def thinned(rows: Sequence[tuple[float, ...]], every: int) -> list[tuple[float, ...]]:
    """One row for each `every` rows, and always the first and the last; it keeps their worst values, as `TRACK` says.

    >>> thinned([(0.0, 0, 0, 0, 0.1, 5, 9), (0.2, 1, 0, 0, 0.7, 4, 9), (0.4, 2, 0, 0, 0.2, 6, 9)], 2)[1]
    (0.4, 2, 0, 0, 0.7, 4, 9)
    """
    if every == 1 or not rows:
        return list(rows)
    kept = sorted({*range(0, len(rows), every), len(rows) - 1})
    spans = (zip(*rows[last + 1 : now + 1], strict=True) for last, now in pairwise([-1, *kept]))
    return [tuple(stands(column) for stands, column in zip(TRACK.values(), span, strict=True)) for span in spans]


def quantised(rows: Sequence[tuple[float, ...]], columns: Sequence[str], coarse: int = 1) -> Whole:
    """Rows as whole numbers of each column's quantum, smaller than `FAR`; what was not there to be measured is `FAR`.

    >>> quantised([(0.2, 1.006, 100.0)], ("elapsed_s", "x_m", "person_sight_m")).tolist()
    [[4, 101, 32767]]
    """
    values = np.asarray(rows, dtype=float).reshape(len(rows), len(columns))
    steps = np.array([quantum(column, coarse) for column in columns])
    most = np.array([FAR_M if column.endswith("_m") and column not in PLACES else math.inf for column in columns])
    whole = np.clip(np.rint(values / steps), 1 - FAR, FAR - 1)
    return np.where(values < most, whole, FAR).astype(np.int32)


def shared(rows: Whole, baseline: Whole) -> int:
    """How many rows at the start are the baseline's."""
    length = min(len(rows), len(baseline))
    differ = np.flatnonzero((rows[:length] != baseline[:length]).any(axis=1))
    return int(differ[0]) if len(differ) else length


def coded(rows: Whole, same: int = 0) -> bytes:
    """The rows after the first `same` as two planes of bytes, column by column."""
    before = rows[same - 1 : same] if same else np.zeros((1, rows.shape[1]), dtype=np.int32)
    words = zigzag(np.diff(rows[same:], axis=0, prepend=before)).T.ravel()
    return (words & 255).astype(np.uint8).tobytes() + (words >> 8).astype(np.uint8).tobytes()


def zigzag(differences: Whole) -> Whole:
    """Differences modulo 2^16 as numbers that are small when the difference is.

    >>> zigzag(np.array([0, -1, 1, -2, 65535])).tolist()
    [0, 1, 2, 3, 1]
    """
    signed = (differences + WORD // 2) % WORD - WORD // 2
    return (signed << 1 ^ signed >> 15) % WORD


TRACK_HZ = SAMPLE_HZ / TRACK_EVERY
EVERYTHING = 1 << 30
"""More seeds than there are."""
NONE = -1
DEFLATE = 6
"""Level of compression: 9 takes seven times as long for 3 % less."""


@dataclass(frozen=True)
class Detail:
    """How much of the tracks goes into the page.

    Attributes:
        every: how many rows of a track one row stands for.
        coarse: the step of positions, speeds and distances, in finest steps.
        seeds: how many seeds keep the tracks of the mutants, the lowest first; `EVERYTHING` for all.
    """

    every: int
    coarse: int
    seeds: int

    def __str__(self) -> str:
        """Rows in a second, and the steps."""
        return self.at_rate(TRACK_HZ)

    def at_rate(self, track_hz: float) -> str:
        """The same of tracks that have `track_hz` rows in a second."""
        step = f"{QUANTUM * self.coarse:g}"
        return f"{track_hz / self.every:g} Hz, in steps of {step} m and {step} m/s"


DETAILS = (
    Detail(1, 1, EVERYTHING),
    Detail(1, 2, EVERYTHING),
    Detail(2, 2, EVERYTHING),
    Detail(2, 2, 1),
    Detail(5, 2, 1),
    Detail(1, 1, 0),
)
"""From the most to the least; the page takes the first that fits."""


MOST_LISTED = 15_000
"""Greatest number of flights that the page lists one by one; its figures count all."""


def listed(outcomes: Iterable[Outcome], most: int = MOST_LISTED) -> frozenset[tuple[str, int]]:
    """The situations and seeds whose flights the page lists: the lowest seeds, in whole, of at most `most` flights.

    Flights of one pair are compared with each other, so the first pair is listed whatever its size.
    """
    kept, count = list[tuple[str, int]](), 0
    flights = Counter((outcome.situation, outcome.seed) for outcome in outcomes)
    for pair, number in sorted(flights.items(), key=lambda one: (one[0][1], one[0][0])):
        count += number
        if kept and count > most:
            break
        kept.append(pair)
    return frozenset(kept)


@dataclass(frozen=True)
class Packed:
    """The flights of a campaign.

    Attributes:
        texts: by situation the base64 text of its deflated flights.
        says: of which flights there are tracks, and of which not.
    """

    texts: Mapping[str, str]
    says: str


def packs(outcomes: Iterable[Outcome], requirements: Sequence[str], detail: Detail, every: int = 1) -> Packed:
    """Pack the flights, situation by situation; PLACEBO, which is its baseline, is left out.

    Args:
        outcomes: of the campaign.
        requirements: names, in the order of the readings.
        detail: how much of the tracks is kept.
        every: pack one situation in this many, to estimate the size of all.
    """
    shown = (outcome for outcome in outcomes if outcome.mutant != PLACEBO_ID)
    by_situation = grouped(shown, lambda outcome: outcome.situation)
    seeds = {outcome.seed for listed in by_situation.values() for outcome in listed if outcome.mutant != BASELINE}
    kept = set(sorted(seeds)[: detail.seeds])
    tracked, texts = defaultdict[tuple[bool, int], list[bool]](list), {}
    for key, listed in list(by_situation.items())[::every]:
        records, texts[key] = _pack(listed, requirements, detail, kept)
        for entry in records:
            if not entry["invalid"]:
                tracked[entry["mutant"] != BASELINE, entry["seed"]].append(entry["track"] is not None)
    hz = next((rate for listed in by_situation.values() for o in listed if (rate := _rate_hz(o.track))), TRACK_HZ)
    return Packed(texts, tracks_told(detail.at_rate(hz), tracked))


def _rate_hz(track: bytes) -> float | None:
    """Rows of a track in a second; None where it has too few."""
    rows = rows_of(track)
    return round(1 / (rows[1][0] - rows[0][0]), 2) if len(rows) > 2 else None


def tracks_told(detail: str, tracked: Mapping[tuple[bool, int], Sequence[bool]]) -> str:
    """The sentences that say of which flights the page has tracks.

    Args:
        detail: how they are kept, in words.
        tracked: by whether a mutant flew, and seed: of each flight that counts, whether it has one.
    """
    every = [has for flags in tracked.values() for has in flags]
    if all(every):
        return f"Tracks: every flight, {detail}."
    if not any(every):
        return "Tracks: of no flight; `replay` flies each again."
    groups: dict[str, list[tuple[bool, int]]] = {"Every flight": [], "Some": [], "None": []}
    for group, flags in tracked.items():
        groups["Every flight" if all(flags) else "Some" if any(flags) else "None"].append(group)
    parts = [f"{words} of {_whose(members)}" for words, members in groups.items() if members]
    return ".  ".join((f"Tracks: {sum(every)} of {len(every)} flights, {detail}", *parts, "`replay` flies the rest."))


def _whose(members: Sequence[tuple[bool, int]]) -> str:
    """As in: the unmutated drone with seeds 0-9, mutants with seed 0."""
    whose = {"the unmutated drone": False, "mutants": True}
    own = {who: [seed for other, seed in members if other is mutated] for who, mutated in whose.items()}
    return ", ".join(f"{who} with seed{'s' * (len(seeds) > 1)} {ranges(seeds)}" for who, seeds in own.items() if seeds)


def columns(detail: Detail) -> list[dict[str, Any]]:
    """The columns of the tracks with the step of each."""
    return [{"name": column, "quantum": quantum(column, detail.coarse)} for column in TRACK_COLUMNS]


def _pack(
    outcomes: Sequence[Outcome], requirements: Sequence[str], detail: Detail, seeds: set[int]
) -> tuple[list[dict[str, Any]], str]:
    """The records, and the base64 text of, deflated: a length (4 bytes, little endian), JSON of that length, tracks.

    Flights with one digest share a track; a track is its own rows, and the number of rows before
    them that it shares with another.
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
        asked = place is None and outcome.track and (outcome.mutant == BASELINE or outcome.seed in seeds)
        if asked and (kept := rows_of(outcome.track)):
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
    content = {"flights": all_printable(records), "tracks": tracks}
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    deflated = zlib.compress(struct.pack("<I", len(text)) + text + b"".join(body), DEFLATE)
    return records, base64.b64encode(deflated).decode()


def rows_of(track: bytes) -> list[tuple[float, ...]]:
    """The rows of a track; none where time does not rise, as when an earlier version kept other columns."""
    rows = unpack_track(track)
    return rows if all(one[0] < next_[0] for one, next_ in pairwise(rows)) else []


def record(outcome: Outcome, baseline: Outcome | None, requirements: Sequence[str]) -> dict[str, Any]:
    """What the page shows of one flight beside its track."""
    flight = flight_of(outcome, baseline) if outcome.mutant != BASELINE else None
    # robustness (none of what was never triggered), moment of the violation, compliance, episodes of the trigger
    readings = {
        one.requirement: [_short(one.robustness, 4), _short(one.violated_at_s), one.compliance.value, one.triggered]
        for one in outcome.readings
    }
    return {
        **by_field(outcome, "mutant", "seed", "ending", "invalid", "carried", "altered", "struck", "stack_error"),
        "status": flight.status.value if flight else baseline_status(outcome),
        **({"revealed": [*flight.revealed, *flight.operability_revealed]} if flight else {}),
        "duration_s": _short(outcome.duration_s),
        "infected_at_s": _short(outcome.infected_at_s),
        "readings": [readings.get(name) for name in requirements],
        "violations": [
            [v.requirement, *(_short(value) for value in (v.t_s, v.x, v.y, v.z)), v.struck] for v in outcome.violations
        ],
    }


def _short(value: float | None, digits: int = 3) -> float | None:
    return None if value is None else round(value, digits)


DIGITS = 2
"""Centimetres."""


def scenes(study: Study, situations: Iterable[str]) -> dict[str, Any]:
    """The mines, each once, and by situation its scene.

    Raises:
        InputError: the values of a situation do not go together.
    """
    mines: list[dict[str, Any]] = []
    by = {key: scene(study.grid.world(study.grid.situation(key)), mines) for key in situations}
    return {"mines": mines, "situations": by}


def scene(world: World, mines: list[dict[str, Any]]) -> dict[str, Any]:
    """The place of a world's mine in `mines`, to which it is added, and bodies, waypoints and home [m, world].

    A body is its role, its outline, the path of one that moves, and its name, which `struck` has too.
    """
    seen = scene_of(world)
    floor = [_outline(ring) for ring in seen.floor]
    # a closed floor draws its own walls
    mine = {"floor": floor, "walls": [] if floor else [_outline(segment) for segment in seen.walls]}
    if mine not in mines:
        mines.append(mine)
    return {
        "mine": mines.index(mine),
        "bodies": [
            [body.kind, _outline(body.outline), _outline(body.path), own.name]
            for own, body in zip(world.present, seen.bodies, strict=True)
        ],
        "waypoints": _outline(seen.waypoints),
        "home": _rounded(seen.home),
    }


def _outline(points: Iterable[tuple[float, float]]) -> list[list[float]]:
    return list(map(_rounded, points))


def _rounded(point: tuple[float, float]) -> list[float]:
    return [round(float(point[0]), DIGITS), round(float(point[1]), DIGITS)]


STEP_M = 0.1
"""Between two places of a path that is drawn [m]: five pixels of the page's map."""
KEPT = ("mutant", "seed", "ending", "infected_at_s", "violations")
"""What the map needs of a flight beside its path."""


def found(study: Study, campaign: str, outcomes: Iterable[Outcome], mines: list[dict[str, Any]]) -> dict[str, Any]:
    """The finds of the study, and the names of those that do not fit it any more.

    Args:
        study: the study, with the grid of the campaign.
        campaign: its name.
        outcomes: of the campaign, with their tracks.
        mines: those that the page has; new ones are added.
    """
    finds, names = study.finds, [requirement.name for requirement in study.requirements]
    # another further grid may use the same keys for other situations
    same = study.grid_name in (None, finds.grid, finds.searched.name if finds.searched else None)
    flown = grouped((outcome for outcome in outcomes if same and not outcome.invalid), lambda one: one.situation)
    listed, misfits = [], list(finds.misfits)
    for find in finds.finds:
        stands = _scene(find, finds, mines)
        if stands is None:
            misfits.append(find.name)
            continue
        shows = [
            {"mutant": mutant}
            | {name: float(f"{one:.4g}") if isinstance(one, float) else one for name, one in asdict(told).items()}
            for mutant, told in find.shows.items()
        ]
        listed.append(
            by_field(find, "name", "situation", "mutant")
            | {"words": words(find), "shows": shows, "scene": stands}
            | {"command": flies(find, find.mutant, finds, campaign, study.grid_name or "")}
            | {"flights": _pair(find, flown[find.situation], names)}
        )
    return {"grid": finds.grid, "finds": listed, "misfits": misfits}


def _scene(one: Find | Break, finds: KnownFinds, mines: list[dict[str, Any]]) -> dict[str, Any] | None:
    """What stands in a found situation; None where its values do not go together any more."""
    assert finds.searched is not None
    try:
        return scene(finds.searched.world(finds.searched.situation(one.situation)), mines)
    except InputError:
        return None


def _pair(find: Find, outcomes: Sequence[Outcome], requirements: Sequence[str]) -> list[dict[str, Any]] | None:
    """A flight of a mutant that the find shows, and the baseline's of that seed where there is one.

    The mutant that the find was made for is taken first, and of its flights the first that violates the requirement.

    Returns:
        None where no such mutant was flown there.
    """
    baselines = {outcome.seed: outcome for outcome in outcomes if outcome.mutant == BASELINE}

    def rank(outcome: Outcome) -> tuple[bool, bool, str, int]:
        violated = {violation.requirement for violation in outcome.violations}
        silent = find.shows[outcome.mutant].requirement not in violated
        return outcome.mutant != find.mutant, silent, outcome.mutant, outcome.seed

    flown = min((outcome for outcome in outcomes if outcome.mutant in find.shows), key=rank, default=None)
    if flown is None:
        return None
    clean = baselines.get(flown.seed)
    pair = [(one, record(one, clean, requirements)) for one in (flown, clean) if one is not None]
    return [{name: told[name] for name in KEPT} | {"rows": _path(one.track)} for one, told in pair]


def _path(track: bytes) -> list[list[float]]:
    """Time [s] and place [m, world] along a track, `STEP_M` apart, with the first row and the last."""
    rows, kept = rows_of(track), list[list[float]]()
    for row in rows:
        x, y = row[1:3]
        if not kept or row is rows[-1] or math.dist((x, y), kept[-1][1:]) >= STEP_M:
            kept.append([round(row[0], 2), round(x, 2), round(y, 2)])
    return kept


def broken(finds: KnownFinds, mines: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The breaks of a study, without those whose values do not go together any more.

    Args:
        finds: of the study.
        mines: those that the page has; new ones are added.
    """
    listed = []
    for one in finds.breaks:
        if (stands := _scene(one, finds, mines)) is None or finds.searched is None:
            continue
        # with the seeds that confirmed the break
        named = f"--mutant PLACEBO --situation {shlex.quote(one.name)} --baseline-seeds {one.flights}"
        told = by_field(one, "name", "situation", "requirement", "struck", "violated", "flights", "alike", "t_s")
        told |= {"words": words(one), "where": place(one), "belief": belief(one)}
        told |= {"place": list(one.place[:2]), "scene": stands}
        told |= {"command": f"scaloft-fi run --grid {finds.searched.name} {named}"}
        listed.append(told)
    return listed
