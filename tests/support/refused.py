"""Refusals: what bad input is told."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from scaloft_fi.errors import InputError


def refusal(call: Callable[..., object], *arguments: object) -> str:
    """What a call refuses its arguments with: one sentence, on one line."""
    with pytest.raises(InputError) as caught:
        call(*arguments)
    said = str(caught.value)
    assert "\n" not in said
    return said
