"""Parts of the page held against other countings: finds and breaks, thresholds and margins, maps of kills."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from datetime import date
from itertools import combinations, pairwise, product
from pathlib import Path
from typing import Any

import pytest
from builders import outcome
from finding import BAR, flies, found
from pages import Opened, counts_of, embedded, exported
from papers import SEEDS, STUDY, campaign, evidence_of, flight

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.kill_matrix import KillEntry, KillRow
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import score
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, Subject
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.sim.grid import Find, load_grid
from scaloft_fi.study import KnownFinds, Study
from scaloft_fi.verbs.report.analyses import (
    Evidence,
    accepted,
    bounds_of,
    by_ladder,
    folding,
    limits,
    terms,
    thresholds,
)
from scaloft_fi.verbs.report.flights import STEP_M, broken, listed
from scaloft_fi.verbs.report.flights import found as told_finds
from scaloft_fi.verbs.report.page import asset, html, page

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


def test_each_find_has_its_words_evidence_scene_and_command(both: dict[str, Any]):
    assert (both["grid"], both["misfits"]) == ("paper+found", ["lost"])
    for find, told in zip(FINDS, both["finds"], strict=True):
        assert (told["name"], told["situation"], told["mutant"]) == (find.name, find.situation, find.mutant)
        assert told["words"] == "human walks, cruise speed 0.8 m/s"
        assert told["command"] == flies(find.mutant)
        assert [one["mutant"] for one in told["shows"]] == list(find.shows)
    one = both["finds"][1]["shows"][0]
    assert (one["requirement"], one["struck"], one["violated"], one["flights"]) == ("SR2", "person", 6, 6)
    assert (one["p"], one["alpha"], one["held"], one["margin"], one["spread"]) == (0.00025, 0.005, 10, 0.071, 0.02)
    still, walking = ({name: path for _, _, path, name in find["scene"]["bodies"]} for find in both["finds"])
    assert not still["person"]
    assert len(walking["person"]) > 1
    assert set(walking) - set(still) == {"obstacle"}


def test_flights_of_the_campaign_are_a_pair_that_shows_the_find(both: dict[str, Any], evidence: Evidence):
    flown, unflown = both["finds"]
    assert unflown["flights"] is None
    mutated, clean = flown["flights"]
    assert [one["mutant"] for one in (mutated, clean)] == [LATE, "baseline"]
    assert mutated["seed"] == clean["seed"] == 0
    assert [violation[0] for violation in mutated["violations"]] == ["SR2"]
    assert TRACK_COLUMNS[:3] == ("elapsed_s", "x_m", "y_m"), "the page's map reads a row so"
    for rows in (mutated["rows"], clean["rows"]):
        assert (rows[0][0], rows[-1][0]) == (0.0, 40.0)
        assert all(math.dist(a[1:], b[1:]) >= STEP_M - 0.015 for a, b in pairwise(rows[:-1]))
        assert 50 < len(rows) < 200
    (other,) = finds_told(evidence, found("NO-depth@3s", HERE, others=(LESS,)))["finds"]
    assert other["flights"][0]["mutant"] == "NO-depth@3s", "its own mutant first, though it violates nothing"
    (other,) = finds_told(evidence, found("NO-goal", HERE, others=(LATE,)))["finds"]
    assert other["flights"][0]["mutant"] == LATE


def test_flights_over_another_grid_are_of_other_situations_whatever_their_keys(evidence: Evidence):
    (find,) = finds_told(evidence, FINDS[0], grid="wide")["finds"]
    assert find["flights"] is None


def test_a_find_whose_values_do_not_go_together_any_more_is_named_and_left_out(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
):
    def refuse(*_: object) -> None:
        raise InputError("the person would stand in the wall")

    monkeypatch.setattr("scaloft_fi.verbs.report.flights.scene", refuse)
    both = finds_told(evidence, *FINDS)
    assert (both["finds"], both["misfits"]) == ([], ["lost", *(find.name for find in FINDS)])


def test_a_page_without_finds_has_no_section_of_them(told: dict[str, Any]):
    assert told["found"] == {"grid": "", "finds": [], "misfits": []}


def test_the_page_draws_each_find_and_survivors_lead_to_theirs(
    visit: Opened, text: str, both: dict[str, Any], tmp_path: Path
):
    figures = embedded(text, "figures")
    assert visit().page.locator("#found").count() == 0
    more = next(one for one in figures["survivors"] if one["mutant"] == MORE)
    more |= {"next": "find", "find": f"shows-{MORE}", "why": f"A search found it: `{flies(MORE)}` flies it."}
    figures["found"] = both
    file = tmp_path / "found.html"
    file.write_text(html(figures, embedded(text, "flights")), encoding="utf-8")
    seen = visit(file=file)
    section = seen.page.locator("#found")
    assert "lost" in section.locator(".notice").inner_text()
    first, second = section.locator("article").nth(0), section.locator("article").nth(1)
    seen.page.locator('#survivors a[href="#find-1"]').click()
    second.locator("svg.map path.route").wait_for()  # the page follows the link
    assert second.locator("svg.map path.walked").count() == 1
    assert "SR2, strikes person" in second.inner_text()
    assert not second.locator(".command").is_visible()
    second.locator("summary").click()
    assert second.locator(".command code").inner_text() == flies(MORE)
    sheet = visit(f"#mutant={MORE.replace('@', '%40')}", file=file).page.locator("#sheet")
    sheet.locator(".missed svg.map path.route").wait_for()
    sheet.locator('a[href="#find-1"]').click()
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
    assert section.locator(".command code").first.text_content() == FLIES
    row = section.locator("tbody tr").first.inner_text()
    assert "violates SR1, strikes bar" in row
    assert "obstacle map, 0.58 m" in row


SEARCHED = "T0O0W0D0H1"


@pytest.fixture(scope="module")
def measured(study: Study) -> tuple[Evidence, dict[str, Any]]:
    """A ladder of 0.5, 1 and 3 s, of which the mildest survives, and a search in one situation that flew 2 s there."""
    outcomes = campaign(study, ("LATE-human@3s", "LATE-human@1s", "MORE-goal@0.6m"))
    milder = [_as(o, "0.5s") for o in campaign(study, ("MORE-goal@0.6m",)) if o.mutant == "MORE-goal@0.6m"]
    between = [_as(flight(study, "LATE-human@3s", SEARCHED, seed), "2s") for seed in SEEDS]
    evidence = evidence_of(study, (*outcomes, *milder, *between))
    return evidence, embedded(page(evidence, 1), "figures")


def _as(outcome: Outcome, magnitude: str) -> Outcome:
    return replace(outcome, subject=Subject(f"LATE-human@{magnitude}", "LATE", "human", magnitude))


def test_the_ends_of_a_margin_and_the_robustness_there_are_those_of_the_export(
    measured: tuple[Evidence, dict[str, Any]],
):
    evidence, told = measured
    (entry,) = told["thresholds"]
    rows = [row for row in exported(evidence) if row["mutant"].startswith("LATE-human")]
    counted = counts_of(exported(evidence))
    expected = {}
    for key in {row["situation"] for row in rows}:
        here = {m: counted[f"LATE-human@{m}s"][key] for m in ("0.5", "1", "2", "3")}
        flown = {float(m): count for m, count in here.items() if count.flown}
        kills = min((m for m, count in flown.items() if count.most), default=None)
        # its cell puts SR2 at risk, so where SR1 alone is steady nothing is told of it
        survived = [m for m, count in flown.items() if "SR2" in count.tests and not count.most]
        harmless = [m for m, count in flown.items() if not count.infected and "not_infected" in count.statuses]
        survives = max((m for m in (*survived, *harmless) if kills is None or m < kills), default=None)
        if kills is not None or survived:
            rho = [None if end is None else _least(rows, key, end) for end in (survives, kills)]
            expected[key] = (survives, kills, rho, sorted(flown))
    said = {one["key"]: (one["survives"], one["kills"], one["rho"]["SR2"], one["flown"]) for one in entry["situations"]}
    assert said == expected
    assert said[SEARCHED][:2] == (0.5, 1.0)
    assert (entry["fault"], entry["unit"], entry["worse"], entry["against"]) == ("LATE-human", "s", 1, ["SR2"])
    assert entry["least"] == told["margins"]["LATE-human"] == "0.5-1 s"
    assert entry["situations_flown"] == 32
    assert {one["seen"] for one in entry["situations"]} == {None}


def _least(rows: list[dict[str, Any]], key: str, magnitude: float) -> float:
    """The least robustness against SR2."""
    name = f"LATE-human@{magnitude:g}s"
    return min(row["rho_SR2"] for row in rows if row["mutant"] == name and row["situation"] == key)


def test_a_magnitude_flown_where_a_search_asked_for_it_is_no_rung_of_the_ladder(
    measured: tuple[Evidence, dict[str, Any]],
):
    (ladder,) = measured[1]["ladders"]
    assert [rung["magnitude"] for rung in ladder["rungs"]] == ["0.5s", "1s", "3s"]
    late = [mutant["id"] for mutant in measured[1]["mutants"] if mutant["cell"] == "LATE-human"]
    assert late == ["LATE-human@0.5s", "LATE-human@1s", "LATE-human@2s", "LATE-human@3s"]
    assert [mutant["id"] for mutant in measured[1]["mutants"] if mutant["searched"]] == ["LATE-human@2s"]


def test_what_is_seen_without_a_verdict_is_no_kill(study: Study):
    outcomes = campaign(study, ("LATE-human@3s", "LATE-human@1s"), range(1))
    few = [o for o in outcomes if o.mutant != "LATE-human@3s" or o.situation in (SEARCHED, "T0O1W0D0H1")]
    scored = score(few, study.roster, study.space)
    (entry,) = thresholds(few, scored, study.matrix, study.requirements)
    ends = {one["key"]: (one["survives"], one["seen"], one["kills"]) for one in entry["situations"] if one["seen"]}
    assert ends == dict.fromkeys((SEARCHED, "T0O1W0D0H1"), (1.0, 3.0, None))
    assert entry["least"] == "seen 1-3 s"


def test_the_page_has_each_fault_that_was_flown_at_several_phases(study: Study):
    mutants = ("NO-velcmd@1s", "NO-velcmd@1s#5s", "NO-velcmd@1s#sight", "LATE-human@3s")
    told = embedded(page(evidence_of(study, campaign(study, mutants, range(1))), 1), "figures")
    (when,) = told["whens"]
    assert when["fault"] == "NO-velcmd@1s"
    assert [(strike["phase"], strike["at_event"]) for strike in when["strikes"]] == [
        ("", False),
        ("#5s", False),
        ("#sight", True),
    ]


def test_magnitudes_are_in_order_and_forms_without_one_stay_as_they_are(study: Study):
    order = by_ladder(study.matrix, study.roster)
    ids = [mutant.id for mutant in study.catalogue]
    cells = [id_.split("@")[0].split("#")[0] for id_ in sorted(ids, key=order)]
    assert cells == [id_.split("@")[0].split("#")[0] for id_ in ids]
    phases = ["", "#5s", "#15s", "#mode", "#sight"]
    assert sorted({f"NO-velcmd@1s{phase}" for phase in phases}, key=order) == [f"NO-velcmd@1s{p}" for p in phases]
    late = [f"LATE-human@{text}" for text in ("0.5s", "0.688s", "1s", "1.06s", "3s", "5s", "12s")]
    assert sorted(set(late), key=order) == late


def test_the_reference_studys_limits_are_told_in_the_units_of_their_signals(study: Study):
    told = {entry["name"]: entry for entry in bounds_of(study.requirements)}

    def short(bounds: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
        return [tuple(bound.values()) for bound in bounds]

    assert short(told["SR1"]["demands"]) == [("clearance_m", ">", 0.0, None, False)]
    assert short(told["SR2"]["demands"]) == [
        ("speed_mps", "<=", 0.25, None, True),
        ("clearance_person_m", ">", 0.0, None, False),
    ]
    assert short(told["SR2"]["when"]) == [
        ("elapsed_s", ">=", 2.0, None, False),
        ("person_sight_m", "<=", 3.0, 2.0, False),
    ]
    # its trigger is one of two things: no conjunction
    assert told["OP1"]["demands"] == told["OP1"]["when"] == []


@pytest.mark.parametrize(
    "text",
    [
        "always(a > 0 or b > 0)",
        "always(not (a > 0))",
        "always(a + b > 3)",
        "always(abs(a) > 3)",
        "always(a > 0 and b > 0 implies c > 0)",
        "always(once[0:2](a > 0))",
        "always(historically[1:2](a > 0))",
        "always(historically[0:2](historically[0:2](a > 0)))",
        "always(a > b)",
    ],
)
def test_what_is_more_than_a_conjunction_of_bounds_is_not_taken_apart(text: str):
    (entry,) = bounds_of([Requirement("R", Kind.SAFETY, text, trigger="t > 0")])
    assert entry == {"name": "R", "demands": [], "when": []}


def test_brackets_negative_bounds_and_definitions():
    text = "always(((trigger implies (a / 2 <= 3 and -1 <= b)) and low))"
    (entry,) = bounds_of([Requirement("R", Kind.SAFETY, text, trigger="t > 0", definitions=(("low", "c < 5"),))])
    assert json.loads(json.dumps([tuple(bound.values()) for bound in entry["demands"]])) == [
        ["a", "<=", 6.0, None, True],
        ["b", ">=", -1.0, None, True],
        ["c", "<", 5.0, None, False],
    ]


def test_the_reference_study_limits_clearance_speed_and_the_distance_at_which_that_counts(study: Study):
    found = {
        (limit["requirement"], limit["signal"], limit["sense"], limit["bound"], limit["role"])
        for limit in limits(study.requirements, TRACK_COLUMNS)
    }
    assert ("SR1", "clearance_m", ">", 0.0, "demands") in found
    assert ("SR2", "speed_mps", "<=", 0.25, "demands") in found
    assert ("SR2", "person_sight_m", "<=", 3.0, "when") in found


@pytest.mark.parametrize(
    ("text", "bound"),
    [("always(speed_mps / 0.5 <= 3)", 1.5), ("always(speed_mps>=-2.5)", -2.5), ("always(x_m > 1)", None)],
)
def test_a_limit_is_in_the_unit_of_its_signal(text: str, bound: float | None):
    found = limits([Requirement("R", Kind.SAFETY, text)], ("speed_mps",))
    assert [limit["bound"] for limit in found] == ([] if bound is None else [bound])


def test_a_survivor_is_told_with_its_disposition_and_the_situations_that_it_does_not_name(evidence: Evidence):
    study, more, day = evidence.study, "MORE-goal@0.6m", date(2027, 1, 31)
    scored = score(evidence.outcomes, study.roster, study.space)
    known = (Disposition(more, "A. Engineer", "there is 1 m of room", day, (SEARCHED,)),)
    tests = [key for key, count in counts_of(exported(evidence))[more].items() if count.tests]
    for today, state in ((None, "uncovered"), (day, "uncovered"), (date(2027, 2, 1), "expired")):
        told = accepted(scored, study.roster, known, today)
        assert told["today"] == (today and today.isoformat())
        found = {entry["mutant"]: entry for entry in told["judged"]}
        assert found["LESS-goal@0.05m"].keys() == {"mutant", "state", "surviving"}
        assert (found["LESS-goal@0.05m"]["state"], sorted(found[more]["surviving"])) == ("open", sorted(tests))
        said = [found[more][name] for name in ("state", "owner", "reason", "until", "situations")]
        assert said == [state, "A. Engineer", "there is 1 m of room", "2027-01-31", [SEARCHED]]
        assert sorted(found[more]["unnamed"]) == sorted(set(tests) - {SEARCHED})


def grid(*sizes: int) -> Space:
    """Axes with these numbers of values."""
    axes = tuple("ABCDEFGH"[: len(sizes)])
    values = tuple(tuple(map(str, range(size))) for size in sizes)
    keyed = tuple(("".join(a + v for a, v in zip(axes, point, strict=True)), point) for point in product(*values))
    return Space(axes, values, values, keyed)


@pytest.mark.parametrize("count", range(2, 7))
def test_neighbours_differ_in_one_axis_and_opposite_edges_meet(count: int):
    space = grid(*[2] * count)
    fold = folding(space)
    keys = fold["keys"]
    assert sorted(key for row in keys for key in row) == sorted(space.point)
    for row, column in product(range(len(keys)), range(len(keys[0]))):
        here = space.point[keys[row][column]]
        sides = zip((*fold["down"], *fold["across"]), (*fold["rows"][row], *fold["columns"][column]), strict=True)
        assert [level for _, level in sorted(sides)] == list(map(int, here))
        for beside in (keys[row][column - 1], keys[row - 1][column]):
            assert sum(a != b for a, b in zip(here, space.point[beside], strict=True)) == 1


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ((8,) * 4, "of 4096 situations could not be read; at most 512 are drawn"),
        ((2,), "needs 2 axes or more; this grid has 1"),
    ],
)
def test_a_grid_without_a_map_says_why_and_has_no_terms(sizes: tuple[int, ...], said: str):
    space = grid(*sizes)
    (key, *_) = space.point
    entries = (KillEntry("X-x", key, kills=("R",)),)
    row = KillRow(Subject("X-x"), "mutant", True, Status.REVEALED, Verdict.DETECTED, Ratio(1, 1), entries)
    assert said in folding(space)["reason"]
    assert folding(space).keys() == {"reason"}
    assert terms(space, row) == []


def test_terms_hold_every_kill_and_no_survival_and_are_the_fewest(evidence: Evidence, text: str):
    told, counted = embedded(text, "figures"), counts_of(exported(evidence))
    levels = {entry["key"]: entry["levels"] for entry in told["situations"]}
    boxes = list(product(([0], [1], [0, 1]), repeat=5))

    def inside(key: str, box: Sequence[Sequence[int]]) -> bool:
        return all(level in admitted for admitted, level in zip(box, levels[key], strict=True))

    for mutant in told["mutants"]:
        counts = counted[mutant["id"]]
        on = {key for key, count in counts.items() if mutant["verdict"] == "detected" and count.most}
        off = {key for key, count in counts.items() if count.flown and (count.tests or not count.infected)} - on
        patterns = [term["levels"] for term in mutant["terms"]]
        assert on <= {key for key in levels if any(inside(key, pattern) for pattern in patterns)}
        assert not any(inside(key, pattern) for key in off for pattern in patterns)
        fitting = [box for box in boxes if not any(inside(key, box) for key in off)]
        fewest = next(
            size
            for size in range(len(patterns) + 1)
            for chosen in combinations(fitting, size)
            if all(any(inside(key, box) for box in chosen) for key in on)
        )
        assert len(patterns) == fewest
        # the condition in words is that of the terms; of a mutant without a kill it says where a violation was seen
        if on:
            assert mutant["condition"].count(" or ") + 1 == len(patterns)
        assert all(term["words"] in mutant["condition"] or term["words"] == "everywhere" for term in mutant["terms"])


def edges(space: Space, *boxes: Sequence[Sequence[int]]) -> tuple[int, int]:
    """Horizontal and vertical pieces of the outlines that the page's script draws around some boxes."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    script = f"""
        const DATA = {{ karnaugh: {json.dumps(folding(space))} }};
        const s = (name, properties, ...children) => ({{ name, properties, children: children.flat(Infinity) }});
        {asset("karnaugh.js")}
        const terms = {json.dumps([{"levels": box} for box in boxes])};
        const drawn = outlines(terms).children.filter((one) => "data-term" in one.properties);
        console.log(drawn.map((one) => one.properties.d).join(""));
    """
    drawn = subprocess.run([node, "-e", script], capture_output=True, text=True, check=True).stdout
    return drawn.count("H"), drawn.count("V")


ANY, TWO = [0, 1], grid(2, 2, 2, 2, 2)


def test_an_outline_is_open_where_its_term_goes_on_at_the_opposite_edge():
    # the fourth axis at 0: columns 0, 1 and 6, 7 of all four rows, one block across the edge
    assert edges(TWO, [ANY, ANY, ANY, [0], ANY]) == (2 * 4, 2 * 4)
    assert edges(TWO, [ANY, ANY, ANY, [1], ANY]) == (2 * 4, 2 * 4)
    assert edges(TWO, [ANY] * 5) == (2 * 8, 2 * 4)
    # with the fifth axis at 1: two blocks of one column each
    assert edges(TWO, [ANY, ANY, ANY, [0], [1]]) == (2 * 2, 4 * 4)


def test_where_opposite_edges_are_no_neighbours_every_outline_is_shut():
    # columns 0, 1 and 4, 5 of 6: the last differs from the first on two axes
    assert edges(grid(3, 3, 2), [[0, 1, 2], [0, 2], ANY]) == (2 * 4, 4 * 3)


def test_terms_of_axes_with_more_values_name_all_levels_that_they_admit():
    space = grid(3, 2)
    killing = ("A0B0", "A0B1", "A1B0", "A1B1")
    entries = tuple(KillEntry("X-x", key, kills=("R",) if key in killing else (), tested=True) for key in space.point)
    row = KillRow(Subject("X-x"), "mutant", True, Status.REVEALED, Verdict.DETECTED, Ratio(4, 6), entries)
    (term,) = terms(space, row)
    assert term["levels"] == [[0, 1], [0, 1]]


def test_a_large_campaign_lists_whole_pairs_of_the_lowest_seeds_and_always_the_first():
    flights = [outcome(mutant, key, seed) for mutant in ("baseline", LATE) for key in "ab" for seed in (0, 1)]
    assert listed(flights) == {("a", 0), ("b", 0), ("a", 1), ("b", 1)}
    assert listed(flights, most=5) == {("a", 0), ("b", 0)}
    assert listed(flights, most=1) == {("a", 0)}
    assert listed([]) == frozenset()
