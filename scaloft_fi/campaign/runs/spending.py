"""The campaign's spending of alpha: once for a number of seeds that is fixed before the flights, or by looks.

Before it flies, each run records in the store its mutants and seeds.  A mutant with more than one record is judged by
looks.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.campaign.store.store import Store

if TYPE_CHECKING:
    from scaloft_fi.study import Study

NOTE = "asked"
"""Prefix of the names of these notes."""


def remember_seeds(store: Store, mutants: Iterable[str], seeds: Iterable[int]) -> None:
    """Record mutants and seeds of a run; a mutant is skipped if an earlier record has all of these seeds.

    Raises:
        InputError: the store cannot be written.
    """
    wanted, known = frozenset(seeds), _asked(store)
    news = sorted({mutant for mutant in mutants if not any(wanted <= before for before in known.get(mutant, ()))})
    if news:
        content = json.dumps({"seeds": sorted(wanted), "mutants": news})
        store.set_notes({f"{NOTE} {hashlib.sha256(content.encode()).hexdigest()[:16]}": content})


def spending_of(study: Study, store: Store) -> Spending:
    """The spending of alpha on the mutants of a store."""
    return Spending(study.alpha, frozenset(mutant for mutant, seeds in _asked(store).items() if len(seeds) > 1))


def _asked(store: Store) -> dict[str, set[frozenset[int]]]:
    """The recorded sets of seeds by mutant."""
    asked: dict[str, set[frozenset[int]]] = {}
    for mutants, seeds in store.records(NOTE, _read):
        for mutant in mutants:
            asked.setdefault(mutant, set()).add(seeds)
    return asked


def _read(content: Any) -> tuple[list[str], frozenset[int]]:
    return list(map(str, content["mutants"])), frozenset(map(int, content["seeds"]))
