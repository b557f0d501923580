from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from refusal import sentence

Call = Callable[..., Result]
ASKED = ("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
EDITS = {
    "situations.yaml": ("eventually(person_sight_m <= 3)", "eventually(clearance_person_m < 1)"),
    "requirements.yaml": ("person_sight_m / 3 <= 1", "person_sight_m / 3 <= 3"),
}


def beyond(study: Path, name: str) -> None:
    """Let a file of the study ask a signal for more than is measured of it."""
    path = study / "sim" / name
    old, new = EDITS[name]
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize("name", EDITS)
def test_a_study_that_asks_beyond_a_cap_does_not_fly_and_leaves_nothing_behind(
    call: Call, copy: Path, tmp_path: Path, name: str
) -> None:
    beyond(copy, name)
    assert f"{name}:" in sentence(call(*ASKED, study=copy))
    assert not (tmp_path / "campaign").exists()


@pytest.mark.parametrize("name", EDITS)
@pytest.mark.parametrize("verb", ["score", "status", "export", "kills", "worksheet", "coverage", "report"])
def test_who_reads_results_refuses_a_study_that_asks_beyond_a_cap(
    call: Call, copy: Path, tmp_path: Path, verb: str, name: str
) -> None:
    assert call(*ASKED, study=copy).exit_code == 0
    beyond(copy, name)
    words = ("--output", str(tmp_path / "page.html")) if verb == "report" else ()
    assert "it must be compared with" in sentence(call(verb, *words, study=copy))
    assert not (tmp_path / "page.html").exists()
