from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from experiments import random_faults as experiment
from experiments.pages import registered
from experiments.random_draw import DECADES, GUIDEWORD, PACKAGES, TIMES, Draw, fields
from experiments.random_faults import FAULTS
from scaloft_fi.hazop.name import parse
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import ALL
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.stack.messages import field_type, number_fields, vector_fields
from scaloft_fi.streams import generator
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(ROOT)


@pytest.fixture(scope="module")
def draw(study: Study) -> Draw:
    return Draw.of(study)


@pytest.fixture(scope="module")
def many(draw: Draw) -> tuple[Mutant, ...]:
    return draw.faults(2000)


def test_the_committed_faults_are_what_the_draw_gives(study: Study) -> None:
    assert experiment.FILE.read_text(encoding="utf-8") == experiment.text_of(experiment.drawn(study))
    assert experiment.read_faults() == experiment.drawn(study)


def test_there_are_as_many_as_default_mutants(study: Study) -> None:
    assert len(experiment.read_faults()) == FAULTS == len(study.roster.defaults)


def test_no_fault_is_drawn_twice(many: tuple[Mutant, ...]) -> None:
    assert len({(f.seam, f.operator, *sorted(f.arguments.items())) for f in many}) == len(many)


def test_no_id_is_one_of_the_matrix(study: Study) -> None:
    assert GUIDEWORD not in {cell.guideword for cell in study.matrix}
    ids = [fault.id for fault in experiment.read_faults()]
    assert len(set(ids)) == len(ids)
    assert all(str(parse(id_)) == id_ and parse(id_).guideword == GUIDEWORD for id_ in ids)


def test_a_longer_draw_begins_with_the_shorter_one(draw: Draw, many: tuple[Mutant, ...]) -> None:
    assert draw.faults(FAULTS) == many[:FAULTS]


def test_each_seam_is_drawn_as_often_as_another(draw: Draw) -> None:
    seams = draw.stack.seams
    drawn = Counter(draw.fault(1, generator("test", number)).seam for number in range(1000 * len(seams)))
    assert set(drawn) == {seam.name for seam in seams}
    assert all(abs(number - 1000) < 6 * math.sqrt(1000) for number in drawn.values())


def test_each_operator_but_the_identity_fits_a_seam(draw: Draw) -> None:
    fitting = {operator.name for operators in draw.fitting.values() for operator in operators}
    own = {name for name, operator in OPERATORS.items() if operator.make.__module__.startswith(PACKAGES)}
    assert fitting == own - {"identity"}


def test_the_largest_magnitudes_are_those_of_the_plan(draw: Draw) -> None:
    told = {f"{float(f'{most:.3g}'):g} {unit}" for unit, most in draw.quantities.items() if unit}
    (line,) = re.findall(r"declare \(`quantities`\):\n +(.*);", registered("random_faults"))
    assert set(line.split(", ")) == told
    assert draw.quantities[""] == 1.0


def test_magnitudes_of_a_bias_spread_over_three_decades_of_both_signs(draw: Draw) -> None:
    seam, operator = draw.stack.by_name["velcmd"], OPERATORS["bias"]
    rng, top = generator("test", "bias"), draw.quantities["m/s"]
    drawn = [draw.arguments(seam, operator, rng) for _ in range(6000)]
    found = np.array([a["amount"] for a in drawn if a["field"] == "velocity"], float)
    decades = np.log10(np.abs(found) / top)
    assert decades.min() == pytest.approx(-DECADES, abs=0.01)
    assert decades.max() == pytest.approx(0.0, abs=0.01)
    assert np.quantile(decades, (0.25, 0.5, 0.75)) == pytest.approx([-2.25, -1.5, -0.75], abs=0.15)
    assert np.mean(found > 0) == pytest.approx(0.5, abs=0.05)


def test_a_share_is_uniform_and_a_factor_as_often_below_one_as_above(draw: Draw) -> None:
    rng, depth = generator("test", "share"), draw.stack.by_name["depth"]
    shares = [float(draw.arguments(depth, OPERATORS["drop"], rng)["share"]) for _ in range(2000)]
    assert np.quantile(shares, (0.1, 0.5, 0.9)) == pytest.approx([0.1, 0.5, 0.9], abs=0.05)
    factors = [float(draw.arguments(depth, OPERATORS["scale"], rng)["factor"]) for _ in range(2000)]
    assert np.mean(np.array(factors) > 1.0) == pytest.approx(0.5, abs=0.05)
    assert 1e-3 <= min(factors) < max(factors) <= 1e3


def test_every_fault_begins_within_the_shortest_mission(draw: Draw, many: tuple[Mutant, ...]) -> None:
    timed = [f.arguments for f in many if set(TIMES) & set(f.arguments)]
    assert timed
    for arguments in timed:
        first_s = arguments.get("at_s", arguments.get("period_s", 0.0)) + arguments.get("phase_s", 0.0)
        assert 0.0 < first_s <= draw.shortest_s * 1.001


def test_a_number_for_a_field_is_in_the_unit_of_that_field(draw: Draw, many: tuple[Mutant, ...]) -> None:
    checked = 0
    for fault in many:
        name = next((n for n in ("amount", "sigma") if n in fault.arguments), "")
        if not name:
            continue
        seam, field = draw.stack.by_name[fault.seam], str(fault.arguments["field"])
        units = {seam.unit(one) for one in (number_fields(seam.message) if field == ALL else (field,))}
        top = draw.quantities[units.pop()]
        assert not units
        assert top * 0.999e-3 <= abs(float(fault.arguments[name])) <= top * 1.001
        checked += 1
    assert checked > 100


def test_a_component_is_named_only_of_a_vector_and_only_angles_are_turned(draw: Draw, many: tuple[Mutant, ...]) -> None:
    for fault in many:
        seam, field = draw.stack.by_name[fault.seam], str(fault.arguments.get("field", ""))
        if field and fault.arguments.get("component"):
            assert field in vector_fields(seam.message)
        if fault.operator == "turn":
            assert seam.unit(field) == "rad"
        if fault.operator == "set" and field != ALL:
            assert field_type(seam.message, field) in (float, int, bool)


def test_one_number_for_all_fields_needs_one_unit(draw: Draw) -> None:
    assert ALL in fields(draw.stack.by_name["stamps"], OPERATORS["bias"])
    assert ALL not in fields(draw.stack.by_name["fix"], OPERATORS["bias"])
    assert ALL in fields(draw.stack.by_name["fix"], OPERATORS["scale"])
    assert ALL in fields(draw.stack.by_name["stamps"], OPERATORS["set"])


def test_a_tap_can_be_made_of_every_fault(study: Study, many: tuple[Mutant, ...]) -> None:
    from scaloft_fi.campaign.flights.fly import facts

    scenario = study.scenario(study.grid.situations[0])
    known = facts(scenario, study.sim.stack.parameters)
    for fault in many:
        wire = wire_for(fault, study.stack, contexts(fault.id, scenario.key, 0, known))
        assert wire.listens(fault.seam)
        assert Mutant.from_json(fault.to_json()) == fault
