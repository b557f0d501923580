"""What a terminal shows of every verb that does not fly: it fits the width, and loses nothing without colours."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from click.testing import Result
from forms import READERS

Call = Callable[..., Result]
MARK = re.compile(r"\x1b\[[0-9;]*m")
AVAILABLE = re.compile(r"[\d.]+ GiB available")
"""Free memory, which `doctor` prints, is another one in each call."""
HELDS = re.compile(r"`[^`]*`")
"""A command, within which no line may end."""
SCREENS = (
    *(words for words in READERS if words != ("mutants", "--check")),
    ("seams", "person"),
    ("axes", "H"),
    ("map",),
    ("score", "--all"),
    ("kills", "LATE-human"),
)
"""`check` prints lines for editors, of any length."""


def _too_wide(text: str, width: int) -> list[str]:
    """The lines that are wider, without those of a single word or command, which is never broken."""
    lines = [line for line in text.splitlines() if len(line) > width and not line.startswith("    scaloft-fi ")]
    return [line for line in lines if " " in HELDS.sub("-", line.strip())]


@pytest.mark.parametrize("words", SCREENS, ids=" ".join)
def test_a_screen_fits_the_terminal_and_says_the_same_without_colours(
    told: Call, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    def shown(width: int, colours: str) -> str:
        with monkeypatch.context() as patch:
            patch.setenv("COLUMNS", str(width))
            patch.setenv(colours, "1")
            done = told(*words)
        assert done.exit_code == 0, done.output
        return AVAILABLE.sub("9.9 GiB available", done.stdout)

    plain = {width: shown(width, "NO_COLOR") for width in (60, 80, 160)}
    assert {width: _too_wide(text, width) for width, text in plain.items()} == {60: [], 80: [], 160: []}
    assert not any(map(MARK.search, plain.values()))
    assert MARK.sub("", shown(80, "FORCE_COLOR")) == plain[80]
