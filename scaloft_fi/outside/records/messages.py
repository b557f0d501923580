"""Collect the values of signals from messages, whatever library reads them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.errors import InputError
from scaloft_fi.outside.records.source import (
    MOST_MESSAGES,
    Series,
    Source,
    Timing,
    lacks,
    number,
    steps,
    too_many,
)

DEEPEST = 8
"""Deepest field that is listed."""


@dataclass(frozen=True)
class Message:
    """A message of a record: topic, time at which it was received [ns], and content, a mapping or an object."""

    topic: str
    received_ns: int
    content: Any


def topics_of(path: Path, sources: Iterable[Source], timing: Timing, there: Iterable[str]) -> tuple[str, ...]:
    """The topics that sources and timing need.

    Raises:
        InputError: a source has no topic, or the record lacks it.
    """
    known = list(there)
    for source in sources:
        if not source.topic or not source.field:
            raise InputError(f"{path}: signal {source.signal!r} must have a topic and a field, as the record has them")
        if source.topic not in known:
            raise lacks(path, source, "topic", source.topic, known)
    if timing.clock and timing.clock not in known:
        raise lacks(path, Source("time"), "topic", timing.clock, known)
    return tuple(dict.fromkeys([*(source.topic for source in sources), *filter(None, [timing.clock])]))


def collect(
    path: Path, messages: Iterable[Message], sources: Sequence[Source], timing: Timing
) -> Mapping[Source, Series]:
    """The series of each source.

    Raises:
        InputError: there are too many messages, a message lacks a field, or a value is no finite number.
    """
    by_topic: dict[str, list[tuple[Source, tuple[str | int, ...]]]] = {}
    for source in sources:
        way = steps(source.field)
        if way is None:
            raise InputError(
                f"{path}: signal {source.signal!r}: field {source.field!r} must be like pose.position.x or q[0]"
            )
        by_topic.setdefault(source.topic, []).append((source, way))
    found: dict[Source, tuple[list[float], list[float]]] = {source: ([], []) for source in sources}
    ticks: tuple[list[float], list[float]] = ([], [])
    for count, message in enumerate(messages):
        if count >= MOST_MESSAGES:
            raise too_many(path)
        place = f"message {count + 1} ({message.topic})"
        received_s = message.received_ns * 1e-9
        if message.topic == timing.clock:
            ticks[0].append(received_s)
            ticks[1].append(_seconds(path, place, _first_stamp(message.content)))
        asked = by_topic.get(message.topic, ())
        if not asked:
            continue
        t_s = _stamp(path, place, message.content) if timing.stamped else received_s
        for source, way in asked:
            times, values = found[source]
            times.append(t_s)
            values.append(number(path, source, place, _value(path, source, message.content, way)))
    return {source: _series(times, values, timing, ticks) for source, (times, values) in found.items()}


def _series(
    times: list[float],
    values: list[float],
    timing: Timing,
    ticks: tuple[list[float], list[float]],
) -> Series:
    """Sorted by time; a message before the first tick of the clock is left out."""
    times_s, numbers = np.array(times), np.array(values)
    if timing.clock and not timing.stamped:
        last = np.searchsorted(np.array(ticks[0]), times_s, side="right") - 1
        times_s, numbers = np.array([0.0, *ticks[1]])[last[last >= 0] + 1], numbers[last >= 0]
    order = np.argsort(times_s, kind="stable")
    return Series(times_s[order], numbers[order])


def _value(path: Path, source: Source, content: Any, way: Sequence[str | int]) -> Any:
    value = content
    for step in way:
        try:
            value = value[step] if isinstance(step, int) or isinstance(value, Mapping) else getattr(value, step)
        except (KeyError, AttributeError, IndexError, TypeError):
            there = fields_of(content)
            raise lacks(path, source, f"field of {source.topic!r}", source.field, there) from None
    return value


def _stamp(path: Path, place: str, content: Any) -> float:
    header = content.get("header", content) if isinstance(content, Mapping) else getattr(content, "header", content)
    return _seconds(path, place, _first_stamp(header))


def _first_stamp(content: Any) -> Any:
    """The stamp, or the clock, in a message."""
    for name in ("stamp", "timestamp", "clock"):
        stamp = content.get(name) if isinstance(content, Mapping) else getattr(content, name, None)
        if stamp is not None:
            return stamp
    return None


def _seconds(path: Path, place: str, stamp: Any) -> float:
    """A stamp of seconds and nanoseconds in seconds."""
    parts = stamp if isinstance(stamp, Mapping) else getattr(stamp, "__dict__", None) or {}
    second = next((parts[name] for name in ("sec", "secs") if name in parts), getattr(stamp, "sec", None))
    nano = next((parts[n] for n in ("nanosec", "nsec", "nsecs") if n in parts), getattr(stamp, "nanosec", 0))
    if second is None:
        raise InputError(f"{path}: {place}: the message has no stamp; take the time at which messages were received")
    told = Source("time")
    return number(path, told, place, second) + number(path, told, place, nano) * 1e-9


def fields_of(content: Any, name: str = "", depth: int = 0) -> Iterator[str]:
    """The fields of a message that are numbers, each with its parts; an array is told by its first place."""
    if depth > DEEPEST:
        return
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from fields_of(value, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(content, bool | int | float | np.number | np.bool_):
        yield name
    elif isinstance(content, list | tuple | np.ndarray):
        if len(content):
            yield from fields_of(content[0], f"{name}[0]", depth + 1)
    elif hasattr(content, "__dict__"):
        yield from fields_of({key: value for key, value in vars(content).items() if key[:1] != "_"}, name, depth)
