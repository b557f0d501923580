"""The page in a real Chromium, opened from disk: it renders, clicks and keys work, nothing is asked of any network."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import pytest
from pages import Opened, embedded, unpacked
from papers import BAR, HOSTILE, SHAKY
from printed import run
from studies import ROOT

from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.judge.space import Space
from scaloft_fi.output import printable
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence, folding
from scaloft_fi.verbs.report.page import html
from scaloft_fi.verbs.report.page import page as page_of
from scaloft_fi.verbs.snapshot import Stale

MOST_WORDS = 4000
FLIGHT = "#flight=LATE-human%403s/T0O0W0D0H1/1"


def test_both_matrices_are_drawn_whole(visit: Opened, text: str):
    told, page = embedded(text, "figures"), visit().page
    assert page.locator("#hazop td").count() == len(told["cells"]) == 156
    assert page.locator("#kills td.state").count() == len(told["mutants"]) * len(told["situations"])
    # the names, a line for each axis, and one for each safety requirement
    assert page.locator("table.kills thead tr").count() == 1 + len(told["axes"]) + 2
    for mutant in told["mutants"]:
        row = page.locator(f'#kills tr[data-mutant="{mutant["id"]}"]')
        states = row.locator("td.state").evaluate_all("cells => cells.map((cell) => cell.dataset.state)")
        assert states == [told["signs"][result[0]] for result in mutant["results"]]
        said = row.locator("td.rate").text_content().strip()
        if mutant["control"]:
            assert said == "shows itself by SR1"
        else:
            rate = mutant["kill_rate"]
            assert mutant["verdict"].replace("_", " ") in said
            killed = f"{rate['part']}/{rate['whole']}" if rate["whole"] else "tested"
            bare = mutant["verdict"] == "detected" and not rate["part"]
            assert said.endswith("no\u00a0kill" if bare else killed)
    for cell, text in (("LATE-human", "\u25cf\u25cf\u25cf 8/16"), ("MORE-goal", "\u2013 op"), ("LESS-goal", "? 0/30")):
        assert page.locator(f'#hazop td[data-cell="{cell}"]').inner_text().split("\n")[0] == text
    assert page.locator('#hazop td[data-cell="REVERSE-velcmd"]').inner_text() == "SR1"


def test_no_two_signs_of_the_kill_matrix_look_the_same_without_colour(visit: Opened):
    page = visit().page
    looks = page.locator("#kills td.state").evaluate_all(
        """cells => cells.map((cell) => [cell.dataset.state, JSON.stringify([
            ["kill", "no_test"].includes(cell.dataset.state) ? cell.textContent.replace(/./g, "x") : "",
            getComputedStyle(cell, "::before").content, getComputedStyle(cell).backgroundImage,
            getComputedStyle(cell).boxShadow === "none"])])"""
    )
    by_sign: dict[str, set[str]] = {}
    for sign, look in looks:
        by_sign.setdefault(sign, set()).add(look)
    assert all(len(found) == 1 for found in by_sign.values())
    assert len({look for found in by_sign.values() for look in found}) == len(by_sign) == 7


def test_the_first_screen_answers_and_shows_the_matrix_whole(visit: Opened, told: dict[str, Any]):
    page = visit(viewport={"width": 1440, "height": 900}).page
    head = page.locator(".masthead")
    verdicts = [one["verdict"] for one in told["mutants"] if one["counts"]]
    answer = head.locator(".answer").inner_text()
    assert f"show {verdicts.count('detected')} of {len(verdicts)} faults" in answer
    assert f"miss {verdicts.count('not_detected')}" in answer
    assert answer.endswith("damage.")
    counts = [int(text) for text in head.locator(".fates b").all_inner_texts()]
    assert sum(counts) == len(verdicts)
    worst = [one["id"] for one in told["mutants"] if one["counts"] and one["verdict"] == "not_detected"]
    assert head.locator(".worst a.id").all_inner_texts() == worst
    for words in ("How sure: ", "Not claimed: ", "What next: "):
        assert words in head.inner_text()
    assert head.locator(".buttons a").all_inner_texts() == ["What is missing", "How sure", "What next"]
    for part in ("#hazop table", ".buttons"):
        box = page.locator(part).bounding_box()
        assert box["y"] + box["height"] <= 900


def test_how_sure_and_what_is_not_claimed_are_behind_a_button(visit: Opened, told: dict[str, Any]):
    page = visit().page
    page.get_by_role("link", name="How sure").click()
    said = page.locator("#sure").inner_text().replace("\n", " ")
    _, not_shown, sure, following = (one["text"].replace("`", "").replace(".  ", ". ") for one in told["answers"])
    for sentence in (*told["head"]["fails"], *told["head"]["claims"], sure):
        assert sentence.replace(".  ", ". ") in said
    page.get_by_role("link", name="What next").click()
    assert not_shown.lower() in page.locator("#next").inner_text().lower()
    assert following.lower() in page.locator(".first").inner_text().lower()


def test_a_link_to_a_section_opens_what_it_has_behind_a_click(visit: Opened):
    page = visit(whole=False).page
    assert page.locator("table.kills").is_hidden()
    page.get_by_role("link", name="Kill matrix").click()
    assert page.locator("table.kills").is_visible()


@pytest.mark.release
def test_the_published_report_has_at_most_four_thousand_words_before_a_click(visit: Opened, tmp_path: Path):
    written = tmp_path / "reference.html"
    assert run("report", "--campaign", ROOT / "results" / "published" / "reference", "--output", written) == 0
    page = visit(file=written, whole=False).page
    parts = page.locator("main > *:not(#glossary):not(.paper)").all_inner_texts()
    shown = sum(len(text.split()) for text in parts)
    assert 2000 < shown <= MOST_WORDS
    record = json.loads((ROOT / "results" / "published" / "reference" / "score.json").read_text())
    acting = {*Study.open(ROOT).roster.defaults.values()} - {m["id"] for m in record["composition"]["without_effect"]}
    missed = [m for m in record["mutants"] if m["verdict"] == "not_detected" and m["id"] in acting]
    worst = [m for m in missed if m["severity"] == "injury"]
    part, whole = (record["ratios"]["mutation_score"][name] for name in ("part", "whole"))
    answer = page.locator(".answer").inner_text()
    assert f"show {part} of {whole} faults and miss {len(missed)}; {len(worst)} of the missed" in answer


def test_the_ratios_are_printed_as_they_are_in_the_figures(visit: Opened, told: dict[str, Any]):
    page = visit().page
    for ratio in told["ratios"]:
        assert page.get_by_text(f"{ratio['part']}/{ratio['whole']}", exact=True).count()
        assert page.get_by_text(ratio["population"], exact=True).count() == 1


def test_a_click_on_a_kill_shows_a_flight_that_has_it_and_back_returns(visit: Opened, told: dict[str, Any]):
    seen = visit()
    page = seen.page
    for mutant, seed in (("LATE-human@3s", 0), ("LATE-human@1s", 1)):
        cell = page.locator(f'#kills tr[data-mutant="{mutant}"] td.state[data-state="kill"]').first
        assert cell.text_content() == "2"
        key = told["situations"][int(cell.get_attribute("data-column"))]["key"]
        cell.click()
        page.wait_for_selector("#sheet .map")
        assert seen.hash() == f"#flight={mutant.replace('@', '%40')}/{key}/{seed}"
        assert mutant in page.locator("#sheet-title").inner_text()
        assert (
            page.locator("#sheet .command code").inner_text()
            == f"scaloft-fi replay --campaign paper {mutant}/{key}/{seed}"
        )
        assert "Revealed by SR2" in page.locator("#sheet .verdict").inner_text()
        assert "detected by SR2" in page.locator("#sheet").inner_text()
        page.go_back()
        page.wait_for_selector("#sheet", state="hidden")
        assert seen.hash() == ""
    page.go_forward()
    page.wait_for_selector("#sheet .map")


def test_what_is_no_test_says_why(visit: Opened, told: dict[str, Any]):
    page = visit().page
    keys = [situation["key"] for situation in told["situations"]]
    for key, letter, why in ((BAR, "r", "SR1 red, SR2 vacuous"), (SHAKY, "u", "SR1 unsteady, SR2 vacuous")):
        row = page.locator('#kills tr[data-mutant="MORE-goal@0.6m"]')
        cell = row.locator(f'td.state[data-column="{keys.index(key)}"]')
        assert (cell.get_attribute("data-state"), cell.text_content()) == ("no_test", letter)
        assert f"no test: {why}" in cell.get_attribute("aria-label")


def test_the_pairs_of_the_unmutated_drone_that_are_not_steady_are_listed(visit: Opened, told: dict[str, Any]):
    page = visit().page
    section = page.locator("#baseline")
    ill = {pair["situation"] for pair in told["pairs"] if pair["state"] in ("red", "unsteady", "open")}
    rows = section.locator("table").nth(1).locator("tbody tr")
    assert rows.count() == len(ill)
    assert "2 situations of 32 put no fault to the safety test" in section.locator(".note").inner_text()
    bar = rows.filter(has_text=BAR)
    for words in ("red 10/10", "vacuous", "open 10/10", "nothing tests here", "strikes bar"):
        assert words in bar.inner_text()
    assert "unsteady 3/10" in rows.filter(has_text=SHAKY).inner_text()
    bar.locator("a").click()
    page.wait_for_selector("#sheet .map")
    assert "Violates a safety requirement without any fault" in page.locator("#sheet .verdict").inner_text()


def test_back_and_forward_at_once_leave_the_flight_open(visit: Opened):
    seen = visit()
    page = seen.page
    page.locator('#kills tr[data-mutant="LATE-human@3s"] td.state[data-state="kill"]').first.click()
    page.wait_for_selector("#sheet .map")
    flight = seen.hash()
    # the close event of the sheet comes after both
    page.evaluate(
        """(flight) => {
            history.replaceState(null, "", "#"); dispatchEvent(new PopStateEvent("popstate"));
            history.replaceState(null, "", flight); dispatchEvent(new PopStateEvent("popstate"));
        }""",
        flight,
    )
    page.wait_for_timeout(300)
    assert page.locator("#sheet .map").is_visible()
    assert seen.hash() == flight


def test_the_paths_drawn_are_the_tracks_of_that_flight_and_its_baseline(visit: Opened, text: str):
    told = embedded(text, "figures")
    quanta = [entry["quantum"] for entry in told["columns"]]
    flights = unpacked(embedded(text, "flights")["T0O0W0D0H1"], quanta)
    page = visit(FLIGHT).page
    for kind, mutant in (("flown", "LATE-human@3s"), ("clean", "baseline")):
        (flight,) = (f for f in flights if (f["mutant"], f["seed"]) == (mutant, 1))
        drawn = page.locator(f"#sheet .map path.{kind}").get_attribute("d")
        points = [tuple(map(float, pair.split(","))) for pair in drawn.replace("M", "L").split("L")[1:]]
        assert len(points) == len(flight["rows"])
        # a linear map: equal steps on the ground are equal steps on the screen
        (x0, y0), (x1, y1) = points[0], points[-1]
        first, last = flight["rows"][0], flight["rows"][-1]
        assert x1 - x0 == pytest.approx(52 * (last[1] - first[1]), abs=0.2)
        assert y0 - y1 == pytest.approx(52 * (last[2] - first[2]), abs=0.2)
    assert page.locator("#sheet .chart").count() == 3
    assert page.locator("#sheet .chart line.limit").count() >= 3
    assert page.locator("#sheet .map .infection").count() == 1
    assert page.locator("#sheet .map .violation").count() == 1


def test_another_seed_is_another_flight(visit: Opened):
    seen = visit("#flight=LATE-human%401s/T0O0W0D0H1/1")
    page = seen.page
    assert "Revealed by SR2" in page.locator("#sheet .verdict").inner_text()
    page.locator('#sheet button[data-seed="0"]').click()
    page.wait_for_selector('#sheet button[data-seed="0"][aria-pressed="true"]')
    assert "Survived" in page.locator("#sheet .verdict").inner_text()
    assert seen.hash().endswith("/0")


def test_the_matrices_are_walked_and_opened_by_keys(visit: Opened):
    seen = visit()
    page = seen.page
    for board, opened in (("#hazop", "#cell="), ("#kills", "#flight=")):
        assert page.locator(f'{board} [role="gridcell"][tabindex="0"]').count() == 1
        page.locator(f'{board} [role="gridcell"][tabindex="0"]').focus()
        for key in ("ArrowRight", "ArrowDown", "ArrowLeft", "End", "Home", "ArrowRight"):
            page.keyboard.press(key)
        assert page.locator(f'{board} [role="gridcell"][tabindex="0"]').count() == 1
        here = page.evaluate("[document.activeElement.cellIndex, document.activeElement.parentElement.sectionRowIndex]")
        # the first row of the kill matrix is the parameter's heading
        assert here == [2, 1 if board == "#hazop" else 2]
        focused = page.evaluate("document.activeElement.getAttribute('aria-label')")
        assert focused
        page.keyboard.press("Enter")
        page.wait_for_selector("#sheet .sheet-body")
        assert seen.hash().startswith(opened)
        page.keyboard.press("Escape")
        page.wait_for_selector("#sheet", state="hidden")
        page.wait_for_function("() => !location.hash")  # the close event comes later
        assert page.evaluate("document.activeElement.getAttribute('aria-label')") == focused


def test_a_cell_shows_its_mutants_and_they_lead_to_flights(visit: Opened):
    page = visit("#cell=LATE-human").page
    assert page.locator("#sheet .mutant h3").first.inner_text() == "LATE-human@3s"
    assert "LATE-human@1s detected by SR2" in page.locator("#sheet .sheet-body > details > summary").inner_text()
    page.locator("#sheet .flown-list").first.locator("xpath=..").locator("summary").click()
    page.locator('#sheet .flown-list a:has([data-state="kill"])').first.click()
    page.wait_for_selector("#sheet .map")
    page.go_back()
    page.wait_for_selector("#sheet .mutant")


def test_filters_and_order_of_the_kill_matrix(visit: Opened):
    page = visit().page
    rows = page.locator("#kills tr[data-mutant]")
    page.get_by_label("text in id or condition").fill("late-human")
    assert rows.count() == 2
    assert "2 of 6 mutants" in page.locator("#kills output").inner_text()
    page.get_by_label("text in id or condition").fill("")
    page.locator("#kills select").nth(0).select_option("rate")
    whole = [one.split("/") for one in rows.locator("td.rate .number").all_text_contents() if one]
    shares = [int(part) / int(all_) for part, all_ in whole]
    assert shares == sorted(shares, reverse=True)
    page.locator("#kills select").nth(3).select_option("detected")
    assert rows.evaluate_all("all => all.map((row) => row.dataset.mutant)").count("MORE-goal@0.6m") == 0
    page.locator("#kills select").nth(3).select_option("")
    page.locator("#kills select").nth(2).select_option("goal")
    assert rows.count() == 2
    page.locator("#kills select").nth(2).select_option("")
    page.get_by_label("magnitudes").select_option("counts")
    assert rows.evaluate_all("all => all.map((row) => row.dataset.mutant)").count("LATE-human@1s") == 0
    assert rows.count() == 4


def test_hostile_names_appear_letter_by_letter_and_break_nothing(
    visit: Opened, hostile: Evidence, hostile_text: str, tmp_path: Path
):
    file = tmp_path / "hostile <b>&.html"
    file.write_text(hostile_text, encoding="utf-8")
    page = visit(file=file).page
    assert page.locator("h1").inner_text() == f"{hostile.study.folder.name}: campaign {HOSTILE[0]}"
    parameters = page.locator('#hazop th[scope="row"]').evaluate_all("heads => heads.map((head) => head.textContent)")
    assert parameters[: len(HOSTILE)] == list(map(printable, HOSTILE))
    assert page.evaluate("document.querySelectorAll('img, iframe, [onerror], [onclick]').length") == 0
    assert page.evaluate("document.scripts.length") == 3
    assert HOSTILE[1] in page.locator("#survivors .accepted").first.text_content()
    page.locator('#kills td.state[data-state="kill"]').first.click()
    page.wait_for_selector("#sheet .map")
    assert HOSTILE[0] in page.locator("#sheet .verdict").text_content()
    assert "pwned" not in page.title().split(" \u00b7 ")[-1]
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("width", [400, 1280])
def test_the_page_never_scrolls_sideways(visit: Opened, width: int):
    page = visit(viewport={"width": width, "height": 800}).page
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.evaluate(f"location.hash = '{FLIGHT}'")
    page.wait_for_selector("#sheet .map")
    assert page.evaluate("document.getElementById('sheet').scrollWidth") <= width


def test_dark_colours_follow_the_system_and_the_switch(visit: Opened):
    page = visit(color_scheme="dark").page
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.get_by_role("button", name="Switch to light colours").click()
    light = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert sum(map(int, dark[4:-1].split(","))) < 120 < 600 < sum(map(int, light[4:-1].split(",")))


def test_in_print_everything_is_light_and_laid_out(visit: Opened):
    page = visit(color_scheme="dark").page
    page.emulate_media(media="print")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.locator("#bar").is_hidden()
    assert page.evaluate("getComputedStyle(document.querySelector('.matrix-box')).overflow") == "visible"
    assert page.pdf(prefer_css_page_size=True)[:4] == b"%PDF"


def test_every_cell_has_a_name_and_every_control_a_label(visit: Opened):
    page = visit(FLIGHT).page
    unnamed = page.evaluate(
        "[...document.querySelectorAll('[role=gridcell], svg[role=img], button, input, select, dialog')]"
        ".filter((node) =>"
        " !(node.getAttribute('aria-label') || node.getAttribute('aria-labelledby') || node.labels?.length"
        " || node.textContent.trim())).length"
    )
    assert unnamed == 0


def test_a_browser_that_cannot_inflate_says_so_and_names_the_command(browser: Any, path: Path):
    context = browser.new_context()
    context.add_init_script("delete globalThis.DecompressionStream")
    page = context.new_page()
    page.goto(path.as_uri() + FLIGHT)
    said = page.locator("main").inner_text()
    for words in ("it has no DecompressionStream", "The command scaloft-fi score prints the tables."):
        assert words in said
    context.close()


def test_a_page_without_a_track_says_why(visit: Opened, evidence: Evidence, tmp_path: Path):
    file = tmp_path / "small.html"
    file.write_text(page_of(evidence, 1), encoding="utf-8")
    page = visit(FLIGHT, file=file).page
    assert page.locator("#sheet .map .flown").count() == 0
    assert "of the unmutated drone with seeds 0-9" in page.locator("#sheet .note").first.inner_text()


def test_a_click_on_a_mutant_shows_its_karnaugh_map_and_a_cell_of_it_the_flight(visit: Opened, told: dict[str, Any]):
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
    assert mutant["terms"][0]["words"] in page.locator("#sheet .sheet-body .keys").last.inner_text()
    edge = page.locator("#sheet .karnaugh svg").bounding_box()
    first, last = cells.first.bounding_box(), cells.last.bounding_box()
    assert (edge["x"], edge["y"]) == pytest.approx((first["x"], first["y"]), abs=1)
    assert edge["x"] + edge["width"] == pytest.approx(last["x"] + last["width"], abs=1)
    page.locator('#sheet .map-cell[data-state="kill"]').first.click()
    page.wait_for_selector("#sheet .map")
    page.go_back()
    page.wait_for_selector("#sheet .karnaugh")


def test_the_karnaugh_map_is_walked_by_keys(visit: Opened):
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


def test_the_karnaugh_map_is_printed_and_readable_in_dark(visit: Opened):
    page = visit("#mutant=LATE-human%403s", color_scheme="dark").page
    page.wait_for_selector("#sheet .karnaugh")
    ink = "getComputedStyle(document.querySelector('#sheet .map-cell[data-state=kill] .plate')).color"
    assert page.evaluate(ink) == "rgb(12, 26, 43)"
    page.emulate_media(media="print")
    assert page.locator("#sheet .karnaugh").is_visible()
    assert page.locator("main").is_hidden()
    assert page.evaluate(ink) == "rgb(255, 255, 255)"


def test_a_grid_that_cannot_be_folded_says_why_and_lists_the_situations(visit: Opened, text: str, tmp_path: Path):
    space = Space(("A",), (("0", "1"),), (("x", "y"),), ())
    told = embedded(text, "figures") | {"karnaugh": folding(space)}
    file = tmp_path / "wide.html"
    file.write_text(html(told, embedded(text, "flights")), encoding="utf-8")
    page = visit("#mutant=LATE-human%403s", file=file).page
    page.wait_for_selector("#sheet .note")
    assert "needs 2 axes or more; this grid has 1." in page.locator("#sheet .note").inner_text()
    assert page.locator("#sheet .karnaugh").count() == 0
    assert page.locator("#sheet .flown-list li").count() == 32


def test_beside_a_margin_stands_the_limit_that_it_is_measured_against(visit: Opened, told: dict[str, Any]):
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
):
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


def test_another_magnitude_is_not_taken_for_the_default_and_a_failed_gate_has_no_tick(
    visit: Opened, evidence: Evidence, tmp_path: Path
):
    milder = tuple(one for one in evidence.outcomes if one.mutant != "LATE-human@3s")
    failed = "no score is valid: gate failed: PLACEBO differs from the baseline: PLACEBO/T0O0W0D0H0/0"
    file = tmp_path / "milder.html"
    file.write_text(page_of(replace(evidence, outcomes=milder, stale=Stale(invalid=(failed,)))), encoding="utf-8")
    page = visit(file=file).page
    assert page.locator('#hazop td[data-cell="LATE-human"]').inner_text() == "not default"
    assert failed in page.locator(".masthead [role=alert]").inner_text()
    held = page.locator(".gate").evaluate_all("gates => gates.map((gate) => [gate.dataset.held, gate.textContent])")
    assert [one for one, _ in held[:2]] == ["no", "no"]
    assert held[1][1].endswith("does not equal the unmutated drone bit for bit.")
