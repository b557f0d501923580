"""What a refusal looks like, for the tests of all verbs."""

from __future__ import annotations

from click.testing import Result


def sentence(result: Result) -> str:
    """The one sentence of a refusal: exit code 2, nothing else printed."""
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("error: ")
    assert "Traceback" not in line
    return line
