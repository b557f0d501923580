"""The public surface changes on purpose only: see `tests/support/api_surface.py`."""

from __future__ import annotations

import inspect
import sys

import api_surface
import pytest

import scaloft_fi
from scaloft_fi import api


@pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="other versions of Python write signatures otherwise")
def test_the_public_surface_is_the_one_that_was_written_down() -> None:
    assert api_surface.surface().splitlines() == api_surface.FILE.read_text().splitlines(), (
        "a public name has changed: run `python tests/support/api_surface.py` and write the change into CHANGELOG.md"
    )


def test_every_public_name_is_there_and_says_what_it_is() -> None:
    for module in (scaloft_fi, api):
        for name in module.__all__:
            value = getattr(module, name)
            if inspect.isfunction(value) or inspect.isclass(value):
                assert value.__doc__, name
