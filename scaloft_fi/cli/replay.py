"""`scaloft-fi replay`: fly one flight again, bit for bit, and draw it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import line_format_option
from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import campaign_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say, tell, tell_line
from scaloft_fi.errors import GateError, InputError

if TYPE_CHECKING:
    from scaloft_fi.campaign.plan.flight import Flight
    from scaloft_fi.judge.outcome import Outcome
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.study import Study
    from scaloft_fi.views.flights.replayed import Compared

PICTURES = (".svg", ".png")
RECORDINGS = (".mcap", ".csv")


@verb(
    "replay",
    examples=(
        ("Fly one flight again and compare its digest", "scaloft-fi replay LATE-human@3s/T0O0W0D0H1/0"),
        (
            "Draw it on the map, the baseline beside it",
            "scaloft-fi replay LATE-human@3s/T0O0W0D0H1/0 --output flight.svg",
        ),
        ("Record the unmutated drone for Foxglove", "scaloft-fi replay baseline/T0O0W0D0H1/0 --output flight.mcap"),
    ),
)
@click.argument("name", shell_complete=names.flights, metavar="MUTANT/SITUATION/SEED")
@study_option
@campaign_option
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write a map of the flight (.svg, .png), a recording for Foxglove (.mcap), or a table of its log (.csv).",
)
@click.option("--gui", is_flag=True, help="Watch the flight in PyBullet's window, in real time.")
@click.option(
    "--same-platform",
    is_flag=True,
    help="Exit with 4 when the digest differs from that of a flight of another platform.  "
    "[default: when status, ending or violations differ]",
)
@line_format_option
def replay_command(
    name: str,
    study_folder: Path | None,
    campaign: str,
    output: Path | None,
    gui: bool,
    same_platform: bool,
    style: str,
) -> None:
    """Fly one flight again and compare its digest with the campaign's; on another platform, status and ending too.

    MUTANT is `baseline`, `PLACEBO` or a mutant's id.  The map shows the baseline beside the mutant.
    """
    if output is not None and output.suffix.lower() not in (*PICTURES, *RECORDINGS):
        raise InputError(f"--output={str(output)!r} must end in .svg, .png, .mcap or .csv")
    check_writable(output)
    from scaloft_fi.campaign.processes.start import one_thread_each

    one_thread_each()
    from scaloft_fi.campaign.flights.commanded import Commanded
    from scaloft_fi.campaign.flights.fly import fly_log, judged
    from scaloft_fi.campaign.flights.physics import Physics
    from scaloft_fi.campaign.store.flown_grid import study_of
    from scaloft_fi.views.flights.replayed import REPLAY, Likeness, replay_table, replay_values
    from scaloft_fi.views.tables.table import Format, render

    study = study_of(study_folder, campaign)
    flight = _flight(study, name)
    study.check((flight.situation,))
    (Commanded() if study.command else Physics()).prepare(study, say)
    if gui and study.command:
        raise InputError("--gui shows flights of our simulator, and a command flies this study (sim/flyer.yaml)")
    if gui:
        from scaloft_fi.campaign.flights.window import fly_in_window

        log = fly_in_window(study, flight)
    else:
        log = fly_log(study, flight)
    outcome = judged(study, flight, log)
    words = study.grid.titles(flight.situation)
    if style != "json":
        tell(f"{render((replay_table(outcome, words, log),), Format.TABLE)}\n")
    if output is not None and output.suffix.lower() in RECORDINGS:
        from scaloft_fi.views.flights.log_table import log_table
        from scaloft_fi.views.flights.mcap import mcap

        write(output, log_table(log) if output.suffix.lower() == ".csv" else mcap(log, outcome.name))
    elif output is not None:
        write(output, _drawn(study, flight, outcome, log, output.suffix.lower()))
    compared = _compared(study, campaign, flight, outcome, same_platform=same_platform)
    if style == "json":
        tell(REPLAY.json(replay_values(outcome, words, compared, None if output is None else str(output))))
    elif output is not None:
        tell_line(f"{'recording' if output.suffix.lower() in RECORDINGS else 'map'}: {output}")
    if compared.likeness is Likeness.DIFFERS:
        raise GateError(compared.told)
    if style != "json":
        tell_line(compared.told)


def _flight(study: Study, name: str) -> Flight:
    from scaloft_fi.campaign.store.held import flight_named

    parts = name.split("/")
    if len(parts) != 3 or not parts[2].isdecimal():
        raise InputError(f"{name!r} must be MUTANT/SITUATION/SEED, as in baseline/T0O0W0D0H1/0")
    return flight_named(study, parts[0], parts[1], int(parts[2]))


def _drawn(study: Study, flight: Flight, outcome: Outcome, log: FlightLog, suffix: str) -> bytes:
    """The map of the flight beside its baseline, as the bytes of a file with this suffix."""
    from scaloft_fi.campaign.flights.fly import fly_log, judged
    from scaloft_fi.campaign.plan.flight import Flight
    from scaloft_fi.judge.outcome import BASELINE
    from scaloft_fi.views.pictures.map import draw
    from scaloft_fi.views.pictures.picture import png
    from scaloft_fi.views.pictures.scene import scene_of, track_of

    tracks = [track_of(log, outcome, flight.subject.id)]
    if flight.mutant is not None:
        clean = Flight(None, flight.situation, flight.seed)
        clean_log = fly_log(study, clean)
        tracks.insert(0, track_of(clean_log, judged(study, clean, clean_log), BASELINE))
    words = ", ".join(study.grid.titles(flight.situation))
    title = f"{flight.subject.id} in {flight.situation.key}, seed {flight.seed}"
    svg = draw(scene_of(study.scenario(flight.situation).world), tracks, title=title, subtitle=words)
    return png(svg) if suffix == ".png" else svg.encode()


def _compared(study: Study, campaign: str, flight: Flight, outcome: Outcome, *, same_platform: bool) -> Compared:
    """How the flight compares with the campaign's; with `same_platform` other bits always differ."""
    from scaloft_fi.campaign.plan.flight import Flight
    from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
    from scaloft_fi.campaign.store.folder import STORE_NAME, campaign_folder
    from scaloft_fi.campaign.store.key import flight_key
    from scaloft_fi.campaign.store.platforms import Platforms
    from scaloft_fi.campaign.store.store import Store
    from scaloft_fi.judge.facts import APART_M, agreement, digests, parting_s
    from scaloft_fi.sim.log import Ending
    from scaloft_fi.views.flights.replayed import Compared, Likeness, reading_text

    clean = Flight(None, flight.situation, flight.seed)
    path = campaign_folder(study, campaign) / STORE_NAME
    if not path.is_file():
        return Compared(Likeness.NOTHING, f"no campaign in {path.parent} to compare with")
    with Store(path, create=False) as store:
        known, beside = (store.get(flight_key(study, one)) for one in (flight, clean))
        theirs = Platforms(store).of((flight.situation.key, flight.seed))
    if known is None or known.invalid:
        return Compared(Likeness.NOTHING, f"the campaign in {path.parent} holds no such flight to compare with")
    if digests(known) == digests(outcome):
        return Compared(Likeness.SAME_BITS, f"bit for bit the flight in {path.parent}")
    if not study.stack.deterministic:
        listed = ", ".join(f"{reading.requirement} {reading_text(reading)}" for reading in known.readings)
        return Compared(
            Likeness.ANOTHER,
            f"the stack is not deterministic, so this is another flight than that in {path.parent}, which "
            f"{Ending(known.ending).sentence} after {known.duration_s:.2f} s: {listed}",
        )
    changed = ", ".join(differences(fingerprint(), theirs))
    where = f"on another platform ({changed})" if changed else "on the same platform"
    if same_platform or not changed:
        return Compared(
            Likeness.DIFFERS,
            f"{outcome.name} differs from the flight in {path.parent}, flown {where}: digest {known.digest} there",
        )
    pair = ([], []) if flight.mutant is None or beside is None else ([beside], [_fly(study, clean)])
    compared = agreement([known, *pair[0]], [outcome, *pair[1]])
    apart_s = parting_s(known.track, outcome.track)
    when = "at no time" if apart_s is None else f"from {apart_s:.2f} s on"
    parted = f"the drones are more than {APART_M * 1000:g} mm apart {when}"
    if compared.facts:
        differs = f"the flight differs in more than bits from that in {path.parent}, flown {where}"
        return Compared(Likeness.DIFFERS, f"{differs}: {compared.named()}; {parted}")
    return Compared(
        Likeness.SAME_FACTS,
        f"other bits than the flight in {path.parent}, which was flown {where}, and the same status, ending and "
        f"violations; {parted}",
    )


def _fly(study: Study, flight: Flight) -> Outcome:
    from scaloft_fi.campaign.flights.fly import fly_log, judged

    return judged(study, flight, fly_log(study, flight))
