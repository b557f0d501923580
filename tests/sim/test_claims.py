"""Claims are declared for a stack by its name."""

from __future__ import annotations

import pytest
from tiny_stack import SOUND

from scaloft_fi.errors import InputError
from scaloft_fi.sim.stacks import CLAIMS, claims_of, declare_claims
from scaloft_fi.sources import closure
from scaloft_fi.stack.declaration import Claim, Instant
from scaloft_fi.stack.reference import declaration as reference
from scaloft_fi.study import Study

STUDY = Study.open()


@pytest.fixture(autouse=True)
def no_claims_are_left():
    yield
    CLAIMS._entries.pop("hop", None)


def _sure(now: Instant) -> float:
    return 0.0


def test_a_stack_declares_its_claims_once():
    one = Claim("clock", "s", 0.1, _sure, about=("elapsed_s",), seam="level")
    declare_claims("hop", one)
    assert claims_of(SOUND, ["elapsed_s"]) == (one,)
    with pytest.raises(ValueError, match="claims of the stack 'hop' is declared twice"):
        declare_claims("hop")


def test_the_reference_stack_has_claims_and_a_stack_may_have_none():
    assert claims_of(STUDY.stack, STUDY.signals) == reference.CLAIMS
    assert claims_of(SOUND, []) == ()


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        (Claim("clock", "s", 0.1, _sure, seam="lvel"), "seam 'lvel' does not exist; did you mean 'level'?"),
        (Claim("clock", "s", 0.1, _sure, about=("elapsed",)), "signal 'elapsed' does not exist; did you mean"),
    ],
)
def test_a_claim_about_what_does_not_exist_is_refused(claim: Claim, message: str):
    declare_claims("hop", claim)
    with pytest.raises(InputError) as refused:
        claims_of(SOUND, ["elapsed_s", "x_m"])
    assert f"stack 'hop': claim 'clock': {message}" in str(refused.value)


def test_no_flight_depends_on_a_claim():
    flying = closure(STUDY.flying_modules)
    assert not [name for name in flying if "claim" in name]
