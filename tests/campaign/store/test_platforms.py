"""The platforms of the flights of a store."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from options import cases

from scaloft_fi.campaign.store import platforms
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.store import NOTE, Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome, Subject

ONE, TWO = {"numpy": "1"}, {"numpy": "2"}
PAIRS = [("D0H0", 0), ("D0H0", 1), ("D0/H1", 0)]


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """A store with a baseline in each pair, flown on the platform ONE."""
    opened = Store(tmp_path / STORE_NAME)
    opened.set_meta(ONE)
    for situation, seed in PAIRS:
        opened.put(f"{situation}-{seed}", Outcome(Subject("baseline"), situation, seed, "landed", digest="a"))
    return opened


def test_a_claim_sets_the_flights_of_its_pairs_apart_and_leaves_the_others(store: Store):
    with store:
        platforms.claim(store, PAIRS[1:], TWO)
        known = platforms.Platforms(store)
        assert [known.of(pair) for pair in PAIRS] == [ONE, TWO, TWO]
        assert store.known(f"{situation}-{seed}" for situation, seed in PAIRS) == {"D0H0-0"}
        assert len(store.flights()) == len(PAIRS)  # nothing is lost
        platforms.claim(store, PAIRS, TWO)
        platforms.claim(store, PAIRS[:1], ONE)
        assert [platforms.Platforms(store).of(pair) for pair in PAIRS] == [ONE, TWO, TWO]


def test_a_claim_of_the_own_platform_moves_nothing(store: Store):
    with store:
        platforms.claim(store, PAIRS, ONE)
        assert len(store.known(f"{situation}-{seed}" for situation, seed in PAIRS)) == len(PAIRS)
        assert platforms.set_apart(store) == []
        assert platforms.Platforms(store).mixture(store.outcomes()) == ""


def test_what_a_sample_showed_holds_in_both_directions_and_bits_are_more_than_facts(store: Store):
    with store:
        outcomes = list(store.outcomes())
        assert platforms.Platforms(store).unproved(TWO, outcomes) == ["numpy 2 here, 1 there"]
        platforms.remember(store, platforms.FACTS, ONE, TWO)
        known = platforms.Platforms(store)
        assert known.unproved(TWO, outcomes) == []
        assert known.unproved(TWO, outcomes, only_bits=True) == ["numpy 2 here, 1 there"]
        assert not known.equal(ONE, TWO)
        platforms.remember(store, platforms.BITS, TWO, ONE)
        assert platforms.Platforms(store).equal(ONE, TWO)
        assert platforms.Platforms(store).only(TWO)


@cases("notes")
def test_a_damaged_note_is_bad_input(store: Store, notes: dict[str, str]):
    with store:
        store.set_meta({NOTE + name: text for name, text in notes.items()})
        with pytest.raises(InputError, match=r"the note 'platform of D0H0/.*does not name a platform"):
            platforms.Platforms(store)


CPUINFO = Path("/proc/cpuinfo")
PROGRAM = "from scaloft_fi.campaign.store.platforms import fingerprint as f; print(f()['{package} kernels'])"


def test_a_fingerprint_differs_by_what_changed():
    here = platforms.fingerprint()
    assert {"system", "machine", "processor", "python", "numpy", "pybullet"} <= here.keys()
    assert platforms.differences(here, here) == []
    assert platforms.differences({"numpy": "2"}, {"numpy": "1"}) == ["numpy 2 here, 1 there"]


@pytest.mark.skipif(not CPUINFO.exists() or "avx2" not in CPUINFO.read_text(), reason="no kernels to choose between")
@pytest.mark.parametrize("package", platforms.BRING_OPENBLAS)
def test_a_fingerprint_names_the_kernels_that_each_package_multiplies_with(package: str):
    if platforms.fingerprint()[f"{package} kernels"] == "unknown":
        pytest.skip(f"{package} is not linked with OpenBLAS")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(package=package)],
        env=os.environ | {"OPENBLAS_CORETYPE": "HASWELL", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "Haswell"


def test_kernels_of_a_library_that_does_not_tell_are_unknown(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("scaloft_fi.campaign.store.platforms.find_spec", lambda _package: None)
    here = platforms.fingerprint()
    assert (here["numpy kernels"], here["scipy kernels"]) == ("unknown", "unknown")
