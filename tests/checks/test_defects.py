"""Each kind of finding by a planted defect: the sentence, its place, its remedy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml
from processes import ROOT
from studies import copied

from scaloft_fi.checks import Finding, Severity
from scaloft_fi.checks.check import check_study

TABLE = Path(__file__).parents[1] / "support" / "defects.yaml"


@dataclass(frozen=True)
class Defect:
    """A planted defect, and the finding that it brings.

    Attributes:
        file: the file that is edited.
        old, new: a text in it, and what takes its place; without `old` the file is new.
        what, remedy: parts of the sentence and of the remedy.
        at: a text in the line that the finding names.
        severity, situation: of the finding.
    """

    file: str
    what: str
    old: str = ""
    new: str = ""
    remedy: str = ""
    at: str = ""
    severity: str = "error"
    situation: str = ""

    def plant(self, study: Path) -> None:
        path = study / self.file
        text = path.read_text() if self.old else ""
        assert self.old in text
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.replace(self.old, self.new, 1) if self.old else self.new)

    def found_in(self, study: Path, finding: Finding) -> bool:
        if self.what not in finding.what or self.remedy not in finding.remedy:
            return False
        assert finding.severity == self.severity, finding
        assert finding.file == str(study / self.file), finding
        assert self.situation == finding.situation, finding
        if self.at:
            assert finding.line, finding
            assert self.at in (study / self.file).read_text().splitlines()[finding.line - 1], finding
        return True


DEFECTS = {name: Defect(**told) for name, told in yaml.safe_load(TABLE.read_text()).items()}
SEVERAL = (
    "an unknown seam",
    "an unknown key of a guideword",
    "an unknown role",
    "an unknown shape",
    "an unknown waypoint",
    "a number out of range",
    "a vehicle that is too heavy",
    "an unknown sensor",
    "an unknown kind of requirement",
    "an unknown signal",
    "a predicate over an unknown signal",
    "an axis without a name",
    "an unknown file",
)
"""Of eight files, several of some."""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """The reference study without its further grids and finds, which take most of the time."""
    return copied(tmp_path, "found.yaml", "grids")


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_is_found_with_its_place_and_its_remedy(study: Path, name: str):
    defect = DEFECTS[name]
    defect.plant(study)
    check = check_study(study)
    found = [finding for finding in check.findings if defect.found_in(study, finding)]
    assert found, [str(finding) for finding in check.findings]
    others = [finding for finding in check.findings if finding.severity is Severity.ERROR and finding not in found]
    assert others == [], "one defect, one error"


def test_the_page_shows_what_is_found(study: Path):
    for name in ("a predicate that comes true in no flight", "a waypoint without room for the hull"):
        DEFECTS[name].plant(study)
    found = {str(finding).replace(str(study), "my_study") for finding in check_study(study).findings}
    shown = (ROOT / "docs" / "check.md").read_text().split("```")[1].strip().splitlines()
    assert len(shown) == 3
    assert set(shown) <= found


def test_several_defects_at_once_are_all_found(study: Path):
    for name in SEVERAL:
        DEFECTS[name].plant(study)
    found = check_study(study).findings
    lost = [name for name in SEVERAL if not any(DEFECTS[name].found_in(study, finding) for finding in found)]
    assert lost == [], [str(finding) for finding in found]
