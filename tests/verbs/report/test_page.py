"""The page and its flights: one file, inert, whole, of bounded size, where it is asked for."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
import zlib
from array import array
from collections.abc import Callable, Iterable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pages import embedded, unpacked
from papers import HOSTILE, MUTANTS, campaign, column, evidence_of, jitter
from printed import Call, told_by

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys, flight_named, remember_seeds
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, TRACK_COLUMNS, Outcome, unpack_track
from scaloft_fi.output import all_printable, printable
from scaloft_fi.sim.log import FAR_M
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence, gather
from scaloft_fi.verbs.report.flights import (
    DETAILS,
    FAR,
    Detail,
    coded,
    columns,
    packs,
    quantised,
    quantum,
    record,
    rows_of,
    shared,
    thinned,
)
from scaloft_fi.verbs.report.page import MOST_BYTES, SCRIPTS, STYLES, inert, page

json_values = st.recursive(
    st.text() | st.integers() | st.none(), lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner)
)


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def tags(text: str) -> list[tuple[str, dict[str, str | None]]]:
    parser = Tags()
    parser.feed(text)
    return parser.found


@given(json_values)
def test_inert_json_holds_no_markup_and_comes_back(values: object):
    import json

    text = inert(values)
    assert not set("<>&") & set(text)
    assert json.loads(text) == all_printable(values)


def test_hostile_names_change_no_element_of_the_page(text: str, hostile_text: str):
    assert tags(hostile_text) == tags(text)


def test_hostile_names_are_in_the_figures_as_printable_texts(hostile: Evidence, hostile_text: str):
    told = embedded(hostile_text, "figures")
    assert told["campaign"] == printable(HOSTILE[0])
    assert told["study"] == hostile.study.folder.name
    assert [parameter["title"] for parameter in told["parameters"]][: len(HOSTILE)] == all_printable(HOSTILE)
    assert [axis["title"] for axis in told["axes"]] == all_printable(HOSTILE[:5])
    assert told["fingerprint"] == all_printable({HOSTILE[1]: HOSTILE[2]})


def test_the_policy_admits_this_style_and_this_script_and_nothing_else(text: str):
    policy = next(entry["content"] for tag, entry in tags(text) if entry.get("http-equiv") == "Content-Security-Policy")
    style = re.search(r"<style>(.*?)</style>", text, re.DOTALL)
    script = re.search(r"<script>(.*?)</script>", text, re.DOTALL)
    for name, part in (("style-src", style[1]), ("script-src", script[1])):
        digest = base64.b64encode(hashlib.sha256(part.encode()).digest()).decode()
        assert f"{name} 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none';")
    assert "unsafe" not in policy


def test_nothing_in_the_page_names_another_file(text: str):
    linked = [
        (tag, name, value) for tag, entry in tags(text) for name, value in entry.items() if name in ("src", "href")
    ]
    assert linked == [("link", "href", "data:,"), ("a", "href", "#main")]
    addresses = set(re.findall(r"https?://[^\s\"'`)]+", text.replace("\\/", "/")))
    assert addresses == {"http://www.w3.org/2000/svg"}
    assert not re.search(r"@import|url\(|\binnerHTML\b|\beval\(|\bfetch\(", text)


def test_every_asset_is_part_of_the_page():
    from importlib.resources import files

    names = {entry.name for entry in files("scaloft_fi.verbs.report").joinpath("assets").iterdir()}
    assert names == {*STYLES, *SCRIPTS, "page.html"}


@pytest.mark.release
def test_a_page_that_would_be_too_large_keeps_less_of_the_tracks_and_says_so(study: Study):
    outcomes = [
        jitter(o, seed)
        for seed in range(3)
        for o in campaign(study, MUTANTS, range(1), range(1))
        if o.mutant != "PLACEBO"
    ]
    large = evidence_of(study, outcomes)
    whole = page(large)
    assert str(DETAILS[0]) in embedded(whole, "figures")["detail"]
    least = len(page(large, 1))
    bound = (len(whole) + least) // 2
    small = page(large, bound)
    assert len(small.encode()) <= bound
    assert any(str(detail) in embedded(small, "figures")["detail"] for detail in DETAILS[1:])
    assert MOST_BYTES == 5_000_000


@pytest.mark.parametrize("bound", [1])
def test_figures_are_never_dropped(evidence: Evidence, bound: int):
    told = embedded(page(evidence, bound), "figures")
    assert "Every flight of the unmutated drone with seeds 0-9" in told["detail"]
    assert len(told["mutants"]) == len(MUTANTS)


MUTANT = "LATE-human@3s"


@pytest.fixture
def folder(study: Study, tmp_path: Path) -> str:
    """A campaign that asked for more seeds later."""
    keys = Keys(study)
    with Store(tmp_path / STORE_NAME) as store:
        for outcome in campaign(study, (MUTANT,), range(1), range(1)):
            store.put(keys.key(flight_named(study, outcome.mutant, outcome.situation, outcome.seed)), outcome)
        for seeds in (range(1), range(3)):
            remember_seeds(store, [MUTANT], seeds)
        store.set_meta({"system": "Paper"})
    return f"{tmp_path}/"


def test_all_of_the_campaign_is_there(study: Study, folder: str):
    evidence = gather(study, folder)
    flown = sorted(campaign(study, (MUTANT,), range(1), range(1)), key=lambda o: o.name)
    assert sorted(evidence.outcomes, key=lambda o: o.name) == flown
    assert evidence.spending.grown == {MUTANT}
    assert evidence.fingerprint == {"system": "Paper"}
    assert (evidence.stale.sentences, evidence.owed) == ((), 0)


def test_it_is_read_at_one_moment(study: Study, folder: str, monkeypatch: pytest.MonkeyPatch):
    opened, plain = [], Store.meta
    (late, *_) = campaign(study, (), range(1), range(1))

    def interrupted(store: Store) -> dict[str, str]:
        opened.append(store)
        with Store(store.path) as other:
            other.put("another", replace(late, seed=7))
        assert "another" not in {flight.key for flight in store.flights()}
        return plain(store)

    monkeypatch.setattr(Store, "meta", interrupted)
    gather(study, folder)
    assert len(opened) == 1


def test_a_campaign_without_flights_is_one_sentence(study: Study, tmp_path: Path):
    with Store(tmp_path / STORE_NAME):
        pass
    with pytest.raises(InputError, match="nothing to show"):
        gather(study, f"{tmp_path}/")


NAMES = ("SR1", "SR2", "SR2-literal", "OP1")


def _read(evidence: Evidence, detail: Detail) -> dict[str, list[dict[str, object]]]:
    quanta = [entry["quantum"] for entry in columns(detail)]
    return {key: unpacked(pack, quanta) for key, pack in packs(evidence.outcomes, NAMES, detail).texts.items()}


def test_every_flight_but_placebo_is_there_once(evidence: Evidence):
    found = [(f["mutant"], key, f["seed"]) for key, flights in _read(evidence, DETAILS[0]).items() for f in flights]
    assert sorted(found) == sorted((o.mutant, o.situation, o.seed) for o in evidence.outcomes if o.mutant != PLACEBO_ID)


def test_a_track_of_the_page_is_the_flights_to_half_a_step(evidence: Evidence):
    read = _read(evidence, DETAILS[0])
    for outcome in evidence.outcomes[::7]:
        if outcome.mutant == PLACEBO_ID or not outcome.track:
            continue
        (flight,) = (f for f in read[outcome.situation] if (f["mutant"], f["seed"]) == (outcome.mutant, outcome.seed))
        rows = unpack_track(outcome.track)
        assert len(flight["rows"]) == len(rows)  # type: ignore[arg-type]
        for ours, theirs in zip(flight["rows"], rows, strict=True):  # type: ignore[call-overload]
            assert ours[0] == pytest.approx(theirs[0], abs=0.026)
            assert ours[column("x_m")] == pytest.approx(theirs[column("x_m")], abs=0.0051)
            assert ours[column("speed_mps")] == pytest.approx(theirs[column("speed_mps")], abs=0.0051)


def test_flights_that_equal_their_baseline_share_its_track(evidence: Evidence):
    for flights in _read(evidence, DETAILS[0]).values():
        clean = {f["seed"]: f["track"] for f in flights if f["mutant"] == BASELINE}
        same = [f for f in flights if f["mutant"] == "NO-depth@3s"]
        assert same
        assert all(f["track"] == clean[f["seed"]] for f in same)


@pytest.mark.release
@pytest.mark.parametrize("detail", DETAILS)
def test_less_detail_leaves_every_flight_and_every_baselines_track(evidence: Evidence, detail: Detail):
    for flights in _read(evidence, detail).values():
        for flight in flights:
            if flight["mutant"] == BASELINE:
                assert flight["rows"] is not None
            elif detail.seeds == 1 and flight["seed"] == 1 and flight["mutant"] == "LESS-goal@0.05m":
                assert flight["rows"] is None


def test_the_page_says_of_which_flights_it_has_tracks(evidence: Evidence):
    def says(outcomes: Iterable[Outcome], detail: Detail = DETAILS[0]) -> str:
        return packs(outcomes, NAMES, detail).says

    def only(kept: Callable[[Outcome], bool]) -> list[Outcome]:
        # a digest of its own, as the page shares tracks of equal flights
        own = [replace(o, digest=o.name) for o in evidence.outcomes]
        return [o if kept(o) else replace(o, track=b"") for o in own]

    assert says(evidence.outcomes) == "Tracks: every flight, 5 Hz, in steps of 0.01 m and 0.01 m/s."
    assert says(only(lambda _: False)) == "Tracks: of no flight; `replay` flies each again."
    published = says(only(lambda o: o.seed < (5 if o.mutant == BASELINE else 1)))
    counts, every, none, *_ = published.split(".  ")
    valid = [o for o in evidence.outcomes if o.mutant != PLACEBO_ID and not o.invalid]
    with_track = sum(o.seed < (5 if o.mutant == BASELINE else 1) for o in valid)
    assert counts == f"Tracks: {with_track} of {len(valid)} flights, 5 Hz, in steps of 0.01 m and 0.01 m/s"
    assert every == "Every flight of the unmutated drone with seeds 0-4, mutants with seed 0"
    assert none == "None of the unmutated drone with seeds 5-9, mutants with seeds 1-2"
    part = says(only(lambda o: o.situation.endswith("H1")), DETAILS[3])
    assert "Some of the unmutated drone with seeds 0-9, mutants with seed 0" in part
    assert "None of mutants with seeds 1-2" in part


def test_a_flight_that_failed_says_why_and_has_no_track(evidence: Evidence):
    broken = [f for flights in _read(evidence, DETAILS[0]).values() for f in flights if f["invalid"]]
    assert [(f["status"], f["invalid"], f["rows"]) for f in broken] == [("invalid", "the worker died", None)]


def test_a_track_with_other_columns_is_no_track(evidence: Evidence):
    rows = unpack_track(evidence.outcomes[0].track)
    values = array("f", [value for row in rows for value in row[:5]])
    assert rows_of(evidence.outcomes[0].track) == rows
    for damaged in (values, values[:-1]):
        with pytest.raises(ValueError, match="damaged"):
            rows_of(zlib.compress(damaged.tobytes()))


def test_a_reading_that_tests_nothing_has_no_robustness(evidence: Evidence):
    flown = next(outcome for outcome in evidence.outcomes if outcome.mutant == BASELINE and not outcome.struck)
    idle = replace(flown, readings=tuple(replace(r, rho=24.0, triggered=0) for r in flown.readings[:1]))
    told = record(idle, None, NAMES)["readings"]
    assert told == [[None, None, "vacuous", 0], None, None, None]


values = st.floats(-150, 150, width=32)
rows = st.lists(st.tuples(*[values] * len(TRACK_COLUMNS)), min_size=1, max_size=12)
wholes = st.lists(st.tuples(*[st.integers(-FAR, FAR)] * 3), min_size=1, max_size=12)


@given(rows, st.integers(1, 3))
def test_a_value_comes_back_to_half_a_quantum_or_as_nothing_to_measure(track: list[tuple[float, ...]], coarse: int):
    for row, whole in zip(track, quantised(track, TRACK_COLUMNS, coarse).tolist(), strict=True):
        for name, value, number in zip(TRACK_COLUMNS, row, whole, strict=True):
            if name in ("clearance_m", "person_sight_m") and value >= FAR_M:
                assert number == FAR
            else:
                assert abs(number * quantum(name, coarse) - value) <= quantum(name, coarse) / 2 + 1e-9


def test_what_is_no_number_is_nothing_to_measure():
    assert quantised([(math.nan,), (math.inf,)], ("speed_mps",)).tolist() == [[FAR], [FAR]]


@given(wholes, st.data())
def test_two_planes_of_bytes_hold_the_rows_after_the_shared_ones(track: list[tuple[int, ...]], data: st.DataObject):
    whole = np.array(track, dtype=np.int32)
    same = data.draw(st.integers(0, len(track)))
    code = coded(whole, same)
    own = len(track) - same
    assert len(code) == 2 * 3 * own
    back = []
    for place in range(3):
        value = track[same - 1][place] if same else 0
        for row in range(own):
            low, high = code[place * own + row], code[3 * own + place * own + row]
            word = low + 256 * high
            value = (value + (word >> 1 ^ -(word & 1)) + 32768) % 65536 - 32768
            back.append((row, place, value))
    assert back == [(row, column, track[same + row][column]) for column in range(3) for row in range(own)]


@given(wholes, wholes)
def test_shared_counts_the_rows_before_the_first_that_differs(one: list[tuple[int, ...]], other: list[tuple[int, ...]]):
    common = 0
    while common < min(len(one), len(other)) and one[common] == other[common]:
        common += 1
    assert shared(np.array(one, dtype=np.int32), np.array(other, dtype=np.int32)) == common


@given(rows, st.integers(1, 5))
def test_a_thinned_track_keeps_its_ends_and_its_extremes(track: list[tuple[float, ...]], every: int):
    kept = thinned(track, every)
    assert kept[0] == track[0]
    assert kept[-1][0] == track[-1][0]
    fastest, nearest = TRACK_COLUMNS.index("speed_mps"), TRACK_COLUMNS.index("clearance_m")
    assert max(row[fastest] for row in kept) == max(row[fastest] for row in track)
    assert min(row[nearest] for row in kept) == min(row[nearest] for row in track)


def test_the_page_of_a_campaign_is_written_into_its_folder_and_says_what_score_says(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    result = told_by(call("report"))
    path = tmp_path / "campaign" / "report.html"
    assert result == f"report: {path} ({len(path.read_bytes()) / 1e6:.1f} MB)\n"
    told = embedded(path.read_text(encoding="utf-8"), "figures")
    scored = json.loads(call("score", "--format", "json").stdout)
    ratios = {ratio["name"]: ratio for ratio in told["ratios"]}
    assert scored["ratios"].pop("without_accepted") == scored["ratios"]["mutation_score"]  # nobody accepted any
    for name, ratio in scored["ratios"].items():
        assert (ratios[name]["part"], ratios[name]["whole"]) == (ratio["part"], ratio["whole"])
    assert told["pairs"] == [{**pair, "called": pair["state"]} for pair in scored["pairs"]]
    assert told["coverage"] == scored["coverage"]
    rows = json.loads(call("export").stdout)
    assert told["flights"] == len(rows)


def test_the_page_can_go_elsewhere_and_the_same_campaign_makes_the_same_bytes(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    pages = [tmp_path / "a.html", tmp_path / "b.html"]
    for path in pages:
        assert call("report", "--output", str(path)).exit_code == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_a_day_is_taken_from_the_command_line_only(call: Call, tmp_path: Path):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    path = tmp_path / "a.html"
    for words, today in (((), None), (("--today", "2027-02-01"), "2027-02-01")):
        assert call("report", "--output", str(path), *words).exit_code == 0
        assert embedded(path.read_text(encoding="utf-8"), "figures")["accepted"]["today"] == today
