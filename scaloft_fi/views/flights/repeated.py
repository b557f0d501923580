"""A flight that was flown once more, compared with the same flight in a campaign."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.store.archive import STORE_NAME, campaign_folder, is_archive
from scaloft_fi.campaign.store.flown_grid import opened
from scaloft_fi.campaign.store.held import flight_key
from scaloft_fi.campaign.store.origin import differences, fingerprint
from scaloft_fi.campaign.store.platforms import Platforms
from scaloft_fi.errors import GateError
from scaloft_fi.judge.status import APART_M, agreement, digests, in_step, parting_s
from scaloft_fi.sim.log import Ending
from scaloft_fi.views.flights.logged_flight import LoggedFlight, reading_text


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
    """How a flight compares with the campaign's, as a word and in a sentence."""

    likeness: Likeness
    told: str


def compared(flown: LoggedFlight, campaign: str, *, same_platform: bool) -> str:
    """How a flight compares with the same flight of a campaign, in a sentence; arguments as of `comparison`.

    Raises:
        GateError: the digests differ on the same platform or with `same_platform`, or the facts differ.
    """
    found = comparison(flown, campaign, same_platform=same_platform)
    if found.likeness is Likeness.DIFFERS:
        raise GateError(found.told)
    return found.told


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
        known, beside = (store.get(flight_key(study, one)) for one in (flight, clean))
        theirs = Platforms(store).of((flight.situation.key, flight.seed))
    if known is None or known.invalid:
        return Comparison(Likeness.NOTHING, f"the campaign in {folder} holds no such flight to compare with")
    # an archive that lacks the digest of the beliefs has it for no flight
    if digests(known) == digests(outcome) or (known.digest == outcome.digest and not known.perceived_digest):
        return Comparison(Likeness.SAME_BITS, f"bit for bit the flight in {folder}")
    if not study.stack.deterministic:
        listed = ", ".join(f"{reading.requirement} {reading_text(reading)}" for reading in known.readings)
        return Comparison(
            Likeness.ANOTHER,
            f"the stack is not deterministic, so this is another flight than that in {folder}, which "
            f"{Ending(known.ending).sentence} after {known.duration_s:.2f} s: {listed}",
        )
    changed = ", ".join(differences(fingerprint(), theirs))
    where = f"on another platform ({changed})" if changed else "on the same platform"
    if same_platform or not changed:
        return Comparison(
            Likeness.DIFFERS,
            f"{outcome.name} differs from the flight in {folder}, flown {where}: digest {known.digest} there",
        )
    pair = ([], []) if flown.clean is None or beside is None else ([beside], [flown.clean.outcome])
    agreed = agreement([known, *pair[0]], [outcome, *pair[1]])
    apart_s = parting_s(known.track, outcome.track)
    when = "at no time" if apart_s is None else f"from {apart_s:.2f} s on"
    known_s = in_step(known.track, outcome.track)  # the trajectories of an archive may be thinner
    parted = f"; the drones are more than {APART_M * 1000:g} mm apart {when}" if known_s else ""
    if agreed.facts:
        differs = f"the flight differs in more than bits from that in {folder}, flown {where}"
        return Comparison(Likeness.DIFFERS, f"{differs}: {agreed.named()}{parted}")
    return Comparison(
        Likeness.SAME_FACTS,
        f"other bits than the flight in {folder}, which was flown {where}, and the same status, ending and "
        f"violations{parted}",
    )
