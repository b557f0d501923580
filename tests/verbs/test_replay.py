"""`replay` and `judge`: a flight beside its record, records of others, the file for players of logs."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import records
from click.testing import Result
from mcap.reader import make_reader
from options import cases
from printed import STUDY, Call, invoked, no_terms, of_form, told_by
from studies import copied

from scaloft_fi.campaign.flights.command import judged_record, known_of, mapping_of
from scaloft_fi.campaign.flights.fly import Flight, fly_log, judged
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.sim.log import NEVER_S, Ending, Event, FlightLog
from scaloft_fi.study import Study
from scaloft_fi.verbs.replay import REPLAY, Comparison, Likeness, LoggedFlight, Replayed, comparison, log_table, mcap
from scaloft_fi.views.table import Format, render

LOG = FlightLog({"elapsed_s": np.array([0.0, 40.0])}, Ending.LANDED, "", NEVER_S, "", {}, 60.0)


def test_a_window_needs_a_display(call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    result = call("replay", "baseline/T0O0W0D0H1/0", "--gui")
    assert result.exit_code == 2
    assert "--gui needs a display" in result.stderr


def test_a_requirement_that_the_flight_did_not_put_to_the_test_has_no_robustness():
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


def test_json_has_the_facts_and_how_the_flight_compares():
    study = Study.open(STUDY)
    flight = flight_named(study, "baseline", "T0O0W0D0H0", 0)
    readings = (Reading("SR2", Kind.SAFETY, 24.0, None, 0, open=False),)
    flown = Outcome(flight.subject, "T0O0W0D0H0", 0, ending="landed", readings=readings, digest="abc")
    found = Comparison(Likeness.SAME_BITS, "bit for bit the flight in there")
    told = of_form("replay", REPLAY.json(Replayed(LoggedFlight(study, flight, LOG, flown), found, None)))
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


def test_equal_digests_are_the_same_flight_on_every_platform(replayed: _Replayed):
    for numpy in ("1", "2"):
        assert replayed.compared(numpy, replayed.outcome, same_platform=True).startswith("bit for bit the flight in")


def test_other_bits_on_the_same_platform_fail_the_gate(replayed: _Replayed):
    with pytest.raises(GateError, match="flown on the same platform: digest fault there"):
        replayed.compared("1", replace(replayed.outcome, digest="other"))


def test_other_bits_on_another_platform_are_told_and_fail_the_strict_rule_only(replayed: _Replayed):
    other = replace(replayed.outcome, digest="other")
    said = replayed.compared("2", other)
    assert "flown on another platform (numpy 2 here, 1 there), and the same status, ending and violations" in said
    with pytest.raises(GateError, match=r"flown on another platform \(numpy 2 here, 1 there\): digest fault there"):
        replayed.compared("2", other, same_platform=True)


def test_another_status_beside_the_baseline_of_the_own_platform_is_named(replayed: _Replayed):
    """The flight is masked here, because it equals the baseline of this platform."""
    with pytest.raises(GateError, match=r"differs in more than bits .*\(masked, landed here, survived, landed there\)"):
        replayed.compared("2", replace(replayed.outcome, digest="clean 2"))


def test_replay_of_a_stack_that_is_not_deterministic_says_what_it_cannot_do_and_shows_the_record(
    replayed: _Replayed, monkeypatch: pytest.MonkeyPatch
):
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


def test_a_reader_of_mcap_gets_back_pose_signals_and_events_in_the_order_of_time():
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


def test_the_file_says_which_flight_it_is():
    reader = make_reader(io.BytesIO(mcap(log(), "LATE-human@3s/T0/0")))
    (about,) = reader.iter_metadata()
    assert about.metadata == {"name": "LATE-human@3s/T0/0", "digest": log().digest, "ending": "struck"}


FLIGHTS = ("LATE-human@3s/T0O0W0D0H1/0", "REVERSE-velcmd/T0O0W0D0H0/0")
COLUMNS = (
    *("elapsed_s", "remaining_s", "x_m", "y_m", "z_m", "speed_mps", "clearance_m", "person_sight_m"),
    *("clearance_person_m", "told_person", "told_range_m", "waypoints_left", "landed"),
)


def judge(*words: str | Path, study: Path = STUDY) -> Result:
    return invoked("judge", *words, "--study", str(study))


def a_record(folder: Path, **last: float) -> Path:
    """Two seconds of hovering far from everything, with these values in the last sample."""
    benign = dict.fromkeys(COLUMNS, 0.0) | dict.fromkeys(("clearance_m", "clearance_person_m"), 1.0)
    benign |= {"remaining_s": 50.0, "person_sight_m": 100.0, "waypoints_left": 2.0}
    rows = [benign | {"elapsed_s": i / 20.0} for i in range(41)]
    rows[-1] |= last
    path = folder / "flight.csv"
    path.write_text("\n".join([",".join(COLUMNS), *(",".join(str(row[name]) for name in COLUMNS) for row in rows)]))
    return path


def test_a_violation_is_a_finding_with_time_and_place_and_the_exit_code_is_0(tmp_path: Path):
    done = told_by(judge(a_record(tmp_path, clearance_m=-0.001, x_m=3.5), "--format", "json"))
    rows = {row["requirement"]: row for row in of_form("judge", done)["readings"]}
    assert (rows["SR1"]["verdict"], rows["SR1"]["violated_at_s"], rows["SR1"]["x"]) == ("violated", 2.0, 3.5)
    assert (rows["SR1"]["robustness"], rows["SR2"]["verdict"], rows["SR2"]["robustness"]) == (-0.001, "open", None)


@pytest.mark.parametrize("order", ["good bad none", "bad good none", "none bad good", "bad none", "bad good folder"])
def test_of_many_records_every_verdict_is_told_before_the_errors(order: str, tmp_path: Path):
    good = a_record(tmp_path)
    places = {"good": good, "bad": tmp_path / "bad.csv", "none": tmp_path / "none.csv", "folder": tmp_path / "folder"}
    places["bad"].write_text("elapsed_s\n")
    places["folder"].mkdir()
    done = judge(*(places[name] for name in order.split()), "--format", "json")
    told = of_form("judge", done.stdout)
    unread = [name for name in order.split() if name != "good"]
    assert done.exit_code == 2
    assert [Path(one["file"]).stem for one in told["unread"]] == unread
    assert {Path(one["file"]) for one in told["readings"]} == ({good} if "good" in order else set())
    assert [line.partition(":")[0] for line in done.stderr.splitlines()] == ["error"] * len(unread)


@pytest.mark.parametrize(
    ("heights_m", "more", "ending"),
    [
        ((0, 1, 2), "", None),
        ((0, 1, 0), "", None),
        ((1, 1, 1), "end: {column: t, least: 1.5}", None),
        ((0, 1, 0), "landed: {column: down}", "landed"),
    ],
    ids=["in the air", "on the ground again", "by the mapping", "landed"],
)
def test_a_record_without_a_time_limit_ends_and_is_not_at_its_limit(
    heights_m: tuple[int, ...], more: str, ending: str | None, tmp_path: Path
):
    study, mapping = copied(tmp_path / "study"), tmp_path / "own.yaml"
    columns = ", ".join(f"{name}: {{column: t}}" for name in ("x_m", "y_m", "far"))
    landed, more = (f", {more}", "") if "landed" in more else ("", more)
    signals = f"clearance_m: {{constant: 2}}, z_m: {{column: z}}, {columns}{landed}"
    mapping.write_text(f"time: {{column: t}}\nsignals: {{{signals}}}\n{more}")
    (study / "sim" / "requirements.yaml").write_text(
        "requirements: {A: {kind: safety, formula: always(far < 6 and clearance_m > 1.5)}}"
    )
    rows = [f"{t_s},{z_m},{int(t_s != 1)}" for t_s, z_m in enumerate(heights_m)]
    (tmp_path / "own.csv").write_text("\n".join(["t,z,down", *rows]) + "\n")
    done = judge(tmp_path / "own.csv", "--record", mapping, "--format", "json", study=study)
    told = of_form("judge", done.stdout)
    assert (told["records"][0]["ending"], told["readings"][0]["verdict"]) == (ending, "held")


@cases("formula", "verdict", "robustness")
def test_a_requirement_takes_any_signal_of_a_record_as_far_as_it_was_measured(
    formula: str, verdict: str, robustness: float, tmp_path: Path
):
    study, mapping = copied(tmp_path / "study"), tmp_path / "own.yaml"
    columns = {"x_m": "x", "wind": "wind", "roll_rad": "roll", "clearance_m": "near", "person_sight_m": "sight"}
    more = "y_m: {constant: 0}, z_m: {constant: 2}, pitch_rad: {constant: 0}, clearance_person_m: {column: near}"
    entries = ", ".join(f"{name}: {{column: {column}}}" for name, column in columns.items())
    mapping.write_text(f"time: {{column: t}}\nsignals: {{{entries}, {more}}}")
    (study / "sim" / "requirements.yaml").write_text(f"requirements: {{A: {{kind: safety, formula: {formula}}}}}")
    (tmp_path / "own.csv").write_text("t,x,wind,roll,near,sight\n0,0,4,0,4,300\n1,3,7,0.4,2,400\n2,3,4,0,4,300\n")
    done = judge(tmp_path / "own.csv", "--record", mapping, "--format", "json", study=study)
    (reading,) = of_form("judge", done.stdout)["readings"]
    assert (reading["verdict"], reading["robustness"]) == (verdict, pytest.approx(robustness))


@pytest.mark.parametrize("formula", ["always(tilt_rad < 1)", "always(speed_mps < 1)", "always(yaw_rad < 1)"])
def test_a_signal_that_does_not_follow_from_the_record_is_named_with_what_it_follows_from(formula: str, tmp_path: Path):
    study, mapping = copied(tmp_path / "study"), tmp_path / "own.yaml"
    mapping.write_text("time: {column: t}\nsignals: {x_m: {column: t}, y_m: {column: t}, z_m: {column: t}}")
    (study / "sim" / "requirements.yaml").write_text(f"requirements: {{A: {{kind: safety, formula: {formula}}}}}")
    (tmp_path / "own.csv").write_text("t\n0\n1\n")
    done = judge(tmp_path / "own.csv", "--record", mapping, study=study)
    name = formula[7:].partition(" ")[0]
    assert f"requirement A needs the signal '{name}', and {mapping} maps neither signal '{name}' nor " in done.stderr


def test_what_breaks_a_requirement_between_samples_is_told(tmp_path: Path):
    study, mapping = copied(tmp_path / "study"), tmp_path / "own.yaml"
    mapping.write_text("time: {column: t}\nsignals: {x_m: {column: x}, y_m: {column: x}, z_m: {column: x}}")
    (study / "sim" / "requirements.yaml").write_text("requirements: {A: {kind: safety, formula: always(x_m < 2)}}")
    for peak, between_s in ((3, 0.15), (1, None)):
        (tmp_path / "own.csv").write_text(f"t,x\n0,1\n0.11,1\n0.12,{peak}\n0.13,1\n1,1\n")
        done = judge(tmp_path / "own.csv", "--record", mapping, "--format", "json", study=study)
        (reading,) = of_form("judge", done.stdout)["readings"]
        assert (reading["verdict"], reading["between_s"]) == ("held", between_s)


def test_what_a_record_lost_is_told_at_the_times_of_its_flight(tmp_path: Path):
    study, mapping = (
        copied(tmp_path / "study"),
        records.mapping(tmp_path, "", "{topic: place, field: 'at[0]'}", "{constant: 1}"),
    )
    (study / "sim" / "requirements.yaml").write_text("requirements: {A: {kind: safety, formula: always(x_m < 20)}}")
    path = records.ulog(tmp_path, {place: place for place in range(10, 20)})
    path.write_bytes(path.read_bytes()[:-40])
    noted = " ".join(judge(path, "--record", mapping, study=study).stdout.split())
    assert "drop-outs of its writer: 10, 0.145 s in all: the longest 0.019 s at 1.90 s, 0.018 s at 1.80 s," in noted
    assert "the record is cut; its last message is at 3.80 s: the file ends in the middle of a message" in noted
    told = of_form("judge", judge(path, "--record", mapping, "--format", "json", study=study).stdout)
    assert [(one["kind"], one["at_s"], one["lasts_s"]) for one in told["losses"][-2:]] == [
        ("drop-out", 2.9, 0.019),
        ("cut", 4.8, None),
    ]
    held = " ".join(judge(path, "--fields", study=study).stdout.split())
    assert "its last message is at 4.80 s of the record" in held


def test_the_drafted_mapping_of_our_own_record_gives_the_same_verdicts(tmp_path: Path):
    path, mapping = a_record(tmp_path, clearance_person_m=-0.1), tmp_path / "drafted.yaml"
    mapping.write_text(of_form("judge", judge(path, "--fields", "--format", "json").stdout)["mappings"][0])
    assert "clearance_person_m: {" in mapping.read_text()
    own, drafted = (
        of_form("judge", judge(path, *words, "--format", "json").stdout)["readings"]
        for words in ((), ("--record", mapping))
    )
    assert drafted == own


def test_a_ready_mapping_is_named_with_the_nearest(tmp_path: Path):
    done = judge(a_record(tmp_path), "--record", "px5")
    assert done.exit_code == 2
    assert "--record='px5' must be a file or a ready mapping; did you mean 'px4'" in done.stderr


def test_a_requirement_whose_condition_never_comes_true_is_vacuous(tmp_path: Path):
    readings = of_form("judge", judge(a_record(tmp_path), "--format", "json").stdout)["readings"]
    verdicts = {one["requirement"]: one["verdict"] for one in readings}
    assert (verdicts["SR1"], verdicts["SR2"]) == ("held", "vacuous")


def test_a_situation_gives_route_and_time_limit_to_a_record_without_them(tmp_path: Path):
    record = a_record(tmp_path)
    mapping = tmp_path / "own.yaml"
    names = [name for name in COLUMNS if name not in ("elapsed_s", "remaining_s", "waypoints_left")]
    entries = [f"  {name}: {{column: {name}}}" for name in names]
    mapping.write_text("\n".join(["time: {column: elapsed_s}", "signals:", *entries]))
    refused = judge(record, "--record", mapping)
    assert refused.exit_code == 2
    assert "requirement OP1 needs the signal 'remaining_s'" in refused.stderr
    assert refused.stderr.count("\n") == 1
    done = judge(record, "--record", mapping, "--situation", "T0O0W0D0H0", "--format", "markdown")
    assert (done.exit_code, no_terms(done.stdout)) == (0, [])
    told = of_form("judge", judge(record, "--situation", "T0O0W0D0H0", "--format", "json").stdout)
    assert told["records"][0]["ending"] is None, "it ends long before the limit"


def test_the_study_names_the_mapping_of_its_records(tmp_path: Path, copy: Path, call: Call):
    (copy / "sim" / "record.yaml").write_text("signals: {x_mm: {column: x}}")
    done = invoked("judge", str(a_record(tmp_path)), "--study", str(copy))
    assert done.exit_code == 2
    assert "record.yaml maps no signal 'x_m'; did you mean 'x_mm'" in done.stderr


@pytest.mark.flight
@pytest.mark.parametrize("name", FLIGHTS)
def test_a_flight_of_ours_is_judged_from_its_records_as_it_is_judged_directly(name: str, tmp_path: Path):
    study = Study.open(STUDY)
    mutant, situation, seed = name.split("/")
    flight = flight_named(study, mutant, situation, int(seed))
    log = fly_log(study, flight)
    outcome = judged(study, flight, log)
    assert outcome.violations
    (tmp_path / "flight.csv").write_bytes(log_table(log))
    (tmp_path / "flight.mcap").write_bytes(mcap(log, name))
    known, mapping = known_of(study, flight.situation), mapping_of(study)
    for ending in ("csv", "mcap"):
        record = judged_record(study, tmp_path / f"flight.{ending}", mapping, known)
        assert tuple(finding.reading for finding in record.findings) == outcome.readings
        places = [finding.place for finding in record.findings if finding.place is not None]
        assert places == [(found.x, found.y, found.z) for found in outcome.violations]
        assert (record.flight.log.ending, record.flight.log.struck) == (log.ending, log.struck)
