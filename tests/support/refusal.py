"""How a verb ends, for the tests of all verbs: its exit code, what a refusal looks like."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import Result

from scaloft_fi.cli import main


def sentence(result: Result) -> str:
    """The one sentence of a refusal: exit code 2, nothing else printed."""
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("error: ")
    assert "Traceback" not in line
    return line


def run(*words: str | Path) -> int:
    """The exit code of the command, called in this process, with the streams of the test."""
    with pytest.raises(SystemExit) as left:
        main([*map(str, words)])
    assert isinstance(left.value.code, int)
    return left.value.code
