"""The situations that searches found, `sim/found.yaml`: those that show mutants, and those that break the drone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from scaloft_fi import marks
from scaloft_fi.document import Item, is_there, load
from scaloft_fi.errors import InputError
from scaloft_fi.marks import ByName, Examples, Key, Listed, NotNegative, OneOrMore, Otherwise, Share, Size, Whole
from scaloft_fi.model import read

FILE = "found.yaml"
MOST_FINDS = 1_000


@dataclass(frozen=True)
class Again:
    """The evidence of a replication, from seeds that nothing before used.

    Attributes:
        seed: the first seed.
        p: by the exact test of the one requirement, adjusted by Holm over all pairs that were replicated together.
        violated: flights of the mutant that violate the requirement.
        flights: flights of the mutant.
        held: baselines that hold the requirement with a robustness above their spread.
        baselines: baselines.
        mission: baselines that hold every operability requirement and meet the value of every axis.
    """

    seed: Whole
    p: Share
    violated: Whole
    flights: OneOrMore
    held: Whole
    baselines: OneOrMore
    mission: Whole


@dataclass(frozen=True)
class Evidence:
    """The evidence that a situation shows a mutant, from seeds that the search never flew.

    Attributes:
        requirement: the requirement that the mutant violates.
        candidate: which candidate of the mutant the situation was, from 1.
        p: by the score's own test.
        alpha: what p was compared with.
        violated: flights of the mutant that violate the requirement.
        flights: flights of the mutant, with the seeds from 0 on.
        held: baselines that hold the requirement with a robustness above `spread`.
        baselines: baselines, with the seeds from 0 on.
        margin: robustness that nine in ten baselines reach, in the requirement's unit.
        spread: standard deviation of the robustness over the baselines, in the requirement's unit.
        struck: the body that the first violating flight strikes; empty for none.
        mission: baselines that hold every operability requirement and meet the value of every axis.
        again: the evidence of a replication; null: not replicated.
    """

    requirement: Annotated[str, Examples("SR2")]
    candidate: OneOrMore
    p: Share
    alpha: Annotated[float, marks.Bounds(above=0.0, most=1.0)]
    violated: Whole
    flights: OneOrMore
    struck: Annotated[str, Otherwise(""), Examples("wall")]
    held: Whole
    baselines: OneOrMore
    margin: float
    spread: NotNegative
    mission: Whole
    again: Again | None = None


@dataclass(frozen=True)
class Find:
    """A situation that shows mutants.

    Attributes:
        name: name of the situation.
        situation: its key in the grid of the search.
        words: the values that are not benign, in words.
        mutant: the mutant that it was found for.
        shows: the evidence for each mutant that it shows, the one that it was found for first.
        seed: seed of the search.
    """

    name: Key
    situation: Annotated[str, Examples("T1O0W0D0H1Cs=0.871")]
    words: tuple[str, ...]
    mutant: Annotated[str, Examples("LATE-pose@0.5s")]
    shows: Annotated[Mapping[str, Evidence], Size(1, MOST_FINDS), Listed("mutant", "id of the mutant")]
    seed: Whole

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a find without the evidence for its own mutant."""
        if self.mutant not in self.shows:
            place = item.need("shows").place
            yield InputError(f"{place}: shows must have the evidence for {self.mutant!r}, its own mutant")


@dataclass(frozen=True)
class Break:
    """A situation in which the unmutated drone violates a safety requirement.

    Attributes:
        name: name of the situation; it follows from requirement, struck, leg, near and belief.
        situation: its key in the grid of the search.
        words: the values that are not benign, in words.
        requirement: the requirement.
        struck: the body that is struck at the violation; empty for none.
        leg: between which places of the route, such as `corner to end`.
        near: the body that is struck; the nearer of the two places where none is.
        belief: the stage whose belief was the most wrong before the violation; empty where none was wrong.
        error: how far from the truth that belief was, in `unit`.
        unit: unit of the error.
        violated: flights that violate the requirement, more than half.
        flights: flights, with the seeds from 0 on.
        alike: flights that do so in the same way: they strike the same, on the same leg, after the same wrong belief.
        flight: seed of the flight that `leg`, `near`, `belief`, `error`, `t_s` and `place` tell of.
        t_s: time of the violation from take-off [s].
        place: (3,) centre of the vehicle then [m, world].
        seed: seed of the search.
    """

    name: Key
    situation: Annotated[str, Examples("T1O0W0D0H1Cs=0.871")]
    words: tuple[str, ...]
    requirement: Annotated[str, Examples("SR1")]
    struck: Annotated[str, Otherwise(""), Examples("bar")]
    leg: Annotated[str, Examples("corner to end")]
    near: Annotated[str, Examples("corner")]
    belief: Annotated[str, Otherwise(""), Examples("pose")]
    error: NotNegative
    unit: Annotated[str, Otherwise(""), Examples("m")]
    violated: Whole
    flights: OneOrMore
    alike: OneOrMore
    flight: Whole
    t_s: NotNegative
    place: tuple[float, float, float]
    seed: Whole

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse counts of flights that contradict each other."""
        if not self.flights < 2 * self.violated <= 2 * self.flights:
            yield item.need("violated").error(f"more than half of flights={self.flights}, and no more than all")
        if self.alike > self.violated:
            yield item.need("alike").error(f"at most violated={self.violated}")


@dataclass(frozen=True)
class Finds:
    """The situations that searches found; `scaloft-fi seek` writes this file.

    Attributes:
        grid: name of the grid whose keys they have.
        finds: the situations that show mutants, by name.
        breaks: the situations that break the unmutated drone, by name.
    """

    grid: Annotated[str, Examples("search")]
    finds: Annotated[tuple[Find, ...], ByName(), Size(0, MOST_FINDS)]
    breaks: Annotated[tuple[Break, ...], ByName(), Size(0, MOST_FINDS)] = ()

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
    return read(Finds, load(path)) if is_there(path) else None
