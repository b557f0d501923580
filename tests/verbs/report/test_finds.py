"""The found situations of the page, and those that break the unmutated drone: evidence, map, flights, the command."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from browsing import Opened
from finding import BAR, flies, found
from papers import STUDY
from reading import embedded

from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS
from scaloft_fi.sim.found import Find
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.study import KnownFinds, Study
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.flights import STEP_M, broken
from scaloft_fi.verbs.report.flights import found as told_finds
from scaloft_fi.verbs.report.page import html

LATE, MORE, LESS = "LATE-human@3s", "MORE-goal@0.6m", "LESS-goal@0.05m"
HERE, ELSEWHERE = "T0O0W0D0H1", "T1O1W0D0H2Cs=0.8"
FINDS = (found(LATE, HERE, others=(LESS,)), found(MORE, ELSEWHERE, struck="person"))


def finds_told(evidence: Evidence, *finds: Find, grid: str | None = None) -> dict[str, Any]:
    """What the page has of finds, in a study with this grid."""
    study = Study.open(STUDY, grid)
    names = {"lost": "it is gone"}
    vars(study)["finds"] = KnownFinds(finds, names, "paper+found", load_grid(STUDY / "sim", "search"))
    return told_finds(study, "paper", evidence.outcomes, [])


@pytest.fixture(scope="module")
def both(evidence: Evidence) -> dict[str, Any]:
    return finds_told(evidence, *FINDS)


def test_each_find_has_its_words_evidence_scene_and_command(both: dict[str, Any]) -> None:
    assert (both["grid"], both["misfits"]) == ("paper+found", ["lost"])
    for find, listed in zip(FINDS, both["finds"], strict=True):
        assert (listed["name"], listed["situation"], listed["mutant"]) == (find.name, find.situation, find.mutant)
        assert listed["words"] == "human walks, cruise speed 0.8 m/s"
        assert listed["command"] == flies(find.mutant)
        assert [one["mutant"] for one in listed["shows"]] == list(find.shows)
    one = both["finds"][1]["shows"][0]
    assert (one["requirement"], one["struck"], one["violated"], one["flights"]) == ("SR2", "person", 6, 6)
    assert (one["p"], one["alpha"], one["held"], one["margin"], one["spread"]) == (0.00025, 0.005, 10, 0.071, 0.02)
    still, walking = ({name: path for _, _, path, name in find["scene"]["bodies"]} for find in both["finds"])
    assert not still["person"]
    assert len(walking["person"]) > 1
    assert set(walking) - set(still) == {"obstacle"}


def test_flights_of_the_campaign_are_a_pair_that_shows_the_find(both: dict[str, Any], evidence: Evidence) -> None:
    flown, unflown = both["finds"]
    assert unflown["flights"] is None
    mutated, clean = flown["flights"]
    assert [one["mutant"] for one in (mutated, clean)] == [LATE, "baseline"]
    assert mutated["seed"] == clean["seed"] == 0
    assert [violation[0] for violation in mutated["violations"]] == ["SR2"]
    assert TRACK_COLUMNS[:3] == ("elapsed_s", "x_m", "y_m"), "the page's map reads a row so"
    for flight in (mutated, clean):
        rows = flight["rows"]
        assert (rows[0][0], rows[-1][0]) == (0.0, 40.0)
        assert all(math.dist(a[1:], b[1:]) >= STEP_M - 0.015 for a, b in pairwise(rows[:-1]))
        assert 50 < len(rows) < 200
    (other,) = finds_told(evidence, found("NO-depth@3s", HERE, others=(LESS,)))["finds"]
    assert other["flights"][0]["mutant"] == "NO-depth@3s", "its own mutant first, though it violates nothing"
    (other,) = finds_told(evidence, found("NO-goal", HERE, others=(LATE,)))["finds"]
    assert other["flights"][0]["mutant"] == LATE


def test_flights_over_another_grid_are_of_other_situations_whatever_their_keys(evidence: Evidence) -> None:
    (find,) = finds_told(evidence, FINDS[0], grid="wide")["finds"]
    assert find["flights"] is None


def test_a_find_whose_values_do_not_go_together_any_more_is_named_and_left_out(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise InputError("the person would stand in the wall")

    monkeypatch.setattr("scaloft_fi.verbs.report.flights.scene", refuse)
    both = finds_told(evidence, *FINDS)
    assert (both["finds"], both["misfits"]) == ([], ["lost", *(find.name for find in FINDS)])


def test_a_page_without_finds_has_no_section_of_them(told: dict[str, Any]) -> None:
    assert told["found"] == {"grid": "", "finds": [], "misfits": []}


def test_the_page_draws_each_find_and_survivors_lead_to_theirs(
    visit: Opened, text: str, both: dict[str, Any], tmp_path: Path
) -> None:
    figures = embedded(text, "figures")
    assert visit().page.locator("#found").count() == 0
    more = next(one for one in figures["survivors"] if one["mutant"] == MORE)
    more |= {"next": "find", "find": f"shows-{MORE}", "why": f"A search found it: `{flies(MORE)}` flies it."}
    figures["found"] = both
    # the first find again and again: of many each is folded
    for name, finds in (("few", both["finds"]), ("many", [*both["finds"], *both["finds"][:1] * 8])):
        file = tmp_path / f"{name}.html"
        file.write_text(html(figures | {"found": both | {"finds": finds}}, embedded(text, "flights")), encoding="utf-8")
        seen = visit(file=file)
        section = seen.page.locator("#found")
        assert "lost" in section.locator(".notice").inner_text()
        first, second = section.locator("details").nth(0), section.locator("details").nth(1)
        assert first.get_attribute("open") == ("" if name == "few" else None)
        seen.page.locator('#survivors a[href="#find-1"]').click()
        second.locator("svg.map path.route").wait_for()  # the page follows the link
        assert second.locator("svg.map path.walked").count() == 1
        assert second.locator(".command code").inner_text() == flies(MORE)
        assert "SR2, strikes person" in second.inner_text()
    visit(f"#mutant={MORE.replace('@', '%40')}", file=file).page.locator('#sheet a[href="#find-1"]').click()
    page = seen.page
    first.locator("summary").click()
    assert first.locator("svg.map path").evaluate_all(
        "all => ['flown', 'clean', 'violation'].map((kind) => all.filter((one) => one.classList.contains(kind)).length)"
    ) == [1, 1, 1]
    assert "kill: SR2 violated in 3 of 3 flights" in first.inner_text()
    first.locator("dl a").click()
    page.wait_for_selector("#sheet .map")
    assert seen.hash() == f"#flight=LATE-human%403s/{HERE}/0"


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

    monkeypatch.setattr("scaloft_fi.verbs.report.flights.scene", refuse)
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
