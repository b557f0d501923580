from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.campaign.workers.cluster import MOST_MESSAGE, Inbox, Message, sealed, unsealed

KEY, OTHER = b"k" * 32, b"o" * 32
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text() | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@given(st.text(), st.integers(), st.text(), st.integers(), st.text(), PLAIN)
def test_what_is_sealed_is_read_again_with_the_same_key_only(
    run: str, number: int, worker: str, order: int, kind: str, content: Any
) -> None:
    message = Message(run, number, worker, order, kind, content)
    assert unsealed(KEY, sealed(KEY, message)) == message
    with pytest.raises(ValueError, match="not signed with this key"):
        unsealed(OTHER, sealed(KEY, message))


@given(st.data())
def test_a_changed_message_is_refused(data: st.DataObject) -> None:
    text = sealed(KEY, Message("run", 1, "tcp://h:1", 1, "outcome", {"row": [1.5]}))
    place = data.draw(st.integers(0, len(text) - 1))
    other = data.draw(st.characters().filter(lambda character: character != text[place]))
    with pytest.raises(ValueError, match="not signed with this key"):
        unsealed(KEY, text[:place] + other + text[place + 1 :])


@given(PLAIN | st.binary() | st.tuples(st.text(), st.binary()))
def test_what_is_no_sealed_message_is_counted(event: Any) -> None:
    inbox = Inbox(KEY)
    inbox.receive((0.0, event))
    inbox.receive(event)
    assert inbox.strange == 2
    assert list(inbox.messages(0.0)) == []
    (line,) = inbox.summary()
    assert line == "warning: 2 messages on the scheduler did not carry the key of the run and were ignored"


def test_a_message_of_this_run_counts_once_and_in_order() -> None:
    inbox = Inbox(KEY)
    number, _ = inbox.order("fly", None)

    def receive(*, run: str = inbox.run, number: int = number, worker: str = "w", order: int = 1) -> None:
        inbox.receive((0.0, sealed(KEY, Message(run, number, worker, order, "begun"))))

    receive()
    receive()  # replayed
    receive(order=3)
    receive(order=2)  # late, so replayed
    receive(worker="v")
    receive(number=number + 1)  # of no task
    assert inbox.strange == 3
    assert [(m.worker, m.order) for m in inbox.messages(0.0)] == [("w", 1), ("w", 3), ("v", 1)]
    receive(run="a run beside this one, with the same key")
    assert inbox.strange == 3
    assert not list(inbox.messages(0.0))


def test_a_message_is_bounded() -> None:
    with pytest.raises(ValueError, match="is longer than"):
        sealed(KEY, Message("run", 1, "w", 1, "outcome", "x" * MOST_MESSAGE))
    with pytest.raises(ValueError, match="no sealed message"):
        unsealed(KEY, "x" * (MOST_MESSAGE + 1))
    with pytest.raises(ValueError, match="JSON compliant"):
        sealed(KEY, Message("run", 1, "w", 1, "outcome", float("nan")))


def test_a_signed_message_of_other_parts_is_refused() -> None:
    from scaloft_fi.campaign.workers.cluster import _mac

    for parts in ([], {}, ["run", "1", "w", 1, "kind", None], ["run", True, "w", 1, "kind", None], ["run", 1]):
        body = json.dumps(parts)
        with pytest.raises(ValueError, match="has other parts"):
            unsealed(KEY, _mac(KEY, body) + body)
