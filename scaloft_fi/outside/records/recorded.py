"""From a record to a flight log."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.outside.records.derived import DERIVED, Known
from scaloft_fi.outside.records.kind import RecordKind, kind_of
from scaloft_fi.outside.records.record_map import Entry, RecordMap
from scaloft_fi.outside.records.sampling import instants, moment_s, sampled
from scaloft_fi.outside.records.source import Series, Source
from scaloft_fi.sim.log import NEVER_S, Count, Ending, FlightLog
from scaloft_fi.sim.signals import clearance_name
from scaloft_fi.stack.messages import Array

PLACE = ("x_m", "y_m", "z_m")
"""Signals that every record must have: a violation has a place."""
LANDED, CLEARANCE = "landed", "clearance_m"


@dataclass(frozen=True)
class RecordCount:
    """What the record says of the fault's seam; see `sim.log.Count`."""

    carried: int
    altered: int
    first_altered_s: float | None


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
    series = _read(path, kind, mapping, entries)
    start_s, end_s = _span(path, mapping, series)
    at_s = instants(path, start_s, end_s)
    signals: dict[str, Array] = {"elapsed_s": at_s}
    for name, entry in entries.items():
        signals[name] = sampled(path, name, entry, _of(series, entry), start_s, at_s)
    _derive(signals, mapping, known, {*PLACE, *needed, *wanted})
    ending, last = _ending(signals)
    signals = {name: _frozen(values[: last + 1]) for name, values in signals.items()}
    struck = _struck(signals, known) if ending is Ending.STRUCK else ""
    return FlightLog(
        signals=signals,
        ending=ending,
        struck=struck,
        struck_at_s=float(signals["elapsed_s"][-1]) if ending is Ending.STRUCK else NEVER_S,
        stack_error="",
        counts=_counts(path, mapping, series, start_s, signals["elapsed_s"]),
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
    if unknown := derived.lacking(known):
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


def _read(path: Path, kind: RecordKind, mapping: RecordMap, entries: Mapping[str, Entry]) -> Mapping[Source, Series]:
    moments = [moment.entry for moment in (mapping.start, mapping.end) if moment]
    counts = [entry for entry in (mapping.altered, mapping.carried) if entry]
    sources = [entry.source for entry in (*entries.values(), *moments, *counts) if entry.source is not None]
    return kind.read(path, list(dict.fromkeys(sources)), mapping.timing)


def _of(series: Mapping[Source, Series], entry: Entry) -> Series | None:
    return None if entry.source is None else series[entry.source]


def _span(path: Path, mapping: RecordMap, series: Mapping[Source, Series]) -> tuple[float, float]:
    """Start and end of the flight [s]."""
    track = _of(series, mapping.signals["x_m"])
    if track is None or not len(track.times_s):
        raise InputError(f"{path}: signal 'x_m' has no message, so the flight has no start")
    start_s, end_s = float(track.times_s[0]), float(track.times_s[-1])
    if mapping.start and mapping.start.entry.source:
        start_s = moment_s(path, "start", mapping.start, series[mapping.start.entry.source])
    if mapping.end and mapping.end.entry.source:
        end_s = moment_s(path, "end", mapping.end, _after(series[mapping.end.entry.source], start_s))
    return start_s, end_s


def _after(series: Series, start_s: float) -> Series:
    later = series.times_s >= start_s
    return Series(series.times_s[later], series.values[later])


def _derive(signals: dict[str, Array], mapping: RecordMap, known: Known, asked: Collection[str]) -> None:
    """Add the signals that follow from others; contacts and touch-down end the log, so they are asked for always."""
    for name in sorted({*asked, CLEARANCE} - signals.keys()):
        if name in DERIVED and not lacking(mapping, known, name):
            signals[name] = DERIVED[name].value(signals, known)


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


def _counts(
    path: Path, mapping: RecordMap, series: Mapping[Source, Series], start_s: float, at_s: Array
) -> dict[str, Count]:
    if mapping.altered is None:
        return {}
    altered = sampled(path, "altered", mapping.altered, _of(series, mapping.altered), start_s, at_s)
    carried = altered
    if mapping.carried is not None:
        carried = sampled(path, "carried", mapping.carried, _of(series, mapping.carried), start_s, at_s)
    first = np.flatnonzero(altered > 0.0)
    count = int(altered[-1])
    return {"record": RecordCount(max(int(carried[-1]), count), count, float(at_s[first[0]]) if len(first) else None)}


def _frozen(values: Array) -> Array:
    frozen = np.ascontiguousarray(values)
    frozen.setflags(write=False)
    return frozen


def names_of(path: Path) -> Sequence[str]:
    """What a record has: its columns, or its fields after their topics.

    Raises:
        InputError: it cannot be read.
    """
    return kind_of(path).names(path)
