from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("LATE-human",), "must be MUTANT/SITUATION/SEED"),
        (("LATE-human/T0O0W0D0H1/x",), "must be MUTANT/SITUATION/SEED"),
        (("LATE-humna/T0O0W0D0H1/0",), "LATE-humna"),
        (("LATE-human/T0O0W0D0H7/0",), "no situation 'T0O0W0D0H7'"),
        (("baseline/T0O0W0D0H1/0", "--output", "map.pdf"), "must end in .svg, .png or .mcap"),
        (("baseline/T0O0W0D0H1/0", "--output", "no/where/map.svg"), "cannot be written"),
    ],
)
def test_bad_words_are_one_sentence_before_anything_flies(
    call: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], said: str
) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.flights.fly.fly_log", lambda *_: pytest.fail("it flew"))
    result = call("replay", *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_window_needs_a_display(call: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    result = call("replay", "baseline/T0O0W0D0H1/0", "--gui")
    assert result.exit_code == 2
    assert "--gui needs a display" in result.stderr
