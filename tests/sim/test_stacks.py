"""Claims are declared for a stack by its name; its settings are read when it is flown."""

from __future__ import annotations

import pytest
from tiny_stack import SOUND

from scaloft_fi.errors import InputError
from scaloft_fi.sim.load import load
from scaloft_fi.sim.stacks import CLAIMS, claims_of, declare_claims
from scaloft_fi.sources import closure
from scaloft_fi.stack.declaration import Claim
from scaloft_fi.stack.reference.declaration import CLAIMS as OURS
from scaloft_fi.study import Study

STUDY = Study.open()


@pytest.fixture(autouse=True)
def no_claims_are_left():
    yield
    CLAIMS._entries.pop("hop", None)


def clock(**about):
    return Claim("clock", "s", 0.1, lambda _now: 0.0, **about)


def test_a_stack_declares_its_claims_once_and_may_have_none():
    assert claims_of(STUDY.stack, STUDY.signals) == OURS
    assert claims_of(SOUND, []) == ()
    one = clock(about=("elapsed_s",), seam="level")
    declare_claims("hop", one)
    assert claims_of(SOUND, ["elapsed_s"]) == (one,)
    with pytest.raises(ValueError, match="claims of the stack 'hop' is declared twice"):
        declare_claims("hop")


@pytest.mark.parametrize(
    ("claim", "message"),
    [
        (clock(seam="lvel"), "seam 'lvel' does not exist; did you mean 'level'?"),
        (clock(about=("elapsed",)), "signal 'elapsed' does not exist; did you mean"),
    ],
)
def test_a_claim_about_what_does_not_exist_is_refused(claim, message):
    declare_claims("hop", claim)
    with pytest.raises(InputError) as refused:
        claims_of(SOUND, ["elapsed_s", "x_m"])
    assert f"stack 'hop': claim 'clock': {message}" in str(refused.value)


def test_no_flight_depends_on_a_claim():
    assert not [name for name in closure(STUDY.flying_modules) if "claim" in name]


def test_the_stack_is_a_name_and_plain_parameters_and_an_unknown_setting_is_named(config, edited):
    assert config.stack.name == "reference"
    assert "name" not in config.stack.parameters
    assert isinstance(config.stack.parameters["control"]["rotors"], list)
    choice = load(edited("stack.yaml", "goal_radius_m:", "gaol_radius_m:")).stack
    sentence = r"stack.yaml:\d+: unknown key 'gaol_radius_m' in mission; did you mean 'goal_radius_m'"
    with pytest.raises(InputError, match=sentence):
        choice.settings(choice.declaration)
