from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.mutants.check_operator import check_operator, operators_of
from scaloft_fi.mutants.operators import OPERATORS, clock


def _undocumented(*_: Any, **__: Any) -> Any:
    return lambda _t_s, sample: sample


DELAY = OPERATORS["delay"].example
BROKEN: Mapping[str, tuple[dict[str, Any], str]] = {
    "another sample": ({"example": replace(DELAY, after=DELAY.before)}, "sample 0 of its example: "),
    "too few samples": ({"example": replace(DELAY, after=())}, "has 0 samples after, and "),
    "a predicate": ({"example": replace(DELAY, after=lambda _before, _after: False)}, "its example does not hold"),
    "no docstring": ({"make": _undocumented}, "its docstring must begin with a sentence"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_does_not_hold_is_a_sentence(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    changed, said = BROKEN[what]
    monkeypatch.setitem(OPERATORS._entries, "delay", replace(OPERATORS["delay"], **changed))
    check = check_operator("delay")
    assert any(said in failure for failure in check.failures)
    assert said in str(check)


def test_an_unknown_operator_names_the_nearest_one() -> None:
    with pytest.raises(InputError, match="did you mean 'delay'"):
        check_operator("dealy")


def test_the_operators_of_a_package_are_those_of_its_modules() -> None:
    assert set(operators_of(clock.__name__)) < set(operators_of("scaloft_fi.mutants.operators")) < set(OPERATORS)
    assert operators_of("scaloft_fi.mut") == ()
