from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path

import pytest
from options import cases
from processes import install

from scaloft_fi.errors import DeclaredError, InputError
from scaloft_fi.registry import Registry, load_plugins, plugin_behind


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for installed packages; what is imported from it is forgotten afterwards."""
    monkeypatch.syspath_prepend(tmp_path)
    known = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - known:
        del sys.modules[name]


def test_a_name_is_declared_once_whether_it_stands_there_or_is_promised():
    colours = Registry[int]("colour")
    colours.declare("red", 1)
    colours.promise("blue", "math:pi")
    for name in ("red", "blue"):
        with pytest.raises(ValueError, match=f"colour '{name}' is declared twice"):
            colours.declare(name, 2)
        with pytest.raises(ValueError, match=f"colour '{name}' is declared twice"):
            colours.promise(name, "math:e")
    assert dict(colours) == {"red": 1, "blue": pytest.approx(3.14159, abs=1e-5)}


def test_a_promised_entry_is_imported_when_it_is_asked_for(site: Path):
    (site / "late_entry.py").write_text("FOUND = 7\n")
    entries = Registry[int]("entry")
    entries.promise("late", "late_entry:FOUND")
    assert "late" in entries
    assert list(entries) == ["late"]
    assert len(entries) == 1
    assert "late_entry" not in sys.modules
    assert entries["late"] == entries["late"] == 7
    assert len(entries) == 1


def test_a_promise_outlives_a_failed_import(site: Path):
    entries = Registry[int]("entry")
    entries.promise("late", "late_entry:FOUND")
    with pytest.raises(ImportError):
        entries["late"]
    (site / "late_entry.py").write_text("FOUND = 7\n")
    assert entries["late"] == 7


def test_the_module_whose_import_declares_an_entry_is_known_whatever_function_declares_it(site: Path):
    (site / "colour_library.py").write_text("def paint(colours, name):\n    colours.declare(name, 1)\n")
    (site / "colour_plugin.py").write_text(
        "from colour_library import paint\nfrom colours import COLOURS\npaint(COLOURS, 'red')\n"
    )
    (site / "colours.py").write_text("from scaloft_fi.registry import Registry\nCOLOURS = Registry('colour')\n")
    import_module("colour_plugin")
    assert sys.modules["colours"].COLOURS.declared_in == {"red": "colour_plugin"}


@cases("code", "reason")
def test_a_plugin_that_cannot_be_loaded_is_named_with_its_package(site: Path, code: str, reason: str):
    (site / "broken_plugin.py").write_text(code)
    install(site, "broken-package", {"broken": "broken_plugin"})
    sentence = f"plugin 'broken' of package 'broken-package' cannot be loaded: {reason}; mend or uninstall it"
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        load_plugins()


def test_what_a_plugin_prints_when_it_is_imported_goes_to_the_standard_error(
    site: Path, capfd: pytest.CaptureFixture[str]
):
    (site / "talking_plugin.py").write_text("print('hello')\n")
    install(site, "talking-package", {"talking": "talking_plugin"})
    load_plugins()
    assert capfd.readouterr() == ("", "hello\n")


def test_an_error_is_the_plugins_when_its_code_raised_it_or_its_cause(site: Path):
    (site / "raising_plugin.py").write_text("def go():\n    raise KeyError('lost')\n")
    install(site, "raising-package", {"raising": "raising_plugin"})
    load_plugins()
    go = sys.modules["raising_plugin"].go
    with pytest.raises(KeyError) as direct:
        go()
    assert plugin_behind(direct.value) == "plugin 'raising' of package 'raising-package'"
    outer = RuntimeError("outer")
    outer.__cause__ = direct.value
    assert plugin_behind(outer) == "plugin 'raising' of package 'raising-package'"
    assert plugin_behind(KeyError("ours")) == ""
    assert plugin_behind(DeclaredError("ours", "raising_plugin")) == "plugin 'raising' of package 'raising-package'"


def test_a_miss_without_a_near_name_says_where_such_names_come_from():
    few, many = Registry[int]("colour"), Registry[int]("operator", "scaloft-fi operators")
    with pytest.raises(InputError, match=r"^no colour 'x'; install the package that declares it$"):
        few["x"]
    few.declare("red", 1)
    with pytest.raises(InputError, match=r"^no colour 'x'; allowed: 'red', or install the package that declares it$"):
        few["x"]
    sentence = "no operator 'x'; take one that `scaloft-fi operators` lists, or install the package that declares it"
    with pytest.raises(InputError, match=f"^{sentence}$"):
        many["x"]
