"""Holds a stack to its contract: flies it a few times and says in sentences what the framework cannot rely on."""

from __future__ import annotations

import copy
import math
import threading
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from scaloft_fi.aside import answers_apart, foreign
from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.registry import in_one_line
from scaloft_fi.sim.stacks import claims_of
from scaloft_fi.stack.declaration import TICK_HZ, Declaration, Instant, PlainWire, Seam, Stack, Wire
from scaloft_fi.stack.messages import Imu, Thrust
from scaloft_fi.study import Study

if TYPE_CHECKING:
    from scaloft_fi.setup import Setup
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.situation import Situation


S = TypeVar("S")

LEAST_POLLS = 0.9
"""A seam is polled at its rate if it is polled at this share of its ticks or steps; a stack may begin late."""


@dataclass
class _Polls:
    """What was seen on one seam."""

    seam: Seam
    count: int = 0
    carried: int = 0
    last_s: float = -math.inf
    twice_s: float | None = None
    wrong: str = ""
    written: bool = False
    kept: Any = None
    copied: Any = None


class InspectingWire:
    """Carries every sample as it is, listens on every seam, and watches each poll."""

    def __init__(self, declared: Declaration) -> None:
        self._polls = {seam.name: _Polls(seam) for seam in declared.seams}
        self._strange: dict[str, None] = {}

    def listens(self, seam: str) -> bool:
        """Everywhere."""
        return True

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        polls = self._polls.get(seam)
        if polls is None:
            self._strange[seam] = None
            return sample
        if t_s <= polls.last_s and polls.twice_s is None:
            polls.twice_s = t_s
        polls.count, polls.last_s = polls.count + 1, t_s
        polls.carried += sample is not None
        if polls.kept is not None and polls.seam.differ(polls.kept, polls.copied):
            polls.written = True
        polls.kept, polls.copied = sample, copy.deepcopy(sample)
        if sample is not None and not isinstance(sample, polls.seam.message):
            polls.wrong = type(sample).__name__
        return sample

    @property
    def silent(self) -> tuple[str, ...]:
        """The seams that are polled and carried no sample."""
        return tuple(name for name, polls in self._polls.items() if polls.count and not polls.carried)

    @property
    def polled(self) -> int:
        """Number of declared seams that are polled."""
        return sum(polls.count > 0 for polls in self._polls.values())

    def complaints(self, duration_s: float) -> list[str]:
        """A sentence for each thing that is not as declared."""
        sentences = [f"seam {name!r} is used, but not declared" for name in self._strange]
        for name, polls in self._polls.items():
            due = duration_s * polls.seam.rate_hz
            if not polls.count:
                sentences.append(f"seam {name!r} is declared, but never polled")
            elif polls.twice_s is not None:
                sentences.append(f"seam {name!r} is polled twice for the time {polls.twice_s:g} s")
            elif polls.count < LEAST_POLLS * due - 1.0 or polls.count > due + polls.seam.rate_hz / TICK_HZ + 1.0:
                rate_hz = polls.count / duration_s
                sentences.append(
                    f"seam {name!r} declares rate_hz={polls.seam.rate_hz:g}, but is polled {rate_hz:.3g} times a second"
                )
            if polls.wrong:
                sentences.append(
                    f"seam {name!r} declares the message {polls.seam.message.__name__}, but carries {polls.wrong}"
                )
            if polls.written:
                sentences.append(f"a sample of seam {name!r} is written to after it was sent; send a new one")
        return sentences


METHODS = ("stamps", "autopilot", "companion", "step")
"""What a stack may raise in without ending the flight."""
RAISES_AT_S = 5.0
"""When a method is made to raise [s]."""


@dataclass(frozen=True)
class StackCheck:
    """What `check_stack` found.

    Attributes:
        stack: name of the stack.
        situation, seed: which flight was flown.
        failures: a sentence for each thing that the framework cannot rely on; empty for a sound stack.
        observations: what is no failure, but good to know: what an error in each method leads to.
    """

    stack: str
    situation: str
    seed: int
    failures: tuple[str, ...]
    observations: tuple[str, ...] = ()

    def __str__(self) -> str:
        head = f"stack {self.stack!r} in {self.situation}, seed {self.seed}: "
        verdict = "it keeps its contract" if not self.failures else f"{len(self.failures)} failures"
        return "\n".join([head + verdict, *(f"- {line}" for line in (*self.failures, *self.observations))])


def check_stack(study: Path | str | None = None, *, situation: str = "", seed: int = 0) -> StackCheck:
    """Fly the stack of a study and hold it against its declaration.

    Two flights of the baseline must be alike, as far as the stack declares itself deterministic; a third, with the
    identity on every seam, must be like them, and every poll of it is watched.  Where all of that holds, one more
    flight for each method tells what the drone does once the method raises.

    Args:
        study: folder of the study whose `sim/stack.yaml` names the stack; as for `Study.open`.
        situation: key; the grid's first one when empty.
        seed: of the noise.

    Raises:
        InputError: the study cannot be opened, has no such situation, or is flown by a command.
    """
    opened = Study.open(study)
    if opened.command is not None:
        raise InputError(f"{opened.folder}: a command flies this study (sim/flyer.yaml), so its stack is not called")
    chosen = opened.grid.situation(situation) if situation else opened.grid.situations[0]
    return _Inspection(opened, chosen, seed).result()


@dataclass(frozen=True)
class SeenPolls:
    """What one baseline flight shows of the seams.

    Attributes:
        failures: a sentence for each thing that is not as declared.
        silent: the seams that are polled and carried no sample.
        polled: number of declared seams that are polled.
        duration_s: length of the flight [s].
    """

    failures: tuple[str, ...]
    silent: tuple[str, ...] = ()
    polled: int = 0
    duration_s: float = 0.0


def polls_of(setup: Setup, situation: Situation) -> SeenPolls:
    """Fly the baseline once, with the identity on every seam, and watch every poll."""
    inspection, watching = _Inspection(setup, situation, 0), InspectingWire(setup.stack)
    log = inspection.flown(watching, guarded(setup.stack), "a baseline flight")
    if log is None or not inspection.takes_off(log):
        return SeenPolls(tuple(inspection.failures))
    failures = watching.complaints(log.duration_s)
    return SeenPolls(tuple(failures), watching.silent, watching.polled, log.duration_s)


def guarded(declared: Declaration) -> Declaration:
    """The declaration of a stack whose orders to the rotors are looked at."""
    return replace(declared, make=lambda task, wire: _Guarded(declared.make(task, wire)))


@dataclass
class _Inspection:
    setup: Setup
    situation: Situation
    seed: int
    failures: list[str] = field(default_factory=list)
    observations: list[str] = field(default_factory=list)

    def result(self) -> StackCheck:
        """Fly, and say what came of it."""
        declared = guarded(self.setup.stack)
        first = self.flown(PlainWire(), declared, "the first baseline flight")
        if first is not None and self.takes_off(first):
            self._check_beliefs(declared, first)
            self._check_claims(declared, first)
            self._check_second(declared, first)
            self._check_polls(declared, first)
        for method in METHODS if not self.failures else ():
            self._check_raising(declared, method)
        return StackCheck(declared.name, self.situation.key, self.seed, tuple(self.failures), tuple(self.observations))

    @answers_apart()
    def flown(self, wire: Wire, declared: Declaration, flight: str) -> FlightLog | None:
        """The log of one flight; None, with a failure, where it cannot be flown."""
        from scaloft_fi.sim.flight import fly

        try:
            return fly(self.setup.sim, self.situation, self.seed, wire, declared)
        except ScaloftError as error:
            self.failures.append(f"{flight} cannot be flown: {error}")
        except foreign() as error:  # whatever the stack raises is what is asked for
            self.failures.append(f"{flight} cannot be flown: {in_one_line(error)}")
        return None

    def takes_off(self, first: FlightLog) -> bool:
        """Whether the drone leaves the ground and its stack raises nothing; else no other flight is worth its time."""
        before = len(self.failures)
        if first.stack_error:
            self.failures.append(f"the stack raises in a baseline flight: {first.stack_error}")
        if first.duration_s < 1.0 or max(first.signals["z_m"]) < first.signals["z_m"][0] + 0.3:
            self.failures.append("the drone never leaves the ground in the baseline flight")
        return len(self.failures) == before

    def _check_beliefs(self, declared: Declaration, first: FlightLog) -> None:
        for belief in declared.beliefs:
            values = first.signals[belief.name]
            if max(values) > belief.most:
                self.failures.append(
                    f"belief {belief.name!r} reaches {max(values):g}, but declares most={belief.most:g}"
                )
            if math.isnan(belief.unknown) and any(map(math.isnan, values.tolist())):
                self.failures.append(f"belief {belief.name!r} is NaN, but declares no value for unknown")

    def _check_claims(self, declared: Declaration, first: FlightLog) -> None:
        try:
            claims = claims_of(declared, first.signals)
        except ScaloftError as error:
            self.failures.append(str(error))
            return
        x_m, y_m, z_m = (float(first.signals[name][-1]) for name in ("x_m", "y_m", "z_m"))
        for claim in claims:
            try:
                off = float(claim.error(Instant(first.signals, None, (x_m, y_m, z_m), "")))
            except Exception as problem:  # noqa: BLE001 - whatever the claim raises is what is asked for
                self.failures.append(f"claim {claim.stage!r} raises at the end of a flight: {in_one_line(problem)}")
                continue
            if not math.isfinite(off):
                self.failures.append(f"claim {claim.stage!r} has the error {off} at the end of a flight")

    def _check_second(self, declared: Declaration, first: FlightLog) -> None:
        if not declared.deterministic:
            return
        before = threading.active_count()
        second = self.flown(PlainWire(), declared, "the second baseline flight")
        if threading.active_count() > before:
            self.failures.append("the stack leaves threads behind; a fork, which flies mutants, would lose them")
        if second is None:
            return
        if second.digest != first.digest:
            self.failures.append(
                "two flights of the baseline differ; draw no random numbers, read no clock, keep no state between"
                " flights, or declare deterministic=False"
            )
        elif second.perceived_digest != first.perceived_digest:
            self.failures.append("two flights of the baseline are alike, but the stack's beliefs differ")

    def _check_polls(self, declared: Declaration, first: FlightLog) -> None:
        watching = InspectingWire(declared)
        log = self.flown(watching, declared, "the flight with the identity on every seam")
        if log is None:
            return
        self.failures += watching.complaints(log.duration_s)
        if declared.deterministic and log.digest != first.digest:
            self.failures.append(
                "the identity on every seam changes the flight; the stack must not ask whether the wire listens,"
                " and a fast path must have the bits of `step`"
            )

    def _check_raising(self, declared: Declaration, method: str) -> None:
        broken = replace(declared, make=lambda task, wire: _Raising(declared.make(task, wire), method))
        log = self.flown(PlainWire(), broken, f"a flight in which {method!r} raises")
        if log is not None:
            end = f"{log.ending.sentence} at {log.duration_s:.1f} s"
            self.observations.append(f"when {method!r} raises at {RAISES_AT_S:g} s, the drone {end}")


class _Guarded:
    """A stack whose every order to the rotors is looked at before the compiled physics reads it."""

    def __init__(self, stack: Stack) -> None:
        self._stack = stack

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stack, name)

    def step(self, now_s: float, imu: Imu) -> Thrust | None:
        """The stack's order.

        Raises:
            StackError: it is no `Thrust` of four finite numbers.
        """
        from scaloft_fi.sim.flight import StackError

        thrust = self._stack.step(now_s, imu)
        if thrust is None:
            return None
        if not isinstance(thrust, Thrust):
            raise StackError(f"`step` returns {type(thrust).__name__}, which must be Thrust or None")
        if np.shape(thrust.rotors) != (4,):
            raise StackError(
                f"`step` returns the thrust of rotors of shape {np.shape(thrust.rotors)}, which must be (4,)"
            )
        if not np.isfinite(thrust.rotors).all():
            raise StackError(f"`step` returns a thrust that is no number at {now_s:.3f} s")
        return thrust


class _Raising:
    """A stack of which one method raises from a time on; without the fast path, which would not call it."""

    fast_path = None

    def __init__(self, stack: Stack, method: str) -> None:
        self._stack, self._method = stack, method

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._stack, name)
        if name != self._method:
            return attribute

        def raising(now_s: float, *arguments: Any) -> Any:
            if now_s >= RAISES_AT_S:
                raise RuntimeError("raised by check_stack")
            return attribute(now_s, *arguments)

        return raising
