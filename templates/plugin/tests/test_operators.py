"""Each operator of the package turns the samples of its example into those that the example says."""

import pytest
from scaloft_fi.api import check_operator, operators_of

OWN = operators_of("your_plugin")


def test_there_is_an_operator():
    assert OWN


@pytest.mark.parametrize("name", OWN)
def test_the_example_holds(name):
    assert check_operator(name).failures == ()
