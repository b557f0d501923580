from __future__ import annotations

from pathlib import Path

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys, current_in, flight_named, with_tracks
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, pack_track
from scaloft_fi.study import Study

STUDY = Path(__file__).parents[3]
HERE = "T0O0W0D0H1"
FLOWN = (("baseline", 0), ("baseline", 1), ("LATE-human@3s", 0), ("NO-human@100%", 0))


def test_only_the_trajectories_asked_for_are_read(tmp_path: Path) -> None:
    study, keys = Study.open(STUDY), Keys(Study.open(STUDY))
    track = pack_track({name: [1.0, 2.0] for name in TRACK_COLUMNS})
    with Store(tmp_path / STORE_NAME) as store:
        for mutant, seed in FLOWN:
            planned = keys.planned(flight := flight_named(study, mutant, HERE, seed))
            store.plan([planned])
            store.put(planned.key, Outcome(flight.subject, HERE, seed, ending="landed", track=track))
        known = current_in(study, store)
        found = with_tracks(study, store, known, ["baseline", "LATE-human@3s"])
        first = with_tracks(study, store, known, ["baseline"], [1])
    assert not any(outcome.track for outcome in known)
    assert {o.name for o in found if o.track} == {f"baseline/{HERE}/0", f"baseline/{HERE}/1", f"LATE-human@3s/{HERE}/0"}
    assert {outcome.name for outcome in first if outcome.track} == {f"baseline/{HERE}/1"}
    assert [outcome.name for outcome in first] == [outcome.name for outcome in known]
