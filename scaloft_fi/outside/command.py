"""A simulator of one's own: the command that flies a flight, as `sim/flyer.yaml` declares it, within bounds.

The simulator, or a remapping of its launch file, writes `/x_raw` where it used to write `/x`; the relay reads `/x_raw`,
lets the wire of the flight carry the sample over the seam, and writes `/x`.
"""

from __future__ import annotations

import json
import re
import shutil
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError, ScaloftError, did_you_mean, shown
from scaloft_fi.marks import MOST, Bounds, Called, Choices, Examples, Given, MoreThanZero, Needed, Reads, Size
from scaloft_fi.model import read
from scaloft_fi.mutants.mutant import EVERY_SEAM
from scaloft_fi.output import line
from scaloft_fi.outside.border import BORDERS, PORTS, Border, BorderError, BorderName, Topic
from scaloft_fi.outside.exchange import DONE, LINE, Command, Processes
from scaloft_fi.stack.declaration import Declaration, Seam, Wire
from scaloft_fi.stack.messages import Stamp

MOST_LIMIT_S = 24 * 3600.0
_RUN = Examples(("{python}", "fly.py", "--situation", "{situation}", "--record", "{record}"))
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


def runs(program: str, folder: Path) -> bool:
    """Whether a program can be started in a folder, below which it is looked for where it is a path."""
    return shutil.which(str(folder / program) if "/" in program else program) is not None


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


def _of_type(*types: str) -> Callable[[Mapping[str, Collection[str]]], dict[str, Any]]:
    return lambda _names: {"type": list(types) if len(types) > 1 else types[0]}


Word = Annotated[Text, Reads(_text, _of_type("string", "number"))]


@dataclass(frozen=True)
class Relay:
    """A relay between two topics of the simulator, through the tap of a seam.

    Attributes:
        source: the topic that it reads.
        to: another topic, which it writes.
        border: what the topics go over.
        type: type of the messages, as the border names it.
        frame: frame id of messages.
        qos: quality of service, as the border names it.
        fields: fields of the border's message by path to those of the sample.
    """

    source: Annotated[str, Called("from"), Examples("/cmd_vel")]
    to: Annotated[str, Examples("/cmd_vel_faulty")]
    border: BorderName
    type: Annotated[str, Examples("geometry_msgs/msg/Twist")] = ""
    frame: str = ""
    qos: Annotated[Mapping[str, Any], Size()] = field(default_factory=dict)
    fields: Annotated[Mapping[str, str], Size()] = field(default_factory=dict)

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a relay from a topic to itself."""
        if self.source == self.to:
            yield item.error("between two topics: to= must not be from=")


@dataclass(frozen=True)
class ClockTopic:
    """The topic on which the simulator tells its time.

    Attributes:
        name: name of the topic.
        border: what the topic goes over.
        type: type of its messages; see `border.Topic`.
    """

    name: Annotated[str, Called("topic"), Examples("/clock")]
    border: BorderName
    type: str = ""


@dataclass(frozen=True)
class Offer:
    """How the faults of a seam reach the simulator.

    Attributes:
        port: the port whose message it has; left out: as the stack declares the seam.
        relay: the relay that carries its samples; left out: the simulator injects the fault itself.
        parameter: the command gets the fault in {fault} and injects it itself.
    """

    port: Annotated[str, Called("message"), Choices(lambda: {name: port.meaning for name, port in PORTS.items()})] = ""
    relay: Relay | None = None
    parameter: bool = False
    CONDITIONS: ClassVar[Mapping[str, object]] = {
        "oneOf": [{"required": ["relay"]}, {"required": ["parameter"], "properties": {"parameter": {"const": True}}}]
    }

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse a seam whose faults nobody, or two, would inject."""
        if self.parameter is (self.relay is not None) or (item.get("parameter") and not self.parameter):
            yield item.error("{parameter: true}, so that the command gets the fault in {fault}, or {relay: {...}}")
        elif item.name == EVERY and (self.port or self.relay):
            yield item.error("{parameter: true}: it stands for the seams of the stack")


@dataclass(frozen=True)
class FlightCommand:
    """A command that flies instead of our simulator.

    Attributes:
        run: program and arguments; {situation}, {seed}, {fault}, {record}, {folder}, {study}, {python} and values of
            the situation by dotted path stand in braces.
        record: name of the file, in a private folder of the flight, that it records to; with * any that fits.
        limit_s: longest wall time of a flight [s].
        env: environment variables beside ours; with the same places in braces.
        mission_s: time limit of a flight, simulated; left out: that of its situation [s].
        deterministic: whether two flights of the same subject, situation and seed are the same.
        inputs: files of the study, beside sim/, that decide what is flown; a changed one flies again.
        seams: the seams that the matrix may use, by name; `every` stands for all of the stack.
        clock: the topic on which the simulator tells its time; left out: by the stamps of messages.
        flyer: a command flies.
        place: where these stand, for errors.
    """

    run: Annotated[tuple[Word, ...], Size(1, MOST, "a list that begins with a program"), _RUN]
    record: Annotated[str, Reads(_record, _of_type("string")), Examples("flight.csv")]
    limit_s: Annotated[float, Bounds(above=0.0, most=MOST_LIMIT_S), Examples(120)]
    env: Annotated[Mapping[str, Word], Size()] = field(default_factory=dict)
    mission_s: MoreThanZero | None = None
    deterministic: bool = False
    inputs: Annotated[tuple[Annotated[str, Reads(_inside, _of_type("string"))], ...], Size()] = ()
    seams: Annotated[Mapping[str, Offer], Size()] = field(default_factory=dict)
    clock: ClockTopic | None = None
    place: Annotated[str, Given(lambda item: (item.get("seams") or item).place)] = ""
    flyer: Annotated[Literal["command"], Needed()] = "command"

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
        return replace(stack, seams=tuple(seams.values()), canaries=canaries, deterministic=self.deterministic)

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
    return read(FlightCommand, load(path))


CLOCK_S = 0.05
"""How often a border is told the time [s, wall]."""
_RAW, _CLOCK = "_raw", "_clock"


class Tick(NamedTuple):
    """The simulated time."""

    stamp_s: Stamp


@dataclass
class _Line:
    """One relay under way.  polled_s: when its seam was polled last [s, wall]; t_s: the time of that poll."""

    seam: Seam
    polled_s: float = 0.0
    t_s: float = 0.0


@dataclass
class Relays:
    """All relays of one flight.

    A seam is polled whenever a message comes, and at its rate while none comes, so that a late sample can be delivered.
    Time is that of the simulator's clock since it was first told; without a clock that of the stamps of the messages
    since the first one, and it passes as the wall clock between them.

    Attributes:
        relays: by name of the seam.
        stack: declares the seams.
        wire: carries the samples.
        folder: empty, for the borders.
        clock: the topic of the simulator's clock; None without one.
    """

    relays: Mapping[str, Relay]
    stack: Declaration
    wire: Wire
    folder: Path
    clock: ClockTopic | None = None
    _borders: dict[str, Border] = field(default_factory=dict)
    _lines: dict[str, _Line] = field(default_factory=dict)
    _first_stamp_s: float | None = None
    _clock_s: float = 0.0
    _began_s: float = 0.0
    _told_s: float = 0.0

    def begin(self) -> Mapping[str, str]:
        """Open the borders; returns what the simulator needs in its environment to find them.

        Raises:
            BorderError: a border cannot be opened.
        """
        self._began_s = time.monotonic()
        environment: dict[str, str] = {}
        clocks = [self.clock.border] if self.clock and self.relays else []
        for name in dict.fromkeys([*(relay.border for relay in self.relays.values()), *clocks]):
            folder = self.folder / name
            folder.mkdir()
            topics = []
            for seam, relay in self.relays.items():
                if relay.border == name:
                    message, more = self.stack.by_name[seam].message, (relay.type, relay.frame, relay.qos, relay.fields)
                    topics.append(Topic(seam + _RAW, relay.source, message, False, *more))
                    topics.append(Topic(seam, relay.to, message, True, *more))
            if self.clock and self.clock.border == name:
                topics.append(Topic(_CLOCK, self.clock.name, Tick, outward=False, type=self.clock.type))
            border = BORDERS[name](topics, folder)
            self._borders[name] = border
            border.open()
            environment |= border.environment
        self._lines = {name: _Line(self.stack.by_name[name]) for name in self.relays}
        return environment

    def attend(self) -> None:
        """Carry what has come since the last call.

        Raises:
            BorderError: a message does not fit its seam, or messages came faster than they can be carried.
        """
        now_s = time.monotonic()
        if self.clock:
            self._hear(self._borders[self.clock.border], self.clock.name)
        for name, relay in self.relays.items():
            border, line = self._borders[relay.border], self._lines[name]
            arrival = border.take(name + _RAW)
            if arrival.refused:
                raise BorderError(f"the relay of seam {name!r} cannot read {relay.source}: {arrival.refused}")
            if arrival.count > 1:
                raise BorderError(
                    f"the relay of seam {name!r} lost {arrival.count - 1} messages, which came all at once"
                )
            since_s = self._clock_s - line.t_s if self.clock else now_s - line.polled_s
            if arrival.sample is None and since_s < 1.0 / line.seam.rate_hz:
                continue
            line.t_s = max(line.t_s, self._time(line, arrival.sample, now_s))
            line.polled_s = now_s
            delivered = self.wire.cross(name, line.t_s, arrival.sample)
            if delivered is not None:
                border.send(name, line.t_s, delivered)
        if now_s - self._told_s >= CLOCK_S:
            self._told_s = now_s
            for border in self._borders.values():
                border.clock(max(line.t_s for line in self._lines.values()))

    def _hear(self, border: Border, name: str) -> None:
        """Take the simulator's time, if it was told."""
        arrival = border.take(_CLOCK)
        if arrival.refused:
            raise BorderError(f"the relays cannot read the clock {name}: {arrival.refused}")
        if arrival.sample is not None:
            self._clock_s = self._since_first(arrival.sample.stamp_s)

    def _since_first(self, stamp_s: float) -> float:
        """The time of a stamp since the first one [s]."""
        if self._first_stamp_s is None:
            self._first_stamp_s = float(stamp_s)
        return float(stamp_s) - self._first_stamp_s

    def _time(self, line: _Line, sample: object, now_s: float) -> float:
        """The time of a poll since the first message, or since the borders were opened [s]."""
        if self.clock:
            return self._clock_s
        stamp_s = getattr(sample, "stamp_s", None)
        if isinstance(stamp_s, int | float):
            return self._since_first(stamp_s)
        return line.t_s + now_s - (line.polled_s or self._began_s)

    def close(self) -> None:
        """Close the borders; may be called twice."""
        for border in self._borders.values():
            border.close()
        self._borders.clear()


LOOK_S = 0.002
"""How often a running command is looked at [s, wall]."""
SHOWN_LINES, SHOWN = 5, 400
"""How many of its last lines an error shows, and how many characters of them."""
_TOLD: Mapping[str, tuple[type[int | float], float, str]] = {
    "altered": (int, 10**12, "a whole number >= 0"),
    "carried": (int, 10**12, "a whole number >= 0"),
    "first_altered_s": (float, 1e9, "a number >= 0"),
}
"""Type and greatest value of each number that a command may tell, and what it must be, in words."""


class CommandError(ScaloftError):
    """The command failed: a failure of the harness, not of the drone."""

    exit_code = 4


@dataclass(frozen=True)
class Told:
    """What the last line of the command's output says, a JSON object.

    Attributes:
        altered, carried: how many samples the fault altered, and how many its seam carried; None = not told.
        first_altered_s: time of the first altered sample [s]; None = never, or not told.
        stack_error: exception of the stack under test, after which the flight went on; "" without one.
    """

    altered: int | None = None
    carried: int | None = None
    first_altered_s: float | None = None
    stack_error: str = ""


def run_command(
    words: Sequence[str],
    env: Mapping[str, str],
    cwd: Path,
    limit_s: float,
    folder: Path,
    attend: Callable[[], None] | None = None,
    lifeline: int | None = None,
) -> Told:
    """Run a command to its end; returns what its last line of output says.

    The arguments are those of `finished`.

    Raises:
        BorderError: it cannot be started, or its guard has died.
        CommandError: it takes longer, or fails.
    """
    how, lines = finished(words, env, cwd, limit_s, folder, attend, lifeline)
    if how != DONE:
        raise CommandError(f"the command {how}; it said last: {said_last(lines)}")
    return told("".join(lines[-1:]))


def said_last(lines: Sequence[str]) -> str:
    """The last lines of a command, for a sentence."""
    return " / ".join(line(one)[:LINE] for one in lines[-SHOWN_LINES:])[-SHOWN:] or "nothing"


def finished(
    words: Sequence[str],
    env: Mapping[str, str],
    cwd: Path,
    limit_s: float,
    folder: Path,
    attend: Callable[[], None] | None = None,
    lifeline: int | None = None,
) -> tuple[str, Sequence[str]]:
    """Run a command until it ends or its time is over; returns how, as in `DONE`, and its last lines.

    Args:
        words: program and arguments.
        env: environment variables beside ours.
        cwd: where it runs.
        limit_s: longest time that it may take [s, wall].
        folder: empty folder for the end of its output.
        attend: called again and again while it runs.
        lifeline: as of `Processes`.

    Raises:
        BorderError: it cannot be started, or its guard has died.
    """
    processes = Processes([Command(tuple(words), env)], cwd, {}, folder, lifeline)
    due_s = time.monotonic() + limit_s
    try:
        processes.start()
        while not processes.ended() and time.monotonic() < due_s:
            if attend is not None:
                attend()
            time.sleep(LOOK_S)
    finally:
        processes.stop()
    return processes.how or f"ran longer than {limit_s:g} s", processes.lines()


def told(last: str) -> Told:
    """What the last line of output says; nothing where it is no JSON object.

    Raises:
        CommandError: it is one, with a value that is not allowed.
    """
    if not last.startswith("{"):
        return Told()
    try:
        said = json.loads(last)
    except (ValueError, RecursionError):
        return Told()
    numbers: dict[str, Any] = {}
    for name, (kind, most, must) in _TOLD.items():
        number = said.get(name)
        if number is None:
            continue
        if isinstance(number, bool) or not isinstance(number, int | kind) or not 0 <= number <= most:
            raise CommandError(f"the last line says {name}={shown(number)}, which must be {must}")
        numbers[name] = kind(number)
    return Told(**numbers, stack_error=line(str(said.get("stack_error") or ""))[:SHOWN])
