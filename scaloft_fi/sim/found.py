"""The situations that searches found, `sim/found.yaml`: those that show mutants, and those that break the drone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.document import Item, is_there, load
from scaloft_fi.errors import InputError

FILE = "found.yaml"
MOST_FINDS = 1_000


@dataclass(frozen=True)
class Again:
    """The evidence of a replication: flights on seeds that nothing before used.

    Attributes:
        seed: the first seed of them.
        p: by the exact test of the one requirement, adjusted by Holm over all pairs that were replicated together.
        violated: flights of the mutant that violate the requirement; flights: its flights.
        held, baselines, mission: as in `Evidence`.
    """

    seed: int
    p: float
    violated: int
    flights: int
    held: int
    baselines: int
    mission: int


@dataclass(frozen=True)
class Evidence:
    """The evidence that a situation shows a mutant, from seeds that the search never flew.

    Attributes:
        requirement: the requirement that the mutant violates.
        candidate: which candidate of the mutant the situation was, from 1.
        p: by the score's own test; alpha: what it was compared with.
        violated: flights of the mutant that violate the requirement; flights: its flights, with the seeds 0, 1, ...
        struck: the body that the first violating flight strikes; empty for none.
        held: baselines that hold the requirement with a robustness above `spread`; baselines: with the seeds 0, 1, ...
        margin: robustness that nine in ten baselines reach; spread: standard deviation over the baselines.
        mission: baselines that hold every operability requirement and meet the value of every axis.
        again: the evidence of a replication; None before one.
    """

    requirement: str
    candidate: int
    p: float
    alpha: float
    violated: int
    flights: int
    struck: str
    held: int
    baselines: int
    margin: float
    spread: float
    mission: int
    again: Again | None = None


@dataclass(frozen=True)
class Find:
    """A named situation that a search found.

    Attributes:
        name: name of the situation.
        situation: its key in the grid of the search.
        words: the values that are not benign, in words.
        mutant: the mutant that it was found for.
        shows: the evidence for each mutant that it shows, the one that it was found for first.
        seed: seed of the search.
    """

    name: str
    situation: str
    words: tuple[str, ...]
    mutant: str
    shows: Mapping[str, Evidence]
    seed: int


@dataclass(frozen=True)
class Break:
    """A named situation in which the unmutated drone violates a safety requirement.

    Attributes:
        name: name of the situation; it follows from requirement, struck, leg, near and belief.
        situation: its key in the grid of the search.
        words: the values that are not benign, in words.
        requirement: the requirement.
        struck: the body that is struck at the violation; empty for none.
        leg: between which places of the route, such as `corner to end`.
        near: the body that is struck; the nearer of the two places where none is.
        belief: the stage whose belief was the most wrong before the violation; empty where none was wrong.
        error: how far from the truth that belief was; unit: of the error.
        violated: flights that violate the requirement; flights: with the seeds 0, 1, ...
        alike: flights that do so in the same way: they strike the same, on the same leg, after the same wrong belief.
        flight: seed of the flight that `leg`, `near`, `belief`, `error`, `t_s` and `place` tell of.
        t_s: time of the violation [s from take-off].
        place: (3,) centre of the vehicle then [m, world].
        seed: seed of the search.
    """

    name: str
    situation: str
    words: tuple[str, ...]
    requirement: str
    struck: str
    leg: str
    near: str
    belief: str
    error: float
    unit: str
    violated: int
    flights: int
    alike: int
    flight: int
    t_s: float
    place: tuple[float, float, float]
    seed: int


@dataclass(frozen=True)
class Finds:
    """The finds of a study.

    Attributes:
        grid: name of the grid whose keys they have.
        finds: situations that show mutants, in the file's order.
        breaks: situations that break the unmutated drone, in the file's order.
    """

    grid: str
    finds: tuple[Find, ...]
    breaks: tuple[Break, ...] = ()

    @property
    def named(self) -> dict[str, str]:
        """The key of each situation by its name."""
        shown = {find.name: find.situation for find in self.finds}
        return shown | {one.name: one.situation for one in self.breaks}


def read_finds(folder: Path) -> Finds | None:
    """The finds of a study; None without the file.

    Args:
        folder: the study's `sim` folder.

    Raises:
        InputError: a key is missing or unknown, or a value is not allowed; the message names the place.
    """
    path = folder / FILE
    if not is_there(path):
        return None
    item = load(path)
    grid = item.need("grid").text()
    finds = tuple(_find(name, entry) for name, entry in item.need("finds").mapping(most=MOST_FINDS).items())
    breaks_item = item.get("breaks")
    broken = breaks_item.mapping(most=MOST_FINDS).items() if breaks_item else ()
    breaks = tuple(_break(name, entry) for name, entry in broken)
    item.close()
    return Finds(grid, finds, breaks)


def _find(name: str, item: Item) -> Find:
    shows_item = item.need("shows")
    find = Find(
        name=name,
        situation=item.need("situation").text(),
        words=tuple(word.text() for word in item.need("words")),
        mutant=item.need("mutant").text(),
        shows={mutant: _evidence(entry) for mutant, entry in shows_item.mapping(most=MOST_FINDS).items()},
        seed=item.need("seed").whole(),
    )
    item.close()
    if find.mutant not in find.shows:
        raise InputError(f"{shows_item.place}: shows must have the evidence for {find.mutant!r}, its own mutant")
    return find


def _break(name: str, item: Item) -> Break:
    violated_item, alike_item = item.need("violated"), item.need("alike")
    x, y, z = item.need("place").numbers(3)
    found = Break(
        name=name,
        situation=item.need("situation").text(),
        words=tuple(word.text() for word in item.need("words")),
        requirement=item.need("requirement").text(),
        struck=_optional(item, "struck"),
        leg=item.need("leg").text(),
        near=item.need("near").text(),
        belief=_optional(item, "belief"),
        error=item.need("error").number(least=0.0),
        unit=_optional(item, "unit"),
        violated=violated_item.whole(),
        flights=item.need("flights").whole(least=1),
        alike=alike_item.whole(least=1),
        flight=item.need("flight").whole(),
        t_s=item.need("t_s").number(least=0.0),
        place=(x, y, z),
        seed=item.need("seed").whole(),
    )
    item.close()
    if not found.flights < 2 * found.violated <= 2 * found.flights:
        raise violated_item.error(f"more than half of flights={found.flights}, and no more than all")
    if found.alike > found.violated:
        raise alike_item.error(f"at most violated={found.violated}")
    return found


def _optional(item: Item, key: str) -> str:
    entry = item.get(key)
    return entry.text() if entry else ""


def _evidence(item: Item) -> Evidence:
    evidence = Evidence(
        requirement=item.need("requirement").text(),
        candidate=item.need("candidate").whole(least=1),
        p=item.need("p").number(least=0.0, most=1.0),
        alpha=item.need("alpha").number(above=0.0, most=1.0),
        violated=item.need("violated").whole(),
        flights=item.need("flights").whole(least=1),
        struck=_optional(item, "struck"),
        held=item.need("held").whole(),
        baselines=item.need("baselines").whole(least=1),
        margin=item.need("margin").number(),
        spread=item.need("spread").number(least=0.0),
        mission=item.need("mission").whole(),
        again=_again(again_item) if (again_item := item.get("again")) else None,
    )
    item.close()
    return evidence


def _again(item: Item) -> Again:
    again = Again(
        seed=item.need("seed").whole(),
        p=item.need("p").number(least=0.0, most=1.0),
        violated=item.need("violated").whole(),
        flights=item.need("flights").whole(least=1),
        held=item.need("held").whole(),
        baselines=item.need("baselines").whole(least=1),
        mission=item.need("mission").whole(),
    )
    item.close()
    return again
