from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.console import wrapped

WORDS = st.lists(st.sampled_from(["NO-depth@3s", "a", "`scaloft-fi run --seeds 3`", "p/" * 30]), max_size=20)


@given(WORDS, st.integers(30, 100))
def test_no_word_and_no_command_that_fits_is_broken(words: list[str], width: int) -> None:
    lines = wrapped(" ".join(words), width, "  ", "    ").split("\n")
    assert " ".join(" ".join(lines).split()) == " ".join(words)
    for line in lines:
        assert len(line) <= width or len(line.split()) == 1
    assert sum(line.count("`scaloft-fi run --seeds 3`") for line in lines) == words.count("`scaloft-fi run --seeds 3`")


def test_a_command_that_is_longer_than_a_line_is_broken_between_its_words() -> None:
    assert wrapped("`scaloft-fi run --mutant LATE-human@3s`", 24) == "`scaloft-fi run --mutant\nLATE-human@3s`"
