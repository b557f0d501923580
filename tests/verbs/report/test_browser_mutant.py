"""The sheet of a mutant in a real Chromium: its Karnaugh map, its disposition."""

from __future__ import annotations

from dataclasses import replace
from datetime import date, timedelta
from pathlib import Path

import pytest
from browsing import Opened
from reading import embedded

from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.judge.space import Space
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.matrices import folding
from scaloft_fi.verbs.report.page import html
from scaloft_fi.verbs.report.page import page as page_of


def test_a_click_on_a_mutant_shows_its_karnaugh_map_and_a_cell_of_it_the_flight(visit: Opened, text: str) -> None:
    told = embedded(text, "figures")
    mutant = next(one for one in told["mutants"] if one["id"] == "LATE-human@3s")
    seen = visit()
    page = seen.page
    page.locator('#kills tr[data-mutant="LATE-human@3s"] th a').click()
    page.wait_for_selector("#sheet .karnaugh")
    assert seen.hash() == "#mutant=LATE-human%403s"
    cells = page.locator("#sheet .karnaugh .map-cell")
    place = {situation["key"]: number for number, situation in enumerate(told["situations"])}
    drawn = cells.evaluate_all("all => all.map((one) => [one.dataset.key, one.dataset.state, one.textContent])")
    words = {"kill": "kill SR2 3/3", "tested": "nothing seen"}
    assert [key for key, _, _ in drawn] == [key for row in told["karnaugh"]["keys"] for key in row]
    for key, state, said in drawn:
        assert state == told["signs"][mutant["results"][place[key]][0]]
        # words in every cell, so that no colour is needed to tell them apart
        assert said == words.get(state, state.replace("_", " "))
    assert page.locator("#sheet .karnaugh path[data-term]").count() == len(mutant["terms"]) == 1
    assert mutant["terms"][0]["words"] in page.locator("#sheet .sheet-body .keys").inner_text()
    edge = page.locator("#sheet .karnaugh svg").bounding_box()
    first, last = cells.first.bounding_box(), cells.last.bounding_box()
    assert (edge["x"], edge["y"]) == pytest.approx((first["x"], first["y"]), abs=1)
    assert edge["x"] + edge["width"] == pytest.approx(last["x"] + last["width"], abs=1)
    page.locator('#sheet .map-cell[data-state="kill"]').first.click()
    page.wait_for_selector("#sheet .map")
    page.go_back()
    page.wait_for_selector("#sheet .karnaugh")


def test_the_karnaugh_map_is_walked_by_keys(visit: Opened) -> None:
    seen = visit("#mutant=LATE-human%403s")
    page = seen.page
    page.wait_for_selector("#sheet .karnaugh")
    page.locator('#sheet .map-cell[tabindex="0"]').focus()
    for key in ("ArrowRight", "ArrowDown"):
        page.keyboard.press(key)
    key = page.evaluate("document.activeElement.dataset.key")
    assert key == "T0O1W0D0H1"
    page.keyboard.press("Enter")
    page.wait_for_selector("#sheet .map")
    assert seen.hash() == f"#flight=LATE-human%403s/{key}/0"


def test_the_karnaugh_map_is_printed_and_readable_in_dark(visit: Opened) -> None:
    page = visit("#mutant=LATE-human%403s", color_scheme="dark").page
    page.wait_for_selector("#sheet .karnaugh")
    ink = "getComputedStyle(document.querySelector('#sheet .map-cell[data-state=kill] .plate')).color"
    assert page.evaluate(ink) == "rgb(12, 26, 43)"
    page.emulate_media(media="print")
    assert page.locator("#sheet .karnaugh").is_visible()
    assert page.locator("main").is_hidden()
    assert page.evaluate(ink) == "rgb(255, 255, 255)"


def test_a_grid_that_cannot_be_folded_says_why_and_lists_the_situations(
    visit: Opened, text: str, tmp_path: Path
) -> None:
    space = Space(("A",), (("0", "1"),), (("x", "y"),), ())
    told = embedded(text, "figures") | {"karnaugh": folding(space)}
    file = tmp_path / "wide.html"
    file.write_text(html(told, embedded(text, "flights")), encoding="utf-8")
    page = visit("#mutant=LATE-human%403s", file=file).page
    page.wait_for_selector("#sheet .note")
    assert "needs 2 axes or more; this grid has 1." in page.locator("#sheet .note").inner_text()
    assert page.locator("#sheet .karnaugh").count() == 0
    assert page.locator("#sheet .flown-list li").count() == 32


def test_beside_a_margin_stands_the_limit_that_it_is_measured_against(visit: Opened, text: str) -> None:
    told = embedded(text, "figures")
    page = visit().page
    section = page.locator("#ladders")
    limit = "limit of SR2: speed \u2264 0.25 m/s where time of flight \u2265 2 s and distance to the person in sight"
    assert limit in section.locator("figcaption").first.inner_text()
    (entry,) = told["thresholds"]
    rows = section.locator("details tbody tr")
    assert rows.count() == len(entry["situations"])
    for row, found in zip(rows.all(), entry["situations"], strict=True):
        assert found["key"] in row.inner_text()
        said = row.locator("td").nth(3).inner_text()
        assert said == ("\u2013" if found["kills"] is None else f"{found['kills']:g} s")
        assert row.locator("svg .dot").count() == (found["kills"] is not None)
    page = visit("#cell=LATE-human").page
    page.wait_for_selector("#sheet dl")
    assert limit in page.locator("#sheet dl").inner_text()


def test_a_disposition_stands_beside_its_survivor_and_a_given_day_marks_it(
    visit: Opened, evidence: Evidence, tmp_path: Path
) -> None:
    day = date(2027, 1, 31)
    known = Disposition("MORE-goal@0.6m", "A. Engineer", "there is 1 m of room", day)
    study = Study.open(evidence.study.folder)
    vars(study)["dispositions"] = (known,)
    for today, words in ((None, "accepted until 2027-01-31"), (day + timedelta(1), "expired, last day 2027-01-31")):
        file = tmp_path / f"{today}.html"
        file.write_text(page_of(replace(evidence, study=study, today=today), 1), encoding="utf-8")
        page = visit("#mutant=MORE-goal%400.6m", file=file).page
        for place in ('#survivors tr:has([href*="MORE-goal"])', "#sheet"):
            beside = page.locator(f"{place} .accepted")
            assert f"{words} by A. Engineer: there is 1 m of room" in beside.text_content()
