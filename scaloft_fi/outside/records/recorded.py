"""From a record to a flight log: signals sampled at 20 Hz, and those derived that a record lacks.

The last value is held: a value between two messages was never measured, and a flag or a distance to the nearest body
jumps, so that a line between two values would tell of states that were not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.outside.records.record_map import Keep, MappedSignal, RecordKind, RecordMap, Series, kind_of
from scaloft_fi.sim.log import NEVER_S, SAMPLE_HZ, Ending, FlightLog, clearance_name
from scaloft_fi.stack.messages import Array, Point

PASS_M = 0.5
"""A waypoint counts as passed within this horizontal distance [m]."""
AIRBORNE_M = 0.3
"""Waypoints count only after the vehicle has been this high above the start [m]."""

Signals = Mapping[str, Array]


@dataclass(frozen=True)
class Known:
    """What is known of a flight beside its record.

    Attributes:
        surfaces: surfaces of the world.
        home: where the flight starts and ends [m, world].
        route: waypoints of the situation, home last; None where the situation is not known.
        limit_s: time limit of the flight [s]; None where it is not known.
    """

    surfaces: tuple[str, ...]
    home: tuple[float, float]
    route: tuple[Point, ...] | None = None
    limit_s: float | None = None


@dataclass(frozen=True)
class Derived:
    """A signal that follows from others.

    Attributes:
        needs: names of the others, by what is known of the flight.
        value: the signal (T,), from these and `elapsed_s`.
        given: what must be known of the situation of the flight for it; None where it is not known.
    """

    needs: Callable[[Known], tuple[str, ...]]
    value: Callable[[Signals, Any], Array]
    given: Callable[[Known], object] = lambda _: ""


def _yaw(signals: Signals, _: Known) -> Array:
    x, y, z, w = (signals[name] for name in ("qx", "qy", "qz", "qw"))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _clearances(known: Known) -> tuple[str, ...]:
    return tuple(map(clearance_name, known.surfaces))


def _waypoints_left(signals: Signals, known: Known) -> Array:
    assert known.route is not None
    left, passed, airborne = [], 0, False
    start_m = float(signals["z_m"][0])
    for x_m, y_m, z_m in zip(*(signals[name].tolist() for name in ("x_m", "y_m", "z_m")), strict=True):
        airborne |= z_m - start_m > AIRBORNE_M
        while airborne and passed < len(known.route):
            if math.hypot(x_m - known.route[passed][0], y_m - known.route[passed][1]) > PASS_M:
                break
            passed += 1
        left.append(float(len(known.route) - passed))
    return np.array(left)


DERIVED: Mapping[str, Derived] = MappingProxyType(
    {
        "remaining_s": Derived(
            lambda _: (), lambda signals, known: known.limit_s - signals["elapsed_s"], lambda known: known.limit_s
        ),
        "speed_mps": Derived(
            lambda _: ("vx_mps", "vy_mps", "vz_mps"),
            lambda signals, _: np.sqrt(signals["vx_mps"] ** 2 + signals["vy_mps"] ** 2 + signals["vz_mps"] ** 2),
        ),
        "home_m": Derived(
            lambda _: ("x_m", "y_m"),
            lambda signals, known: np.hypot(signals["x_m"] - known.home[0], signals["y_m"] - known.home[1]),
        ),
        "yaw_rad": Derived(lambda _: ("qx", "qy", "qz", "qw"), _yaw),
        "clearance_m": Derived(
            _clearances,
            lambda signals, known: np.min(np.array([signals[name] for name in _clearances(known)], np.float64), axis=0),
        ),
        "waypoints_left": Derived(lambda _: ("x_m", "y_m", "z_m"), _waypoints_left, lambda known: known.route),
    }
)
"""The derived signals by name."""


LONGEST_S = 3 * 3600.0
"""Longest flight of a record [s]."""
NEAR_S = 1e-6
"""Times that differ by less than this are equal [s]: records round them."""


def instants(path: Path, start_s: float, end_s: float) -> Array:
    """The times of the samples since the start, (T,) [s]; the last one is not before the end.

    Raises:
        InputError: the flight has no duration, or is too long.
    """
    duration_s = end_s - start_s
    if not 0.0 < duration_s <= LONGEST_S:
        told = f"the flight from {start_s:.3f} s to {end_s:.3f} s"
        raise InputError(f"{path}: {told} must last more than 0 s and at most {LONGEST_S:,.0f} s")
    count = math.ceil((duration_s - NEAR_S) * SAMPLE_HZ) + 1
    return np.arange(max(count, 2)) / SAMPLE_HZ


def sampled(path: Path, name: str, entry: MappedSignal, series: Series | None, start_s: float, at_s: Array) -> Array:
    """A signal at the times `at_s` (T,) since `start_s` [s].

    Raises:
        InputError: it has no value at the start and no `unknown`.
    """
    if series is None:
        return np.full(len(at_s), entry.constant)
    plain = (entry.factor, entry.offset) == (1.0, 0.0)
    values = series.values if plain else entry.factor * series.values + entry.offset
    until = np.searchsorted(series.times_s, start_s + at_s + NEAR_S, side="right")
    if until[0] == 0 and entry.unknown is None:
        first = f"its first message is at {series.times_s[0]:.3f} s" if len(values) else "it has no message"
        why = f"the flight starts at {start_s:.3f} s and {first}"
        raise InputError(
            f"{path}: signal {name!r} is not known at the start: {why}; give unknown: VALUE, or a later start"
        )
    held = np.concatenate([[entry.unknown or 0.0], values])[until]
    if entry.keep is Keep.LAST or not len(values):
        return held
    worst = np.minimum if entry.keep is Keep.LEAST else np.maximum
    for place in np.flatnonzero(np.diff(until, prepend=until[0])):
        held[place] = worst.reduce(values[until[place - 1] : until[place]])
    return held


def moment_s(path: Path, moment: MappedSignal, series: Series, from_s: float = -math.inf) -> float:
    """When a moment comes, at `from_s` or later [s].

    Raises:
        InputError: it never comes.
    """
    reached = np.flatnonzero((series.values >= moment.least) & (series.times_s >= from_s))
    if not len(reached):
        raise InputError(
            f"{path}: the {moment.signal} of the flight never comes: no message is at least {moment.least:g}"
        )
    return float(series.times_s[reached[0]])


PLACE = ("x_m", "y_m", "z_m")
"""Signals that every record must have: a violation has a place."""
LANDED, CLEARANCE = "landed", "clearance_m"


def flight_log(
    path: Path,
    mapping: RecordMap,
    known: Known,
    *,
    needed: Mapping[str, str],
    wanted: Collection[str] = (),
    beliefs: Collection[str] = (),
) -> FlightLog:
    """Read a record.

    The log ends at the first contact (`clearance_m` at or below 0), at touch-down (`landed` rises to 1), or with the
    record, as the logs of our own flights do.

    Args:
        path: the record.
        mapping: where the signals stand in it.
        known: what is known of the flight beside it.
        needed: signals that the log must have, each with who needs it, for errors.
        wanted: signals that the log has where the record has them.
        beliefs: which signals are beliefs of the stack.

    Raises:
        InputError: the record cannot be read, or lacks a needed signal.
    """
    kind = kind_of(path)
    if mapping.loose:
        mapping = mapping.within(frozenset(kind.names(path)))
    position = dict.fromkeys(PLACE, "the place of a violation")
    names = _direct(path, kind, mapping, known, {**position, **needed}, wanted)
    entries = {name: mapping.signals[name] for name in names}
    beside = filter(None, (mapping.start, mapping.end, mapping.altered, mapping.carried))
    sources = dict.fromkeys(entry for entry in (*entries.values(), *beside) if entry.constant is None)
    series = kind.read(path, list(sources), mapping.timing)
    start_s, end_s = _span(path, mapping, series)
    at_s = instants(path, start_s, end_s)

    def of(name: str, entry: MappedSignal) -> Array:
        return sampled(path, name, entry, series.get(entry), start_s, at_s)

    signals: dict[str, Array] = {"elapsed_s": at_s} | {name: of(name, entry) for name, entry in entries.items()}
    # contacts end the log, so they are asked for always
    for name in sorted({*PLACE, *needed, *wanted, CLEARANCE} - signals.keys()):
        if name in DERIVED and not lacking(mapping, known, name):
            signals[name] = DERIVED[name].value(signals, known)
    ending, last = _ending(signals)
    signals = {name: np.ascontiguousarray(values[: last + 1]) for name, values in signals.items()}
    for values in signals.values():
        values.setflags(write=False)
    counts: dict[str, SeamCount] = {}
    if mapping.altered is not None:
        altered = of("altered", mapping.altered)[: last + 1]
        carried = altered if mapping.carried is None else of("carried", mapping.carried)[: last + 1]
        first, count = np.flatnonzero(altered > 0.0), int(altered[-1])
        first_s = float(at_s[first[0]]) if len(first) else None
        counts["record"] = SeamCount(max(int(carried[-1]), count), count, first_s)
    struck = _struck(signals, known) if ending is Ending.STRUCK else ""
    return FlightLog(
        signals=signals,
        ending=ending,
        struck=struck,
        struck_at_s=float(signals["elapsed_s"][-1]) if ending is Ending.STRUCK else NEVER_S,
        stack_error="",
        counts=counts,
        t_max_s=known.limit_s if known.limit_s is not None else float(signals["elapsed_s"][-1]),
        beliefs=tuple(name for name in signals if name in beliefs),
    )


def lacking(mapping: RecordMap, known: Known, name: str) -> str:
    """What a mapping lacks for a signal, in words; "" when it maps the signal or the signal follows from others."""
    if name in mapping.signals or name == "elapsed_s":
        return ""
    derived = DERIVED.get(name)
    if derived is None:
        return f"{mapping.name} maps no signal {name!r}"
    if derived.given(known) is None:
        unknown = "the situation of the flight"
        return f"{mapping.name} maps no signal {name!r}, which follows from {unknown} where that is known"
    lost = next((need for need in derived.needs(known) if need not in mapping.signals), None)
    return f"{mapping.name} maps neither signal {name!r} nor {lost!r}, from which it follows" if lost else ""


def _direct(
    path: Path, kind: RecordKind, mapping: RecordMap, known: Known, needed: Mapping[str, str], wanted: Collection[str]
) -> list[str]:
    """The signals to read: those of the mapping that are asked for, and those from which others follow."""
    for name, by in needed.items():
        if lack := lacking(mapping, known, name):
            near = did_you_mean(name, kind.names(path))
            raise InputError(f"{path}: {by} needs the signal {name!r}, and {lack}{near}")
    names = dict.fromkeys(name for name in (*needed, *wanted) if name in mapping.signals)
    for name in (*needed, *wanted, CLEARANCE, LANDED):
        if name in mapping.signals:
            names[name] = None
        elif name in DERIVED and not lacking(mapping, known, name):
            names |= dict.fromkeys(DERIVED[name].needs(known))
    names |= dict.fromkeys(name for name in map(clearance_name, known.surfaces) if name in mapping.signals)
    return [name for name in names if name != "elapsed_s"]


def _span(path: Path, mapping: RecordMap, series: Mapping[MappedSignal, Series]) -> tuple[float, float]:
    """Start and end of the flight [s]."""
    track = series.get(mapping.signals["x_m"])
    if track is None or not len(track.times_s):
        raise InputError(f"{path}: signal 'x_m' has no message, so the flight has no start")
    start_s, end_s = float(track.times_s[0]), float(track.times_s[-1])
    if mapping.start:
        start_s = moment_s(path, mapping.start, series[mapping.start])
    if mapping.end:
        end_s = moment_s(path, mapping.end, series[mapping.end], start_s)
    return start_s, end_s


def _ending(signals: Mapping[str, Array]) -> tuple[Ending, int]:
    """How the flight ended, and its last sample."""
    last = len(signals["elapsed_s"]) - 1
    ends = [(last + 1, Ending.TIMED_OUT)]
    if CLEARANCE in signals:
        touched = np.flatnonzero(signals[CLEARANCE] <= 0.0)
        ends += [(int(touched[0]), Ending.STRUCK)] if len(touched) else []
    if LANDED in signals:
        down = signals[LANDED] >= 0.5
        landing = np.flatnonzero(down[1:] & ~down[:-1])
        ends += [(int(landing[0]) + 1, Ending.LANDED)] if len(landing) else []
    place, ending = min(ends, key=lambda end: end[0])
    return ending, min(place, last)


def _struck(signals: Mapping[str, Array], known: Known) -> str:
    """The surface that the vehicle touches in the last sample; "" where the record does not tell."""
    there = [name for name in known.surfaces if clearance_name(name) in signals]
    nearest = min(there, key=lambda name: float(signals[clearance_name(name)][-1]), default="")
    return nearest if nearest and signals[clearance_name(nearest)][-1] <= 0.0 else ""


def names_of(path: Path) -> Sequence[str]:
    """What a record has: its columns, or its fields after their topics.

    Raises:
        InputError: it cannot be read.
    """
    return kind_of(path).names(path)
