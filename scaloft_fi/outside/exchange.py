"""The exchange of one flight with its stages outside: settings, processes, border, one round over the seams a time."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field
from pathlib import Path
from shutil import rmtree
from typing import Annotated, Any

from scaloft_fi.document import Item
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.marks import MOST, Bounds, Choices, Examples, Pattern, Scalar, Size
from scaloft_fi.output import line as inert
from scaloft_fi.outside import guard
from scaloft_fi.outside.border import BORDERS, PORTS, Border, BorderError, BorderName, Topic
from scaloft_fi.stack.declaration import Wire

START_S, STOP_S = 10.0, 5.0
"""Greatest time in which the guard starts, and in which it ends everything [s, wall]."""
DONE, KILLED = "ended with code 0", "was ended by SIGKILL"
"""How a process ends that has succeeded, and one that the machine or a person has ended."""
LINE = 300
"""Most characters of a line of output in a sentence."""


@dataclass(frozen=True)
class Command:
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

    def filled(self, words: Mapping[str, str]) -> Command:
        """The command with every word in braces replaced; other braces stay.

        >>> Command(("fly", "--speed={cruise_mps} {x}")).filled({"cruise_mps": "0.5"}).run
        ('fly', '--speed=0.5 {x}')
        """

        def replaced(text: str) -> str:
            for word, value in words.items():
                text = text.replace(f"{{{word}}}", value)
            return text

        return Command(tuple(map(replaced, self.run)), {key: replaced(v) for key, v in self.env.items()}, self.folder)


class FlightFolder:
    """A folder of one flight, which a keeper removes when this process and `Processes` with `lifeline` have ended.

    Args:
        files: that the processes make elsewhere, which are removed with it.

    Attributes:
        path: the folder.
        lifeline: the descriptor whose last end is the end of the folder.
    """

    def __init__(self, files: Sequence[Path] = ()) -> None:
        self.path, self._files = Path(tempfile.mkdtemp(prefix="scaloft-")), files
        command = [sys.executable, "-I", "-S", guard.__file__, str(self.path), *map(str, files)]
        null = subprocess.DEVNULL
        self._keeper = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=null, stderr=null, start_new_session=True
        )
        assert self._keeper.stdin is not None
        self.lifeline = self._keeper.stdin.fileno()

    def close(self) -> None:
        """Remove the folder and the files; may be called twice."""
        rmtree(self.path, ignore_errors=True)
        for file in self._files:  # the keeper does so too, and may have been killed
            with suppress(OSError):
                file.unlink()
        assert self._keeper.stdin is not None
        self._keeper.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            self._keeper.wait(STOP_S)


class Processes:
    """The processes of one flight.

    The process that uses them flies this flight only: orphans that a killed guard leaves are adopted by it, and `stop`
    ends whatever it has below it.

    Args:
        commands: what to start, in order, without a shell.
        study: folder of the study.
        environment: what the border adds to their environment.
        folder: private to the flight; the end of their output is kept there.
        lifeline: of the `FlightFolder` that is kept as long as they run; None without one.

    Attributes:
        how: how the first of them that has ended did so, such as `KILLED`; "" while all run.
    """

    def __init__(
        self,
        commands: Sequence[Command],
        study: Path,
        environment: Mapping[str, str],
        folder: Path,
        lifeline: int | None = None,
    ) -> None:
        self._commands, self._study, self._output = commands, study.absolute(), folder / "output"
        self._environment, self._lifeline = environment, lifeline
        self._guard: subprocess.Popen[bytes] | None = None
        self._news, self._started = b"", False
        self._ended = self.how = ""
        self._spared: frozenset[int] = frozenset()

    def start(self) -> None:
        """Start all of them.

        Raises:
            BorderError: one cannot be started; the sentence names it.  Or their guard has died.
        """
        guard.prctl(guard.PR_SET_CHILD_SUBREAPER, 1)
        self._spared = frozenset(guard.descendants(os.getpid()))
        words = {"python": sys.executable, "study": str(self._study)}
        commands = [
            {
                "run": filled.run,
                "env": {**os.environ, **self._environment, **filled.env},
                "folder": str(self._study / filled.folder),
            }
            for filled in (command.filled(words) for command in self._commands)
        ]
        order = {"commands": commands, "output": str(self._output)}
        self._guard = subprocess.Popen(
            [sys.executable, "-I", "-S", guard.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            pass_fds=() if self._lifeline is None else (self._lifeline,),
        )
        assert self._guard.stdin is not None
        with suppress(OSError):  # the guard has just died; the next lines say so
            self._guard.stdin.write(json.dumps(order).encode() + b"\n")
            self._guard.stdin.flush()
        due_s = time.monotonic() + START_S
        while not self._ended and not self._started and time.monotonic() < due_s:
            self._listen(0.05)
        if not self._started:  # one that has ended since was started, and `ended` says how
            raise BorderError(self._ended or f"the guard of the processes did not start within {START_S:g} s")

    def ended(self, within_s: float = 0.0) -> str:
        """A sentence on the first of them that has ended; "" while all run.

        Args:
            within_s: how long to wait for an end [s, wall].

        Raises:
            BorderError: their guard has died, which is no fault of theirs.
        """
        if not self._ended and self._guard is not None:
            self._listen(within_s)
        return self._ended

    def computing(self) -> bool:
        """Whether one of them computes, or would if it had a processor: it is slow, not silent."""
        return any(map(_computes, self._pids()))

    def computed_s(self) -> float:
        """Processor time of those that run [s], in steps of a hundredth (Linux)."""
        return sum(map(_computed_s, self._pids()))

    def _pids(self) -> set[int]:
        return set() if self._guard is None else guard.descendants(self._guard.pid)

    def _listen(self, wait_s: float) -> None:
        """Read what the guard tells."""
        assert self._guard is not None
        assert self._guard.stdout is not None
        while select.select([self._guard.stdout], [], [], wait_s)[0]:
            text = os.read(self._guard.stdout.fileno(), guard.CHUNK)
            if not text and not self._ended:
                raise BorderError(f"the guard of the processes ended; their last lines: {self.last_lines() or 'none'}")
            if not text:
                return
            self._news += text
            wait_s = 0.0
        *whole, self._news = self._news.split(b"\n")
        for line in whole:
            what, number, detail = line.decode(errors="replace").split(" ", 2)
            self._started |= what == "started"
            if what != "started" and not self._ended:
                self.how = _how(what, detail)
                self._ended = f"{_program(self._commands[int(number)])} {self.how}"

    def last_lines(self, count: int = 5) -> str:
        """The last lines that they wrote, made inert and joined by " / "; "" for none."""
        return " / ".join(inert(line)[:LINE] for line in self.lines()[-count:])

    def lines(self) -> list[str]:
        """The lines at the end of what they wrote, empty ones left out."""
        text = b""
        for path in (self._output.with_name(f"{self._output.name}.old"), self._output):
            with suppress(OSError):
                text += path.read_bytes()
        return [line.strip() for line in text.decode(errors="replace").splitlines() if line.strip()]

    def stop(self) -> None:
        """End them: SIGINT, SIGTERM, SIGKILL in turn, half a second apart; nothing is left.  May be called twice."""
        if self._guard is None:
            return
        ending, self._guard = self._guard, None
        for pipe in filter(None, (ending.stdin, ending.stdout)):
            with suppress(OSError):
                pipe.close()
        try:
            ending.wait(STOP_S)
        except subprocess.TimeoutExpired:
            ending.kill()
            ending.wait()
        guard.kill_below(os.getpid(), self._spared)


def _program(command: Command) -> str:
    """The program of a command: that of an interpreter is its first argument."""
    program, *arguments = command.run
    if program == "{python}" or Path(program).name.startswith("python"):
        program = next((one for one in arguments if not one.startswith("-")), program)
    return inert(Path(program).name)[:LINE]


def _how(what: str, detail: str) -> str:
    """How a process ended.

    >>> _how("ended", "-9"), _how("ended", "3"), _how("failed", "No such file or directory")
    ('was ended by SIGKILL', 'ended with code 3', 'cannot be started: No such file or directory')
    """
    if what == "failed":
        return f"cannot be started: {detail}"
    code = int(detail)
    return f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"


BELOW = {"flight_control": ("velocity", "land"), "planner": ("goal", "speed_limit", "land")}
"""What of our drone flies below the stages outside, and the ports that it takes orders from."""
FRAMES = ("", "world", "body")
_ANY_TEXT = Pattern(".*", "a text")


def _orders() -> dict[str, str]:
    return {below: f"takes {' and '.join(orders)} from outside" for below, orders in BELOW.items()}


Wait = Annotated[float, Bounds(least=1e-3, most=60.0)]


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
    carries: Annotated[str, Choices(lambda: {name: port.meaning for name, port in PORTS.items()}, named="ports")]
    type: str = ""
    frame: Annotated[str, Examples(*FRAMES[1:]), _ANY_TEXT] = ""
    qos: Mapping[str, Scalar] = field(default_factory=dict)
    fields: Mapping[str, str] = field(default_factory=dict)
    awaited: bool = True

    def as_topic(self, seam: str) -> Topic:
        """The topic of the border."""
        port = PORTS[self.carries]
        return Topic(
            seam, self.topic, port.message, port.outward, self.type, self.frame, self.qos, self.fields, self.awaited
        )


def _computes(pid: int) -> bool:
    """Whether a thread of a process runs, or waits for a processor or a disk (Linux)."""
    try:
        stats = [path.read_bytes() for path in Path(f"/proc/{pid}/task").glob("*/stat")]
    except OSError:  # one has ended just now, so that it computed until now
        return True
    return any(stat.rpartition(b")")[2].split()[0] in (b"R", b"D") for stat in stats)


def _computed_s(pid: int) -> float:
    """Processor time of a process [s]; 0 of one that has ended just now (Linux)."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return 0.0
    user, system = stat.rpartition(b")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


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
        answer_s: how long a tick waits for its answer [s, wall]; where flights are deterministic, a tick waits on
            while a process computes, up to `silent_ticks` times so much of its processor time, since a loaded machine
            must not decide what flies.
        ready_s: how long the processes may take to come up [s, wall].
        pace: greatest simulated time per wall time; 0 = as fast as the answers come.
        silent_ticks: ticks in a row without an answer after which the stack outside counts as hung.
        deterministic: whether two flights of the same subject, situation and seed have the same bits.
        version: of the programs outside the study, in words; another one means other flights.
    """

    border: BorderName
    below: Annotated[str, Choices(_orders)]
    processes: tuple[Command, ...]
    seams: Annotated[Mapping[str, SeamConfig], Size(1, MOST, "a seam, at least")]
    inside: Any
    answer: str = ""
    answer_s: Wait = 0.5
    ready_s: Wait = 30.0
    pace: Annotated[float, Bounds(least=0.0, most=1000.0)] = 0.0
    silent_ticks: Annotated[int, Bounds(least=1, most=1000)] = 20
    deterministic: bool = False
    version: str = ""

    def contradictions(self, item: Item) -> Iterator[InputError]:
        """Refuse what does not fit together."""
        seams = item.need("seams")
        for name, seam in self.seams.items():
            yield from self._misfit(seam, seams.need(name))
        orders = BELOW[self.below]
        if orders[0] not in [seam.carries for seam in self.seams.values()]:
            needs = f"needs a seam that carries {orders[0]!r}, because below={self.below!r}"
            yield InputError(f"{seams.place}: {seams.name} {needs}")
        inward = [name for name, seam in self.seams.items() if not PORTS[seam.carries].outward]
        if self.answer and self.answer not in inward:
            place = item.need("answer").place
            yield InputError(f"{place}: answer={self.answer!r} is not known{did_you_mean(self.answer, inward)}")
        elif not self.answer and not self.pace:
            needs = "needs `answer`, the seam that answers each tick, or `pace`, such as 1.0"
            yield InputError(f"{item.place}: {item.name} {needs}")

    def _misfit(self, seam: SeamConfig, item: Item) -> Iterator[InputError]:
        if seam.carries == "velocity" and seam.frame not in FRAMES:
            yield InputError(
                f"{item.need('frame').place}: frame={seam.frame!r} is not known{did_you_mean(seam.frame, FRAMES)}"
            )
        carries = item.need("carries")
        twins = [name for name, other in self.seams.items() if other.carries == seam.carries]
        if not PORTS[seam.carries].outward and seam.carries not in BELOW[self.below]:
            yield carries.error(f"taken by {self.below}, which takes {' and '.join(BELOW[self.below])}")
        elif not PORTS[seam.carries].outward and len(twins) > 1:
            yield InputError(f"{carries.place}: {seam.carries!r} is carried by {' and '.join(twins)}; one is allowed")
        elif misfit := BORDERS[self.border].misfit(seam.as_topic(item.name)):
            yield InputError(f"{item.place}: {item.name}: {misfit}")


ENDS_S = 0.3
"""How long a process that answers no more may take to end, before it counts as hung [s, wall]."""
STARVED = 20
"""A process that computes and is given less than one part in so many of a processor counts as hung."""
CHECK_S = 0.02
"""Time between two looks at whether the processes have come up [s, wall]."""


class OutsideError(RuntimeError):
    """The stages outside ended or answer no more: a fault of the drone."""


@dataclass
class Exchange:
    """Carries samples between a flight and its stages outside.

    A process that ends, or a stack that leaves `silent_ticks` in a row without an answer, raises `OutsideError` at that
    tick.  A message that is refused is dropped, and the first such message is the flight's complaint.

    Attributes:
        config: the settings.
        wire: carries every sample over its seam.
        border, processes: to the other side, and what runs there.
        folder: private to the flight.
        complaint: what was wrong with the first refused message; "" while none was.
    """

    config: OutsideConfig
    wire: Wire
    border: Border
    processes: Processes
    folder: FlightFolder
    complaint: str = ""
    _silent: int = 0
    _began_s: float | None = None

    def __post_init__(self) -> None:
        seams = [(name, seam.carries) for name, seam in self.config.seams.items()]
        self._out = [(name, port) for name, port in seams if PORTS[port].outward and port != "inertial"]
        self._in = [(name, port) for name, port in seams if not PORTS[port].outward]

    @classmethod
    def begin(cls, config: OutsideConfig, wire: Wire, study: Path, words: Mapping[str, str]) -> Exchange:
        """Open the border, start the processes and wait until they have come up.

        Args:
            config: the settings.
            wire: carries the samples.
            study: folder of the study.
            words: what the words in braces in `run` and `env` stand for.

        Raises:
            BorderError: they did not come up.
        """
        topics = [seam.as_topic(name) for name, seam in config.seams.items()]
        commands = [process.filled(words) for process in config.processes]
        with ExitStack() as undo:
            folder = undo.enter_context(closing(FlightFolder()))
            border = BORDERS[config.border](topics, folder.path)
            undo.callback(border.close)
            border.open()
            processes = Processes(commands, study, border.environment, folder.path, folder.lifeline)
            undo.callback(processes.stop)
            processes.start()
            exchange = cls(config, wire, border, processes, folder)
            due_s = time.monotonic() + config.ready_s
            while lacking := border.lacking():
                ended = processes.ended()
                if ended or time.monotonic() > due_s:
                    reason = ended or f"not within {config.ready_s:g} s: {lacking}"
                    raise BorderError(f"the stages outside never came up: {reason}{exchange._said()}")
                time.sleep(CHECK_S)
            undo.pop_all()
        return exchange

    def tick(self, now_s: float, offered: Mapping[str, Any]) -> Mapping[str, Any]:
        """One round: send what is offered, tell the time, wait for the answer, take what came.

        Args:
            now_s: time since the start [s].
            offered: sample by outward port; a port without a sample sends nothing.

        Returns:
            Sample by inward port; None where nothing came.

        Raises:
            OutsideError: the stages outside ended or hang.
            BorderError: the border, or the guard of the processes, has died, or a process was killed with SIGKILL,
                which comes from the machine or a person, never from the drone.
        """
        for name, port in self._out:
            self.send(name, now_s, offered.get(port))
        self.border.clock(now_s)
        self._keep_pace(now_s)
        self._await_answer()
        taken = {}
        for name, port in self._in:
            arrival = self.border.take(name)
            if arrival.refused and not self.complaint:
                self.complaint = f"outside at {now_s:.3f} s: {arrival.refused}{self._said()}"
            taken[port] = self.wire.cross(name, now_s, arrival.sample)
        if ended := self.processes.ended():
            raise (BorderError if self.processes.how == KILLED else OutsideError)(f"{ended}{self._said()}")
        return taken

    def send(self, seam: str, now_s: float, sample: Any) -> None:
        """Carry a sample over an outward seam and send what arrives."""
        delivered = self.wire.cross(seam, now_s, sample)
        if delivered is not None:
            self.border.send(seam, now_s, delivered)

    def _keep_pace(self, now_s: float) -> None:
        """Let simulated time run no faster than the pace; the first tick sets the beginning."""
        if not self.config.pace:
            return
        if self._began_s is None:
            self._began_s = time.monotonic() - now_s / self.config.pace
        left_s = self._began_s + now_s / self.config.pace - time.monotonic()
        if left_s > 0.0:
            time.sleep(left_s)

    def _await_answer(self) -> None:
        if not self.config.answer:
            return
        heard, waits = self.border.wait(self.config.answer, self.config.answer_s), 1
        if not heard and self.config.deterministic:
            heard, waits = self._wait_on()
        self._silent = 0 if heard else self._silent + waits
        if self._silent >= self.config.silent_ticks and not self.processes.ended(within_s=ENDS_S):
            topic = self.config.seams[self.config.answer].topic
            lost, waited = self.border.lacking(), f"{self._silent} ticks in a row"
            waited += f": {lost}" if lost else f", for {self.config.answer_s:g} s each"
            if waits > 1:
                waited = f"{waits * self.config.answer_s:g} s of one tick, in which a process computed"
            before = f"; before that, {self.complaint}" if self.complaint else self._said()
            raise OutsideError(f"no answer on {topic} for {waited}{before}")

    def _wait_on(self) -> tuple[bool, int]:
        """Wait while a process computes; whether an answer came, and as how many ticks the wait counts.

        The limit is of processor time, because a process that is given none is not slow: the machine is.
        """
        limit_s = self.config.silent_ticks * self.config.answer_s
        began_s, computed_s = time.monotonic(), self.processes.computed_s()
        heard, computing = False, True
        while computing and not heard:
            if self.processes.computed_s() - computed_s > limit_s or time.monotonic() - began_s > STARVED * limit_s:
                return False, self.config.silent_ticks
            computing = self.processes.computing()  # before the wait: one that has answered computes no more
            heard = self.border.wait(self.config.answer, self.config.answer_s)
        return heard, 1

    def _said(self) -> str:
        lines = self.processes.last_lines()
        return f"; its last lines: {lines}" if lines else ""

    def close(self) -> None:
        """End the processes and close the border; may be called twice."""
        self.processes.stop()
        self.border.close()
        self.folder.close()
