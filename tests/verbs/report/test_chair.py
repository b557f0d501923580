"""The page as the chair of a HAZOP study uses it: two clicks to the flight, keys alone, print, a narrow screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pages import Opened, embedded

from scaloft_fi.verbs.report.page import html

FLIGHT = "#flight=LATE-human%403s/T0O0W0D0H1/1"
SHEETS = ("#cell=LATE-human", "#mutant=LATE-human%403s", "#situation=T0O0W0D0H1", FLIGHT)
SERIOUS = ("serious", "critical")


def open_sheet(page: Any, fragment: str) -> None:
    page.evaluate("hash => { location.hash = hash; }", fragment)
    page.wait_for_function(
        "() => document.querySelector('#sheet[open] .sheet-body') && !document.querySelector('#sheet .notice')"
    )
    if fragment.startswith("#flight"):
        page.wait_for_selector("#sheet .map")


def test_two_clicks_lead_from_a_cell_to_the_flight_that_shows_its_fault(visit: Opened, told: dict[str, Any]):
    first = next(one for one in told["mutants"] if one["id"] == "LATE-human@3s")["first"]
    seen = visit()
    page = seen.page
    page.locator('#hazop td[data-cell="LATE-human"]').click()
    page.locator("#sheet a.go").first.click()
    page.wait_for_selector("#sheet .map")
    assert seen.hash() == f"#flight=LATE-human%403s/{first['situation']}/{first['seed']}"
    assert f"SR2 is violated at {first['t_s']:.2f} s" in page.locator("#sheet .verdict").inner_text()
    # the sheet opens at the moment of the violation, which the map marks and names
    assert page.locator("#sheet .time output").inner_text() == f"{first['t_s']:.2f} s"
    assert page.locator("#sheet .map .violation").count() == 1
    assert page.locator("#sheet .map .label.violated").text_content() == f"SR2, {first['t_s']:.2f} s"
    # beside the unmutated drone
    assert page.locator("#sheet .map path.clean").count() == page.locator("#sheet .map path.flown").count() == 1


def test_a_cell_names_each_kill_by_situation_requirement_and_flight(visit: Opened, told: dict[str, Any]):
    kills = next(one for one in told["mutants"] if one["id"] == "LATE-human@3s")["kills"]
    page = visit("#cell=LATE-human").page
    rows = page.locator("#sheet .mutant").first.locator("table").first.locator("tbody tr")
    situations = {one["key"]: one for one in told["situations"]}
    assert rows.count() == len(kills) == 8
    for said, kill in zip(rows.all_inner_texts(), kills, strict=True):
        situation = situations[kill["situation"]]
        for words in (", ".join(situation["words"]), kill["situation"], "SR2", "3/3", "0/10", "9.50 s"):
            assert words in said
        assert all(f"alias {alias}" in said for alias in situation["aliases"])


def test_a_survivor_has_a_page_that_can_be_sent(visit: Opened, text: str, tmp_path: Path):
    figures = embedded(text, "figures")
    survivor = next(one for one in figures["survivors"] if one["mutant"] == "MORE-goal@0.6m")
    survivor["loss"] |= {"situation": "T0O0W0D0H1", "seed": 1, "flown": 0.2, "share": 0.6}
    cell = next(one for one in figures["cells"] if one["name"] == "MORE-goal")
    file = tmp_path / "sent.html"
    file.write_text(html(figures, embedded(text, "flights")), encoding="utf-8")
    page = visit("#mutant=MORE-goal%400.6m", file=file).page
    page.wait_for_selector("#sheet .map path.flown")
    body = page.locator("#sheet .sheet-body").inner_text()
    # the hazard; the flight in motion beside the unmutated drone's, with its command
    assert page.locator(".sheet-head p").inner_text() == f"{cell['deviation']} {cell['effect']}"
    assert "Of all its flights SR1 lost the most of its margin here." in body
    assert page.locator("#sheet .map path.clean").count() == page.locator("#sheet .player .play").count() == 1
    # why nothing saw it, what would, and its row of the worksheet
    assert survivor["why"].replace("`", "") in body
    commands = page.locator("#sheet .command code").all_inner_texts()
    assert commands == [
        "scaloft-fi replay --campaign paper MORE-goal@0.6m/T0O0W0D0H1/1",
        "scaloft-fi propose --campaign paper MORE-goal@0.6m",
    ]
    assert all(cause in body for cause in cell["causes"])


def test_a_count_picks_out_its_faults_in_the_matrix_and_its_pages_are_walked(visit: Opened, text: str, tmp_path: Path):
    figures, missed = embedded(text, "figures"), ["MORE-goal@0.6m", "LATE-human@3s"]
    for one in figures["mutants"]:
        if one["id"] in missed:
            one |= {"verdict": "not_detected", "counts": True, "same": False, "severity": None}
    figures["mutants"] = [one for one in figures["mutants"] if one["id"] in missed or one["verdict"] != "not_detected"]
    order = [one["id"] for one in figures["mutants"] if one["id"] in missed]
    file = tmp_path / "walked.html"
    file.write_text(html(figures, embedded(text, "flights")), encoding="utf-8")
    seen = visit(file=file)
    page, aside = seen.page, "td => td.filter((one) => !one.classList.contains('aside')).map((one) => one.dataset.cell)"
    every = page.locator("#hazop td").evaluate_all(aside)
    page.get_by_role("button", name=f"Pick out: {len(order)} missed").click()
    picked = page.locator("#hazop td").evaluate_all(aside)
    assert sorted(picked) == sorted(id_.partition("@")[0] for id_ in order)
    page.get_by_role("button", name=f"Pick out: {len(order)} missed").click()
    assert page.locator("#hazop td").evaluate_all(aside) == every
    # from fault to fault, by Enter alone, and round
    open_sheet(page, f"#mutant={order[0]}")
    page.get_by_role("link", name="next fault, missed").focus()
    for place in (1, 0):
        page.keyboard.press("Enter")
        page.locator("#sheet .walk", has_text=f"{place + 1} of 2 missed").wait_for()
        assert page.locator("#sheet-title").inner_text() == order[place]
    # the sheets of their cells, too
    open_sheet(page, f"#cell={picked[0]}")
    assert page.locator("#sheet .walk span").inner_text().endswith("of 2 missed")


def test_a_column_of_the_kill_matrix_is_a_situation_by_name(visit: Opened, told: dict[str, Any]):
    seen = visit()
    page = seen.page
    heads = page.locator("table.kills tr.names th.upright a")
    names = [one["name"] + "".join(one["aliases"]) for one in told["situations"]]
    assert heads.evaluate_all("all => all.map((one) => one.textContent)") == names
    place = next(number for number, one in enumerate(told["situations"]) if one["aliases"] == ["32"])
    heads.nth(place).click()
    page.wait_for_selector("#sheet .map")
    assert page.locator("#sheet-title").inner_text() == "Corner, obstacle, near wall, dark, no human"
    assert "T1O1W1D1H0, alias 32" in page.locator("#sheet .sheet-head").inner_text()
    assert page.locator("#sheet .map .label").all_text_contents() == ["bar", "obstacle", "home, 4", "1, 3", "2", "1 m"]
    rows = page.locator("#sheet table").first.locator("tbody tr").all_inner_texts()
    assert rows[0].split() == ["SR1", "red", "10/10"]


def test_the_matrix_is_shaded_by_certainty_and_hatched_where_nothing_is_decided(visit: Opened):
    page = visit().page

    def look(cell: str) -> list[str]:
        found = page.locator(f'#hazop td[data-cell="{cell}"]')
        text = found.locator(".plate").inner_text()
        style = "node => [getComputedStyle(node).backgroundImage.split('(')[0], getComputedStyle(node).borderTopStyle]"
        return [text, found.get_attribute("data-sure") or "", *found.evaluate(style)]

    assert look("LATE-human") == ["\u25cf\u25cf\u25cf 8/16", "3", "none", "solid"]
    assert look("MORE-goal") == ["\u2013 op", "", "none", "solid"]
    assert look("LESS-goal") == ["? 0/30", "", "repeating-linear-gradient", "dashed"]
    assert look("NO-depth") == ["= not infected", "", "none", "solid"]
    assert page.locator('#hazop td[data-cell="MORE-goal"]').get_attribute("data-rank") == "2"
    legend = page.locator("#hazop details .legend").text_content()
    for words in ("p at most 0.01", "p at most 0.001", "p at most 0.00001", "hatched: something seen"):
        assert words in legend
    # killed by requirements: operability shows one that safety does not
    assert page.locator('#hazop td[data-cell="MORE-goal"] .op').count() == 1
    assert page.locator('#hazop td[data-cell="LATE-human"] .op').count() == 0


@pytest.mark.release
def test_a_flight_plays_and_jumps_to_what_happened(visit: Opened):
    page = visit(FLIGHT).page
    told, play = page.locator("#sheet .time output"), page.locator("#sheet .play")
    assert told.inner_text() == "9.50 s"
    play.click()
    page.wait_for_function("() => parseFloat(document.querySelector('#sheet .time output').textContent) > 0.5")
    play.click()
    stopped = told.inner_text()
    page.wait_for_timeout(200)
    assert told.inner_text() == stopped
    assert play.inner_text().strip().endswith("Play")
    page.get_by_role("button", name="first changed sample").click()
    assert told.inner_text() == "8.00 s"
    assert page.locator("#sheet .map .hull").first.get_attribute("visibility") == "visible"
    assert "SR2 violated" in page.locator("#sheet .jumps").inner_text()


@pytest.mark.release
def test_who_asks_for_less_motion_gets_no_moving_picture(visit: Opened):
    page = visit(FLIGHT, reduced_motion="reduce").page
    assert page.locator("#sheet .play").count() == 0
    page.get_by_role("button", name="SR2 violated").click()
    assert page.locator("#sheet .time output").inner_text() == "9.50 s"


def test_keys_alone_lead_to_the_flight_and_back(visit: Opened):
    seen = visit()
    page = seen.page
    focused = "document.activeElement.textContent"
    # the skip link, the bar, the head, then one stop for the matrix
    for _ in range(60):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.getAttribute('role')") == "gridcell":
            break
    for _ in range(8):
        page.keyboard.press("ArrowRight")
    assert page.evaluate("document.activeElement.dataset.cell") == "LATE-human"
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("Enter")
    page.wait_for_selector("#sheet .mutant")
    for _ in range(5):
        page.keyboard.press("Tab")
        if "See the flight" in page.evaluate(focused):
            break
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("Enter")
    page.wait_for_selector("#sheet .map")
    for _ in range(20):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.type") == "range":
            break
    before = page.locator("#sheet .time output").inner_text()
    page.keyboard.press("ArrowRight")
    assert page.locator("#sheet .time output").inner_text() != before
    page.keyboard.press("Escape")
    page.wait_for_selector("#sheet", state="hidden")
    assert page.evaluate("document.activeElement.dataset.cell") == "LATE-human"


@pytest.mark.release
def test_a_link_and_the_way_back_draw_a_sheet_once(visit: Opened):
    page = visit("#cell=LATE-human").page
    page.evaluate(
        "() => { window.drawn = 0; new MutationObserver((changes) => { for (const { addedNodes } of changes)"
        " drawn += [...addedNodes].filter((node) => node.className === 'sheet-body').length; })"
        ".observe(document.getElementById('sheet'), { childList: true }); }"
    )
    page.locator("#sheet a.go").first.click()
    page.wait_for_selector("#sheet .map")
    page.go_back()
    page.wait_for_selector("#sheet .mutant")
    page.go_forward()
    page.wait_for_selector("#sheet .map")
    page.wait_for_timeout(100)
    assert page.evaluate("drawn") == 3


@pytest.mark.release
def test_every_head_and_legend_is_a_term_that_leads_to_its_meaning(visit: Opened, told: dict[str, Any]):
    page = visit().page
    known = {form.lower() for entry in told["glossary"] for form in (entry["name"], *entry["also"])}
    known |= {requirement["name"].lower() for requirement in told["requirements"]}
    first = "[...node.childNodes].find((one) => one.textContent.trim())?.textContent ?? ''"
    heads = f"nodes => nodes.map((node) => {first})"
    for fragment, root in (("", "main"), *((sheet, "#sheet") for sheet in SHEETS)):
        if fragment:
            open_sheet(page, fragment)
        parts = f"{root} table.plain thead th", f"{root} .answers dt", f"{root} .legend b:has(a)"
        found = [head for part in parts for head in page.locator(part).evaluate_all(heads)]
        assert [head for head in found if head.lower() not in known and not head.isdigit()] == []
        assert found
        lost = f"[...document.querySelectorAll('{root} a.term')].filter((one) => !document.querySelector(one.hash))"
        assert page.evaluate(f"{lost}.map((one) => one.textContent)") == []
    page.locator("#sheet a.term").first.click()
    page.wait_for_selector("#sheet", state="hidden")
    assert page.evaluate("document.activeElement.id") == page.evaluate("location.hash.slice(1)")


@pytest.mark.release
def test_on_paper_stands_what_is_behind_a_click_on_the_screen(visit: Opened, told: dict[str, Any]):
    page = visit(color_scheme="dark").page
    page.wait_for_selector("#details[data-ready]", state="attached")
    assert page.locator("#details").is_hidden()
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    (mutant,) = (one for one in told["mutants"] if one["counts"] and one["verdict"] == "detected")
    detail = page.locator("#details .detail")
    assert detail.count() == 1
    assert detail.locator("table").first.locator("tbody tr").count() == len(mutant["kills"])
    for picture in (".map", ".chart", ".keys"):
        assert detail.locator(picture).first.is_visible()
    assert page.locator("main details:not([open])").count() == 0
    for part in ("#glossary dd", "#reading dd", "#kills details table", "#hazop .legend"):
        assert page.locator(part).first.is_visible()
    cut = "nodes => nodes.filter((node) => node.scrollWidth > node.clientWidth + 1).length"
    page.set_viewport_size({"width": 1030, "height": 700})  # A4 across without its margins
    assert page.locator("main .scroll, main .matrix-box").evaluate_all(cut) == 0
    assert page.pdf(prefer_css_page_size=True)[:4] == b"%PDF"


@pytest.mark.release
def test_on_a_narrow_screen_a_value_says_what_it_is(visit: Opened):
    page = visit("#cell=LATE-human", viewport={"width": 390, "height": 844}).page
    head = "getComputedStyle(document.querySelector('#sheet .mutant td'), '::before').content"
    assert page.evaluate(head).replace('" "', "") in ('"killed by: "', '"killed by" ": "')
    page.keyboard.press("Escape")
    page.wait_for_selector("#sheet", state="hidden")
    cell = page.locator('#hazop td[data-cell="LATE-human"]')
    assert page.evaluate("node => getComputedStyle(node, '::before').content", cell.element_handle()) == '"LATE"'
    box = cell.bounding_box()
    assert box["x"] + box["width"] <= 390
    assert page.evaluate("document.documentElement.scrollWidth") == 390


@pytest.mark.release
@pytest.mark.parametrize(
    ("fragment", "context"),
    [
        ("", {}),
        ("", {"color_scheme": "dark"}),
        ("", {"viewport": {"width": 390, "height": 844}}),
        (FLIGHT, {}),
        ("#mutant=LATE-human%403s", {}),
    ],
    ids=["light", "dark", "390 px", "an open flight", "the page of a mutant"],
)
def test_axe_finds_nothing_serious(visit: Opened, fragment: str, context: dict[str, Any]):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page = visit(fragment, **context).page
    if fragment:
        page.wait_for_selector("#sheet .map")
    found = axe.run(page).response["violations"]
    assert [(one["id"], one["nodes"][0]["target"]) for one in found if one["impact"] in SERIOUS] == []
