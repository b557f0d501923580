"""Finding and reading a study's matrix; refusals are recorded in `test_load.txt`."""

from __future__ import annotations

from pathlib import Path

import pytest
from options import as_recorded
from refused import refusal

from scaloft_fi.errors import InputError
from scaloft_fi.hazop import load
from scaloft_fi.hazop.load import FOLDERS, find_study, load_matrix
from scaloft_fi.hazop.matrix import CellStatus, SeverityClass

GUIDEWORDS = "LATE: {title: LATE, meaning: after its time}\nMORE: {title: MORE, meaning: larger}\n"
PARAMETERS = "human: {title: person detection, intent: seen, node: detector -> limit, unit: boxes}\n"
MORE = "MORE: {status: not_meaningful, reason: none here}\n"
LATE = """LATE:
  status: credible
  deviation: late
  causes: [slow]
  effect: slow late
  requirements: [SR2]
  faults:
    - seam: person
      operator: delay
      magnitude: {argument: delay_s, unit: s, ladder: [1, 3], default: 3}
"""


def hazop(folder: Path, human: str = LATE + MORE, **files: str) -> Path:
    (folder / "matrix").mkdir(parents=True)
    for name, text in {"guidewords": GUIDEWORDS, "parameters": PARAMETERS, "matrix/human": human, **files}.items():
        (folder / f"{name}.yaml").write_text(text)
    return folder


def with_magnitude(magnitude: str) -> str:
    return LATE.replace("{argument: delay_s, unit: s, ladder: [1, 3], default: 3}", magnitude) + MORE


def test_a_small_study_loads_with_the_places_of_its_faults(tmp_path: Path):
    matrix = load_matrix(hazop(tmp_path))
    fault = matrix.cell("LATE-human").faults[0]
    assert matrix.cell("MORE-human").status is CellStatus.NOT_MEANINGFUL
    assert fault.place_of("operator") == f"{tmp_path}/matrix/human.yaml:9"
    assert fault.place_of("delay_s") == f"{tmp_path}/matrix/human.yaml:10"
    assert matrix.cell("LATE-human").requirements_place == f"{tmp_path}/matrix/human.yaml:6"


CLASSES = "injury: {title: a person is hurt, meaning: hurt}\ndamage: {title: the drone breaks, meaning: broken}\n"
CONTROL = LATE.replace("LATE", "MORE").replace("credible", "control")


def with_class(name: str) -> str:
    return f"{LATE}  severity: {name}\n{MORE}"


BAD_CELLS = {
    "a blank cell": LATE,
    "an empty cell": LATE + "MORE:\n",
    "an unknown guideword": LATE + MORE + "LATER: {}\n",
    "an unknown status": LATE + "MORE: {status: credibel}\n",
    "a reason left out": LATE + "MORE: {status: not_meaningful}\n",
    "an empty reason": LATE + "MORE: {status: not_meaningful, reason: ''}\n",
    "a deviation that is not meaningful": LATE + "MORE: {status: not_meaningful, reason: none, effect: x}\n",
    "an unknown key": LATE.replace("effect:", "efect:") + MORE,
    "a key too many": LATE.replace("  effect", "  likelihood: 3\n  effect") + MORE,
    "no cause": LATE.replace("[slow]", "[]") + MORE,
    "one requirement without a list": LATE.replace("[SR2]", "SR2") + MORE,
    "an unknown key of a fault": LATE.replace("operator:", "operater:") + MORE,
    "a ladder that is a number": with_magnitude("{argument: delay_s, unit: s, ladder: 3, default: 3}"),
    "an empty ladder": with_magnitude("{argument: delay_s, unit: s, ladder: [], default: 3}"),
    "a default off the ladder": with_magnitude("{argument: delay_s, unit: s, ladder: [1, 2], default: 3}"),
    "a ladder that repeats": with_magnitude("{argument: delay_s, unit: s, ladder: [1, 1.0], default: 1}"),
    "a ladder that rises and falls": with_magnitude(
        "{argument: delay_s, unit: s, ladder: [0.2, 0.5, 0.1], default: 0.5}"
    ),
    "a ladder of numbers and names": with_magnitude("{argument: delay_s, unit: s, ladder: [1, x], default: 1}"),
    "a truth value on the ladder": with_magnitude("{argument: delay_s, unit: s, ladder: [yes], default: 1}"),
    "a name with a slash": with_magnitude("{argument: axis, ladder: [x/y], default: x/y}"),
    "a unit of a name": with_magnitude("{argument: axis, unit: m, ladder: [x], default: x}"),
    "a unit with a slash": with_magnitude("{argument: v, unit: m/s, ladder: [1], default: 1}"),
    "a direction that is none": with_magnitude("{argument: v, unit: m, worse: lager, ladder: [1, 2], default: 1}"),
    "a direction of names": with_magnitude("{argument: axis, worse: larger, ladder: [x], default: x}"),
    "a neutral magnitude without an order": with_magnitude(
        "{argument: v, unit: m, worse: unordered, neutral: 1, ladder: [1, 2], default: 1}"
    ),
    "a scale of zero": with_magnitude("{argument: v, unit: m, scale: 0, ladder: [1], default: 1}"),
    "a scale of a name": with_magnitude("{argument: axis, scale: 2, ladder: [x], default: x}"),
    "a unit that is no multiple of the argument's": with_magnitude(
        "{argument: delay_s, unit: bananas, ladder: [1], default: 1}"
    ),
    "a unit without its scale": with_magnitude("{argument: delay_s, unit: ms, ladder: [1], default: 1}"),
    "a unit with another's scale": with_magnitude("{argument: delay_s, unit: ms, scale: 60, ladder: [1], default: 1}"),
    "a fixed argument that varies": LATE.replace("      magnitude", "      arguments: {delay_s: 1}\n      magnitude")
    + MORE,
    "a list as argument": LATE.replace("      magnitude", "      arguments: {axes: [1, 2]}\n      magnitude") + MORE,
    "phases that are no flag": LATE + "      phases: 4\n" + MORE,
    "phases of nothing": LATE + "      phases: true\n" + MORE,
    "an expectation that is another": LATE + "      expected: {status: survived, reason: x}\n" + MORE,
    "an expectation without reason": LATE + "      expected: {status: not_infected}\n" + MORE,
    "an expectation off the ladder": LATE
    + "      expected: {status: not_infected, reason: x, magnitudes: [2]}\n"
    + MORE,
    "two faults in one unit": LATE + LATE.split("faults:\n")[1] + MORE,
    "a second fault without magnitude": LATE + "    - {seam: person, operator: drop}\n" + MORE,
    "a syntax error": LATE + MORE + "EARLY: {status: [\n",
    "a cell that stands twice": LATE + MORE + MORE,
}
"""Cells of a parameter that are wrong."""
BAD: dict[str, dict[str, str]] = {
    **{what: {"human": cells} for what, cells in BAD_CELLS.items()},
    "a guideword in small letters": {"guidewords": "late: {title: LATE, meaning: x}\n"},
    "a guideword without meaning": {"guidewords": "LATE: {title: LATE}\n"},
    "an extension without reason": {"guidewords": "LATE: {title: LATE, meaning: x, extension: true}\n"},
    "a guideword's unknown key": {"guidewords": "LATE: {title: LATE, meaning: x, extention: true}\n"},
    "a parameter in capitals": {"parameters": "HUMAN: {title: x, intent: x, node: x, unit: x}\n"},
    "a parameter without intent": {"parameters": "human: {title: x, node: x, unit: x}\n"},
    "a parameter without cells": {"parameters": PARAMETERS + "imu: {title: x, intent: x, node: x, unit: x}\n"},
    "cells of no parameter": {"parameters": PARAMETERS.replace("human", "humans")},
    "an unknown class": {"human": with_class("inury"), "severities": CLASSES},
    "a number for a class": {"human": with_class("3"), "severities": CLASSES},
    "a class in a study without any": {"human": with_class("injury")},
    "a class of a cell that is not meaningful": {
        "human": LATE + MORE.replace("}", ", severity: injury}"),
        "severities": CLASSES,
    },
    "a class of a control": {"human": LATE + CONTROL + "  severity: damage\n", "severities": CLASSES},
    "a class in capitals": {"severities": "Injury: {title: t, meaning: m}\n"},
    "a class without meaning": {"severities": "injury: {title: t}\n"},
    "a class with its rank": {"severities": "injury: {title: t, meaning: m, rank: 1}\n"},
    "a list of classes": {"severities": "[injury]\n"},
}
"""Files of a study that are wrong, by their names."""


def test_whatever_is_wrong_is_one_sentence_with_its_place(tmp_path: Path):
    said = {}
    for number, (what, files) in enumerate(BAD.items()):
        folder = hazop(tmp_path / str(number), **files)
        said[what] = refusal(load_matrix, folder).replace(f"{folder}/", "")
    as_recorded(__file__, said)


def test_the_classes_stand_in_the_order_of_the_file_the_worst_first(tmp_path: Path):
    matrix = load_matrix(hazop(tmp_path, with_class("damage"), severities=CLASSES))
    assert [(one.rank, one.id) for one in matrix.classes] == [(0, "injury"), (1, "damage")]
    assert matrix.severities == {"LATE-human": SeverityClass(1, "damage", "the drone breaks", "broken")}
    part = matrix.only(["LATE"])
    assert (part.severities, part.classes) == (matrix.severities, matrix.classes)


@pytest.mark.parametrize("files", [{"severities": CLASSES}, {}])
def test_a_cell_needs_no_class(tmp_path: Path, files: dict[str, str]):
    assert load_matrix(hazop(tmp_path, **files)).severities == {}


def test_an_unknown_seam_is_refused_where_the_seams_are_given(tmp_path: Path):
    with pytest.raises(InputError, match=r"human.yaml:8: seam='person' is not known; did you mean 'persons'\?"):
        load_matrix(hazop(tmp_path), seams=("persons", "depth"))


def test_a_missing_file_is_one_sentence(tmp_path: Path):
    with pytest.raises(InputError, match=r"guidewords.yaml: cannot be read"):
        load_matrix(tmp_path)


def study(path: Path) -> Path:
    for name in FOLDERS:
        (path / name).mkdir(parents=True)
    return path


def test_the_nearest_study_upwards_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    here = study(tmp_path / "mine")
    (here / "results" / "deep").mkdir(parents=True)
    monkeypatch.chdir(here / "results" / "deep")
    assert find_study() == here


@pytest.mark.parametrize("place", ["scaloft_fi/_study", "."])
def test_outside_a_study_the_packaged_one_is_used_else_that_beside_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
):
    known = study(tmp_path / "installed" / place)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setattr(load, "_PACKAGE", tmp_path / "installed" / "scaloft_fi")
    assert find_study() == known


def test_no_study_anywhere_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(load, "_PACKAGE", tmp_path / "scaloft_fi")
    with pytest.raises(InputError, match=r"no study in .* name one with --study"):
        find_study()


def test_a_named_folder_that_is_no_study_says_what_it_lacks(tmp_path: Path):
    (tmp_path / "hazop").mkdir()
    with pytest.raises(InputError, match=r"must be a folder with hazop/, mutants/ and sim/; it lacks mutants/, sim/"):
        find_study(tmp_path)


def test_a_named_folder_that_is_not_there_is_told_with_the_nearest_study_beside_it(tmp_path: Path):
    for name in ("hazop", "mutants", "sim"):
        (tmp_path / "my_mine" / name).mkdir(parents=True)
    (tmp_path / "my_mint").mkdir()
    with pytest.raises(InputError, match=rf"and sim/; there is no such folder; did you mean '{tmp_path}/my_mine'\?"):
        find_study(tmp_path / "my_mina")
    with pytest.raises(InputError, match=r"and sim/; there is no such folder$"):
        find_study(tmp_path / "nowhere" / "my_mina")


def test_a_named_study_is_taken_as_it_was_named(tmp_path: Path):
    assert find_study(str(study(tmp_path / "mine"))) == tmp_path / "mine"


def test_a_fault_where_what_flies_offers_no_seam_is_refused_with_its_place(tmp_path: Path):
    with pytest.raises(
        InputError, match=r"matrix/\w+\.yaml:\d+: faults=\[\.\.\.\] must be left out where what flies offers"
    ):
        load_matrix(hazop(tmp_path), seams={})
