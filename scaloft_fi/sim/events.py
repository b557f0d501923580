"""The events of a flight: those that the map marks, and those at which a fault may strike.

| event | occurs |
|---|---|
| `sight` | when a person first is in free sight within 3 m |
| `obstacle` | when an obstacle comes within 1 m of the hull; again after the vehicle has left it |
| `waypoint` | when a waypoint of the route is passed; home is the last one |
| `light` | when the visible light begins to change |
| the kind of a belief's mark | when the stack's declaration marks it, such as a change of mode |

The flight loop tells the wire of them at 20 Hz, before the stack runs in that tick; the stack learns of none of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scaloft_fi.document import Item
from scaloft_fi.hazop.matrix import names_event
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.sim.log import CLEARANCE_CAP_M, Event, clearance_name
from scaloft_fi.sim.world import ROLES, Role, World
from scaloft_fi.stack.declaration import Belief, Mark
from scaloft_fi.streams import Array

HAPPENING = "#a16207"
"""Colour of the mark of a happening on a map."""


def events_of(
    elapsed_s: Array,
    declared: Iterable[Belief],
    believed: Mapping[str, Array],
    counts: Mapping[str, SeamCount],
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
    events = [Event(t_s, "happening", f"{name} begins", HAPPENING) for t_s, name in began]
    for name, mark in ((belief.name, belief.mark) for belief in declared if belief.mark is not None):
        strikes = Strike(mark)
        for t_s, value in zip(elapsed_s.tolist(), believed[name].tolist(), strict=True):
            if strikes(value):
                text = mark.text.format(mark.values[int(value)]) if mark.values else mark.text
                events.append(Event(t_s, mark.kind, text, mark.colour))
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


PERSON_SIGHT_M = 3.0
"""A person in sight within this distance counts [m]: near enough to matter, and not in sight from take-off on."""


Row = Mapping[str, float]
"""The truth signals of one sample by name."""


@dataclass(frozen=True)
class TruthEvent:
    """An event of the ground truth.

    Attributes:
        holds: (sample before, this sample, obstacles of the world) -> whether the state that begins with it holds.
        can_come: whether a study with this `world.yaml` can bring it.
        lacks: what a `world.yaml` lacks that cannot bring it.
        first: whether only the first occurrence counts.
    """

    holds: Callable[[Row, Row, Sequence[str]], bool]
    can_come: Callable[[Item], bool] = lambda _world: True
    lacks: str = ""
    first: bool = False


def _has_body(trait: Callable[[Role], bool]) -> Callable[[Item], bool]:
    def has(world: Item) -> bool:
        roles = {body.need("role").text() for body in world.need("bodies").mapping().values()}
        return any(trait(ROLES[role]) for role in roles if role in ROLES)

    return has


def _has_light(world: Item) -> bool:
    entries = found.mapping() if (found := world.get("happenings")) else {}
    return any(entry.need("kind").text() == "light" for entry in entries.values())


TRUTH_EVENTS: Mapping[str, TruthEvent] = {
    "sight": TruthEvent(
        lambda _before, now, _obstacles: now["person_sight_m"] <= PERSON_SIGHT_M,
        _has_body(lambda role: role.is_person),
        "body that is a person",
        first=True,
    ),
    "obstacle": TruthEvent(
        lambda _before, now, obstacles: any(now[clearance_name(name)] < CLEARANCE_CAP_M for name in obstacles),
        _has_body(lambda role: role.is_obstacle),
        "body that is an obstacle",
    ),
    "waypoint": TruthEvent(lambda before, now, _obstacles: now["waypoints_left"] < before["waypoints_left"]),
    "light": TruthEvent(
        lambda before, now, _obstacles: now["light"] != before["light"], _has_light, "happening of kind light"
    ),
}


def events_in(world: Item, beliefs: Iterable[Belief]) -> Mapping[str, str]:
    """The events of a study's flights, by name: why one can come in none of them, "" where it can.

    A body or a happening counts although no situation may bring it.  A mark whose kind has the name of an event of the
    ground truth is that event.

    Args:
        world: the study's `world.yaml`.
        beliefs: of the stack.

    Raises:
        InputError: a body or a happening has no role or kind; the message names its place.
    """
    events = TRUTH_EVENTS.items()
    truth = {name: "" if one.can_come(world) else f"{world.path} has no {one.lacks}" for name, one in events}
    kinds = (belief.mark.kind for belief in beliefs if belief.mark is not None)
    return truth | {kind: "" for kind in kinds if names_event(kind) and kind not in truth}


class Lookout:
    """Tells the wire of one flight of the events that its taps await.

    Args:
        wire: has the names of the events that its taps await, `awaited`, and learns of them by `occur`.
        world: the world of the flight.
        names: names of the truth signals, in order.
        beliefs: of the stack, in order.
    """

    def __init__(self, wire: Any, world: World, names: Sequence[str], beliefs: Sequence[Belief]) -> None:
        self._wire, self._names, awaited = wire, names, wire.awaited
        self._obstacles = world.bodies_with(lambda role: role.is_obstacle)
        events = ((name, event) for name, event in TRUTH_EVENTS.items() if name in awaited)
        self._truth = [(name, event.holds, Strike(Mark(name, "", event.first))) for name, event in events]
        self._marks = [
            (mark.kind, place, Strike(mark))
            for place, mark in enumerate(belief.mark for belief in beliefs)
            if mark is not None and mark.kind in awaited and mark.kind not in TRUTH_EVENTS
        ]
        self._before: Row | None = None

    @classmethod
    def of(cls, wire: Any, world: World, names: Sequence[str], beliefs: Sequence[Belief]) -> Lookout | None:
        """The lookout of a flight; None where no tap of its wire awaits an event."""
        return cls(wire, world, names, beliefs) if getattr(wire, "awaited", None) else None

    def look(self, t_s: float, truth: Sequence[float], beliefs: Sequence[float]) -> None:
        """Tell the wire what occurs in the sample at `t_s` [s]."""
        now = dict(zip(self._names, truth, strict=True))
        before, self._before = self._before or now, now
        occurs = [name for name, holds, strikes in self._truth if strikes(holds(before, now, self._obstacles))]
        occurs += [name for name, place, strikes in self._marks if strikes(beliefs[place])]
        for name in occurs:
            self._wire.occur(name, t_s)
