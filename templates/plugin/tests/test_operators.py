"""Each operator of the package turns the samples of its example into those that the example says."""

import pytest
from scaloft_fi.mutants.operators import OPERATORS

from your_plugin import operators

OWN = [name for name, one in OPERATORS.items() if one.make.__module__ == operators.__name__]


def test_there_is_an_operator():
    assert OWN


@pytest.mark.parametrize("name", OWN)
def test_the_example_holds(name):
    one = OPERATORS[name]
    tap = one.tap(one.example.context(), one.example.arguments)
    after = [tap(i / one.example.rate_hz, sample) for i, sample in enumerate(one.example.before)]
    assert repr(after) == repr(list(one.example.after))
