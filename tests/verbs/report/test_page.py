"""The page is one inert file made at one moment: no markup from the study, nothing fetched, not too large."""

from __future__ import annotations

import base64
import hashlib
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from papers import HOSTILE, MUTANTS, campaign, evidence_of, jitter
from reading import embedded

from scaloft_fi.campaign.runs.run import remember_seeds
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.console import all_printable, printable
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence, gather
from scaloft_fi.verbs.report.flights import DETAILS
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
def test_inert_json_holds_no_markup_and_comes_back(values: object) -> None:
    import json

    text = inert(values)
    assert not set("<>&") & set(text)
    assert json.loads(text) == all_printable(values)


def test_hostile_names_change_no_element_of_the_page(text: str, hostile_text: str) -> None:
    assert tags(hostile_text) == tags(text)


def test_hostile_names_are_in_the_figures_as_printable_texts(hostile: Evidence, hostile_text: str) -> None:
    told = embedded(hostile_text, "figures")
    assert told["campaign"] == printable(HOSTILE[0])
    assert told["study"] == hostile.study.folder.name
    assert [parameter["title"] for parameter in told["parameters"]][: len(HOSTILE)] == all_printable(HOSTILE)
    assert [axis["title"] for axis in told["axes"]] == all_printable(HOSTILE[:5])
    assert told["fingerprint"] == all_printable({HOSTILE[1]: HOSTILE[2]})


def test_the_policy_admits_this_style_and_this_script_and_nothing_else(text: str) -> None:
    policy = next(entry["content"] for tag, entry in tags(text) if entry.get("http-equiv") == "Content-Security-Policy")
    assert policy is not None
    style = re.search(r"<style>(.*?)</style>", text, re.DOTALL)
    script = re.search(r"<script>(.*?)</script>", text, re.DOTALL)
    assert style
    assert script
    for name, part in (("style-src", style[1]), ("script-src", script[1])):
        digest = base64.b64encode(hashlib.sha256(part.encode()).digest()).decode()
        assert f"{name} 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none';")
    assert "unsafe" not in policy


def test_nothing_in_the_page_names_another_file(text: str) -> None:
    linked = [
        (tag, name, value) for tag, entry in tags(text) for name, value in entry.items() if name in ("src", "href")
    ]
    assert linked == [("link", "href", "data:,"), ("a", "href", "#main")]
    addresses = set(re.findall(r"https?://[^\s\"'`)]+", text.replace("\\/", "/")))
    assert addresses == {"http://www.w3.org/2000/svg"}
    assert not re.search(r"@import|url\(|\binnerHTML\b|\beval\(|\bfetch\(", text)


def test_every_asset_is_part_of_the_page() -> None:
    from importlib.resources import files

    names = {entry.name for entry in files("scaloft_fi.verbs.report").joinpath("assets").iterdir()}
    assert names == {*STYLES, *SCRIPTS, "page.html"}


def test_a_page_that_would_be_too_large_keeps_less_of_the_tracks_and_says_so(study: Study) -> None:
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
def test_figures_are_never_dropped(evidence: Evidence, bound: int) -> None:
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


def test_all_of_the_campaign_is_there(study: Study, folder: str) -> None:
    evidence = gather(study, folder)
    flown = sorted(campaign(study, (MUTANT,), range(1), range(1)), key=lambda o: o.name)
    assert sorted(evidence.outcomes, key=lambda o: o.name) == flown
    assert evidence.spending.grown == {MUTANT}
    assert evidence.fingerprint == {"system": "Paper"}
    assert (evidence.stale.sentences, evidence.owed) == ((), 0)


def test_it_is_read_at_one_moment(study: Study, folder: str, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_a_campaign_without_flights_is_one_sentence(study: Study, tmp_path: Path) -> None:
    with Store(tmp_path / STORE_NAME):
        pass
    with pytest.raises(InputError, match="nothing to show"):
        gather(study, f"{tmp_path}/")
