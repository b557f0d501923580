"""`scaloft-fi replay`: fly one flight again, bit for bit, and draw it.

Channels are JSON with their schemas in the file; `/pose` and `/path` have the shapes of `foxglove.PoseInFrame` and
`foxglove.PosesInFrame`, `/signals` has every signal of the log by name, `/events` is `foxglove.Log`.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from scaloft_fi.campaign.flights.fly import Flight, fly_log, judged
from scaloft_fi.campaign.flights.physics import Commanded, Physics, fly_in_window
from scaloft_fi.campaign.processes import one_thread_each
from scaloft_fi.campaign.store.archive import STORE_NAME, campaign_folder, is_archive, opened, study_of
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.platforms import Platforms, differences, fingerprint
from scaloft_fi.errors import GateError, InputError, needed
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Reading
from scaloft_fi.judge.status import APART_M, JudgedFlight, agreement, digests, flight_of, in_step, parting_s
from scaloft_fi.output import json_text, say, tell, tell_line, write_named
from scaloft_fi.sim.log import Ending, FlightLog
from scaloft_fi.study import Study
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.options import Option, check_writable, verb
from scaloft_fi.views.output import Output
from scaloft_fi.views.picture import draw, png, scene_of, track_of
from scaloft_fi.views.table import Format, Table, csv_text, render


def log_table(log: FlightLog) -> bytes:
    """The signals of the log; `judge` reads them back bit for bit."""
    columns = [values.tolist() for values in log.signals.values()]
    return csv_text(log.signals, zip(*columns, strict=True)).encode()


RECORDINGS = (".mcap", ".csv")
"""Ends of the names of recordings."""


@dataclass(frozen=True, eq=False)
class LoggedFlight:
    """A flight with its log.

    Attributes:
        study: the study.
        flight: subject, situation and seed.
        log: the record of the flight.
        outcome: what the requirements say of it.
    """

    study: Study
    flight: Flight
    log: FlightLog
    outcome: Outcome

    @cached_property
    def clean(self) -> LoggedFlight | None:
        """The baseline of the same situation and seed, flown when it is first asked for; None for a baseline."""
        if self.flight.mutant is None:
            return None
        return fly_with_log(self.study, Flight(None, self.flight.situation, self.flight.seed))

    @cached_property
    def judged(self) -> JudgedFlight:
        """The flight of a mutant, compared with its baseline."""
        return flight_of(self.outcome, self.clean.outcome if self.clean else None)

    def facts(self) -> Table:
        """What happened, as a table of two columns."""
        outcome, log = self.outcome, self.log
        rows: list[tuple[str, str]] = [
            ("situation", ", ".join(self.study.grid.titles(self.flight.situation))),
            ("ending", f"{log.ending.sentence} after {log.duration_s:.2f} s"),
        ]
        if self.flight.mutant is not None:
            first = f", first at {outcome.infected_at_s:.2f} s" if outcome.infected_at_s is not None else ""
            rows.append(("samples altered", f"{outcome.altered} of {outcome.carried}{first}"))
        rows += [(reading.requirement, reading_text(reading)) for reading in outcome.readings]
        if outcome.stack_error:
            rows.append(("stack", outcome.stack_error))
        rows.append(("digest", outcome.digest))
        return Table(outcome.name, ("what", ""), tuple(rows))

    def map(self) -> str:
        """The map of the flight, beside its baseline where it has one, as the text of an SVG file."""
        flight = self.flight
        tracks = [track_of(self.log, self.outcome, flight.subject.id)]
        if self.clean is not None:
            tracks.insert(0, track_of(self.clean.log, self.clean.outcome, BASELINE))
        words = ", ".join(self.study.grid.titles(flight.situation))
        title = f"{flight.subject.id} in {flight.situation.key}, seed {flight.seed}"
        return draw(scene_of(self.study.scenario(flight.situation).world), tracks, title=title, subtitle=words)

    def recording(self, end: str) -> bytes:
        """The log as a file.

        Args:
            end: end of its name: `.csv`, a table, or `.mcap`, for Foxglove.

        Raises:
            InputError: the package that writes the file is not installed.
        """
        return log_table(self.log) if end == ".csv" else mcap(self.log, self.outcome.name)


def ready_to_fly(study: Study, mutant: str, situation: str, seed: int, say: Callable[[str], None]) -> Flight:
    """The flight of `mutant` (`baseline`, `PLACEBO` or an id), after study and simulator were prepared for it.

    Args:
        study: the study.
        mutant: the subject.
        situation: key or alias of the situation.
        seed: seed of the noise.
        say: prints a line for the user.

    Raises:
        InputError: there is no such mutant or situation, or the study cannot be flown.
    """
    flight = flight_named(study, mutant, situation, seed)
    study.check((flight.situation,))
    (Commanded() if study.command else Physics()).prepare(study, say)
    return flight


def fly_with_log(study: Study, flight: Flight) -> LoggedFlight:
    """Fly a flight, in this process."""
    return with_log(study, flight, fly_log(study, flight))


def with_log(study: Study, flight: Flight, log: FlightLog) -> LoggedFlight:
    """The flight with this log."""
    return LoggedFlight(study, flight, log, judged(study, flight, log))


def reading_text(reading: Reading) -> str:
    """A reading in words: `violated at 8.10 s, robustness -0.238`."""
    at = f" at {reading.violated_at_s:.2f} s" if reading.violated_at_s is not None else ""
    rho = reading.robustness
    told = "" if rho is None else f", robustness {rho:.3f}"
    return f"{reading.compliance.value}{at}{told}"


def named(name: str) -> tuple[str, str, int]:
    """Mutant, situation and seed of a name such as `LATE-human@3s/T0O0W0D0H1/0`.

    Raises:
        InputError: the name has another form.
    """
    parts = name.split("/")
    if len(parts) != 3 or not parts[2].isdecimal():
        raise InputError(f"{name!r} must be MUTANT/SITUATION/SEED, with `baseline` for the unmutated drone")
    return parts[0], parts[1], int(parts[2])


class Likeness(StrEnum):
    """How a flight that was flown again is like the campaign's."""

    NOTHING = "nothing_to_compare"
    """There is no campaign, or it has no such flight."""
    SAME_BITS = "same_bits"
    SAME_FACTS = "same_facts"
    """Other bits on another platform, and the same status, ending and violations."""
    ANOTHER = "another_flight"
    """The stack is not deterministic."""
    DIFFERS = "differs"
    """Other bits on the same platform, or other facts: a gate fails."""


class Comparison(NamedTuple):
    """How a flight compares with the campaign's.

    Attributes:
        likeness: how it is like the campaign's.
        told: the same in a sentence.
    """

    likeness: Likeness
    told: str

    def passed(self) -> str:
        """The sentence.

        Raises:
            GateError: the digests differ on the same platform or with `same_platform`, or the facts differ.
        """
        if self.likeness is Likeness.DIFFERS:
            raise GateError(self.told)
        return self.told


def comparison(flown: LoggedFlight, campaign: str, *, same_platform: bool) -> Comparison:
    """How a flight compares with the same flight of a campaign.

    Args:
        flown: the flight.
        campaign: name of the campaign, which need not exist.
        same_platform: whether only equal digests will do, also beside a flight of another platform.
    """
    study, flight, outcome = flown.study, flown.flight, flown.outcome
    clean = Flight(None, flight.situation, flight.seed)
    folder = campaign_folder(study, campaign)
    if not (is_archive(folder) or (folder / STORE_NAME).is_file()):
        return Comparison(Likeness.NOTHING, f"no campaign in {folder} to compare with")
    with opened(study, folder)[1] as store:
        known, beside = (store.get(Keys(study).key(one)) for one in (flight, clean))
        theirs = Platforms(store).of((flight.situation.key, flight.seed))
    if known is None or known.invalid:
        return Comparison(Likeness.NOTHING, f"the campaign in {folder} holds no such flight to compare with")
    # an archive that lacks the digest of the beliefs has it for no flight
    if digests(known) == digests(outcome) or (known.digest == outcome.digest and not known.perceived_digest):
        return Comparison(Likeness.SAME_BITS, f"bit for bit the flight in {folder}")
    if not study.stack.deterministic:
        listed = ", ".join(f"{reading.requirement} {reading_text(reading)}" for reading in known.readings)
        other = f"the stack is not deterministic, so this is another flight than that in {folder}"
        ended = f"{Ending(known.ending).sentence} after {known.duration_s:.2f} s"
        return Comparison(Likeness.ANOTHER, f"{other}, which {ended}: {listed}")
    changed = ", ".join(differences(fingerprint(), theirs))
    where = f"on another platform ({changed})" if changed else "on the same platform"
    if same_platform or not changed:
        differs = f"{outcome.name} differs from the flight in {folder}, flown {where}"
        return Comparison(Likeness.DIFFERS, f"{differs}: digest {known.digest} there")
    pair = ([], []) if flown.clean is None or beside is None else ([beside], [flown.clean.outcome])
    agreed = agreement([known, *pair[0]], [outcome, *pair[1]])
    apart_s = parting_s(known.track, outcome.track)
    when = "at no time" if apart_s is None else f"from {apart_s:.2f} s on"
    known_s = in_step(known.track, outcome.track)  # the trajectories of an archive may be thinner
    parted = f"; the drones are more than {APART_M * 1000:g} mm apart {when}" if known_s else ""
    if agreed.facts:
        differs = f"the flight differs in more than bits from that in {folder}, flown {where}"
        return Comparison(Likeness.DIFFERS, f"{differs}: {agreed.named()}{parted}")
    other = f"other bits than the flight in {folder}, which was flown {where}"
    return Comparison(Likeness.SAME_FACTS, f"{other}, and the same status, ending and violations{parted}")


@dataclass(frozen=True)
class Replayed:
    """A flight that was flown again.

    Attributes:
        flown: the flight.
        comparison: how it compares with the campaign's.
        written: path of the file of --output; null: none was asked for.
    """

    flown: LoggedFlight
    comparison: Comparison
    written: Path | None

    KEYS = (
        *("flown.outcome.mutant", "flown.outcome.situation", "words", "flown.outcome.seed", "flown.log.ending"),
        *("flown.outcome.duration_s", "flown.outcome.infected_at_s", "flown.outcome.altered", "flown.outcome.carried"),
        *("stack_error", "flown.outcome.digest", "flown.outcome.readings"),
        *("comparison.likeness", "compared=comparison.told", "written"),
    )

    @property
    def words(self) -> tuple[str, ...]:
        """The situation in words."""
        return tuple(self.flown.study.grid.titles(self.flown.flight.situation))

    @property
    def stack_error(self) -> str | None:
        """The exception of the stack; null: there was none."""
        return self.flown.outcome.stack_error or None


REPLAY = Output("replay", "1.0", Replayed, rows="readings")


FRAME = "world"
WARNING_KINDS = ("contact", "error")
INFO, WARNING = 2, 3
"""Levels of `foxglove.Log`."""

_NUMBER, _TEXT, _WHOLE = {"type": "number"}, {"type": "string"}, {"type": "integer"}


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


_TIME = _object(sec=_WHOLE, nsec=_WHOLE)
_POSE = _object(
    position=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER), orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
)
_POSES = {"type": "array", "items": _POSE}
_POSE_SIGNALS = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
SCHEMAS = {
    "/pose": ("foxglove.PoseInFrame", _object(timestamp=_TIME, frame_id=_TEXT, pose=_POSE)),
    "/path": ("foxglove.PosesInFrame", _object(timestamp=_TIME, frame_id=_TEXT, poses=_POSES)),
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
    made = needed("mcap.writer", "an .mcap file needs mcap", "mcap")
    if lost := next((name for name in _POSE_SIGNALS if name not in log.signals), None):
        raise InputError(f"an .mcap file needs the signal {lost!r}, which the record of the flight lacks; write .csv")
    file = io.BytesIO()
    writer: Any = made.Writer(file, compression=made.CompressionType.NONE)
    writer.start(profile="", library="scaloft-fi")
    writer.add_metadata("flight", {"name": name, "digest": log.digest, "ending": log.ending.value})
    signals = _object(**dict.fromkeys(log.signals, _NUMBER))
    channels = {}
    for topic, (title, schema) in {**SCHEMAS, "/signals": ("scaloft_fi.Signals", signals)}.items():
        number = writer.register_schema(name=title, encoding="jsonschema", data=json_text(schema).encode())
        channels[topic] = writer.register_channel(topic=topic, message_encoding="json", schema_id=number)
    for t_s, topic, message in sorted(_messages(log), key=lambda entry: entry[0]):
        stamp = round(t_s * 1e9)
        data = json_text(message).encode()
        writer.add_message(channel_id=channels[topic], log_time=stamp, publish_time=stamp, data=data)
    writer.finish()
    return file.getvalue()


def _messages(log: FlightLog) -> Iterator[tuple[float, str, dict[str, Any]]]:
    """Every message with its time [s] and topic."""
    columns = {name: values.tolist() for name, values in log.signals.items()}
    times = columns["elapsed_s"]
    poses = [_pose(columns, i) for i in range(len(times))]
    yield times[0], "/path", {"timestamp": _stamp(times[0]), "frame_id": FRAME, "poses": poses}
    for i, t_s in enumerate(times):
        yield t_s, "/pose", {"timestamp": _stamp(t_s), "frame_id": FRAME, "pose": poses[i]}
        yield t_s, "/signals", {name: values[i] for name, values in columns.items()}
    for event in log.events:
        level = WARNING if event.kind in WARNING_KINDS else INFO
        message = {"timestamp": _stamp(event.t_s), "level": level, "message": event.text, "name": event.kind}
        yield event.t_s, "/events", message


def _pose(columns: dict[str, list[float]], i: int) -> dict[str, Any]:
    return {
        "position": {axis: columns[f"{axis}_m"][i] for axis in "xyz"},
        "orientation": {axis: columns[f"q{axis}"][i] for axis in "xyzw"},
    }


def _stamp(t_s: float) -> dict[str, int]:
    whole = round(t_s * 1e9)
    return {"sec": whole // 10**9, "nsec": whole % 10**9}


ENDS = (".svg", ".png", ".mcap", ".csv")


@verb("replay")
def replay_command(
    *,
    name: Annotated[str, Option("", "", metavar="MUTANT/SITUATION/SEED", complete=names.flights)],
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    output: Annotated[
        Path | None,
        Option(
            "Write a map of the flight (.svg, .png), a recording for Foxglove (.mcap), or a table of its log (.csv).",
            metavar="FILE",
        ),
    ],
    gui: Annotated[bool, Option("Watch the flight in PyBullet's window, in real time.")],
    same_platform: Annotated[
        bool,
        Option(
            "Exit with 4 when the digest differs from that of a flight of another platform.",
            otherwise="when status, ending or violations differ",
        ),
    ],
    untrusted: options.Untrusted,
    style: options.LineFormat,
) -> None:
    """Fly one flight again and compare its digest with the campaign's; on another platform, status and ending too.

    MUTANT is `baseline`, `PLACEBO` or a mutant's id.  The map shows the baseline beside the mutant.

    Examples:
        Fly one flight again and compare its digest: `scaloft-fi replay LATE-human@3s/T0O0W0D0H1/0`
        Draw it on the map, the baseline beside it: `scaloft-fi replay LATE-human@3s/T0O0W0D0H1/0 --output flight.svg`
        Record the unmutated drone for Foxglove: `scaloft-fi replay baseline/T0O0W0D0H1/0 --output flight.mcap`
    """
    check_writable(output, *ENDS)

    one_thread_each()

    study = study_of(study_folder, campaign)
    if gui and study.command:
        raise InputError("--gui shows flights of our simulator, and a command flies this study (sim/flyer.yaml)")
    options.allow(study, untrusted=untrusted)
    flight = ready_to_fly(study, *named(name), say)
    flown = with_log(study, flight, fly_in_window(study, flight)) if gui else fly_with_log(study, flight)
    if style != "json":
        tell(render((flown.facts(),), Format.TABLE))
        tell("\n")
    end = output.suffix.lower() if output else ""
    if output is not None and end in RECORDINGS:
        write_named(output, flown.recording(end))
    elif output is not None:
        write_named(output, png(flown.map()) if end == ".png" else flown.map().encode())
    if output is not None and style != "json":
        tell_line(f"{'recording' if end in RECORDINGS else 'map'}: {output}")
    found = comparison(flown, campaign, same_platform=same_platform)
    if style == "json":
        tell(REPLAY.json(Replayed(flown, found, output)))
    told = found.passed()
    if style != "json":
        tell_line(told)
