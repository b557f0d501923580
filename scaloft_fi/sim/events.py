"""The events of a flight that the map marks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from scaloft_fi.sim.log import Array, Count, Event
from scaloft_fi.stack.declaration import Belief, Mark

HAPPENING = "#a16207"
"""Colour of the mark of a happening on a map."""


def events_of(
    elapsed_s: Array,
    declared: Iterable[Belief],
    believed: Mapping[str, Array],
    counts: Mapping[str, Count],
    struck: str,
    struck_at_s: float,
    error: str,
    began: Iterable[tuple[float, str]] = (),
) -> tuple[Event, ...]:
    """Events in order of time: marked beliefs of the stack, happenings, infection, contact, error of the stack.

    Args:
        elapsed_s: (T,) times of the samples [s].
        declared: the beliefs of the stack.
        believed: (T,) values of each belief by name.
        counts: counts of the wire by seam.
        struck: body of the contact that ended the flight; "" without one.
        struck_at_s: time of that contact [s].
        error: the exception of the stack; "" without one.
        began: start [s] and name of each happening that started.
    """
    events = [
        event
        for belief in declared
        if belief.mark is not None
        for event in _marks(belief.mark, elapsed_s, believed[belief.name])
    ]
    events += [Event(t_s, "happening", f"{name} begins", HAPPENING) for t_s, name in began]
    first = [count.first_altered_s for count in counts.values() if count.first_altered_s is not None]
    if first:
        events.append(Event(min(first), "infection", "the first sample differs"))
    if struck:
        events.append(Event(struck_at_s, "contact", f"strikes {struck}"))
    if error:
        events.append(Event(float(error.split(" at ")[1].split(" s:")[0]), "error", error))
    return tuple(sorted(events, key=lambda event: event.t_s))


class Strike:
    """Whether a marked value makes its event, asked sample by sample: at a change, or at a rise above 0.5."""

    def __init__(self, mark: Mark) -> None:
        self._changes, self._first = bool(mark.values), mark.first
        self._before: float | None = None
        self._over = False

    def __call__(self, value: float) -> bool:
        """Whether the event occurs at this sample."""
        before, self._before = self._before, value
        if self._changes:
            return before is not None and int(value) != int(before)
        rises = value > 0.5 and (before is None or not before > 0.5) and not self._over
        self._over = self._over or (rises and self._first)
        return rises


def _marks(mark: Mark, elapsed_s: Array, values: Array) -> Iterator[Event]:
    """The events of one marked belief."""
    strikes = Strike(mark)
    for t_s, value in zip(elapsed_s.tolist(), values.tolist(), strict=True):
        if strikes(value):
            text = mark.text.format(mark.values[int(value)]) if mark.values else mark.text
            yield Event(t_s, mark.kind, text, mark.colour)
