"""Claims are declared for a stack by its name."""

from __future__ import annotations

import pytest

from scaloft_fi.api import Claim, Instant, declare_claims
from scaloft_fi.sim.claims import CLAIMS, claims_of
from scaloft_fi.sources import closure
from scaloft_fi.stack.reference import claims as reference
from scaloft_fi.study import Study


def _sure(now: Instant) -> float:
    return 0.0


def test_a_stack_declares_its_claims_once():
    one = Claim("clock", "s", 0.1, _sure)
    declare_claims("clockwork", one)
    try:
        assert claims_of("clockwork") == (one,)
        with pytest.raises(ValueError, match="claims of the stack 'clockwork' is declared twice"):
            declare_claims("clockwork")
    finally:
        del CLAIMS._entries["clockwork"]


def test_the_reference_stack_has_claims_and_a_stack_may_have_none():
    assert claims_of("reference") == reference.CLAIMS
    assert claims_of("nobody's") == ()


def test_no_flight_depends_on_a_claim():
    flying = closure(Study.open().flying_modules)
    assert not [name for name in flying if "claim" in name]
