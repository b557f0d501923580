"""How a campaign spends alpha: once on a size told before it flew, or by looks where more seeds were asked for later.

Each run keeps in the store with which seeds it was asked to fly which mutants, before it flies.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from typing import TYPE_CHECKING

from scaloft_fi.analysis.scoring.detection import Spending
from scaloft_fi.campaign.store.store import Store

if TYPE_CHECKING:
    from scaloft_fi.study import Study

NOTE = "asked"
"""What the names of these notes begin with."""


def remember_seeds(store: Store, mutants: Iterable[str], seeds: Iterable[int]) -> None:
    """Keep that a run asks to fly these mutants with these seeds, where no earlier run asked for as many and more.

    Raises:
        InputError: the store cannot be written.
    """
    wanted, known = frozenset(seeds), _asked(store)
    news = sorted({mutant for mutant in mutants if not any(wanted <= before for before in known.get(mutant, ()))})
    if news:
        content = json.dumps({"seeds": sorted(wanted), "mutants": news})
        store.set_notes({f"{NOTE} {hashlib.sha256(content.encode()).hexdigest()[:16]}": content})


def spending_of(study: Study, store: Store) -> Spending:
    """How alpha is spent on the mutants of a store."""
    return Spending(study.alpha, frozenset(mutant for mutant, seeds in _asked(store).items() if len(seeds) > 1))


def _asked(store: Store) -> dict[str, set[frozenset[int]]]:
    """With which sets of seeds runs asked for each mutant."""
    asked: dict[str, set[frozenset[int]]] = {}
    for name, text in store.notes().items():
        if name.startswith(f"{NOTE} "):
            content = json.loads(text)
            for mutant in content["mutants"]:
                asked.setdefault(mutant, set()).add(frozenset(content["seeds"]))
    return asked
