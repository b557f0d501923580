"""What a plugin does wrong is told with the names of plugin and package, never as an internal error."""

from __future__ import annotations

from pathlib import Path

import pytest
from processes import ROOT, called, install
from studies import edit_in

STACK = """
from dataclasses import replace

from scaloft_fi.api import declare_stack
from scaloft_fi.stack.reference.declaration import REFERENCE

def make(task, wire):
    raise LookupError("no licence")

declare_stack(replace(REFERENCE, name="dear", make=make))
"""
OPERATOR = """
from scaloft_fi.api import Example, messages, operator

@operator("break", example=Example(messages.Stamps, {}, (), ()))
def broken(context):
    '''Break.'''
    return lambda t_s, sample: sample.nothing
"""
SENSOR = """
from scaloft_fi.api import SENSORS, SensorKind, messages

class Blind:
    def __init__(self, config, flight): ...

    def measure(self, moment):
        raise LookupError("no light")

SENSORS.declare("blind", SensorKind(Blind, messages.Fix, required=True))
"""
FORMAT = """
from scaloft_fi.api import export_format

@export_format("broken", "nothing")
def broken(dossier):
    return dossier.nothing
"""
STACK_OF_BAD_OPERATORS = STACK.replace("make=make", "operators=('no_such_module',)")


def _told(tmp_path: Path, study: Path, source: str, *verbs: tuple[str, ...]) -> list[tuple[int, str]]:
    """Exit code and last line of each verb, with one module as the plugin 'odd' of package 'odd-ware'."""
    site = tmp_path / "site"
    install(site, "odd-ware", {"odd": "odd_ware"})
    (site / "odd_ware.py").write_text(source)
    done = called(site, *((*words, "--study", str(study)) for words in verbs), cwd=tmp_path)
    return [(code, said.strip().splitlines()[-1]) for code, said in done]


ODD = "error: plugin 'odd' of package 'odd-ware'"


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("import nowhere", "ModuleNotFoundError: No module named 'nowhere'"),
        ("import sys; sys.exit('no')", "SystemExit: no"),
    ],
)
def test_a_plugin_that_cannot_be_imported_is_named(source: str, why: str, tmp_path: Path, copy: Path):
    sentence = f"{ODD} cannot be loaded: {why}; mend or uninstall it"
    assert _told(tmp_path, copy, source, ("mutants", "--check")) == [(2, sentence)]


@pytest.mark.flight
@pytest.mark.parametrize(("source", "why"), [(STACK, "no licence"), (SENSOR, "no light")])
def test_a_stack_or_a_sensor_that_raises_is_named(source: str, why: str, tmp_path: Path, copy: Path):
    if source == STACK:
        edit_in(copy / "sim" / "stack.yaml", "name: reference", "name: dear")
    told = _told(tmp_path, copy, source, ("replay", "baseline/T0O0W0D0H0/0"))
    assert told == [(70, f"{ODD}: LookupError: {why} (SCALOFT_DEBUG=1 shows where)")]


def test_the_operators_of_a_stack_that_cannot_be_imported_are_named(tmp_path: Path, copy: Path):
    edit_in(copy / "sim" / "stack.yaml", "name: reference", "name: dear")
    ((code, line),) = _told(tmp_path, copy, STACK_OF_BAD_OPERATORS, ("mutants", "--check"))
    assert code == 2
    assert "stack 'dear': its operators in 'no_such_module' cannot be loaded: ModuleNotFoundError" in line


@pytest.mark.flight
@pytest.mark.release
def test_an_operator_that_raises_is_named(tmp_path: Path, copy: Path):
    cells = copy / "hazop" / "matrix" / "clock.yaml"
    cells.write_text(
        cells.read_text().replace("operator: scale\n      arguments: {field: all, factor: 0}", "operator: break")
    )
    here = ("--situation", "T0O0W0D0H0", "--baseline-seeds", "1", "--jobs", "1")
    verbs = (("mutants", "--write"), ("replay", "NO-clock/T0O0W0D0H0/0"), ("run", "--mutant", "NO-clock", *here))
    written, replayed, run = _told(tmp_path, copy, OPERATOR, *verbs)
    tapped = "tap on stamps at 0.000 s: AttributeError: 'Stamps' object has no attribute 'nothing'"
    assert written[0] == 0
    assert replayed == (70, f"{ODD}: {tapped}")
    assert run[0] == 4
    assert f"plugin 'odd' of package 'odd-ware': TapError: {tapped}" in run[1]


def test_an_export_format_that_raises_is_named(folder: Path, tmp_path: Path):
    words = ("export", "--format", "broken", "--campaign", str(folder))
    ((code, line),) = _told(tmp_path, ROOT, FORMAT, words)
    assert code == 70
    assert line.startswith(f"{ODD}: AttributeError: 'Dossier' object has no attribute 'nothing'")
