from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import scaloft_fi

STUDY = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def study() -> scaloft_fi.OpenStudy:
    return scaloft_fi.open(STUDY)


def test_the_parts_of_a_study_are_columns(study: scaloft_fi.OpenStudy) -> None:
    assert study.requirements["requirement"].tolist() == ["SR1", "SR2", "SR2-literal", "OP1"]
    assert study.situations.rows == 32
    assert list(study.situations) == ["situation", "aliases", "T", "O", "W", "D", "H"]
    defaults = study.mutants["mutant"][study.mutants["counted"]]
    assert sorted(defaults) == sorted(study.definition.roster.defaults.values())
    assert study.folder == STUDY
    units = dict(zip(study.signals["signal"], study.signals["unit"], strict=True))
    assert (units["x_m"], units["qw"]) == ("m", "")


def test_a_notebook_shows_what_a_study_has(study: scaloft_fi.OpenStudy) -> None:
    assert "paper, 32 situations" in study._repr_html_()


def test_what_check_and_map_show_is_there_as_columns_and_as_a_figure(
    study: scaloft_fi.OpenStudy, tmp_path: Path
) -> None:
    findings = study.check()
    assert list(findings) == ["severity", "file", "line", "what", "situation", "remedy"]
    assert "error" not in findings["severity"].tolist()
    figure = study.map("T1O0W0D0H1")
    assert figure._repr_svg_().startswith("<svg")
    assert figure.save(tmp_path / "plan.PNG").read_bytes().startswith(b"\x89PNG")
    assert figure.save(f"{tmp_path}/plan.svg").read_text() == figure.svg
    with pytest.raises(scaloft_fi.InputError, match=r"must end in .svg or .png"):
        figure.save("plan.pdf")


def test_another_grid_has_its_own_situations_and_names_its_campaign() -> None:
    wide = scaloft_fi.open(STUDY, grid="wide")
    assert wide.situations.rows != 32
    assert wide.campaign().name == "wide"
    assert scaloft_fi.open(STUDY).campaign().name == "default"
    assert wide.campaign("mine").folder == STUDY / "results" / "campaigns" / "mine"


@pytest.mark.parametrize(
    ("study", "grid", "said"),
    [("/nowhere", None, "^study='/nowhere' must be a folder"), (STUDY, "wise", "^grid='wise' must be")],
)
def test_what_is_no_study_is_one_sentence(study: Path | str, grid: str | None, said: str) -> None:
    with pytest.raises(scaloft_fi.InputError, match=said):
        scaloft_fi.open(study, grid)


def test_a_flight_of_nobody_is_refused_before_anything_is_prepared(
    study: scaloft_fi.OpenStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.Physics", lambda: pytest.fail("it was prepared"))
    with pytest.raises(scaloft_fi.InputError, match="LATE-humna"):
        study.fly("LATE-humna", "T0O0W0D0H1")
    with pytest.raises(scaloft_fi.InputError, match="no situation 'T9'"):
        study.fly("LATE-human", "T9")


def test_the_package_itself_imports_nothing_heavy() -> None:
    heavy = "{'numpy', 'click', 'yaml', 'pandas', 'scaloft_fi.api', 'scaloft_fi.study'}"
    program = f"import sys, scaloft_fi; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_name_that_the_package_lacks_is_an_ordinary_error() -> None:
    assert set(scaloft_fi.__all__) <= set(dir(scaloft_fi))
    with pytest.raises(AttributeError, match="'scaloft_fi' has no attribute 'opne'"):
        _ = scaloft_fi.opne  # type: ignore[attr-defined]
