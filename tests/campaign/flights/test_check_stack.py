"""`check_stack` says of each defect of a stack, in a sentence, what the framework cannot rely on."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studies import copied
from tiny_stack import SOUND, FastHop, Hop, Level, hop

from scaloft_fi.campaign.flights.check_stack import StackCheck, check_stack
from scaloft_fi.sim.stacks import CLAIMS, STACKS
from scaloft_fi.stack import messages
from scaloft_fi.stack.declaration import TICK_HZ, Claim, Declaration, Instant, Seam, Task, Wire

pytestmark = pytest.mark.flight

Check = Callable[..., StackCheck]


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    def checked(declared: Declaration, settings: str = "mass_kg: 1.5") -> StackCheck:
        study = copied(tmp_path / "study")
        (study / "sim" / "stack.yaml").write_text(f"name: hop\n{settings}\n")
        monkeypatch.setitem(STACKS._entries, "hop", declared)
        return check_stack(study)

    return checked


def test_a_sound_stack_keeps_its_contract(check: Check):
    result = check(SOUND)
    assert result.failures == ()
    assert "it keeps its contract" in str(result)


def test_it_says_what_comes_of_an_error_in_each_method(check: Check):
    said = check(SOUND).observations
    assert [line.split("'")[1] for line in said] == ["stamps", "autopilot", "companion", "step"]
    assert "the drone touched down at 5.4 s" in said[1]


class PolledTwice(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        self.wire.cross("level", now_s, None)


class PolledSeldom(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        if round(now_s * TICK_HZ) % 2 == 0:
            super().autopilot(now_s, frames)


class PolledAtTicks(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        self.wire.cross("gyro", now_s, None)

    def step(self, now_s: float, imu: messages.Imu) -> messages.Thrust | None:
        return self.wire.cross("rotors", now_s, messages.Thrust(self.rotors.copy()))


class UndeclaredSeam(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        self.wire.cross("secret", now_s, Level(now_s, 0.0))


class WrongMessage(Hop):
    def step(self, now_s: float, imu: messages.Imu) -> messages.Thrust | None:
        self.wire.cross("gyro", now_s, Level(now_s, 0.0))
        return self.wire.cross("rotors", now_s, messages.Thrust(self.rotors.copy()))


class WrittenTo(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        kept = self.rotors
        super().autopilot(now_s, frames)
        kept[:] = self.rotors
        self.rotors = kept

    def step(self, now_s: float, imu: messages.Imu) -> messages.Thrust | None:
        self.wire.cross("gyro", now_s, imu)
        return self.wire.cross("rotors", now_s, messages.Thrust(self.rotors))


class LeavesAThread(Hop):
    def __init__(self, task: Task, wire: Wire) -> None:
        super().__init__(task, wire)
        threading.Thread(target=time.sleep, args=(60.0,), daemon=True).start()


class LateBelief(Hop):
    def beliefs(self, now_s: float) -> Any:
        raise ZeroDivisionError("no clock yet")


class ThreeBeliefs(Hop):
    def beliefs(self, now_s: float) -> Any:
        return np.zeros(3)


class NanBelief(Hop):
    def beliefs(self, now_s: float) -> Any:
        return np.array([math.nan, 0.0])


class TooGreatBelief(Hop):
    def beliefs(self, now_s: float) -> Any:
        return np.array([now_s, 2.0])


class RandomThrust(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        self.rotors = self.rotors * (1.0 + 1e-3 * np.random.default_rng().random())


class RandomBelief(Hop):
    def beliefs(self, now_s: float) -> Any:
        return np.array([now_s, np.random.default_rng().random()])


class KeepsState(Hop):
    flights = 0

    def __init__(self, task: Any, wire: Any) -> None:
        super().__init__(task, wire)
        KeepsState.flights += 1
        self.mass_kg *= 1.0 + 1e-3 * KeepsState.flights


class AsksTheWire(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        if self.wire.listens("level"):
            self.rotors = self.rotors * 1.001


class OtherBits(Hop):
    def __init__(self, task: Any, wire: Any) -> None:
        super().__init__(task, wire)
        self.fast_path = FastHop(self, 1.0 + 1e-12)


class SameBits(Hop):
    def __init__(self, task: Any, wire: Any) -> None:
        super().__init__(task, wire)
        self.fast_path = FastHop(self, 1.0)


class RaisesAtTakeOff(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        raise KeyError("no bus")


class RaisesWhenMade(Hop):
    def __init__(self, task: Any, wire: Any) -> None:
        raise OSError("no licence")


class ThreeRotors(Hop):
    def step(self, now_s: float, imu: messages.Imu) -> messages.Thrust | None:
        self.wire.cross("gyro", now_s, imu)
        return self.wire.cross("rotors", now_s, messages.Thrust(self.rotors[:3].copy()))


class Standing(Hop):
    def autopilot(self, now_s: float, frames: Any) -> None:
        super().autopilot(now_s, frames)
        self.rotors = np.zeros(4)


SPARE = Seam("spare", Level, TICK_HZ, "nobody -> nobody")
DEFECTS: dict[str, tuple[Declaration, str]] = {
    "a seam is never polled": (
        replace(SOUND, seams=(*SOUND.seams, SPARE)),
        "seam 'spare' is declared, but never polled",
    ),
    "a seam is polled twice": (hop(PolledTwice), "seam 'level' is polled twice for the time 0 s"),
    "a seam is polled at every second tick": (hop(PolledSeldom), "seam 'level' declares rate_hz=20, but is polled 10"),
    "a seam of every step is polled at ticks": (
        hop(PolledAtTicks),
        "seam 'gyro' declares rate_hz=240, but is polled 20",
    ),
    "a seam is not declared": (hop(UndeclaredSeam), "seam 'secret' is used, but not declared"),
    "a seam carries another message": (hop(WrongMessage), "seam 'gyro' declares the message Imu, but carries Level"),
    "a sample is written to after it was sent": (
        hop(WrittenTo),
        "a sample of seam 'rotors' is written to after it was sent; send a new one",
    ),
    "a thread outlives the flight": (hop(LeavesAThread), "the stack leaves threads behind"),
    "a belief raises": (hop(LateBelief), "beliefs: ZeroDivisionError: no clock yet"),
    "there is a belief too many": (hop(ThreeBeliefs), "declares 2 beliefs, but `beliefs` returns shape (3,)"),
    "a belief is NaN": (hop(NanBelief), "belief 'clock_s' is NaN, but declares no value for unknown"),
    "a belief is greater than declared": (hop(TooGreatBelief), "belief 'doubt' reaches 2, but declares most=1"),
    "it draws random numbers": (hop(RandomThrust), "two flights of the baseline differ; draw no random numbers"),
    "it believes at random": (hop(RandomBelief), "are alike, but the stack's beliefs differ"),
    "it keeps state between flights": (hop(KeepsState), "keep no state between flights"),
    "it asks whether the wire listens": (hop(AsksTheWire), "the identity on every seam changes the flight"),
    "its fast path has other bits": (hop(OtherBits), "a fast path must have the bits of `step`"),
    "it raises at take-off": (
        hop(RaisesAtTakeOff),
        "the stack raises in a baseline flight: autopilot at 0.000 s: KeyError: 'no bus'",
    ),
    "it cannot be made": (hop(RaisesWhenMade), "the first baseline flight cannot be flown: OSError: no licence"),
    "it has three rotors": (hop(ThreeRotors), "`step` returns the thrust of rotors of shape (3,), which must be (4,)"),
    "it never takes off": (hop(Standing), "the drone never leaves the ground in the baseline flight"),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_defect_is_named(defect: str, check: Check):
    declared, sentence = DEFECTS[defect]
    result = check(declared)
    assert any(sentence in failure for failure in result.failures), result


def test_a_fast_path_with_the_bits_of_the_step_is_sound(check: Check):
    assert check(hop(SameBits)).failures == ()


def test_settings_that_do_not_fit_are_named_with_their_place(check: Check):
    (failure,) = check(SOUND, settings="mass_kg: heavy").failures
    assert "stack.yaml:2: mass_kg='heavy' must be a number" in failure


def test_a_stack_that_declares_no_determinism_may_draw_random_numbers(check: Check):
    assert check(hop(RandomThrust, deterministic=False)).failures == ()


def _beyond(now: Instant) -> float:
    raise IndexError("the log ends")


@pytest.mark.parametrize(
    ("claim", "sentence"),
    [
        (Claim("height", "m", 0.1, lambda _: math.nan), "claim 'height' has the error nan at the end of a flight"),
        (Claim("height", "m", 0.1, _beyond), "claim 'height' raises at the end of a flight: IndexError: the log ends"),
        (Claim("height", "m", 0.1, lambda _: 0.0, seam="lvel"), "stack 'hop': claim 'height': seam 'lvel' does not"),
    ],
)
def test_a_claim_that_cannot_be_asked_is_told(
    check: Check, monkeypatch: pytest.MonkeyPatch, claim: Claim, sentence: str
):
    monkeypatch.setitem(CLAIMS._entries, "hop", (claim,))
    (failure,) = check(SOUND).failures
    assert failure.startswith(sentence)
