"""One short flight as a record of every kind: it flies along x at 1 m/s, and is near the wall for one message."""

from __future__ import annotations

import itertools
import json
import math
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

TIMES_S = np.arange(41) / 10.0
X_M = TIMES_S.copy()
NEAR_AT = 30
"""Index of the message that is near the wall."""
CLEAR_M = np.where(np.arange(41) == NEAR_AT, 0.2, 1.0)

CONSTANT = "{constant: %g}"


def mapping(folder: Path, time: str, x: str, clear: str, more: str = "") -> Path:
    """A mapping that takes these two signals from a record, and the rest from nowhere."""
    entries = {"x_m": x, "clearance_m": clear, "y_m": CONSTANT % 0, "z_m": CONSTANT % 1.5}
    entries |= {"vx_mps": CONSTANT % 1, "vy_mps": CONSTANT % 0, "vz_mps": CONSTANT % 0}
    lines = [f"  {name}: {entry}" for name, entry in entries.items()]
    path = folder / "record.yaml"
    path.write_text("\n".join([f"time: {time}" if time else "", more, "signals:", *lines]) + "\n")
    return path


def table(folder: Path) -> Path:
    """CSV."""
    rows = (f"{t},{x},{c}" for t, x, c in zip(TIMES_S.tolist(), X_M.tolist(), CLEAR_M.tolist(), strict=True))
    path = folder / "flight.csv"
    path.write_text("\n".join(["t_s,x,clear", *rows]) + "\n")
    return path


def rosbag2(folder: Path, plugin: str = "SQLITE3") -> Path:
    """A folder of rosbag2, recorded while the simulation ran at twice real time; positions in millimetres."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store, path = get_typestore(Stores.ROS2_HUMBLE), folder / "bag"
    stamp, header = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    point, stamped = store.types["geometry_msgs/msg/Point"], store.types["geometry_msgs/msg/PointStamped"]
    number, clock = store.types["std_msgs/msg/Float64"], store.types["rosgraph_msgs/msg/Clock"]
    with Writer(path, version=9, storage_plugin=StoragePlugin[plugin]) as writer:
        ticks = writer.add_connection("/clock", clock.__msgtype__, typestore=store)
        where = writer.add_connection("/point", stamped.__msgtype__, typestore=store)
        clear = writer.add_connection("/clear", number.__msgtype__, typestore=store)
        for t_s, x_m, clear_m in zip(TIMES_S.tolist(), X_M.tolist(), CLEAR_M.tolist(), strict=True):
            now = stamp(sec=int(t_s), nanosec=round((t_s - int(t_s)) * 1e9))
            place = stamped(header=header(stamp=now, frame_id="world"), point=point(x=x_m * 1000.0, y=0.0, z=0.0))
            for to, message in ((ticks, clock(clock=now)), (where, place), (clear, number(data=clear_m))):
                writer.write(to, 7_000_000_000 + round(t_s * 0.5e9), store.serialize_cdr(message, to.msgtype))
    return path


def ros_mcap(folder: Path) -> Path:
    """The same in MCAP."""
    return next(rosbag2(folder, "MCAP").glob("*.mcap"))


def rosbag1(folder: Path) -> Path:
    """A bag of ROS 1."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store, path = get_typestore(Stores.ROS1_NOETIC), folder / "flight.bag"
    number = store.types["std_msgs/msg/Float64"]
    with Writer(path) as writer:
        topics = [writer.add_connection(name, number.__msgtype__, typestore=store) for name in ("/x", "/clear")]
        for t_s, *values in zip(TIMES_S.tolist(), X_M.tolist(), CLEAR_M.tolist(), strict=True):
            for topic, value in zip(topics, values, strict=True):
                data = store.serialize_ros1(number(data=value), number.__msgtype__)
                writer.write(topic, 7_000_000_000 + round(t_s * 1e9), data)
    return path


def mcap_of_many_chunks(folder: Path, *, summary: bool = True, odd: str = "") -> Path:
    """An MCAP of JSON in many chunks; `odd`: the encoding of a further topic."""
    from mcap.writer import IndexType, Writer

    path = folder / "own.mcap"
    with path.open("wb") as file:
        index = {} if summary else {"index_types": IndexType.NONE, "repeat_channels": False, "repeat_schemas": False}
        writer = Writer(file, chunk_size=200, use_statistics=summary, use_summary_offsets=summary, **index)
        writer.start()
        topics = [writer.register_channel(name, "json", 0) for name in ("/x", "/clear")]
        if odd:
            writer.add_message(writer.register_channel("/odd", odd, 0), 7_000_000_000, b"?", 7_000_000_000)
        for t_s, *values in zip(TIMES_S.tolist(), X_M.tolist(), CLEAR_M.tolist(), strict=True):
            at_ns = 7_000_000_000 + round(t_s * 1e9)
            for topic, value in zip(topics, values, strict=True):
                writer.add_message(topic, at_ns, json.dumps({"data": value}).encode(), at_ns)
        writer.finish()
    return path


def bomb(folder: Path, kind: str, size: int) -> Path:
    """A small record whose second message unpacks to `size` bytes."""
    import mcap.writer
    from rosbags import rosbag1

    path = folder / f"bomb.{kind.partition('-')[0]}"
    if kind.startswith("mcap"):
        with path.open("wb") as file:
            packed = mcap.writer.CompressionType[kind.partition("-")[2]]
            writer = mcap.writer.Writer(file, chunk_size=100, compression=packed)
            writer.start()
            topic = writer.register_channel("/x", "json", 0)
            for at_ns, data in enumerate((b"1" * 200, bytes(size))):
                writer.add_message(topic, at_ns, data, at_ns)
            writer.finish()
        return path
    bag = rosbag1.Writer(path)
    bag.set_compression(rosbag1.Writer.CompressionFormat[kind.partition("-")[2]])
    with bag:
        bag.write(
            bag.add_connection("/x", "std_msgs/msg/String", msgdef="string data", md5sum="0" * 32), 0, bytes(size)
        )
    return path


def _message(kind: bytes, data: bytes) -> bytes:
    return struct.pack("<HB", len(data), kind[0]) + data


def _begun(formats: Mapping[int, bytes]) -> list[bytes]:
    """The beginning of a log of PX4 with these messages, by number."""
    named = [message.partition(b":")[0] for message in formats.values()]
    return [
        b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0),
        _message(b"B", bytes(40)),
        *(_message(b"F", message) for message in formats.values()),
        *(_message(b"A", struct.pack("<BH", 0, at) + name) for at, name in zip(formats, named, strict=True)),
    ]


def px4(folder: Path, landed: Mapping[int, int]) -> Path:
    """Two seconds of PX4 at rest 3 m up, rolled by 0.2 rad, heading north; `landed`: what it says, by tick of 0.1 s."""
    names = (b"x", b"y", b"z", b"vx", b"vy", b"vz", b"heading")
    parts = _begun(
        {
            0: b"vehicle_local_position:uint64_t timestamp;" + b"".join(b"float %s;" % name for name in names),
            1: b"vehicle_attitude:uint64_t timestamp;float[4] q;",
            2: b"vehicle_land_detected:uint64_t timestamp;bool landed;",
        }
    )
    for tick in range(21):
        at_us = 1_000_000 + tick * 100_000
        parts.append(_message(b"D", struct.pack("<HQ7f", 0, at_us, 4.0, 2.0, -3.0, 0.0, 0.0, 0.0, 0.0)))
        parts.append(_message(b"D", struct.pack("<HQ4f", 1, at_us + 2000, math.cos(0.1), math.sin(0.1), 0.0, 0.0)))
        if tick in landed:
            parts.append(_message(b"D", struct.pack("<HQ?", 2, at_us, bool(landed[tick]))))
    path = folder / "px4.ulg"
    path.write_bytes(b"".join(parts))
    return path


def ulog(folder: Path, dropouts_ms: Mapping[int, int] = MappingProxyType({})) -> Path:
    """A log of PX4; `dropouts_ms`: how long a drop-out is, by the row that it follows."""

    parts = _begun({7: b"place:uint64_t timestamp;float[3] at;float clear;"})
    for place, (t_s, x_m, clear_m) in enumerate(zip(TIMES_S.tolist(), X_M.tolist(), CLEAR_M.tolist(), strict=True)):
        row = struct.pack("<HQ4f", 7, 1_000_000 + round(t_s * 1e6), x_m, 0.0, 0.0, clear_m)
        parts.append(_message(b"D", row))
        if place in dropouts_ms:
            parts.append(_message(b"O", struct.pack("<H", dropouts_ms[place])))
    path = folder / "flight.ulg"
    path.write_bytes(b"".join(parts))
    return path


def dataflash(folder: Path) -> Path:
    """A log of ArduPilot of two seconds: 5 m/s, at rest in attitude."""
    path, rows = folder / "own.bin", []
    formats = {
        128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns", "<BB4s16s64s"),
        129: ("XKF1", "Qffffff", "TimeUS,PN,PE,PD,VN,VE,VD", "<Q6f"),
        130: ("ATT", "Qccc", "TimeUS,Roll,Pitch,Yaw", "<Qhhh"),
    }

    def row(kind: int, *values: object) -> bytes:
        return struct.pack("<BBB", 0xA3, 0x95, kind) + struct.pack(formats[kind][3], *values)

    for kind, (name, letters, columns, form) in formats.items():
        told = (kind, 3 + struct.calcsize(form), name.encode(), letters.encode(), columns.encode())
        rows.append(row(128, *told))
    for tick in range(21):
        at_us, share = 1_000_000 + tick * 100_000, tick / 20.0
        rows += [row(130, at_us, 0, 0, 0), row(129, at_us, 4.0 * share, 0.0, -3.0 * share, 3.0, 4.0, 0.0)]
    path.write_bytes(b"".join(rows))
    return path


def tlog(folder: Path, systems: Sequence[int] = (1,)) -> Path:
    """A log of MAVLink of two seconds: north 4, east 2, down -3 [m] at the end, at 5 m/s, rolled by 0.1 rad."""
    from pymavlink.dialects.v20 import ardupilotmega as mavlink

    path = folder / "own.tlog"
    with path.open("wb") as file:
        for tick, system in itertools.product(range(21), systems):
            link = mavlink.MAVLink(None, srcSystem=system)
            share = tick / 20.0
            for message in (
                link.local_position_ned_encode(tick * 100, 4.0 * share, 2.0 * share, -3.0 * share, 3.0, 4.0, 0.0),
                link.attitude_encode(tick * 100, 0.1, 0.0, 0.5, 0.0, 0.0, 0.0),
            ):
                file.write(struct.pack(">Q", 1_700_000_000_000_000 + tick * 100_000) + message.pack(link))
    return path
