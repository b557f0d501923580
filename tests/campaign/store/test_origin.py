"""Keys of outcomes and what enters them."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.campaign.store.origin import Origin

hashes = st.text("0123456789abcdef", max_size=4)
origins = st.builds(Origin, hashes, hashes, hashes, hashes, hashes, hashes, hashes)


@given(origins, origins, st.integers(0, 2), st.integers(0, 2))
def test_two_keys_are_equal_when_all_that_enters_them_is(one: Origin, other: Origin, seed: int, later: int) -> None:
    assert one.key(seed) == Origin(*one).key(seed)
    assert (one.key(seed) == other.key(later)) == ((one, seed) == (other, later))


@given(origins, origins)
def test_the_parts_that_changed_are_those_that_differ(one: Origin, other: Origin) -> None:
    changed = one.changed(other)
    assert one._replace(**{name: getattr(other, name) for name in changed}) == other
    assert (changed == ()) == (one == other)
