"""The file of accepted survivors: what it may say, and what a draft of it looks like."""

from __future__ import annotations

from datetime import date
from pathlib import Path

import pytest
from builders import GRID

from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import draft, load_dispositions

MATRIX = load_matrix(Path(__file__).parents[1] / "hazop", REFERENCE.by_name)
KEYS = [key for key, _ in GRID.points]
GOOD = """\
LATE-human:
  status: accepted
  owner: A. Engineer
  reason: walking pace is slow enough there
  expires: 2027-01-31
  situations: [T0O0W0D0H1]
"""
DAY = date(2027, 1, 31)


def loaded(folder: Path, text: str) -> tuple[Disposition, ...]:
    path = folder / "dispositions.yaml"
    path.write_text(text, encoding="utf-8")
    return load_dispositions(path, MATRIX, KEYS)


def test_a_study_without_the_file_has_accepted_nothing(tmp_path: Path) -> None:
    assert load_dispositions(tmp_path / "dispositions.yaml", MATRIX, KEYS) == ()


def test_a_bare_cell_is_its_default_and_the_place_is_remembered(tmp_path: Path) -> None:
    (only,) = loaded(tmp_path, GOOD)
    assert (only.mutant, only.expires, only.situations) == ("LATE-human@3s", DAY, ("T0O0W0D0H1",))
    assert only.place.endswith("dispositions.yaml:1")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("LATE-human:", "LATE-humna:", "did you mean 'LATE-human'?"),
        ("LATE-human:", "EARLY-collision:", "not meaningful"),
        ("status: accepted", "status: acepted", "status='acepted' is not known; did you mean 'accepted'?"),
        ("owner: A. Engineer", "owner: ''", "owner='' must be a text"),
        ("reason: walking pace is slow enough there", "reason: ' '", "reason=' ' must be a text"),
        ("2027-01-31", "2027-02-30", "expires='2027-02-30' cannot be read: day is out of range"),
        ("2027-01-31", "'2027-02-30'", "must be a date such as 2027-01-31"),
        ("2027-01-31", "''", "must be a date such as 2027-01-31"),
        ("2027-01-31", "31.1.2027", "must be a date such as 2027-01-31"),
        ("T0O0W0D0H1", "T0O0W0D0H2", "did you mean 'T0O0W0D0H"),
        ("[T0O0W0D0H1]", "[]", "must be a list of at least one"),
        ("owner:", "onwer:", "unknown key 'onwer'"),
        ("  situations", "  sitautions", "unknown key 'sitautions'"),
        ("  expires: 2027-01-31\n", "", "lacks the key 'expires'"),
    ],
)
def test_what_it_does_not_understand_it_refuses_with_the_place(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(InputError) as error:
        loaded(tmp_path, GOOD.replace(old, new))
    assert says in str(error.value)
    assert "dispositions.yaml:" in str(error.value)


@pytest.mark.parametrize("again", ["LATE-human", "LATE-human@3s", "LATE-human@3.0s"])
def test_a_mutant_that_stands_twice_is_refused_however_it_is_written(tmp_path: Path, again: str) -> None:
    with pytest.raises(InputError, match=r"twice|already at"):
        loaded(tmp_path, GOOD + GOOD.replace("LATE-human", again))


def test_a_draft_is_refused_until_it_is_filled_in_and_then_loads(tmp_path: Path) -> None:
    text = draft(["LATE-human@3s", "NO-human@100%"])
    with pytest.raises(InputError, match="owner='' must be a text"):
        loaded(tmp_path, text)
    filled = text.replace('owner: ""', "owner: me").replace('reason: ""', "reason: why")
    entries = loaded(tmp_path, filled.replace('expires: ""', "expires: 2027-01-31"))
    assert [entry.mutant for entry in entries] == ["LATE-human@3s", "NO-human@100%"]
