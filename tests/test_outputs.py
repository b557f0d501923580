"""What every verb prints on two small campaigns, in every format: it stays as it is recorded."""

from __future__ import annotations

import shlex

from effort import usually
from outputs import commands, printed, recorded

EVERY = usually(6, release=1)


def test_each_verb_prints_what_is_recorded_in_every_format() -> None:
    record = recorded()
    asked = list(dict.fromkeys(commands()))
    assert [" ".join(words) for words in asked] == list(record), "the record is made by python tests/support/outputs.py"
    for words in asked[::EVERY]:
        assert printed(words) == record[" ".join(words)], f"scaloft-fi {shlex.join(words)}"
