from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

from scaloft_fi.campaign.store.store import Store

Call = Callable[..., Result]


@pytest.mark.parametrize(
    "words",
    [
        ("score",),
        ("coverage",),
        ("kills",),
        ("worksheet",),
        ("dispositions",),
        ("matrix", "--margins"),
        ("export",),
        ("export", "--format", "junit"),
        ("report", "--output", "page.html"),
    ],
    ids=" ".join,
)
def test_a_verb_opens_the_store_once_and_reads_one_moment(
    call: Call, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    flights = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", "3", "--baseline-seeds", "10")
    assert call("run", *flights, "--jobs", "1", "--quiet").exit_code == 0
    opened: list[Path] = []
    begin = Store.__init__

    def opening(self: Store, path: Path, *rest: object, **named: object) -> None:
        opened.append(path)
        begin(self, path, *rest, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Store, "__init__", opening)
    assert call(*words).exit_code == 0
    assert len(opened) == 1
