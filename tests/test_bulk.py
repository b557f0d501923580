from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, dataclass, replace
from itertools import repeat

import pytest

from scaloft_fi.bulk import bulk


@dataclass(frozen=True, slots=True)
class Pair:
    left: int
    right: str = ""


@dataclass(frozen=True)
class Loose:
    left: int


def test_what_is_made_in_bulk_is_what_single_calls_make() -> None:
    made = bulk(Pair, ([1, 2], repeat("x")))
    assert made == [Pair(1, "x"), Pair(2, "x")]
    assert [type(pair) for pair in made] == [Pair, Pair]
    assert hash(made[0]) == hash(Pair(1, "x"))
    assert replace(made[0], left=3) == Pair(3, "x")
    assert pickle.loads(pickle.dumps(made[0])) == made[0]


def test_it_is_as_frozen() -> None:
    (pair,) = bulk(Pair, ([1], ["x"]))
    with pytest.raises(FrozenInstanceError):
        pair.left = 2  # type: ignore[misc]


def test_of_nothing_nothing_is_made() -> None:
    assert bulk(Pair, ([], [])) == []


def test_a_class_without_slots_is_refused() -> None:
    with pytest.raises(TypeError, match="layout"):
        bulk(Loose, ([1],))
