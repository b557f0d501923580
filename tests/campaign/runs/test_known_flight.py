"""The known flight of `doctor` is a published one."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from paper_flyer import Whole

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.runs.gates import fly_again, packaged_study, published
from scaloft_fi.campaign.store.origin import DECIDES, fingerprint
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

RESULTS = Path(__file__).parents[3] / "results" / "published"


@dataclass
class Recorded(Whole):
    """A flyer with one outcome."""

    outcome: Outcome

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        return replace(self.outcome, subject=flight.subject, situation=flight.situation.key, seed=flight.seed)


def _fly(monkeypatch: pytest.MonkeyPatch, platform: dict[str, str], **changes: Any) -> str:
    known = published()
    monkeypatch.setattr("scaloft_fi.campaign.runs.gates.fingerprint", lambda: platform)
    study = packaged_study()
    mutant, situation, seed = known.name.split("/")
    assert mutant == "baseline"
    subject = Flight(None, study.grid.situation(situation), int(seed)).subject
    outcome = Outcome(subject, situation, int(seed), ending="landed", digest=known.digest)
    return fly_again(lambda _text: None, Recorded(replace(outcome, **changes)))


def test_the_known_flight_is_the_published_one() -> None:
    known = published()
    with (RESULTS / "paper.csv").open(encoding="utf-8") as file:
        row = next(
            row for row in csv.DictReader(file) if f"{row['mutant']}/{row['situation']}/{row['seed']}" == known.name
        )
    assert (row["digest"], row["status"], row["ending"]) == (known.digest, known.facts.status, known.facts.ending)
    assert tuple(row["violated"].split()) == known.facts.violated


def test_its_platform_is_that_of_the_published_campaign_with_the_kernels_that_reproduce_it() -> None:
    platform = json.loads((RESULTS / "reference" / "campaign.json").read_text(encoding="utf-8"))["platform"]
    kernels = {f"{package} kernels": "SkylakeX" for package in ("numpy", "scipy")}
    named = {name: value for name, value in platform.items() if name in DECIDES}
    assert published().platform == {**kernels, **named}


def test_what_decides_bits_is_known_of_each_part_of_a_fingerprint() -> None:
    assert DECIDES.keys() == fingerprint().keys() == published().platform.keys()


def test_equal_digests_are_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    said = _fly(monkeypatch, {"numpy": "2"})
    assert said == "baseline/T0O0W0D0H1/0 has its published digest on this platform"


def test_other_bits_name_the_platforms_and_are_no_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    said = _fly(monkeypatch, {**published().platform, "numpy": "7"}, digest="other")
    assert "has the digest other, not a25e3a7a09ac, and the published status, ending and violations" in said
    assert "published on another platform (numpy 7 here, " in said
    assert "published on this platform" in _fly(monkeypatch, published().platform, digest="other")


def test_other_facts_are_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(GateError, match="other facts: held, struck here, held, landed published"):
        _fly(monkeypatch, {"numpy": "7"}, digest="other", ending="struck")
