"""README and the page of the Python API say what happens; the hooks that make pages do what their examples say."""

from __future__ import annotations

import doctest
import re
import sys
from importlib import import_module
from pathlib import Path

import pytest
from published_flights import ROOT, outcomes

import scaloft_fi
from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.score import score
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.study import NO_FINDS, Study
from scaloft_fi.verbs.first_screen import first_screen, screen_text

PAGE = ROOT / "docs" / "api.md"


@pytest.mark.flight
def test_every_example_of_the_page_gives_what_the_page_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = re.sub(r"^```.*$", "", PAGE.read_text(), flags=re.MULTILINE)  # else the end of a block is expected output
    page = doctest.DocTestParser().get_doctest(text, {}, "docs/api.md", str(PAGE), 0)
    said: list[str] = []
    failed, tried = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(page, out=said.append)
    assert tried > 20
    assert not failed, "".join(said)
    assert [one.name for one in tmp_path.iterdir()] == ["notebook"], "an example wrote elsewhere"


def test_the_page_lists_every_error() -> None:
    errors = [name for name in scaloft_fi.__all__ if name != "ScaloftError" and _is_error(getattr(scaloft_fi, name))]
    assert all(f"| `{name}` |" in PAGE.read_text() for name in errors)


def test_the_page_lists_every_type_of_column() -> None:
    table = PAGE.read_text().partition("| column | holds |")[2].partition("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", "\n".join(row.split("|")[1] for row in table.splitlines()[2:]))) == {
        kind.value for kind in scaloft_fi.ColumnType
    }


def _is_error(value: object) -> bool:
    return isinstance(value, type) and issubclass(value, ScaloftError)


MUTANT, CONTROL = "LATE-human@3s", ("REVERSE-velcmd", "T0O0W0D0H0")


def _flown() -> list[Outcome]:
    """What `run --mutant LATE-human` flies: one seed, ten of the baseline where the mutant infects, one control."""
    published = outcomes()
    mutant = [one for one in published if one.mutant == MUTANT and one.seed == 0]
    infected = {one.situation for one in mutant if one.altered}
    seeds = {key: range(10) if key in infected else range(1) for key in {one.situation for one in mutant}}
    return [
        *(one for one in published if one.mutant == BASELINE and one.seed in seeds[one.situation]),
        *mutant,
        *(one for one in published if (one.mutant, one.situation) == CONTROL and one.seed == 0),
    ]


def test_the_screen_is_that_of_the_published_flights() -> None:
    study, flown = Study.open(ROOT), _flown()
    scored = score(flown, study.roster, study.space)
    screen = first_screen(
        scored, study.roster, study.space, coverage(flown, study.space), lambda _mutant: None, finds=NO_FINDS
    )
    shown = re.search(r"^```\n(Shown .*?)^```$", (Path(ROOT) / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    assert shown
    assert shown[1] == screen_text(screen)


HOOKS = ROOT / "docs" / "hooks"


@pytest.mark.parametrize("name", sorted(path.stem for path in HOOKS.glob("*.py")))
def test_its_examples_hold(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for needed in ("mkdocs", "griffe"):
        pytest.importorskip(needed)
    monkeypatch.syspath_prepend(str(HOOKS))
    assert doctest.testmod(import_module(name)).failed == 0
    assert Path(str(sys.modules[name].__file__)).parent == HOOKS
