"""`replay`: what it says of a flight and its record, and the file for players of logs."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import Result
from forms import of_form
from mcap.reader import make_reader
from printed import no_terms

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.sim.log import NEVER_S, Ending, Event, FlightLog
from scaloft_fi.study import Study
from scaloft_fi.verbs.replay import REPLAY, Comparison, Likeness, LoggedFlight, Replayed, comparison, mcap
from scaloft_fi.views.table import Format, render

STUDY = Path(__file__).parents[2]
LOG = FlightLog({"elapsed_s": np.array([0.0, 40.0])}, Ending.LANDED, "", NEVER_S, "", {}, 60.0)


def test_a_window_needs_a_display(call: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    result = call("replay", "baseline/T0O0W0D0H1/0", "--gui")
    assert result.exit_code == 2
    assert "--gui needs a display" in result.stderr


def test_a_requirement_that_the_flight_did_not_put_to_the_test_has_no_robustness() -> None:
    study = Study.open(STUDY)
    flight = flight_named(study, "baseline", "T0O0W0D0H0", 0)
    readings = (
        Reading("SR1", Kind.SAFETY, 0.3, None, 1, open=False),
        Reading("SR2", Kind.SAFETY, 24.0, None, 0, open=False),
    )
    flown = Outcome(flight.subject, "T0O0W0D0H0", 0, ending="landed", readings=readings)
    shown = (LoggedFlight(study, flight, LOG, flown).facts(),)
    assert no_terms(render(shown, Format.MARKDOWN)) == []
    facts = render(shown, Format.TABLE)
    said = [" ".join(line.split()) for line in facts.splitlines()]
    assert "SR1 held, robustness 0.300" in said
    assert "SR2 vacuous" in said


def test_json_has_the_facts_and_how_the_flight_compares() -> None:
    study = Study.open(STUDY)
    flight = flight_named(study, "baseline", "T0O0W0D0H0", 0)
    readings = (Reading("SR2", Kind.SAFETY, 24.0, None, 0, open=False),)
    flown = Outcome(flight.subject, "T0O0W0D0H0", 0, ending="landed", readings=readings, digest="abc")
    found = Comparison(Likeness.SAME_BITS, "bit for bit the flight in there")
    told = of_form("replay", REPLAY.json(Replayed.of(LoggedFlight(study, flight, LOG, flown), found, None)))
    assert (told["likeness"], told["infected_at_s"], told["written"]) == ("same_bits", None, None)
    assert [(one["compliance"], one["robustness"]) for one in told["readings"]] == [("vacuous", None)]


class _Replayed:
    """LATE-human@3s in T0O0W0D0H1, stored on the platform numpy 1 and flown again on another."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self._folder, self._monkeypatch = folder, monkeypatch
        self.study = Study.open(STUDY)
        self.flight = flight_named(self.study, "LATE-human@3s", "T0O0W0D0H1", 0)
        self.clean = Flight(None, self.flight.situation, 0)
        self.outcome = Outcome(self.flight.subject, "T0O0W0D0H1", 0, "landed", carried=9, altered=3, digest="fault")
        self.baseline = Outcome(self.clean.subject, "T0O0W0D0H1", 0, "landed", digest="clean")
        with Store(folder / STORE_NAME) as store:
            store.set_meta({"numpy": "1"})
            store.put(Keys(self.study).key(self.flight), self.outcome)
            store.put(Keys(self.study).key(self.clean), self.baseline)

    def compared(self, numpy: str, outcome: Outcome, *, clean: str = "clean 2", same_platform: bool = False) -> str:
        """What `replay` says of `outcome` on the platform `numpy`, whose baseline has the digest `clean`."""
        self._monkeypatch.setattr("scaloft_fi.verbs.replay.fingerprint", lambda: {"numpy": numpy})
        again = LoggedFlight(self.study, self.clean, LOG, replace(self.baseline, digest=clean))
        self._monkeypatch.setattr("scaloft_fi.verbs.replay.fly_with_log", lambda *_: again)
        flown = LoggedFlight(self.study, self.flight, LOG, outcome)
        return comparison(flown, f"{self._folder}/", same_platform=same_platform).passed()


@pytest.fixture
def replayed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> _Replayed:
    return _Replayed(tmp_path, monkeypatch)


def test_equal_digests_are_the_same_flight_on_every_platform(replayed: _Replayed) -> None:
    for numpy in ("1", "2"):
        assert replayed.compared(numpy, replayed.outcome, same_platform=True).startswith("bit for bit the flight in")


def test_other_bits_on_the_same_platform_fail_the_gate(replayed: _Replayed) -> None:
    with pytest.raises(GateError, match="flown on the same platform: digest fault there"):
        replayed.compared("1", replace(replayed.outcome, digest="other"))


def test_other_bits_on_another_platform_are_told_and_fail_the_strict_rule_only(replayed: _Replayed) -> None:
    other = replace(replayed.outcome, digest="other")
    said = replayed.compared("2", other)
    assert "flown on another platform (numpy 2 here, 1 there), and the same status, ending and violations" in said
    with pytest.raises(GateError, match=r"flown on another platform \(numpy 2 here, 1 there\): digest fault there"):
        replayed.compared("2", other, same_platform=True)


def test_another_status_beside_the_baseline_of_the_own_platform_is_named(replayed: _Replayed) -> None:
    """The flight is masked here, because it equals the baseline of this platform."""
    with pytest.raises(GateError, match=r"differs in more than bits .*\(masked, landed here, survived, landed there\)"):
        replayed.compared("2", replace(replayed.outcome, digest="clean 2"))


def test_replay_of_a_stack_that_is_not_deterministic_says_what_it_cannot_do_and_shows_the_record(
    replayed: _Replayed, monkeypatch: pytest.MonkeyPatch
) -> None:
    declared = replace(replayed.study.stack, deterministic=False)
    monkeypatch.setitem(replayed.study.__dict__, "stack", declared)
    said = replayed.compared("1", replace(replayed.outcome, digest="other"))
    assert said.startswith("the stack is not deterministic, so this is another flight than that in ")
    ending = Ending(replayed.outcome.ending).sentence
    assert f"which {ending} after {replayed.outcome.duration_s:.2f} s: " in said


NAMES = ("elapsed_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "speed_mps", "told_person")


def log() -> FlightLog:
    signals = {name: np.linspace(0.0, 1.0, 21) for name in NAMES}
    events = (Event(0.3, "person", "person reported"), Event(0.72, "contact", "struck <wall>"))
    return FlightLog(signals, Ending.STRUCK, "wall", 0.72, "", {}, 60.0, events)


def test_a_reader_of_mcap_gets_back_pose_signals_and_events_in_the_order_of_time() -> None:
    reader = make_reader(io.BytesIO(mcap(log(), "LATE-human@3s/T0/0")))
    times, by_topic = [], dict[str, list[dict[str, object]]]()
    for schema, channel, message in reader.iter_messages():
        content = json.loads(message.data)
        jsonschema.validate(content, json.loads(schema.data))
        times.append(message.log_time)
        by_topic.setdefault(channel.topic, []).append(content)
    assert times == sorted(times)
    assert {topic: len(found) for topic, found in by_topic.items()} == {
        "/path": 1,
        "/pose": 21,
        "/signals": 21,
        "/events": 2,
    }
    assert by_topic["/signals"][10] == dict.fromkeys(NAMES, 0.5)
    assert by_topic["/pose"][20]["timestamp"] == {"sec": 1, "nsec": 0}
    assert [event["message"] for event in by_topic["/events"]] == ["person reported", "struck <wall>"]
    assert [event["level"] for event in by_topic["/events"]] == [2, 3]


def test_the_file_says_which_flight_it_is() -> None:
    reader = make_reader(io.BytesIO(mcap(log(), "LATE-human@3s/T0/0")))
    (about,) = reader.iter_metadata()
    assert about.metadata == {"name": "LATE-human@3s/T0/0", "digest": log().digest, "ending": "struck"}
