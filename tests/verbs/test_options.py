from __future__ import annotations

import sys

import pytest

from scaloft_fi.verbs.options import typed


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["/venv/bin/scaloft-fi", "run", "--mutant", "LATE-human*"], "scaloft-fi run --mutant 'LATE-human*'"),
        (["/package/__main__.py", "margin", "LATE-human"], "python -m scaloft_fi margin LATE-human"),
    ],
)
def test_what_was_typed_is_told_as_a_shell_takes_it(
    argv: list[str], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", argv)
    assert typed() == said
