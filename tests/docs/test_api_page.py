"""The page of the Python API says what happens: its examples are run, with real flights."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import pytest

import scaloft_fi
from scaloft_fi.errors import ScaloftError

PAGE = Path(__file__).parents[2] / "docs" / "api.md"


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
