"""Formats that say of a survivor what it rests on say which command flies its find."""

from __future__ import annotations

import json

import pytest
from builders import outcome, pool
from dossiers import dossier
from finding import flies, found, known

from scaloft_fi.verbs.export.dossier import FORMATS

LATE, NO, HERE = "LATE-human@3s", "NO-human@100%", "T0O0W0D0H0"
FLIGHTS = [*pool(HERE), *(outcome(id_, HERE, seed) for id_ in (LATE, NO) for seed in range(3))]


@pytest.mark.parametrize("style", ["mutation-testing", "markdown"])
def test_the_command_stands_behind_the_verdict_of_the_survivor_that_has_a_find(style: str) -> None:
    text = FORMATS[style].content(dossier(FLIGHTS, known(found(LATE)))).decode().replace("\\", "")
    assert text.count(f"; next: {flies(LATE)}") == 1
    assert text.count("; next: ") == 1
    bare = FORMATS[style].content(dossier(FLIGHTS)).decode()
    assert "; next: " not in bare
    if style == "mutation-testing":
        json.loads(bare)


@pytest.mark.parametrize(("style", "next_"), [("sarif", "Next: "), ("junit", "; next: ")])
def test_the_find_is_the_next_step_of_its_survivor_which_needs_no_search(style: str, next_: str) -> None:
    text = FORMATS[style].content(dossier(FLIGHTS, known(found(LATE)))).decode()
    bare = FORMATS[style].content(dossier(FLIGHTS)).decode()
    assert f"{next_}{flies(LATE)}" in text
    assert flies(LATE) not in bare
    assert f"scaloft-fi seek {NO}" in text
    assert f"scaloft-fi seek {LATE}" in bare
    assert f"scaloft-fi seek {LATE}" not in text
