"""One flight as MCAP, which Foxglove and others play: its pose and path, its signals, its events.

Channels are JSON with their schemas in the file; `/pose` and `/path` have the shapes of `foxglove.PoseInFrame` and
`foxglove.PosesInFrame`, `/signals` has every signal of the log by name, `/events` is `foxglove.Log`.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from scaloft_fi.console import json_text
from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from scaloft_fi.sim.log import FlightLog

FRAME = "world"
WARNING_KINDS = ("contact", "error")
INFO, WARNING = 2, 3
"""Levels of `foxglove.Log`."""

_NUMBER, _TEXT, _WHOLE = {"type": "number"}, {"type": "string"}, {"type": "integer"}


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


_TIME = _object(sec=_WHOLE, nsec=_WHOLE)
_POSE = _object(
    position=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER),
    orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER),
)
_POSE_SIGNALS = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
SCHEMAS = {
    "/pose": ("foxglove.PoseInFrame", _object(timestamp=_TIME, frame_id=_TEXT, pose=_POSE)),
    "/path": (
        "foxglove.PosesInFrame",
        _object(timestamp=_TIME, frame_id=_TEXT, poses={"type": "array", "items": _POSE}),
    ),
    "/events": ("foxglove.Log", _object(timestamp=_TIME, level=_WHOLE, message=_TEXT, name=_TEXT)),
}


def mcap(log: FlightLog, name: str) -> bytes:
    """The flight as an MCAP file; time 0 is the start of the flight.

    Args:
        log: of the flight.
        name: `MUTANT/SITUATION/SEED`.

    Raises:
        InputError: the package mcap is not installed.
    """
    try:
        from mcap.writer import CompressionType, Writer
    except ImportError as error:
        raise InputError("an .mcap file needs mcap: pip install 'scaloft-fi[mcap]'") from error
    if lost := next((name for name in _POSE_SIGNALS if name not in log.signals), None):
        raise InputError(f"an .mcap file needs the signal {lost!r}, which the record of the flight lacks; write .csv")
    file = io.BytesIO()
    writer: Any = Writer(file, compression=CompressionType.NONE)
    writer.start(profile="", library="scaloft-fi")
    writer.add_metadata("flight", {"name": name, "digest": log.digest, "ending": log.ending.value})
    signals = _object(**dict.fromkeys(log.signals, _NUMBER))
    channels = {}
    for topic, (title, schema) in {**SCHEMAS, "/signals": ("scaloft_fi.Signals", signals)}.items():
        number = writer.register_schema(name=title, encoding="jsonschema", data=json_text(schema).encode())
        channels[topic] = writer.register_channel(topic=topic, message_encoding="json", schema_id=number)
    for t_s, topic, message in _messages(log):
        stamp = round(t_s * 1e9)
        data = json_text(message).encode()
        writer.add_message(channel_id=channels[topic], log_time=stamp, publish_time=stamp, data=data)
    writer.finish()
    return file.getvalue()


def _messages(log: FlightLog) -> list[tuple[float, str, dict[str, Any]]]:
    """Every message with its time [s], in order of time."""
    columns = {name: values.tolist() for name, values in log.signals.items()}
    times = columns["elapsed_s"]
    poses = [_pose(columns, i) for i in range(len(times))]
    head = {"timestamp": _stamp(times[0]), "frame_id": FRAME}
    messages: list[tuple[float, str, dict[str, Any]]] = [(times[0], "/path", {**head, "poses": poses})]
    for i, t_s in enumerate(times):
        stamp = _stamp(t_s)
        messages.append((t_s, "/pose", {"timestamp": stamp, "frame_id": FRAME, "pose": poses[i]}))
        messages.append((t_s, "/signals", {name: values[i] for name, values in columns.items()}))
    for event in log.events:
        level = WARNING if event.kind in WARNING_KINDS else INFO
        message = {"timestamp": _stamp(event.t_s), "level": level, "message": event.text, "name": event.kind}
        messages.append((event.t_s, "/events", message))
    return sorted(messages, key=lambda entry: entry[0])


def _pose(columns: dict[str, list[float]], i: int) -> dict[str, Any]:
    return {
        "position": {axis: columns[f"{axis}_m"][i] for axis in "xyz"},
        "orientation": {axis: columns[f"q{axis}"][i] for axis in "xyzw"},
    }


def _stamp(t_s: float) -> dict[str, int]:
    whole = round(t_s * 1e9)
    return {"sec": whole // 10**9, "nsec": whole % 10**9}
