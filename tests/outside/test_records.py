from __future__ import annotations

import math
import struct
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import records
from hypothesis import given
from hypothesis import strategies as st
from options import cases

from scaloft_fi.errors import InputError
from scaloft_fi.outside import records as recorded
from scaloft_fi.sim.log import Ending, FlightLog

for library in ("pymavlink.mavutil", "pymavlink.DFReader", "mcap.reader", "pyulog", "rosbags.highlevel"):
    import_module(library)  # the processes that read apart have it then

KNOWN = recorded.Known(("wall",), (0.0, 0.0))
NEEDED = {"clearance_m": "requirement SR1", "speed_mps": "requirement SR2"}
COLUMNS = ("{column: t_s}", "{column: x}", "{column: clear}")
JSON = ("{topic: /x, field: data}", "{topic: /clear, field: data}")
ROS = ("{topic: /point, field: point.x, unit: mm to m}", "{topic: /clear, field: data}")

KINDS: dict[str, tuple[Callable[[Path], Path], tuple[str, str, str]]] = {
    "csv": (records.table, COLUMNS),
    "rosbag2": (records.rosbag2, ("{clock: /clock}", *ROS)),
    "db3": (lambda folder: next(records.rosbag2(folder).glob("*.db3")), ("{clock: /clock}", *ROS)),
    "mcap": (records.ros_mcap, ("{clock: /clock}", *ROS)),
    "rosbag1": (records.rosbag1, ("", "{topic: /x, field: data}", "{topic: /clear, field: data}")),
    "ulog": (records.ulog, ("", "{topic: place, field: 'at[0]'}", "{topic: place, field: clear}")),
    "chunks": (records.mcap_of_many_chunks, ("", *JSON)),
}


def _of(kind: str, folder: Path) -> tuple[Path, Path]:
    """A record of a kind, and its mapping."""
    write, words = KINDS[kind]
    return write(folder), records.mapping(folder, *words)


def _read(path: Path, mapping: Path, needed: dict[str, str] = NEEDED) -> recorded.RecordedFlight:
    return recorded.flight_log(path, recorded.load_record_map(mapping), KNOWN, needed=needed)


def _log(path: Path, mapping: Path, needed: dict[str, str] = NEEDED) -> FlightLog:
    return _read(path, mapping, needed).log


def _drafted(folder: Path, fields: Sequence[recorded.RecordedField]) -> recorded.RecordMap:
    """The mapping that is drafted for these fields."""
    (folder / "drafted.yaml").write_text(recorded.draft(fields))
    return recorded.load_record_map(folder / "drafted.yaml")


def _table(
    tmp_path: Path, text: str, more: str = "", x: str = "{column: x}", clear: str = "{constant: 1}"
) -> FlightLog:
    path = tmp_path / "own.csv"
    path.write_text(text)
    return _log(path, records.mapping(tmp_path, "{column: t}", x, clear, more))


@pytest.mark.parametrize("kind", KINDS)
def test_a_record_of_every_kind_says_the_same(kind: str, tmp_path: Path):
    log = _log(*_of(kind, tmp_path))
    assert len(log.signals["x_m"]) == 81
    assert log.duration_s == 4.0
    held = np.repeat(records.X_M, 2)[:81]  # 10 Hz, held at 20 Hz
    np.testing.assert_allclose(log.signals["x_m"], held, atol=1e-6)
    near = np.flatnonzero(log.signals["clearance_m"] < 0.5)
    assert near.tolist() == [60, 61]
    assert set(log.signals["speed_mps"]) == {1.0}
    assert log.ending is Ending.TIMED_OUT


@pytest.mark.parametrize("kind", KINDS)
def test_a_topic_or_field_that_is_not_there_is_named_with_the_nearest(kind: str, tmp_path: Path):
    write, words = KINDS[kind]
    near = words[2].replace("clear", "claer") if "data" not in words[2] else words[2].replace("data", "dota")
    with pytest.raises(InputError, match=r"signal 'clearance_m' needs the .* did you mean"):
        _log(write(tmp_path), records.mapping(tmp_path, words[0], words[1], near))


def _cut(path: Path, share: float) -> None:
    file = path if path.is_file() else next(path.glob("*.db3"))
    content = file.read_bytes()
    file.write_bytes(content[: round(len(content) * share)])


@pytest.mark.parametrize("kind", ["rosbag2", "db3", "rosbag1"])
def test_half_a_record_that_cannot_be_read_is_refused_with_its_remedy(kind: str, tmp_path: Path):
    path, mapping = _of(kind, tmp_path)
    _cut(path, 0.5)
    with pytest.raises(InputError, match=r"the record cannot be read: .*(malformed|index)") as refused:
        _log(path, mapping)
    assert kind == "rosbag2" or "mends" in str(refused.value)


@pytest.mark.parametrize(
    ("kind", "share"), [("ulog", 0.701), ("csv", 0.7), ("chunks", 0.35), ("chunks", 0.5), ("ulog", 0.9)]
)
def test_a_record_that_is_cut_is_judged_up_to_there_and_says_when(kind: str, share: float, tmp_path: Path):
    path, mapping = _of(kind, tmp_path)
    _cut(path, share)
    flight = _read(path, mapping)
    (loss,) = flight.losses
    assert loss.kind is recorded.Lost.CUT
    assert 1.0 < loss.at_s - flight.begins_s < 4.0
    assert loss.at_s - flight.begins_s == pytest.approx(flight.log.duration_s, abs=0.05)
    assert [one.kind for one in recorded.fields_of(path)[1]] == [recorded.Lost.CUT]


@pytest.mark.parametrize("kind", KINDS)
def test_a_whole_record_lost_nothing(kind: str, tmp_path: Path):
    path, mapping = _of(kind, tmp_path)
    assert (_read(path, mapping).losses, recorded.fields_of(path)[1]) == ((), ())


@pytest.mark.parametrize("ending", ["tlog", "bin"])
@pytest.mark.parametrize("bytes_less", [0, 3, 12, 30])
def test_a_log_of_an_autopilot_says_whether_it_is_cut(ending: str, bytes_less: int, tmp_path: Path):
    path = records.tlog(tmp_path) if ending == "tlog" else records.dataflash(tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) - bytes_less])
    name = "mavlink" if ending == "tlog" else "ardupilot"
    mapping = recorded.ready_map(name, frozenset(recorded.names_of(path)))
    flight = recorded.flight_log(path, mapping, KNOWN, needed={"tilt_rad": "requirement A"})
    assert [one.kind for one in flight.losses] == ([recorded.Lost.CUT] if bytes_less else [])
    assert flight.log.duration_s == pytest.approx(2.0, abs=0.11)


def test_bytes_that_are_no_message_are_counted(tmp_path: Path):
    path = records.dataflash(tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[:-60] + b"garbage" * 3 + whole[-60:])  # a row has 30 bytes
    (loss,) = recorded.fields_of(path)[1]
    assert (loss.kind, loss.why) == (recorded.Lost.DAMAGED, "21 bytes are no message")


def test_zeros_after_the_last_message_of_a_flash_chip_are_no_cut(tmp_path: Path):
    path = records.dataflash(tmp_path)
    path.write_bytes(path.read_bytes() + bytes(400))
    assert recorded.fields_of(path)[1] == ()


def test_the_vehicles_of_a_log_of_mavlink_are_told_apart(tmp_path: Path):
    path = records.tlog(tmp_path, systems=(1, 2, 255))
    counts = {one.topic: one.messages for one in recorded.fields_of(path)[0]}
    assert counts == {"LOCAL_POSITION_NED": 42, "ATTITUDE": 42, "LOCAL_POSITION_NED@2": 21, "ATTITUDE@2": 21}


@pytest.mark.parametrize(
    ("landed", "ending", "duration_s"),
    [
        ({5: 1, 15: 1}, Ending.TIMED_OUT, 2.0),
        ({}, Ending.TIMED_OUT, 2.0),
        ({0: 0, 12: 1}, Ending.LANDED, 1.2),
        ({3: 1, 5: 0, 15: 1}, Ending.LANDED, 1.5),
        ({3: 0}, Ending.TIMED_OUT, 2.0),
    ],
)
def test_a_log_of_px4_ends_at_touch_down_and_not_where_it_first_says_landed(
    landed: dict[int, int], ending: Ending, duration_s: float, tmp_path: Path
):
    path = records.px4(tmp_path, landed)
    needed = dict.fromkeys(("z_m", "speed_mps", "tilt_rad", "home_m", "yaw_rad"), "requirement A")
    mapping = recorded.ready_map("px4", frozenset(recorded.names_of(path)))
    flight = recorded.flight_log(path, mapping, KNOWN, needed=needed)
    assert (flight.log.ending, flight.log.duration_s) == (ending, pytest.approx(duration_s, abs=0.051))
    last = {name: float(flight.log.signals[name][-1]) for name in needed}
    told = {"z_m": 3.0, "speed_mps": 0.0, "tilt_rad": 0.2, "home_m": math.hypot(2.0, 4.0), "yaw_rad": math.pi / 2}
    assert last == pytest.approx(told, abs=1e-5)


def test_drop_outs_of_a_log_of_px4_are_told_with_time_and_duration(tmp_path: Path):
    path = records.ulog(tmp_path, dropouts_ms={10: 80, 30: 7})
    flight = _read(path, records.mapping(tmp_path, *KINDS["ulog"][1]))
    told = [(one.kind, one.at_s, one.lasts_s) for one in flight.losses]
    assert told == [
        (recorded.Lost.DROPOUT, pytest.approx(2.0), 0.08),
        (recorded.Lost.DROPOUT, pytest.approx(4.0), 0.007),
    ]


def test_a_damaged_message_of_px4_is_left_out_and_told(tmp_path: Path):
    path = records.ulog(tmp_path)
    content = path.read_bytes()
    path.write_bytes(content.replace(struct.pack("<HBH", 26, ord("D"), 7), struct.pack("<HBH", 26, ord("D"), 8), 1))
    flight = _read(path, records.mapping(tmp_path, *KINDS["ulog"][1]))
    assert [one.kind for one in flight.losses] == [recorded.Lost.DAMAGED]
    assert flight.log.duration_s == pytest.approx(3.9)


def test_a_topic_that_cannot_be_read_does_not_hide_the_others(tmp_path: Path):
    path = records.mcap_of_many_chunks(tmp_path, odd="protobuf")
    fields, losses = recorded.fields_of(path)
    assert {one.name for one in fields} == {"/x: data", "/clear: data", "/odd: "}
    assert [one.kind for one in losses] == [recorded.Lost.UNREAD]
    assert "'/odd' has messages in 'protobuf'" in losses[0].why
    flight = _read(path, records.mapping(tmp_path, "", *JSON))
    assert flight.log.duration_s == 4.0
    with pytest.raises(InputError, match=r"own\.mcap: topic '/odd' has messages in 'protobuf'"):
        _log(path, records.mapping(tmp_path, "", "{topic: /odd, field: data}", JSON[1]))


def test_an_mcap_without_a_summary_is_read(tmp_path: Path):
    path = records.mcap_of_many_chunks(tmp_path, summary=False)
    flight = _read(path, records.mapping(tmp_path, "", *JSON))
    assert (flight.log.duration_s, flight.losses) == (4.0, ())


@pytest.mark.parametrize("summary", [True, False])
def test_an_mcap_of_which_a_byte_has_changed_is_refused(summary: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from mcap import writer

    plain = partial(writer.Writer, compression=writer.CompressionType.NONE)
    monkeypatch.setattr("mcap.writer.Writer", plain)
    path = records.mcap_of_many_chunks(tmp_path, summary=summary)
    before, number, after = path.read_bytes().rpartition(b'{"data": 0.3}')
    path.write_bytes(before + number.replace(b"3", b"7") + after)
    with pytest.raises(InputError, match=r"own\.mcap: the record cannot be read: bytes of it have changed"):
        _log(path, records.mapping(tmp_path, "", *JSON))
    path.write_bytes(b"")
    with pytest.raises(InputError, match=r"the record cannot be read: the file ends too early"):
        _log(path, records.mapping(tmp_path, "", *JSON))


def test_a_folder_of_rosbag2_with_files_of_mcap_is_read(tmp_path: Path):
    path = records.rosbag2(tmp_path, "MCAP")
    assert _log(path, records.mapping(tmp_path, "{clock: /clock}", *ROS)).duration_s == 4.0


def test_a_table_without_names_of_columns_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match=r"own\.csv:1: the first line must have the names .* and has the number -0\.5"):
        _table(tmp_path, "0,-0.5,1\n1,2,3\n")


def test_messages_may_have_the_time_of_their_stamps(tmp_path: Path):
    path = records.mapping(tmp_path, "{message: stamp}", ROS[0], "{constant: 1}")
    assert _log(records.rosbag2(tmp_path), path).duration_s == 4.0
    path = records.mapping(tmp_path, "{message: received}", ROS[0], "{constant: 1}")
    assert _log(tmp_path / "bag", path).duration_s == 2.0
    with pytest.raises(InputError, match="the message has no stamp"):
        _log(tmp_path / "bag", records.mapping(tmp_path, "{message: stamp}", *ROS))


def test_the_worst_value_since_the_last_sample_is_kept_where_the_mapping_says_so(tmp_path: Path):
    text = "t,x,near\n0,0,1\n0.05,0,1\n0.06,0,0.1\n0.07,0,1\n0.1,0,1\n0.15,0,1\n"
    assert min(_table(tmp_path, text, clear="{column: near}").signals["clearance_m"]) == 1.0
    least = _table(tmp_path, text, clear="{column: near, keep: least}").signals["clearance_m"]
    assert least.tolist() == [1.0, 1.0, 0.1, 1.0]


def test_the_last_message_counts_although_it_comes_between_two_samples(tmp_path: Path):
    log = _table(tmp_path, "t,x,near\n0,0,1\n0.1,0,1\n0.12,0,-0.1\n", clear="{column: near}")
    assert log.duration_s == 0.15
    assert log.ending is Ending.STRUCK


def test_the_flight_begins_and_ends_where_the_mapping_says(tmp_path: Path):
    text = "t,x,armed\n0,0,0\n1,1,1\n2,2,1\n3,3,2\n4,4,2\n"
    more = "start: {column: armed, least: 1}\nend: {column: armed, least: 2}"
    log = _table(tmp_path, text, more)
    assert (log.signals["x_m"][0], log.signals["x_m"][-1], log.duration_s) == (1.0, 3.0, 2.0)
    with pytest.raises(InputError, match="the end of the flight never comes"):
        _table(tmp_path, text, "end: {column: armed, least: 3}")


def test_a_log_without_a_position_begins_and_ends_with_its_other_signals(tmp_path: Path):
    text = "t,x,near\n0,0,\n1,1,1\n2,2,1\n3,,1\n"
    assert _table(tmp_path, text, x="{constant: 0}", clear="{column: near}").duration_s == 2.0
    with pytest.raises(InputError, match="signal 'clearance_m' has no message"):
        _table(tmp_path, "t,x,near\n0,0,\n", x="{constant: 0}", clear="{column: near}")
    with pytest.raises(InputError, match="signal 'x_m' has no message"):
        _table(tmp_path, text, x="{constant: 0}")


def test_a_log_ends_at_the_first_contact_and_names_the_surface(tmp_path: Path):
    path = tmp_path / "record.yaml"
    records.mapping(tmp_path, "{column: t}", "{column: x}", "{column: near}")
    path.write_text(path.read_text() + "  clearance_wall_m: {column: near}\n")
    (tmp_path / "own.csv").write_text("t,x,near\n0,0,1\n1,1,-1\n2,2,1\n")
    log = _log(tmp_path / "own.csv", path)
    assert (log.ending, log.struck, log.struck_at_s, log.duration_s) == (Ending.STRUCK, "wall", 1.0, 1.0)


def test_a_log_ends_at_touch_down_and_not_before_take_off(tmp_path: Path):
    path = records.mapping(tmp_path, "{column: t}", "{column: x}", "{constant: 1}")
    path.write_text(path.read_text() + "  landed: {column: down}\n")
    (tmp_path / "own.csv").write_text("t,x,down\n0,0,1\n1,1,0\n2,2,0\n3,3,1\n4,4,1\n")
    log = _log(tmp_path / "own.csv", path)
    assert (log.ending, log.duration_s) == (Ending.LANDED, 3.0)


def test_an_empty_cell_says_nothing_new_and_unknown_stands_before_the_first_value(tmp_path: Path):
    text = "t,x,near\n0,0,\n0.05,,0.5\n0.1,1,\n"
    log = _table(tmp_path, text, clear="{column: near, unknown: 9}")
    assert log.signals["clearance_m"].tolist() == [9.0, 0.5, 0.5]
    assert log.signals["x_m"].tolist() == [0.0, 0.0, 1.0]
    later = _table(tmp_path, text, clear="{column: near}")
    assert later.signals["clearance_m"].tolist() == [0.5, 0.5]
    with pytest.raises(InputError, match=r"'clearance_m' is not known at the start: .* give unknown: VALUE"):
        _table(tmp_path, text, clear="{column: near}", more="start: {column: x, least: 0}")


@cases("text", "said")
def test_a_wrong_table_is_refused_with_its_place(text: str, said: str, tmp_path: Path):
    with pytest.raises(InputError, match=r"own\.csv") as refused:
        _table(tmp_path, text)
    assert said in str(refused.value)


def test_what_a_requirement_needs_and_the_mapping_lacks_is_named_with_the_nearest_column(tmp_path: Path):
    path = records.table(tmp_path)
    mapping = records.mapping(tmp_path, *COLUMNS)
    with pytest.raises(InputError, match=r"requirement SR2 needs the signal 'clear_m', .*did you mean 'clear'"):
        _log(path, mapping, {"clear_m": "requirement SR2"})
    with pytest.raises(InputError, match="'remaining_s', which follows from the situation of the flight"):
        _log(path, mapping, {"remaining_s": "requirement OP1"})


@cases("text", "said")
def test_a_wrong_mapping_is_refused_with_its_line(text: str, said: str, tmp_path: Path):
    path = tmp_path / "record.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"record\.yaml:\d+: ") as refused:
        recorded.load_record_map(path)
    assert said in str(refused.value)


@pytest.mark.parametrize(
    "text",
    [
        "t;x;near\n0;0;1\n0,05;0,5;1\n",
        "t\tx\tnear\n0\t0\t1\n0.05\t0.5\t1\n",
        "t|x|near\n0|0|1\n0.05|0.5|1\n",
        "\ufefft,x,near\n0,0,1\n0.05,0.5,1\n",
        "# a log\n# of two lines\n\nt,x,near\n0,0,1\n# a break\n0.05,0.5,1\n",
    ],
    ids=["semicolons", "tabs", "bars", "mark of its encoding", "comments"],
)
def test_a_table_is_read_as_people_write_it(text: str, tmp_path: Path):
    assert _table(tmp_path, text).signals["x_m"].tolist() == [0.0, 0.5]


def test_a_line_after_comments_is_named_by_its_number_in_the_file(tmp_path: Path):
    with pytest.raises(InputError, match=r"own\.csv:4: signal 'x_m'"):
        _table(tmp_path, "# a log\nt,x\n# here\n0,fast\n")


def test_a_table_in_latin_1_is_read(tmp_path: Path):
    path = tmp_path / "own.csv"
    path.write_bytes("# H\xf6he\nt,x\n0,0\n1,1\n".encode("latin-1"))
    log = _log(path, records.mapping(tmp_path, "{column: t}", "{column: x}", "{constant: 1}"))
    assert log.signals["x_m"][-1] == 1.0


def _flight(tmp_path: Path, text: str, more: str = "") -> recorded.RecordedFlight:
    path = tmp_path / "own.csv"
    path.write_text(text)
    return _read(path, records.mapping(tmp_path, "{column: t}", "{column: x}", "{column: near}", more))


@pytest.mark.parametrize(
    ("text", "waits_for", "begins_s"),
    [
        ("t,x,near\n0,0,\n0.5,,1\n1,1,1\n", "clearance_m", 0.5),
        ("t,x,near\n0,,1\n0.5,0,\n1,1,1\n", "", 0.5),
        ("t,x,near\n0,0,\n0.002,,1\n1.002,1,1\n", "clearance_m", 0.002),
        ("t,x,near\n0,,\n0.25,0,\n0.5,,1\n1,1,1\n", "clearance_m", 0.5),
    ],
    ids=["later", "the position is later", "by 2 ms", "one after the other"],
)
def test_a_flight_begins_when_every_signal_is_known_and_says_which_was_the_last(
    text: str, waits_for: str, begins_s: float, tmp_path: Path
):
    flight = _flight(tmp_path, text)
    assert (flight.waits_for, flight.begins_s) == (waits_for, begins_s)
    assert flight.log.duration_s == pytest.approx(float(text.splitlines()[-1].split(",")[0]) - begins_s)


@pytest.mark.parametrize(("more", "old"), [("", 0.9), ("gap_s: 60", 0.0), ("gap_s: 0.5", 0.99)])
def test_beyond_its_gap_a_value_is_stale_until_the_next_message(more: str, old: float, tmp_path: Path):
    flight = _flight(tmp_path, "t,x,near\n0,0,1\n10,1,1\n50,2,1\n", more)
    share = flight.stale["clearance_m"].mean()
    assert (share == 0.0) == (old == 0.0)
    assert share <= old
    gap = next(gap for gap in flight.gaps if gap.signal == "clearance_m")
    assert (gap.longest_s, gap.from_s) == (40.0, 10.0)
    assert not flight.stale["clearance_m"][-1]


@given(times=st.lists(st.integers(1, 400), min_size=1, max_size=12, unique=True), gap=st.integers(1, 200))
def test_a_sample_is_stale_exactly_where_its_last_message_is_older_than_the_gap(times: list[int], gap: int):
    series = recorded.Series(np.array([0, *sorted(times)]) / 20.0, np.zeros(len(times) + 1))
    at_s = np.arange(420) / 20.0
    stale = recorded.stale_at(recorded.MappedSignal("x"), series, gap / 20.0, at_s)
    for tick in range(420):
        assert stale[tick] == (tick - max(t for t in (0, *times) if t <= tick) > gap)


@pytest.mark.parametrize("ending", ["tlog", "bin"])
def test_what_is_no_log_of_an_autopilot_is_one_sentence(ending: str, tmp_path: Path):
    path = tmp_path / f"own.{ending}"
    path.write_bytes(b"no log at all" * 40)
    with pytest.raises(InputError, match=r"own\.\w+: .*(does not have|damaged)"):
        recorded.flight_log(path, recorded.READY["mavlink"][0], KNOWN, needed=NEEDED)


def test_a_log_of_mavlink_is_read_by_the_ready_mapping(tmp_path: Path):
    path = records.tlog(tmp_path)
    mapping = recorded.ready_map("mavlink", frozenset(recorded.names_of(path)))
    needed = dict.fromkeys(("z_m", "speed_mps", "tilt_rad", "yaw_rad"), "requirement A")
    flight = recorded.flight_log(path, mapping, KNOWN, needed=needed)
    last = {name: float(flight.log.signals[name][-1]) for name in ("x_m", "y_m", *needed)}
    told = {"x_m": 2.0, "y_m": 4.0, "z_m": 3.0, "speed_mps": 5.0, "tilt_rad": 0.1, "yaw_rad": np.pi / 2 - 0.5}
    assert last == pytest.approx(told, abs=1e-5)


@given(roll=st.floats(-1.5, 1.5), pitch=st.floats(-1.5, 1.5), yaw=st.floats(-3.1, 3.1))
def test_the_tilt_is_the_same_from_angles_and_from_the_quaternion(roll: float, pitch: float, yaw: float):
    cr, sr, cp, sp, cy, sy = (f(a / 2) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    angles = {"roll_rad": roll, "pitch_rad": pitch}
    turned = {"qx": sr * cp * cy - cr * sp * sy, "qy": cr * sp * cy + sr * cp * sy}
    tilts = [
        float(way.value({name: np.array([value]) for name, value in {**angles, **turned}.items()}, KNOWN)[0])
        for way in (recorded.DERIVED["tilt_rad"][0], recorded.DERIVED["tilt_rad"][2])
    ]
    assert tilts[0] == pytest.approx(tilts[1], abs=1e-6)


def test_only_known_endings_are_records(tmp_path: Path):
    with pytest.raises(InputError, match=r"did you mean '\.mcap'"):
        recorded.kind_of(tmp_path / "flight.mcpa")
    with pytest.raises(InputError, match=r"allowed: '\.bag'"):
        recorded.kind_of(tmp_path / "flight")


@pytest.mark.parametrize("kind", ["rosbag1", "ulog", "mcap"])
def test_a_missing_library_is_one_sentence_with_what_to_install(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path, mapping = _of(kind, tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] in ("rosbags", "pyulog", "mcap")]:
        monkeypatch.delitem(sys.modules, name)
    for name in ("rosbags", "pyulog", "mcap"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(InputError, match=r"pip install 'scaloft-fi\[records\]'"):
        _log(path, mapping)


def test_altered_samples_are_counted_from_the_record(tmp_path: Path):
    text = "t,x,hit,sent\n0,0,0,1\n1,1,0,2\n2,2,3,3\n3,3,5,9\n"
    log = _table(tmp_path, text, "altered: {column: hit}\ncarried: {column: sent}")
    (count,) = log.counts.values()
    assert (count.altered, count.carried, count.first_altered_s) == (5, 9, 2.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_record_with_too_many_messages_is_refused(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("scaloft_fi.outside.readers.MOST_MESSAGES", 20)
    with pytest.raises(InputError, match=r"must have at most .* messages or rows"):
        _log(*_of(kind, tmp_path))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "csv"])
def test_a_message_that_is_no_number_is_refused_with_its_place(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(records, "CLEAR_M", np.where(np.arange(41) == 30, np.nan, 1.0))
    with pytest.raises(InputError, match=r"(message \d+ \(/clear\)|place at 4\.0+ s): signal 'clearance_m' .* is nan"):
        _log(*_of(kind, tmp_path))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="bounds of memory are those of Linux")
@pytest.mark.parametrize("cut_bytes", [0, 40])
@pytest.mark.parametrize("kind", ["mcap-ZSTD", "mcap-LZ4", "bag-LZ4"])
def test_a_record_that_unpacks_to_too_much_is_one_sentence(
    kind: str, cut_bytes: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("scaloft_fi.document.APART_BYTES", 64 << 20)
    path = records.bomb(tmp_path, kind, 200 << 20)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - cut_bytes])
    assert len(content) < 2 << 20
    for read in (recorded.fields_of, recorded.names_of):
        with pytest.raises(InputError, match=r"it unpacks to more than \d+ MiB|the record cannot be read: .*index"):
            read(path)


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path):
    for name in ("large.csv", "large.mcap", "large.ulg", "large.bag"):
        with (tmp_path / name).open("wb") as file:
            file.truncate((1 << 30) + 1)
        with pytest.raises(InputError, match="it is larger than"):
            _log(tmp_path / name, records.mapping(tmp_path, *COLUMNS))


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_record_holds_is_told_with_number_and_times(kind: str, tmp_path: Path):
    path, mapping = _of(kind, tmp_path)
    fields = {one.name: one for one in recorded.fields_of(path)[0]}
    entry = recorded.load_record_map(mapping).signals["x_m"]
    one = fields[entry.column or f"{entry.topic}: {entry.field}"]
    assert one.messages > 20
    assert one.rate_hz == pytest.approx((one.messages - 1) / (one.last_s - one.first_s))


def test_a_drafted_mapping_is_a_mapping_and_reads_the_record(tmp_path: Path):
    path = tmp_path / "own.csv"
    path.write_text("Time_ms,X,y,z,vx,clearance\n0,0,0,1,2,3\n1000,0,0,1,2,3\n")
    drafted = _drafted(tmp_path, recorded.fields_of(path)[0])
    assert {*drafted.signals} == {"x_m", "y_m", "z_m", "vx_mps", "clearance_m"}
    assert (drafted.timing.column, drafted.timing.unit_s) == ("Time_ms", 1e-3)
    flight = recorded.flight_log(path, drafted, KNOWN, needed={"clearance_m": "requirement SR1"})
    assert flight.log.duration_s == 1.0


def test_the_draft_for_a_log_of_an_autopilot_is_its_ready_mapping(tmp_path: Path):
    path = records.tlog(tmp_path)
    ready = recorded.ready_map("mavlink", frozenset(recorded.names_of(path)))
    assert dict(_drafted(tmp_path, recorded.fields_of(path)[0]).signals) == dict(ready.signals)


def test_a_column_without_a_name_is_no_field_of_an_autopilot(tmp_path: Path):
    path = tmp_path / "own.csv"
    path.write_text(",timestamp,p_x,pos_y,position_z,v_x\n0,0,0,0,0,0\n1,10000,0,0,0,0\n2,20000,0,0,0,0\n")
    drafted = _drafted(tmp_path, recorded.fields_of(path)[0])
    assert {name: entry.column for name, entry in drafted.signals.items()} == {
        "x_m": "p_x",
        "y_m": "pos_y",
        "z_m": "position_z",
        "vx_mps": "v_x",
    }
    assert drafted.timing.unit_s == 1e-6  # 100 Hz


def _fields(*names: str) -> list[recorded.RecordedField]:
    return [recorded.RecordedField(topic, field, 9, 0.0, 1.0) for topic, field in (name.split(" ") for name in names)]


def test_position_velocity_and_attitude_are_drafted_from_the_topic_that_has_them(tmp_path: Path):
    axes = "xyz"
    fields = _fields(
        *(f"/cmd_vel {part}.{axis}" for part in ("linear", "angular") for axis in axes),
        *(f"/imu {part}.{axis}" for part in ("angular_velocity", "linear_acceleration") for axis in axes),
        *(f"/odom pose.pose.position.{axis}" for axis in axes),
        *(f"/odom pose.pose.orientation.{axis}" for axis in "xyzw"),
        *(f"/odom twist.twist.{part}.{axis}" for part in ("linear", "angular") for axis in axes),
    )
    drafted = _drafted(tmp_path, fields).signals
    assert {entry.topic for entry in drafted.values()} == {"/odom"}
    assert {name: entry.field for name, entry in drafted.items()} == {
        **{f"{axis}_m": f"pose.pose.position.{axis}" for axis in axes},
        **{f"v{axis}_mps": f"twist.twist.linear.{axis}" for axis in axes},
        **{f"q{axis}": f"pose.pose.orientation.{axis}" for axis in "xyzw"},
    }


def test_a_drafted_mapping_is_yaml_whatever_the_names_of_the_columns(tmp_path: Path):
    path = tmp_path / "own.csv"
    path.write_text('t;own "x;back\\slash y;z\n0;1;2;3\n')
    drafted = _drafted(tmp_path, recorded.fields_of(path)[0])
    assert {name: entry.column for name, entry in drafted.signals.items()} == {"y_m": "back\\slash y", "z_m": "z"}


def test_a_drafted_mapping_has_every_field_that_has_the_name_of_a_signal():
    signals = ("elapsed_s", "x_m", "clearance_person_m", "person_sight_m", "speed_mps")
    fields = _fields(*(f" {name}" for name in ("elapsed_s", "x", "clearance_person_m", "person_sight", "speed_mps")))
    lines = recorded.draft(fields, signals).splitlines()
    assert [line.strip() for line in lines if "#" not in line] == [
        'time: {column: "elapsed_s", unit: s}',
        "signals:",
        'x_m: {column: "x"}',
        'clearance_person_m: {column: "clearance_person_m"}',
        'speed_mps: {column: "speed_mps"}',
    ]


@pytest.mark.parametrize(("step", "unit"), [(0.02, "s"), (1.0, "s"), (20, "ms"), (4000, "us"), (1e7, "ns")])
def test_the_unit_of_a_time_is_guessed_from_its_steps(step: float, unit: str, tmp_path: Path):
    path = tmp_path / "own.csv"
    path.write_text("t,x\n" + "".join(f"{step * row},0\n" for row in range(9)))
    assert f'time: {{column: "t", unit: {unit}}}' in recorded.draft(recorded.fields_of(path)[0])


def test_a_table_of_200_000_columns_is_read(tmp_path: Path):
    count = 200_000
    path = tmp_path / "wide.csv"
    path.write_text(",".join(f"c{place}" for place in range(count)) + "\n" + ",".join(["1"] * count) + "\n")
    assert len(recorded.names_of(path)) == count
