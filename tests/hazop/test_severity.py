from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import SeverityClass, load_severities, worst_first

CLASSES = """injury: {title: a person is hurt, meaning: hurt}
damage: {title: the drone breaks, meaning: broken}
"""
LATE = """LATE:
  status: credible
  deviation: late
  causes: [slow]
  effect: slow late
  requirements: [SR2]
  faults: [{seam: person, operator: freeze}]
"""
MORE = "MORE: {status: not_meaningful, reason: none here}\n"
CONTROL = LATE.replace("LATE", "MORE").replace("credible", "control")


def study(folder: Path, severity: str = "", classes: str = CLASSES, more: str = MORE) -> Path:
    (folder / "matrix").mkdir()
    (folder / "guidewords.yaml").write_text("LATE: {title: L, meaning: l}\nMORE: {title: M, meaning: m}\n")
    (folder / "parameters.yaml").write_text("human: {title: person, intent: seen, node: a -> b, unit: boxes}\n")
    (folder / "matrix" / "human.yaml").write_text(LATE + severity + more)
    if classes:
        (folder / "severities.yaml").write_text(classes)
    return folder


def test_the_classes_stand_in_the_order_of_the_file_the_worst_first(tmp_path: Path) -> None:
    matrix = load_matrix(study(tmp_path, "  severity: damage\n"))
    assert [(one.rank, one.id) for one in matrix.classes] == [(0, "injury"), (1, "damage")]
    assert matrix.severities == {"LATE-human": SeverityClass(1, "damage", "the drone breaks", "broken")}


def test_a_part_of_the_matrix_keeps_its_classes(tmp_path: Path) -> None:
    matrix = load_matrix(study(tmp_path, "  severity: injury\n"))
    assert matrix.only(["LATE"]).severities == matrix.severities
    assert matrix.only(["LATE"]).classes == matrix.classes


@pytest.mark.parametrize("classes", [CLASSES, ""])
def test_a_cell_needs_no_class(tmp_path: Path, classes: str) -> None:
    assert load_matrix(study(tmp_path, classes=classes)).severities == {}


@pytest.mark.parametrize(
    ("severity", "classes", "more", "line", "error"),
    [
        ("  severity: inury\n", CLASSES, MORE, 8, "severity='inury' is not known; did you mean 'injury'?"),
        ("  severity: 3\n", CLASSES, MORE, 8, "severity=3 is not known"),
        ("  severity: injury\n", "", MORE, 8, "severity='injury' must be left out in a study without classes"),
        ("", CLASSES, MORE.replace("}", ", severity: injury}"), 8, "unknown key 'severity' in MORE"),
        ("", CLASSES, CONTROL + "  severity: damage\n", 15, "must be left out where the cell is not credible"),
    ],
)
def test_a_wrong_class_is_refused_with_its_place(
    tmp_path: Path, severity: str, classes: str, more: str, line: int, error: str
) -> None:
    with pytest.raises(InputError) as caught:
        load_matrix(study(tmp_path, severity, classes, more))
    assert str(caught.value).startswith(f"{tmp_path}/matrix/human.yaml:{line}:")
    assert error in str(caught.value)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("Injury: {title: t, meaning: m}\n", "name 'Injury' must be small letters"),
        ("injury: {title: t}\n", "injury lacks the key 'meaning'"),
        ("injury: {title: t, meaning: m, rank: 1}\n", "unknown key 'rank' in injury"),
        ("[injury]\n", "must be a mapping"),
    ],
)
def test_a_wrong_list_is_refused_with_its_place(tmp_path: Path, text: str, error: str) -> None:
    path = tmp_path / "severities.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_severities(path)
    assert str(caught.value).startswith(f"{path}:1:")
    assert error in str(caught.value)


@given(st.lists(st.tuples(st.integers(), st.none() | st.integers(0, 3))))
def test_worst_first_sorts_by_class_alone_and_keeps_the_order_within_it(entries: list[tuple[int, int | None]]) -> None:
    def severity(entry: tuple[int, int | None]) -> SeverityClass | None:
        return None if entry[1] is None else SeverityClass(entry[1], "x", "", "")

    found = worst_first(entries, severity)
    for rank in (0, 1, 2, 3, None):
        assert [one for one in found if one[1] == rank] == [one for one in entries if one[1] == rank]
    ranks = [9 if one[1] is None else one[1] for one in found]
    assert ranks == sorted(ranks)
