"""The page in a real Chromium, opened from disk: it renders, clicks and keys work, nothing is asked of any network."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browsing import Opened
from papers import HOSTILE, campaign, evidence_of
from reading import embedded, unpacked

from scaloft_fi.report.evidence import Evidence
from scaloft_fi.report.page import page as page_of
from scaloft_fi.study import Study

FLIGHT = "#flight=LATE-human%403s/T0O0W0D0H1/1"


def test_both_matrices_are_drawn_whole(visit: Opened, text: str) -> None:
    told, page = embedded(text, "figures"), visit().page
    assert page.locator("#hazop td").count() == len(told["cells"]) == 156
    assert page.locator("#kills td.state").count() == len(told["mutants"]) * len(told["situations"])
    assert page.locator("#kills thead tr").count() == len(told["axes"])
    for mutant in told["mutants"]:
        row = page.locator(f'#kills tr[data-mutant="{mutant["id"]}"]')
        states = row.locator("td.state").evaluate_all("cells => cells.map((cell) => cell.dataset.state)")
        plain = [told["statuses"][result[0]] for result in mutant["results"]]
        assert states == plain
        rate = mutant["kill_rate"]
        assert row.locator("td.rate .number").inner_text() == (
            f"{rate['part']}/{rate['whole']}" if rate["whole"] else "n/a"
        )


def test_the_ratios_are_printed_as_they_are_in_the_figures(visit: Opened, text: str) -> None:
    page = visit().page
    for ratio in embedded(text, "figures")["ratios"]:
        assert page.get_by_text(f"{ratio['part']}/{ratio['whole']}", exact=True).count()
        assert page.get_by_text(ratio["population"], exact=True).count() == 1


def test_the_answer_says_how_many_kills_are_more_than_chance_where_seeds_can_tell(
    visit: Opened, study: Study, tmp_path: Path
) -> None:
    leads = []
    for seeds in (2, 10):
        file = tmp_path / f"{seeds}.html"
        flown = campaign(study, ("LATE-human@3s", "MORE-goal@0.6m"), range(seeds))
        file.write_text(page_of(evidence_of(study, flown)), encoding="utf-8")
        leads.append(visit(file=file).page.locator(".lead").inner_text())
    assert leads[0].endswith(" %).")
    assert leads[1].endswith("; repeated flights decide of 1 that more than chance kills them.")


def test_a_click_on_a_result_shows_its_flight_and_back_returns(visit: Opened, text: str) -> None:
    seen = visit()
    page = seen.page
    cell = page.locator('#kills tr[data-mutant="LATE-human@3s"] td.state[data-state="killed"]').first
    column = int(cell.get_attribute("data-column"))
    key = embedded(text, "figures")["situations"][column]["key"]
    cell.click()
    page.wait_for_selector("#sheet .map")
    assert seen.hash() == f"#flight=LATE-human%403s/{key}/0"
    assert "LATE-human@3s" in page.locator("#sheet-title").inner_text()
    assert page.locator("#sheet .command code").inner_text() == f"scaloft-fi replay LATE-human@3s/{key}/0"
    assert "Killed by SR2" in page.locator("#sheet .verdict").inner_text()
    page.go_back()
    page.wait_for_selector("#sheet", state="hidden")
    assert seen.hash() == ""
    page.go_forward()
    page.wait_for_selector("#sheet .map")


def test_back_and_forward_at_once_leave_the_flight_open(visit: Opened) -> None:
    seen = visit()
    page = seen.page
    page.locator('#kills tr[data-mutant="LATE-human@3s"] td.state[data-state="killed"]').first.click()
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


def test_the_paths_drawn_are_the_tracks_of_that_flight_and_its_baseline(visit: Opened, text: str) -> None:
    told = embedded(text, "figures")
    quanta = [entry["quantum"] for entry in told["columns"]]
    flights = unpacked(embedded(text, "flights")["T0O0W0D0H1"], quanta)
    page = visit(FLIGHT).page
    page.wait_for_selector("#sheet .map .flown")
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


def test_another_seed_is_another_flight(visit: Opened) -> None:
    seen = visit("#flight=LATE-human%401s/T0O0W0D0H1/0")
    page = seen.page
    page.wait_for_selector("#sheet .map")
    assert "Killed by SR2" in page.locator("#sheet .verdict").inner_text()
    page.locator('#sheet button[data-seed="1"]').click()
    page.wait_for_selector('#sheet button[data-seed="1"][aria-pressed="true"]')
    assert "Survived" in page.locator("#sheet .verdict").inner_text()
    assert seen.hash().endswith("/1")


def test_the_matrices_are_walked_and_opened_by_keys(visit: Opened) -> None:
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
        assert not seen.hash()
        assert page.evaluate("document.activeElement.getAttribute('aria-label')") == focused


def test_a_cell_shows_its_mutants_and_they_lead_to_flights(visit: Opened) -> None:
    page = visit("#cell=LATE-human").page
    page.wait_for_selector("#sheet .mutant")
    assert page.locator("#sheet .mutant h3").all_inner_texts() == ["LATE-human@1s", "LATE-human@3s"]
    page.locator('#sheet .flown-list a[data-state="killed"]').first.click()
    page.wait_for_selector("#sheet .map")
    page.go_back()
    page.wait_for_selector("#sheet .mutant")


def test_filters_and_order_of_the_kill_matrix(visit: Opened) -> None:
    page = visit().page
    rows = page.locator("#kills tr[data-mutant]")
    page.get_by_label("text in id or condition").fill("late-human")
    assert rows.count() == 2
    assert "2 of 6 mutants" in page.locator("#kills output").inner_text()
    page.get_by_label("text in id or condition").fill("")
    page.locator("#kills select").nth(0).select_option("rate")
    whole = rows.locator("td.rate .number").all_inner_texts()
    shares = [-1.0 if text == "n/a" else int(text.split("/")[0]) / int(text.split("/")[1]) for text in whole]
    assert shares == sorted(shares, reverse=True)
    page.locator("#kills select").nth(2).select_option("goal")
    assert rows.count() == 2
    page.locator("#kills select").nth(2).select_option("")
    page.get_by_label("magnitudes").select_option("counts")
    assert rows.evaluate_all("all => all.map((row) => row.dataset.mutant)").count("LATE-human@1s") == 0
    assert rows.count() == 4


def test_hostile_names_appear_letter_by_letter_and_break_nothing(
    visit: Opened, hostile: Evidence, hostile_text: str, tmp_path: Path
) -> None:
    file = tmp_path / "hostile <b>&.html"
    file.write_text(hostile_text, encoding="utf-8")
    page = visit(file=file).page
    assert page.locator("h1").inner_text() == f"{hostile.study.folder.name}: campaign {HOSTILE[0]}"
    parameters = page.locator('#hazop th[scope="row"]').evaluate_all("heads => heads.map((head) => head.textContent)")
    assert parameters[: len(HOSTILE)] == list(HOSTILE)
    assert page.evaluate("document.querySelectorAll('img, iframe, [onerror], [onclick]').length") == 0
    assert page.evaluate("document.scripts.length") == 3
    assert HOSTILE[1] in page.locator("#survivors .accepted").text_content()
    page.locator('#kills td.state[data-state="killed"]').first.click()
    page.wait_for_selector("#sheet .map")
    assert HOSTILE[0] in page.locator("#sheet .verdict").text_content()
    assert "pwned" not in page.title().split(" \u00b7 ")[-1]
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("width", [400, 1280])
def test_the_page_never_scrolls_sideways(visit: Opened, width: int) -> None:
    page = visit(viewport={"width": width, "height": 800}).page
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.evaluate(f"location.hash = '{FLIGHT}'")
    page.wait_for_selector("#sheet .map")
    assert page.evaluate("document.getElementById('sheet').scrollWidth") <= width


def test_dark_colours_follow_the_system_and_the_switch(visit: Opened) -> None:
    page = visit(color_scheme="dark").page
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.get_by_role("button", name="Switch to light colours").click()
    light = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert sum(map(int, dark[4:-1].split(","))) < 120 < 600 < sum(map(int, light[4:-1].split(",")))


def test_in_print_everything_is_light_and_laid_out(visit: Opened) -> None:
    page = visit(color_scheme="dark").page
    page.emulate_media(media="print")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.locator("#bar").is_hidden()
    assert page.evaluate("getComputedStyle(document.querySelector('.matrix-box')).overflow") == "visible"
    assert page.pdf(prefer_css_page_size=True)[:4] == b"%PDF"


def test_every_cell_has_a_name_and_every_control_a_label(visit: Opened) -> None:
    page = visit(FLIGHT).page
    page.wait_for_selector("#sheet .map")
    unnamed = page.evaluate(
        "[...document.querySelectorAll('[role=gridcell], svg[role=img], button, input, select, dialog')]"
        ".filter((node) =>"
        " !(node.getAttribute('aria-label') || node.getAttribute('aria-labelledby') || node.labels?.length"
        " || node.textContent.trim())).length"
    )
    assert unnamed == 0


def test_a_browser_that_cannot_inflate_says_so_and_still_gives_the_command(browser: Any, path: Path) -> None:
    context = browser.new_context()
    context.add_init_script("delete globalThis.DecompressionStream")
    page = context.new_page()
    page.goto(path.as_uri() + FLIGHT)
    page.wait_for_selector("#sheet .notice")
    assert "DecompressionStream" in page.locator("#sheet .notice").inner_text()
    assert page.locator("#sheet .command code").inner_text() == "scaloft-fi replay LATE-human@3s/T0O0W0D0H1/1"
    context.close()


def test_a_page_without_a_track_says_why(visit: Opened, evidence: Evidence, tmp_path: Path) -> None:
    file = tmp_path / "small.html"
    file.write_text(page_of(evidence, 1), encoding="utf-8")
    page = visit(FLIGHT, file=file).page
    page.wait_for_selector("#sheet .map")
    assert page.locator("#sheet .map .flown").count() == 0
    assert "baselines only" in page.locator("#sheet .note").first.inner_text()
