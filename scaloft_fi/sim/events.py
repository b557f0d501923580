"""The moments of a flight that deserve a mark on its map."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from scaloft_fi.sim.log import Array, Count, Event
from scaloft_fi.stack.reference.stack import MODES


def events_of(
    elapsed_s: Array,
    beliefs: Mapping[str, Array],
    counts: Mapping[str, Count],
    struck: str,
    struck_at_s: float,
    error: str,
) -> tuple[Event, ...]:
    """Events in order of time: first person report, collision flags, changes of mode, infection, contact.

    Args:
        elapsed_s: (T,) times of the samples [s].
        beliefs: (T,) per name, what the stack believed.
        counts: per seam what the wire counted.
        struck: body of the contact that ended the flight; "" without one.
        struck_at_s: when [s].
        error: what the stack raised, "" when nothing.
    """
    found = []
    told = np.flatnonzero(beliefs["told_person"] > 0.5)
    if len(told):
        found.append(Event(float(elapsed_s[told[0]]), "person", "a person is reported"))
    flags = beliefs["collision_flag"] > 0.5
    raised = np.flatnonzero(flags & ~np.concatenate([[False], flags[:-1]]))
    found += [Event(float(elapsed_s[i]), "flag", "the collision flag is raised") for i in raised]
    modes = beliefs["mode"].astype(int)
    changed = np.flatnonzero(np.diff(modes)) + 1
    found += [Event(float(elapsed_s[i]), "mode", f"flight control: {MODES[modes[i]]}") for i in changed]
    first = [count.first_altered_s for count in counts.values() if count.first_altered_s is not None]
    if first:
        found.append(Event(min(first), "infection", "the first sample differs"))
    if struck:
        found.append(Event(struck_at_s, "contact", f"strikes {struck}"))
    if error:
        found.append(Event(float(error.split(" at ")[1].split(" s:")[0]), "error", error))
    return tuple(sorted(found, key=lambda event: event.t_s))
