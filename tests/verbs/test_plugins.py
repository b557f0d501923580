"""What a plugin does wrong is told with the names of plugin and package, never as an internal error."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from plugins import ROOT, call, install

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


@pytest.fixture
def study(tmp_path: Path) -> Path:
    folder = tmp_path / "study"
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def _told(tmp_path: Path, study: Path, source: str, *words: str) -> tuple[int, str]:
    """Exit code and last line of the verb, with one module as the plugin 'odd' of package 'odd-ware'."""
    site = tmp_path / "site"
    install(site, "odd-ware", {"odd": "odd_ware"})
    (site / "odd_ware.py").write_text(source)
    done = call(site, "-m", "scaloft_fi", *words, "--study", study, cwd=tmp_path)
    return done.returncode, done.stderr.strip().splitlines()[-1]


FLOWN = ("run", "--situation", "T0O0W0D0H0", "--baseline-seeds", "1", "--jobs", "1", "--quiet")
ODD = "error: plugin 'odd' of package 'odd-ware'"
IMPORTS = {
    "import nowhere": "ModuleNotFoundError: No module named 'nowhere'",
    "raise RuntimeError('not today')": "RuntimeError: not today",
    "import sys; sys.exit('no')": "SystemExit: no",
    "from scaloft_fi.sim.stacks import STACKS\nSTACKS.declare('reference', None)": (
        "ValueError: stack 'reference' is declared twice"
    ),
}


@pytest.mark.parametrize("source", IMPORTS)
def test_a_plugin_that_cannot_be_imported_is_named(source: str, tmp_path: Path, study: Path) -> None:
    sentence = f"{ODD} cannot be loaded: {IMPORTS[source]}; mend or uninstall it"
    assert _told(tmp_path, study, source, "mutants", "--check") == (2, sentence)


@pytest.mark.flight
def test_a_stack_that_cannot_be_made_is_named(tmp_path: Path, study: Path) -> None:
    settings = study / "sim" / "stack.yaml"
    settings.write_text(settings.read_text().replace("name: reference", "name: dear"))
    code, line = _told(tmp_path, study, STACK, "replay", "baseline/T0O0W0D0H0/0")
    assert (code, line) == (70, f"{ODD}: LookupError: no licence (SCALOFT_DEBUG=1 shows where)")


def test_the_operators_of_a_stack_that_cannot_be_imported_are_named(tmp_path: Path, study: Path) -> None:
    settings = study / "sim" / "stack.yaml"
    settings.write_text(settings.read_text().replace("name: reference", "name: dear"))
    code, line = _told(tmp_path, study, STACK_OF_BAD_OPERATORS, "mutants", "--check")
    assert code == 2
    assert "stack 'dear': its operators in 'no_such_module' cannot be loaded: ModuleNotFoundError" in line


@pytest.mark.flight
def test_a_sensor_that_raises_is_named(tmp_path: Path, study: Path) -> None:
    code, line = _told(tmp_path, study, SENSOR, "replay", "baseline/T0O0W0D0H0/0")
    assert (code, line) == (70, f"{ODD}: LookupError: no light (SCALOFT_DEBUG=1 shows where)")


@pytest.mark.flight
def test_an_operator_that_raises_is_named(tmp_path: Path, study: Path) -> None:
    cells = study / "hazop" / "matrix" / "clock.yaml"
    cells.write_text(
        cells.read_text().replace("operator: scale\n      arguments: {field: all, factor: 0}", "operator: break")
    )
    site = tmp_path / "site"
    install(site, "odd-ware", {"odd": "odd_ware"})
    (site / "odd_ware.py").write_text(OPERATOR)

    def verb(*words: str) -> tuple[int, str]:
        done = call(site, "-m", "scaloft_fi", *words, "--study", study, cwd=tmp_path)
        return done.returncode, done.stdout + done.stderr

    assert verb("mutants", "--write")[0] == 0
    tapped = "TapError: tap on stamps at 0.000 s: AttributeError: 'Stamps' object has no attribute 'nothing'"
    code, told = verb("replay", "NO-clock/T0O0W0D0H0/0")
    assert (code, told.strip().splitlines()[-1]) == (70, f"{ODD}: {tapped.removeprefix('TapError: ')}")
    code, told = verb(
        "run", "--mutant", "NO-clock", "--situation", "T0O0W0D0H0", "--baseline-seeds", "1", "--jobs", "1"
    )
    assert code == 4
    assert f"plugin 'odd' of package 'odd-ware': {tapped}" in told


@pytest.mark.flight
def test_an_export_format_that_raises_is_named(tmp_path: Path, study: Path) -> None:
    assert (
        call(tmp_path, "-m", "scaloft_fi", *FLOWN, "--mutant", "PLACEBO", "--study", study, cwd=tmp_path).returncode
        == 0
    )
    code, line = _told(tmp_path, study, FORMAT, "export", "--format", "broken")
    assert code == 70
    assert line.startswith(f"{ODD}: AttributeError: 'Dossier' object has no attribute 'nothing'")
