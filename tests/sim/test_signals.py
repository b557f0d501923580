from __future__ import annotations

from scaloft_fi.sim.log import Side, belief_signals, signal_names, truth_signals
from scaloft_fi.stack.reference.messages import BELIEFS


def test_names_are_unique_and_carry_their_unit(config):
    signals = truth_signals(config.world.surfaces)
    names = signal_names(config.world.surfaces, BELIEFS)
    assert len(set(names)) == len(names)
    suffixes = {"s": "_s", "m": "_m", "m/s": "_mps", "rad": "_rad"}
    for signal in signals:
        assert signal.meaning
        assert not signal.unit or signal.name.endswith(suffixes[signal.unit])


def test_truth_and_belief_are_kept_apart(config):
    truth, beliefs = truth_signals(config.world.surfaces), belief_signals(BELIEFS)
    assert not {signal.name for signal in truth} & {signal.name for signal in beliefs}
    assert {signal.side for signal in truth} == {Side.TRUTH}
    assert {signal.side for signal in beliefs} == {Side.PERCEIVED}


def test_every_surface_has_a_clearance(config):
    names = [signal.name for signal in truth_signals(config.world.surfaces)]
    assert names[-5:] == [f"clearance_{name}_m" for name in ("wall", "ground", "bar", "obstacle", "person")]
