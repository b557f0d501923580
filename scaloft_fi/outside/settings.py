"""The settings in `sim/stack.yaml` of a stack whose stages run in other processes (`name: outside`)."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from scaloft_fi.outside.border import BORDERS, Topic
from scaloft_fi.outside.ports import PORTS
from scaloft_fi.outside.processes import Command
from scaloft_fi.stack.config import Bounds, ConfigError, Scalar

BELOW = {"flight_control": ("velocity", "land"), "planner": ("goal", "speed_limit", "land")}
"""What of our drone flies below the stages outside, and the ports that it takes orders from."""
FRAMES = ("", "world", "body")

Wait = Annotated[float, Bounds(least=1e-3, most=60.0)]


@dataclass(frozen=True)
class ProcessConfig:
    """A process of every flight.

    Attributes:
        run: program and arguments; `{study}`, `{python}`, `{route}`, `{home}`, `{altitude_m}`, `{cruise_mps}`,
            `{slow_mps}`, `{yaw_deg}` and `{situation}` stand for what they say, in JSON where it is no plain number or
            text.
        env: environment variables beside those of the run.
        folder: where it runs, in the folder of the study.
    """

    run: tuple[str, ...]
    env: Mapping[str, str] = field(default_factory=dict)
    folder: str = "."

    def command(self, words: Mapping[str, str]) -> Command:
        """The command with every word in braces replaced."""
        env = {name: replaced(text, words) for name, text in self.env.items()}
        return Command(tuple(replaced(text, words) for text in self.run), env, self.folder)


def replaced(text: str, words: Mapping[str, str]) -> str:
    """`text` with `{word}` replaced for each of `words`; other braces stay.

    >>> replaced("--speed={cruise_mps} {x}", {"cruise_mps": "0.5"})
    '--speed=0.5 {x}'
    """
    for word, value in words.items():
        text = text.replace(f"{{{word}}}", value)
    return text


@dataclass(frozen=True)
class SeamConfig:
    """A seam whose samples go over a topic.

    Attributes:
        topic: its name on the border.
        carries: the port, what the samples are.
        type: type of the border's messages; "" = its usual one for the port.
        frame: frame id of messages that go out; "world" or "body" for a velocity that comes.
        qos: quality of service, as the border names it.
        fields: fields of the border's message by path to those of the sample; empty = the border's usual mapping.
        awaited: whether the flight waits before take-off until the topic has its other end.
    """

    topic: str
    carries: str
    type: str = ""
    frame: str = ""
    qos: Mapping[str, Scalar] = field(default_factory=dict)
    fields: Mapping[str, str] = field(default_factory=dict)
    awaited: bool = True

    def as_topic(self, seam: str) -> Topic:
        """The topic of the border."""
        port = PORTS[self.carries]
        return Topic(
            seam, self.topic, port.message, port.outward, self.type, self.frame, self.qos, self.fields, self.awaited
        )


@dataclass(frozen=True)
class OutsideConfig:
    """All settings of a stack outside.

    Attributes:
        border: name of the border.
        below: what of our drone flies below the stages outside, a key of `BELOW`.
        processes: what is started for every flight, in order.
        seams: the seams at the border, by name.
        inside: settings of the part that flies below; the flights have them in its schema.
        answer: the seam whose sample answers each tick, which puts the flight into lock step; "" = without.
        answer_s: how long a tick waits for its answer [s, wall].
        ready_s: how long the processes may take to come up [s, wall].
        pace: greatest simulated time per wall time; 0 = as fast as the answers come.
        silent_ticks: ticks in a row without an answer after which the stack outside counts as hung.
        deterministic: whether two flights of the same subject, situation and seed have the same bits.
        version: of the programs outside the study, in words; another one means other flights.
    """

    border: str
    below: str
    processes: tuple[ProcessConfig, ...]
    seams: Mapping[str, SeamConfig]
    inside: Any
    answer: str = ""
    answer_s: Wait = 0.5
    ready_s: Wait = 30.0
    pace: Annotated[float, Bounds(least=0.0, most=1000.0)] = 0.0
    silent_ticks: Annotated[int, Bounds(least=1, most=1000)] = 20
    deterministic: bool = False
    version: str = ""

    def check(self) -> None:
        """Refuse what does not fit together.

        Raises:
            ConfigError: naming the setting.
        """
        _one_of("border", self.border, tuple(BORDERS))
        _one_of("below", self.below, tuple(BELOW))
        if not self.seams:
            raise ConfigError("stack.seams", "must have a seam")
        for name, seam in self.seams.items():
            self._check_seam(f"seams.{name}", seam)
            misfit = BORDERS[self.border].misfit(seam.as_topic(name))
            if misfit:
                raise ConfigError(f"stack.seams.{name}", misfit)
        ports = [seam.carries for seam in self.seams.values()]
        if BELOW[self.below][0] not in ports:
            allowed = f"needs a seam that carries {BELOW[self.below][0]!r}, because below={self.below!r}"
            raise ConfigError("stack.seams", allowed)
        if self.answer:
            _one_of(
                "answer", self.answer, [name for name, seam in self.seams.items() if not PORTS[seam.carries].outward]
            )
        elif not self.pace:
            raise ConfigError("stack", "needs `answer`, the seam that answers each tick, or `pace`, such as 1.0")

    def _check_seam(self, path: str, seam: SeamConfig) -> None:
        _one_of(f"{path}.carries", seam.carries, tuple(PORTS))
        _one_of(f"{path}.frame", seam.frame, FRAMES if seam.carries == "velocity" else (seam.frame,))
        if not PORTS[seam.carries].outward and seam.carries not in BELOW[self.below]:
            taken = ", ".join(BELOW[self.below])
            raise ConfigError(
                f"stack.{path}.carries", f"{seam.carries!r} is not taken where below={self.below!r}: {taken}"
            )
        twins = [name for name, other in self.seams.items() if other.carries == seam.carries]
        if len(twins) > 1 and not PORTS[seam.carries].outward:
            raise ConfigError(
                f"stack.{path}.carries", f"{seam.carries!r} is carried by {' and '.join(twins)}; one is allowed"
            )


def _one_of(path: str, value: str, allowed: Collection[str]) -> None:
    if value not in allowed:
        near = difflib.get_close_matches(value, list(allowed), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(map(repr, allowed))}"
        raise ConfigError(f"stack.{path}", f"{value!r} is not known{hint}")
