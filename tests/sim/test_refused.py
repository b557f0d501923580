"""Bad input of every file of the `sim` folder is refused in one sentence with file and line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from builders import with_range
from finding import BAR
from refused import refusal

from scaloft_fi.campaign.seeking.finds import text
from scaloft_fi.errors import InputError
from scaloft_fi.sim.grid import Finds, load_grid
from scaloft_fi.sim.load import load
from tests.sim.test_grid import FIND

BAD = yaml.safe_load(Path(__file__).with_name("refused.yaml").read_text())
FREE = """free:
  Xs:
    title: cruise speed
    category: speed
    set: mission.cruise_mps
    from: 0.4
    to: 1.2
    unit: m/s
    distribution: uniform
    benign: 0.5
"""


@pytest.fixture
def whole(study: Path) -> Path:
    """The copy with the files that it lacks."""
    own = (study / "situations.yaml").read_text().split("aliases:")[0].replace("name: paper", "")
    (study / "grids" / "free.yaml").write_text(own + FREE)
    (study / "found.yaml").write_text(text(Finds("search", (FIND,), (BAR,))))
    return study


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: f"{bad['file']}: {bad['says']}")
def test_bad_input_is_refused_in_one_sentence_with_file_and_line(whole: Path, bad: dict[str, str]):
    ranged = bad["file"] == "a range"
    file = "situations.yaml" if ranged else bad["file"]
    path = (with_range(whole, first=True) if ranged else whole) / file
    assert bad["old"] in path.read_text()
    path.write_text(path.read_text().replace(bad["old"], bad["new"], 1))
    grid = {"found.yaml": "paper+found", "grids/free.yaml": "free"}.get(file)
    said = refusal(lambda: load(whole, grid=load_grid(whole, grid) if grid else None))
    assert bad["says"] in said
    assert re.search(rf"{file}(:\d+)?: ", said)


@pytest.mark.parametrize("file", ["world", "vehicle", "sensors", "situations", "stack"])
def test_a_missing_file_is_named(study: Path, file: str):
    (study / f"{file}.yaml").unlink()
    with pytest.raises(InputError, match=rf"{file}.yaml: cannot be read: No such file"):
        load(study)
