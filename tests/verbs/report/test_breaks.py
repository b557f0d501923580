"""The situations of the page that break the unmutated drone: what is violated and where, the map, the command."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from browsing import Opened
from finding import BAR
from papers import STUDY
from reading import embedded

from scaloft_fi.errors import InputError
from scaloft_fi.sim.grids import load_grid
from scaloft_fi.study import KnownFinds
from scaloft_fi.verbs.report.finds import broken
from scaloft_fi.verbs.report.page import html

FLIES = f"scaloft-fi run --grid search --mutant PLACEBO --situation {BAR.name} --baseline-seeds 10"
BLIND = replace(BAR, name="breaks-SR2", requirement="SR2", struck="", near="home", leg="corner to home", belief="")
KNOWN = KnownFinds((), {}, "paper+found", load_grid(STUDY / "sim", "search"), (BAR, BLIND))


def test_each_break_has_its_words_place_belief_scene_and_command():
    first, second = broken(KNOWN, [])
    assert (first["name"], first["words"]) == (BAR.name, "corner, dark, cruise speed 0.8 m/s")
    assert (first["where"], first["belief"]) == ("corner to end", "obstacle map, 0.58 m")
    assert (second["where"], second["belief"]) == ("near home, corner to home", "none")
    assert first["command"] == FLIES
    assert first["place"] == [-1.614, 7.714]
    assert first["scene"]["bodies"]


def test_a_break_whose_values_do_not_go_together_any_more_is_left_out(monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: object) -> None:
        raise InputError("the person would stand in the wall")

    monkeypatch.setattr("scaloft_fi.verbs.report.finds.scene", refuse)
    assert broken(KNOWN, []) == []


def test_the_page_draws_each_break_with_the_place_of_the_violation(visit: Opened, text: str, tmp_path: Path):
    figures = embedded(text, "figures")
    assert figures["breaks"] == []
    assert visit().page.locator("#breaks").count() == 0
    mines = figures["scenes"]["mines"]
    file = tmp_path / "breaks.html"
    file.write_text(html(figures | {"breaks": broken(KNOWN, mines)}, embedded(text, "flights")), encoding="utf-8")
    section = visit(file=file).page.locator("#breaks")
    assert section.locator("svg.map path.route").count() == section.locator("svg.map path.violation").count() == 2
    assert section.locator(".command code").first.inner_text() == FLIES
    row = section.locator("tbody tr").first.inner_text()
    assert "violates SR1, strikes bar" in row
    assert "obstacle map, 0.58 m" in row
