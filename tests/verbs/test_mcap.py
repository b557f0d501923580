from __future__ import annotations

import io
import json

import jsonschema
import numpy as np
from mcap.reader import make_reader

from scaloft_fi.sim.log import Ending, Event, FlightLog
from scaloft_fi.verbs.replay import mcap

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
