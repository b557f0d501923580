"""What the page is made from is read at one moment, tracks and spending among it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from papers import campaign

from scaloft_fi.campaign.runs.run import remember_seeds
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import gather

MUTANT = "LATE-human@3s"


@pytest.fixture
def folder(study: Study, tmp_path: Path) -> str:
    """A campaign that asked for more seeds later."""
    keys = Keys(study)
    with Store(tmp_path / STORE_NAME) as store:
        for outcome in campaign(study, (MUTANT,), range(1), range(1)):
            store.put(keys.key(flight_named(study, outcome.mutant, outcome.situation, outcome.seed)), outcome)
        for seeds in (range(1), range(3)):
            remember_seeds(store, [MUTANT], seeds)
        store.set_meta({"system": "Paper"})
    return f"{tmp_path}/"


def test_all_of_the_campaign_is_there(study: Study, folder: str) -> None:
    evidence = gather(study, folder)
    flown = sorted(campaign(study, (MUTANT,), range(1), range(1)), key=lambda o: o.name)
    assert sorted(evidence.outcomes, key=lambda o: o.name) == flown
    assert evidence.spending.grown == {MUTANT}
    assert evidence.fingerprint == {"system": "Paper"}
    assert (evidence.stale.sentences, evidence.owed) == ((), 0)


def test_it_is_read_at_one_moment(study: Study, folder: str, monkeypatch: pytest.MonkeyPatch) -> None:
    opened, plain = [], Store.meta
    (late, *_) = campaign(study, (), range(1), range(1))

    def interrupted(store: Store) -> dict[str, str]:
        opened.append(store)
        with Store(store.path) as other:
            other.put("another", replace(late, seed=7))
        assert "another" not in {flight.key for flight in store.flights()}
        return plain(store)

    monkeypatch.setattr(Store, "meta", interrupted)
    gather(study, folder)
    assert len(opened) == 1


def test_a_campaign_without_flights_is_one_sentence(study: Study, tmp_path: Path) -> None:
    with Store(tmp_path / STORE_NAME):
        pass
    with pytest.raises(InputError, match="nothing to show"):
        gather(study, f"{tmp_path}/")
