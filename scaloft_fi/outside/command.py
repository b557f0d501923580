"""A simulator of one's own: the command that flies a flight, as `sim/flyer.yaml` declares it."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any

from scaloft_fi.document import LARGEST, MOST, Item, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.mutants.mutant import EVERY_SEAM
from scaloft_fi.outside.border import BORDERS
from scaloft_fi.outside.ports import PORTS
from scaloft_fi.stack.declaration import Declaration, Seam

MOST_LIMIT_S = 24 * 3600.0
EVERY = "every"
"""Stands for every seam of the stack that `sim/stack.yaml` names."""
SITUATION, SEED, FAULT = "situation", "seed", "fault"
RECORD, FLIGHT_FOLDER, STUDY, PYTHON = "record", "folder", "study", "python"
_PLACE = re.compile(r"\{([A-Za-z_][\w.\-]*)\}")


@dataclass(frozen=True)
class Text:
    """A text of the command with places for values, `{name}`, and where it stands."""

    text: str
    place: str

    def filled(self, values: Mapping[str, Any]) -> str:
        """The text with its values.

        Raises:
            InputError: there is no such value.
        """

        def value(found: re.Match[str]) -> str:
            name = found[1]
            if name not in values:
                raise InputError(f"{self.place}: there is no value {{{name}}}{did_you_mean(name, values)}")
            given = values[name]
            return given if isinstance(given, str) else json.dumps(given)

        return _PLACE.sub(value, self.text)


@dataclass(frozen=True)
class Relay:
    """A relay between two topics of the simulator, through the tap of a seam.

    Attributes:
        source, to: the topic that it reads, and the one that it writes.
        border: name of the border over which both go.
        type, frame, qos, fields: of both topics; see `border.Topic`.
    """

    source: str
    to: str
    border: str
    type: str = ""
    frame: str = ""
    qos: Mapping[str, Any] = field(default_factory=dict)
    fields: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class ClockTopic:
    """The topic on which the simulator tells its time.  type: of its messages; see `border.Topic`."""

    name: str
    border: str
    type: str = ""


@dataclass(frozen=True)
class Offer:
    """A seam that the matrix may use.

    Attributes:
        port: the port whose message it has; "" = as the stack declares the seam.
        relay: the relay that carries its samples; None = the simulator injects the fault itself.
    """

    port: str = ""
    relay: Relay | None = None


@dataclass(frozen=True)
class FlightCommand:
    """A command that flies one flight.

    Attributes:
        run: program and arguments.
        env: what it gets in its environment beside ours.
        record: name of the file, in the folder of the flight, that it records to; with `*` any one that fits.
        limit_s: longest time that it may take [s, wall].
        mission_s: time limit of a flight [s, simulated]; None = that of its situation.
        deterministic: whether two flights of the same subject, situation and seed are the same.
        inputs: files of the study that decide what is flown, beside `sim/`.
        seams: the seams that the matrix may use, by name.
        clock: the topic by whose time relays work; None = by the stamps of their messages.
        place: where these stand, for errors.
    """

    run: tuple[Text, ...]
    record: str
    limit_s: float
    env: Mapping[str, Text] = field(default_factory=dict)
    mission_s: float | None = None
    deterministic: bool = False
    inputs: tuple[str, ...] = ()
    seams: Mapping[str, Offer] = field(default_factory=dict)
    clock: ClockTopic | None = None
    place: str = ""

    def declared(self, stack: Declaration) -> Declaration:
        """The declaration of a stack, as the command flies it: with the seams that the matrix may use.

        Raises:
            InputError: a seam is not one of the stack's and has no port.
        """
        seams: dict[str, Seam] = {}
        for name, offer in self.seams.items():
            if name == EVERY:
                seams |= stack.by_name
            elif offer.port:
                offered = PORTS[offer.port]
                seams[name] = Seam(name, offered.message, offered.rate_hz, offered.meaning, units=offered.units)
            elif name in stack.by_name:
                seams[name] = stack.by_name[name]
            else:
                hint = did_you_mean(name, stack.by_name)
                said = f"{name!r} is no seam of the stack {stack.name!r}, and has no message: PORT"
                raise InputError(f"{self.place}: {said}{hint}")
        canaries = tuple(name for name in stack.canaries if name in seams)
        return replace(
            stack,
            seams=tuple(seams.values()),
            canaries=canaries,
            deterministic=self.deterministic,
        )

    @property
    def relays(self) -> Mapping[str, Relay]:
        """The relays by name of their seam."""
        return {name: offer.relay for name, offer in self.seams.items() if offer.relay}

    def injects(self, seam: str) -> bool:
        """Whether the simulator injects the faults of a seam itself."""
        return len(self.relays) < len(self.seams) if seam == EVERY_SEAM else seam not in self.relays


def load_command(path: Path) -> FlightCommand:
    """Read `sim/flyer.yaml`.

    Raises:
        InputError: a key is unknown or a value is not allowed; the message names file and line.
    """
    document = load(path)
    document.need("flyer").choice(["command"])
    run = tuple(_text(item) for item in document.need("run").items(most=MOST))
    if not run:
        raise document.need("run").error("a list that begins with a program")
    env, mission, inputs = document.get("env"), document.get("mission_s"), document.get("inputs")
    deterministic, seams, clock = document.get("deterministic"), document.get("seams"), document.get("clock")
    command = FlightCommand(
        run=run,
        record=_record(document.need("record")),
        limit_s=document.need("limit_s").number(above=0.0, most=MOST_LIMIT_S),
        env={name: _text(item) for name, item in env.mapping(most=MOST).items()} if env else {},
        mission_s=mission.number(above=0.0, most=LARGEST) if mission else None,
        deterministic=deterministic.flag() if deterministic else False,
        inputs=tuple(_inside(item) for item in inputs.items(most=MOST)) if inputs else (),
        seams={name: _seam(name, item) for name, item in seams.mapping(most=MOST).items()} if seams else {},
        clock=_clock(clock) if clock else None,
        place=(seams or document).place,
    )
    document.close()
    return command


def _text(item: Item) -> Text:
    if isinstance(item.value, bool) or not isinstance(item.value, str | int | float):
        raise item.error("a text or a number")
    return Text(str(item.value), item.place)


def _record(item: Item) -> str:
    """A file name; it stands in the folder of the flight."""
    name = item.text()
    if PurePath(name).name != name or name in (".", ".."):
        raise item.error("the name of a file, without a folder")
    return name


def _inside(item: Item) -> str:
    """A path inside the study."""
    path = PurePath(item.text())
    if path.is_absolute() or ".." in path.parts:
        raise item.error("the path of a file inside the study")
    return path.as_posix()


def _seam(name: str, item: Item) -> Offer:
    parameter, relay, message = item.get("parameter"), item.get("relay"), item.get("message")
    if (parameter is None) == (relay is None) or (parameter is not None and not parameter.flag()):
        raise item.error("{parameter: true}, so that the command gets the fault in {fault}, or {relay: {...}}")
    port = message.choice(list(PORTS)) if message else ""
    if name == EVERY and (port or relay):
        raise item.error("{parameter: true}: it stands for the seams of the stack")
    item.close()
    return Offer(port, _relay(relay) if relay else None)


def _clock(item: Item) -> ClockTopic:
    kind = item.get("type")
    topic = ClockTopic(
        item.need("topic").text(), item.need("border").choice(list(BORDERS)), kind.text() if kind else ""
    )
    item.close()
    return topic


def _relay(item: Item) -> Relay:
    kind, frame, qos, fields = (item.get(key) for key in ("type", "frame", "qos", "fields"))
    relay = Relay(
        source=item.need("from").text(),
        to=item.need("to").text(),
        border=item.need("border").choice(list(BORDERS)),
        type=kind.text() if kind else "",
        frame=frame.text() if frame else "",
        qos={key: entry.plain() for key, entry in qos.mapping(most=MOST).items()} if qos else {},
        fields={key: entry.text() for key, entry in fields.mapping(most=MOST).items()} if fields else {},
    )
    if relay.source == relay.to:
        raise item.error("between two topics: to= must not be from=")
    item.close()
    return relay
