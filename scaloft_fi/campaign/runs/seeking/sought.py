"""What searches remember in the store: what one seeks when nobody names mutants, and the candidates of all.

An interrupted search has written finds already.  If it left out the mutants that these show when it goes on, it would
not find what it would have found without the interruption.

The candidates of a mutant are numbered over all searches of a campaign: another seed is no new share of alpha.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scaloft_fi.campaign.store.folder import STORE_NAME
from scaloft_fi.campaign.store.store import EmptyError, Store

BEGUN, ENDED, CANDIDATE = "seek begun", "seek ended", "seek candidate"
"""Prefixes of the names of the notes."""


@dataclass(frozen=True)
class Unnamed:
    """A search for which nobody named mutants.

    Attributes:
        seed: of the search.
        campaign: the campaign whose score says what is not detected.
        mutants: what is sought, in the order of the turns.
        number: how many such searches of the store began before.
    """

    seed: int
    campaign: str
    mutants: tuple[str, ...]
    number: int = 0

    def begin(self, store: Store) -> None:
        """Remember it.

        Raises:
            InputError: the store cannot be written.
        """
        store.set_notes({f"{BEGUN} {self.number}": json.dumps(asdict(self))})

    def end(self, store: Store) -> None:
        """Remember that it came to its end, or used up its budget.

        Raises:
            InputError: the store cannot be written.
        """
        store.set_notes({f"{ENDED} {self.number}": json.dumps(self.number)})


def interrupted(folder: Path, seed: int, campaign: str) -> Unnamed | None:
    """The last search of a folder if it did not end and had this seed and campaign.

    Raises:
        InputError: the store cannot be read.
    """
    begun, ended = _notes(folder)
    last = begun[-1] if begun else None
    return last if last and last.number not in ended and (last.seed, last.campaign) == (seed, campaign) else None


def anew(folder: Path, seed: int, campaign: str, mutants: Sequence[str]) -> Unnamed:
    """The next search of a folder.

    Raises:
        InputError: the store cannot be read.
    """
    return Unnamed(seed, campaign, tuple(mutants), len(_notes(folder)[0]))


def _notes(folder: Path) -> tuple[list[Unnamed], set[int]]:
    """The searches that began, in their order, and the numbers of those that ended."""
    path = folder / STORE_NAME
    if not path.is_file():
        return [], set()
    try:
        with Store(path, create=False) as store:
            begun, ended = store.records(BEGUN, _read), set(store.records(ENDED, int))
    except EmptyError:
        return [], set()
    return sorted(begun, key=lambda one: one.number), ended


class Candidates:
    """The candidates of all searches of a campaign.

    Args:
        store: of the campaign.

    Raises:
        InputError: the store cannot be read.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        known = store.records(CANDIDATE, lambda one: (str(one["mutant"]), str(one["situation"]), int(one["number"])))
        self._numbers = {(mutant, situation): number for mutant, situation, number in known}

    def number(self, mutant: str, situation: str) -> int:
        """Which candidate of the mutant a situation is, from 1; a new one is remembered.

        Raises:
            InputError: the store cannot be written.
        """
        place = mutant, situation
        if place not in self._numbers:
            number = 1 + max((one for (other, _), one in self._numbers.items() if other == mutant), default=0)
            self._numbers[place] = number
            note = {"mutant": mutant, "situation": situation, "number": number}
            self._store.set_notes({f"{CANDIDATE} {mutant} {situation}": json.dumps(note)})
        return self._numbers[place]


def _read(content: Any) -> Unnamed:
    mutants = tuple(map(str, content["mutants"]))
    return Unnamed(int(content["seed"]), str(content["campaign"]), mutants, int(content["number"]))
