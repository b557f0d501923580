"""The wire of a mutated stack."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.catalogue import defaults, expected_of, realise
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.mutants.operator import Facts
from scaloft_fi.mutants.wire import SeamCount, TapError, TappedWire, contexts, wire_for
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import Target

CONTEXT = contexts("PLACEBO", "T0O0W0D0H0", 0, Facts())


def test_the_baseline_flies_on_a_plain_wire() -> None:
    assert isinstance(wire_for(None, REFERENCE, CONTEXT), PlainWire)


def test_placebo_passes_every_sample_of_every_seam_through_a_tap_and_alters_none(stream: Any) -> None:
    wire = wire_for(PLACEBO, REFERENCE, CONTEXT)
    assert isinstance(wire, TappedWire)
    for seam in REFERENCE.by_name:
        for t_s, sample in stream(seam):
            assert wire.cross(seam, t_s, sample) is sample
    assert set(wire.counts) == set(REFERENCE.by_name)
    assert set(wire.counts.values()) == {SeamCount(carried=30, altered=0, first_altered_s=None)}


def test_only_the_tapped_seam_is_altered_and_counted(matrix: Matrix, stream: Any) -> None:
    wire = wire_for(realise(matrix, "LATE-human@0.5s"), REFERENCE, CONTEXT)
    assert isinstance(wire, TappedWire)
    for t_s, sample in stream("depth"):
        assert wire.cross("depth", t_s, sample) is sample
    sent = 0
    for t_s, sample in stream("person"):
        wire.cross("person", t_s, sample)
        sent += sample is not None
    assert wire.counts["person"].altered > 0
    assert wire.counts["person"].first_altered_s == 0.0
    assert wire.counts["person"].carried >= sent
    assert set(wire.counts) == {"person"}


def test_a_sample_made_from_nothing_was_carried_and_is_altered(matrix: Matrix) -> None:
    wire = wire_for(realise(matrix, "UNINTENDED-human@5s"), REFERENCE, CONTEXT)
    assert isinstance(wire, TappedWire)
    for k in range(20 * 6):
        wire.cross("person", k / 20, None)
    assert wire.counts["person"] == SeamCount(carried=20, altered=20, first_altered_s=5.0)


def test_a_failing_tap_is_a_matter_of_the_harness() -> None:
    def broken(_t_s: float, _sample: Any) -> Any:
        raise ZeroDivisionError("tap")

    wire = TappedWire([(REFERENCE.by_name["target"], broken)])
    with pytest.raises(TapError, match=r"tap on target at 0\.050 s: ZeroDivisionError: tap"):
        wire.cross("target", 0.05, Target(0, (0.0, 0.0, 0.0)))


def test_randomness_depends_on_mutant_situation_and_seed_only() -> None:
    def draws(mutant_id: str, situation: str, seed: int) -> list[float]:
        return list(contexts(mutant_id, situation, seed, Facts())(REFERENCE.by_name["depth"]).rng.random(3))

    reference = draws("NO-depth@50%", "T0O0W0D0H0", 0)
    assert draws("NO-depth@50%", "T0O0W0D0H0", 0) == reference
    assert draws("NO-depth@25%", "T0O0W0D0H0", 0) != reference
    assert draws("NO-depth@50%", "T1O0W0D0H0", 0) != reference
    assert draws("NO-depth@50%", "T0O0W0D0H0", 1) != reference


def test_a_wire_copied_in_flight_counts_for_itself(matrix: Matrix, stream: Any) -> None:
    wire = wire_for(realise(matrix, "NO-depth@50%"), REFERENCE, contexts("NO-depth@50%", "T0O0W0D0H0", 0, Facts()))
    polls = stream("depth")
    for t_s, sample in polls[:20]:
        wire.cross("depth", t_s, sample)
    branch = copy.deepcopy(wire)
    rest = [branch.cross("depth", t_s, sample) is None for t_s, sample in polls[20:]]
    assert rest == [wire.cross("depth", t_s, sample) is None for t_s, sample in polls[20:]]
    assert np.any(rest)


def test_every_default_alters_what_its_seam_carries_unless_the_matrix_says_otherwise(
    matrix: Matrix, sample_of: Any
) -> None:
    facts = Facts(sighting_s=12.0, settings={"memory": {"voxel_m": 0.15}})
    silent = []
    for mutant in defaults(matrix):
        wire = wire_for(mutant, REFERENCE, contexts(mutant.id, "T0O0W0D0H0", 0, facts))
        assert isinstance(wire, TappedWire)
        rate_hz = REFERENCE.by_name[mutant.seam].rate_hz
        for k in range(int(21 * rate_hz)):
            # one sample in three polls, and a long silence after a reduction of the speed limit
            sent = k % 3 == 0 and not 4.4 < k / rate_hz < 8.0
            sample = sample_of(mutant.seam, k % 16) if sent else None
            wire.cross(mutant.seam, k / rate_hz, sample)
        if not wire.counts[mutant.seam].altered and expected_of(matrix, mutant) is None:
            silent.append(mutant.id)
    assert silent == []
