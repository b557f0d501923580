from __future__ import annotations

from scaloft_fi.sim.signals import PERCEIVED_NAMES, TRUTH_NAMES, Side, signal_names, truth_signals
from scaloft_fi.stack.reference.stack import BELIEFS


def test_names_are_unique_and_carry_their_unit(config):
    signals = truth_signals(config.world.surfaces)
    names = signal_names(config.world.surfaces)
    assert len(set(names)) == len(names)
    suffixes = {"s": "_s", "m": "_m", "m/s": "_mps", "rad": "_rad"}
    for signal in signals:
        assert signal.meaning
        assert not signal.unit or signal.name.endswith(suffixes[signal.unit])


def test_truth_and_belief_are_kept_apart(config):
    assert not set(TRUTH_NAMES) & set(PERCEIVED_NAMES)
    assert all(signal.side is Side.TRUTH for signal in truth_signals(config.world.surfaces))


def test_perceived_signals_are_what_the_stack_tells():
    assert sorted(PERCEIVED_NAMES) == sorted(BELIEFS)


def test_every_surface_has_a_clearance(config):
    names = [signal.name for signal in truth_signals(config.world.surfaces)]
    assert names[-5:] == [f"clearance_{name}_m" for name in ("wall", "ground", "bar", "obstacle", "person")]
