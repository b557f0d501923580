"""Makes the helpers in `support` importable; Hypothesis draws the same examples in every run, at any speed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from scaloft_fi import study

sys.path.insert(0, str(Path(__file__).parent / "support"))

settings.register_profile("scaloft-fi", derandomize=True, deadline=None)
settings.load_profile("scaloft-fi")


@pytest.fixture(scope="session", autouse=True)
def sources_parsed_once() -> Iterator[None]:
    """A study that is opened hashes the sources of the package; in the tests a source of the same bytes only once."""
    meaning, known = study._meaning, dict[tuple[Path, bytes], str]()

    def known_meaning(path: Path) -> str:
        key = path, path.read_bytes()
        if key not in known:
            known[key] = meaning(path)
        return known[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "_meaning", known_meaning)
        yield
