"""The JSON Schemas of `sim/flyer.yaml`, a command that flies, and `sim/record.yaml`, where its record has signals."""

from __future__ import annotations

from scaloft_fi.document import MOST
from scaloft_fi.outside.border import BORDERS, PORTS
from scaloft_fi.outside.command import MOST_LIMIT_S
from scaloft_fi.outside.records.record_map import TIME_UNITS, UNITS, Keep
from scaloft_fi.views.documents.build import (
    Schema,
    anything,
    choice,
    either,
    fixed,
    flag,
    listed,
    mapping,
    named,
    number,
    text,
)
from scaloft_fi.views.documents.declared import Declared

PLACES = "{situation}, {seed}, {fault}, {record}, {folder}, {study}, {python}"


def flyer(_: Declared) -> Schema:
    """`sim/flyer.yaml`."""
    word = {"type": ["string", "number"]}
    return mapping(
        "A command that flies instead of our simulator.",
        {
            "flyer": fixed("command", "a command flies"),
            "run": listed(
                f"program and arguments; {PLACES} and values of the situation by dotted path stand in braces",
                {**word, "description": "a word of the command"},
                least=1,
                most=MOST,
                examples=(["{python}", "fly.py", "--situation", "{situation}", "--record", "{record}"],),
            ),
            "record": text(
                "name of the file, in a private folder of the flight, that it records to; with * any that fits",
                "flight.csv",
            ),
            "limit_s": number("longest wall time of a flight", "s", 120, above=0, most=MOST_LIMIT_S),
        },
        {
            "env": named(
                "environment variables beside ours; with the same places in braces",
                {**word, "description": "a value"},
                most=MOST,
            ),
            "mission_s": number("time limit of a flight, simulated; left out: that of its situation", "s", above=0),
            "inputs": listed(
                "files of the study, beside sim/, that decide what is flown; a changed one flies again",
                text("path inside the study", "fly.py"),
                most=MOST,
            ),
            "deterministic": flag(
                "whether two flights of the same subject, situation and seed are the same", default=False
            ),
            "seams": named(
                "the seams that the matrix may use, by name; `every` stands for all of the stack",
                _offer(),
                most=MOST,
            ),
            "clock": mapping(
                "The topic on which the simulator tells its time; left out: by the stamps of messages.",
                {"topic": text("name of the topic", "/clock"), "border": _border()},
                {"type": text("type of its messages")},
            ),
        },
    )


def _border() -> Schema:
    return choice("what the topic goes over", tuple(BORDERS))


def _offer() -> Schema:
    message = {
        "message": choice(
            "the port whose message it has; left out: as the stack declares the seam",
            {n: p.meaning for n, p in PORTS.items()},
        )
    }
    relay = mapping(
        "A relay between two topics of the simulator, with the fault in it.",
        {
            "from": text("the topic that it reads", "/cmd_vel"),
            "to": text("another topic, which it writes", "/cmd_vel_faulty"),
            "border": _border(),
        },
        {
            "type": text("type of the messages, as the border names it", "geometry_msgs/msg/Twist"),
            "frame": text("frame id of messages"),
            "qos": named("quality of service, as the border names it", anything("a setting"), most=MOST),
            "fields": named(
                "fields of the border's message by path to those of the sample", text("a field"), most=MOST
            ),
        },
    )
    return either(
        "How the faults of a seam reach the simulator.",
        mapping(
            "The command gets the fault in {fault} and injects it itself.",
            {"parameter": fixed(True, "by {fault}")},
            message,
        ),
        mapping("Our relay alters the messages of a topic.", {"relay": relay}, message),
    )


def record(_: Declared) -> Schema:
    """`sim/record.yaml`."""
    about = "where the signals stand, by name; `scaloft-fi signals` says which follow from others"
    return mapping(
        "Where the signals of the requirements stand in a record of a flight.",
        {"signals": named(about, _signal(), least=0, most=MOST)},
        {
            "time": _time(),
            "start": _moment(
                "When the flight starts: at the first message of at least `least`; left out: the first of x_m."
            ),
            "end": _moment(
                "When the flight ends: at the first message of at least `least`; left out: the last of x_m."
            ),
            "altered": _counted("How many samples a fault has altered up to then."),
            "carried": _counted("How many samples the fault's seam has carried up to then."),
        },
    )


def _where() -> tuple[dict[str, Schema], dict[str, Schema]]:
    """Two ways to say where a value stands: in a table, in messages."""
    column = {"column": text("name of the column", "east")}
    topic = {"topic": text("the topic", "/odom"), "field": text("path of the field", "pose.pose.position.x", "q[0]")}
    return column, topic


def _signal() -> Schema:
    value = {"type": ["number", "boolean"]}
    optional = {
        "unit": choice("conversion to the signal's unit; not beside factor and offset", tuple(UNITS)),
        "factor": number("signal = factor x value + offset", default=1),
        "offset": number("signal = factor x value + offset", default=0),
        "unknown": {
            **value,
            "description": "its value before the first message; left out: it must have one by the start",
        },
        "keep": choice("which value stands for the messages since the last sample", tuple(Keep), default=Keep.LAST),
    }
    forms = [
        mapping(name, needed, optional) for name, needed in zip(("In a table.", "In messages."), _where(), strict=True)
    ]
    constant = mapping("Nowhere: always the same.", {"constant": {**value, "description": "the value"}})
    return either("Where a signal stands.", *forms, constant)


def _time() -> Schema:
    messages = {"received": "the time at which a message was received", "stamp": "the stamp in the message"}
    return either(
        "Which time the values have; left out: at which messages were received.",
        mapping(
            "A column of a table.",
            {"column": text("name of the column", "t_s")},
            {"unit": choice("its unit", tuple(TIME_UNITS), default="s")},
        ),
        mapping("Of the messages.", {"message": choice("which time of a message counts", messages)}),
        mapping("A topic that tells the simulated time.", {"clock": text("the topic", "/clock")}),
    )


def _moment(about: str) -> Schema:
    least = {"least": number("the least value that counts", "", 1)}
    return either(about, *(mapping(about, {**where, **least}) for where in _where()))


def _counted(about: str) -> Schema:
    return either(about, *(mapping(about, where) for where in _where()))
