"""The lists of what the reference study has: nothing is missing, and every formula and example is true."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from scaloft_fi.errors import InputError
from scaloft_fi.judge.bounds import bounds_of, check_caps, ranges_of, verdict
from scaloft_fi.judge.stl import Formula
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.sim.log import SIGNALS, TRUTH_NAMES
from scaloft_fi.study import Study
from scaloft_fi.verbs.axes import axis_list
from scaloft_fi.verbs.listing import Listing, shown
from scaloft_fi.verbs.operators import operator_list, sample_text
from scaloft_fi.verbs.seams import acted_on, seam_list
from scaloft_fi.verbs.signals import BOTH, FACTS, REALISED, TO_ASK, signal_list
from scaloft_fi.views.output import csv_tables
from scaloft_fi.views.table import Format

STUDY = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def study() -> Study:
    return Study.open(STUDY)


@pytest.fixture(scope="module")
def wide() -> Study:
    return Study.open(STUDY, "wide")


@pytest.fixture(scope="module")
def lists(study: Study) -> dict[str, Listing]:
    return {
        "signals": signal_list(study),
        "seams": seam_list(study),
        "operators": operator_list(study),
        "axes": axis_list(study.grid),
    }


def test_every_signal_that_a_formula_may_use_is_listed_and_no_other(wide: Study) -> None:
    by_use: dict[str, list[str]] = {BOTH: [], REALISED: [], TO_ASK: []}
    for record in signal_list(wide).records:
        by_use[record["used_in"]].append(record["name"])
    assert by_use[BOTH] == list(wide.signals)
    assert by_use[REALISED] == [name for name in wide.grid.passing_signals if name not in wide.signals]
    assert by_use[TO_ASK] == [name for name in SIGNALS if name not in wide.grid.world().signals]


def test_every_example_of_a_signal_is_a_formula_within_the_caps(wide: Study) -> None:
    names = {*wide.signals, *wide.grid.passing_signals, *SIGNALS}
    for record in signal_list(wide).records:
        check_caps(record["example"], wide.caps)
        formula = Formula.parse(record["example"], names)
        assert record["name"] in formula.names, record
        assert verdict(bounds_of(formula, ranges_of(wide.grid.world(), wide.stack.beliefs, names))) is None, record


def test_every_signal_of_the_ground_truth_has_facts_and_a_unit_or_none() -> None:
    assert FACTS.keys() >= set(TRUTH_NAMES) - {"clearance_wall_m"}


def test_a_capped_signal_tells_what_it_reads_beyond_and_what_to_compare_it_with(lists: dict[str, Listing]) -> None:
    (sight,) = lists["signals"].chosen(["person_sight_m"]).records
    assert (sight["least"], sight["most"], sight["range"]) == (0.0, 6.0, "0 to 6, or 100")
    assert sight["compare"] == "with at most 6 m"
    (wall,) = lists["signals"].chosen(["clearance_wall_m"]).records
    assert (wall["most"], wall["compare"], wall["origin"]) == (1.0, "with less than 1 m", "ground truth, wall")
    (pixels,) = lists["signals"].chosen(["obstacle_pixels"]).records
    assert pixels["most"] == 64 * 48


def test_the_signals_of_a_grid_s_happenings_name_the_happening(wide: Study) -> None:
    (walked, wind) = signal_list(wide).chosen(["person_y_m", "wind_x_mps"]).records
    assert walked["origin"].startswith("happening miner")
    assert "realised` is false" in walked["unknown"]
    assert wind["unit"] == "m/s"


def test_every_fault_of_the_matrix_stands_at_its_seam_and_its_operator(study: Study, lists: dict[str, Listing]) -> None:
    seams = {record["name"]: record for record in lists["seams"].records}
    operators = {record["name"]: record for record in lists["operators"].records}
    for cell in study.matrix:
        for fault in cell.faults:
            assert cell.name in seams[fault.seam]["cells"]
            assert cell.name in operators[fault.operator]["cells"]
            assert fault.operator in seams[fault.seam]["operators"]
            assert fault.seam in operators[fault.operator]["seams"]


def test_what_a_consumer_acts_on_follows_from_the_declared_effect(study: Study) -> None:
    seams = study.stack.by_name
    assert acted_on(seams["goal"]) == ["reached"]
    assert acted_on(seams["clearing"]) == ["forget"]
    assert acted_on(seams["map"]) == ["points", "inflation"]
    assert acted_on(seams["imu"]) == ["stamp_s", "rate", "force"]
    assert acted_on(seams["proximity"]) == ["sectors", "watched", "bearings", "trigger_m", "touched"]


def test_every_field_of_numbers_has_the_unit_that_its_seam_declares(study: Study, lists: dict[str, Listing]) -> None:
    for record in lists["seams"].records:
        units = study.stack.by_name[record["name"]].number_units
        assert {f["name"]: f["unit"] for f in record["fields"] if f["name"] in units} == dict(units)


def test_the_example_of_an_operator_is_what_its_tap_does(lists: dict[str, Listing]) -> None:
    told = {record["name"]: record["polls"] for record in lists["operators"].records}
    assert told.keys() == OPERATORS.keys()
    for name, operator in OPERATORS.items():
        assert [poll["sent"] for poll in told[name]] == list(map(sample_text, operator.example.before))
        if not callable(operator.example.after):
            assert [poll["arrives"] for poll in told[name]] == list(map(sample_text, operator.example.after)), name


def test_an_argument_has_unit_range_and_default(lists: dict[str, Listing]) -> None:
    (freeze,) = lists["operators"].chosen(["freeze"]).records
    hold, period, phase = freeze["arguments"]
    assert (hold["unit"], hold["range"], hold["required"]) == ("s", "from 0", True)
    assert (period["range"], period["default"]) == ("above 0, up to 1e+06", 20.0)
    assert (phase["least"], phase["most"]) == (0.0, 1e6)
    assert freeze["at_events"]
    assert freeze["package"] == "scaloft-fi"


def test_every_value_of_every_axis_is_listed_with_what_it_sets(wide: Study) -> None:
    records = {record["name"]: record for record in axis_list(wide.grid).records}
    for axis in wide.grid.axes:
        assert [value["name"] for value in records[axis.id]["values"]] == [f"{axis.id}{v.id}" for v in axis.values]
        for value, listed in zip(axis.values, records[axis.id]["values"], strict=True):
            assert {one["path"]: one["value"] for one in listed["set"]} == {
                path: item.plain() for path, item in value.changes.items()
            }
            assert listed["realised"]


def test_a_free_axis_tells_its_range_distribution_and_with_what_it_goes() -> None:
    records = {record["name"]: record for record in axis_list(Study.open(STUDY, "search").grid).records}
    light = records["Li"]
    assert (light["from"], light["to"], light["distribution"]) == (0.05, 1.0, "log-uniform")
    assert light["only_with"] == [{"axis": "D", "values": ["0", "2"]}]
    assert records["Du"]["also"] == [{"path": "world.happenings.dust.active", "value": True}]


@pytest.mark.parametrize("name", ["signals", "seams", "operators", "axes"])
@pytest.mark.parametrize("how", [Format.TABLE, Format.MARKDOWN, Format.LATEX])
def test_every_list_comes_in_every_format(lists: dict[str, Listing], name: str, how: Format) -> None:
    listing = lists[name]
    text = shown(listing, how, whole=False)
    assert all(one in text.replace("\\", "") for one in listing.names)
    if how is Format.TABLE:
        assert max(map(len, text.splitlines())) <= 100
    assert shown(listing.chosen(listing.names[:2]), how, whole=True)


@pytest.mark.parametrize("name", ["signals", "seams", "operators", "axes"])
def test_every_list_is_of_its_declared_form(lists: dict[str, Listing], name: str) -> None:
    listing = lists[name]
    whole = json.loads(listing.form.json(listing.values))
    Draft202012Validator(listing.form.schema).validate(whole)
    rows = list(csv.DictReader(io.StringIO(csv_tables(listing.form, listing.values)[name])))
    assert [row["name"] for row in rows] == [record["name"] for record in whole[name]] == list(listing.names)


def test_a_pattern_shows_what_it_fits_and_a_miss_names_the_nearest(lists: dict[str, Listing]) -> None:
    chosen = lists["signals"].chosen(["clearance_b*", "mode", "mode"])
    assert chosen.names == ("clearance_bar_m", "mode")
    with pytest.raises(InputError, match="no seam 'presson'; did you mean 'person'"):
        lists["seams"].chosen(["presson"])
    with pytest.raises(InputError, match="no operator 'zz"):
        lists["operators"].chosen(["zz*"])
