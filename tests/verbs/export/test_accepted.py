"""What each format makes of a survivor that somebody accepted, and of one that has a find; the rows as a table."""

from __future__ import annotations

import io
from datetime import date
from typing import Any
from xml.etree import ElementTree as ET

import pyarrow.parquet
import pytest
import yaml
from builders import GRID, KINDS, ROSTER, campaigns, outcome, pool
from dossiers import dossier
from finding import flies, found, known
from hypothesis import given

from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.verbs.export.assurance import gsn, to_markdown, verification_log
from scaloft_fi.verbs.export.ci import junit, mutation_testing, sarif, summary
from scaloft_fi.verbs.export.dossier import FORMATS, Dossier, parquet
from scaloft_fi.verbs.export.rows import columns, export_rows

LATE, MORE, NO = "LATE-human@3s", "MORE-goal@0.6m", "NO-human@100%"
LAST = date(2027, 1, 31)
KNOWN = Disposition(MORE, "A. Owner", "the goal is far from any wall", LAST)
TOLD = "accepted by A. Owner until 2027-01-31: the goal is far from any wall"


def _dossier(today: date, *more: Disposition) -> Dossier:
    """LATE is detected, MORE survives, NO changes nothing."""
    seeds = range(10)
    flights = [*pool("T0O0W0D0H0"), outcome(NO, altered=0)]
    flights += [outcome(LATE, seed=seed, violated={"SR2": 7.0}) for seed in seeds]
    flights += [outcome(MORE, seed=seed) for seed in seeds]
    return dossier(flights, dispositions=(KNOWN, *more), today=today)


@pytest.fixture
def holds() -> Dossier:
    return _dossier(LAST)


@pytest.fixture
def expired() -> Dossier:
    return _dossier(date(2027, 2, 1))


def _goals(dossier: Dossier) -> dict[str, Any]:
    nodes: dict[str, Any] = yaml.safe_load(gsn(dossier))
    return nodes


def test_the_goal_of_an_accepted_survivor_is_developed_until_the_last_day(holds: Dossier, expired: Dossier) -> None:
    nodes = _goals(holds)
    supporters = [nodes[name] for name in nodes["G4"]["supportedBy"]]
    (goal, others) = supporters
    assert MORE in goal["text"]
    assert [nodes[name]["text"] for name in goal["supportedBy"]] == [f"hazop/dispositions.yaml: {TOLD}"]
    assert others["undeveloped"]
    assert [one["text"] for one in nodes.values() if "challenges" in one] == [
        f"{NO} was not put to the test",
        f"{MORE} would not have been revealed",
    ]
    assert "undeveloped" not in nodes["G4"]
    assert _goals(expired)["G4"]["undeveloped"]
    assert TOLD not in gsn(expired)


def test_where_every_mutant_that_is_not_detected_is_accepted_no_goal_over_them_is_left_open() -> None:
    flights = [*pool("T0O0W0D0H0"), *(outcome(MORE, seed=seed) for seed in range(10))]
    nodes = _goals(dossier(flights, dispositions=(KNOWN,), today=LAST))
    assert not [name for name, node in nodes.items() if node.get("undeveloped")]


def test_junit_skips_an_accepted_survivor_and_fails_it_after_the_last_day(holds: Dossier, expired: Dossier) -> None:
    (case,) = ET.fromstring(junit(holds)).findall(f".//testcase[@name='{MORE}']")
    skipped = case.find("skipped")
    assert skipped is not None
    assert skipped.attrib["message"].endswith(TOLD)
    (case,) = ET.fromstring(junit(expired)).findall(f".//testcase[@name='{MORE}']")
    assert [child.tag for child in case] == ["failure"]


def test_sarif_suppresses_an_accepted_survivor_with_the_justification(holds: Dossier, expired: Dossier) -> None:
    def suppressed(dossier: Dossier) -> dict[str, Any]:
        (run,) = sarif(dossier)["runs"]
        return {one["partialFingerprints"]["mutant/v1"]: one["suppressions"] for one in run["results"]}

    assert suppressed(holds) == {
        NO: [],
        MORE: [{"kind": "external", "status": "accepted", "justification": TOLD}],
    }
    assert suppressed(expired) == {NO: [], MORE: []}


def test_readers_of_mutation_testing_ignore_an_accepted_survivor(holds: Dossier, expired: Dossier) -> None:
    def told(dossier: Dossier) -> dict[str, tuple[str, str]]:
        mutants = [one for file in mutation_testing(dossier)["files"].values() for one in file["mutants"]]
        return {one["id"]: (one["status"], one["statusReason"]) for one in mutants}

    assert told(holds)[MORE][0] == "Ignored"
    assert told(holds)[MORE][1].startswith(TOLD)
    assert (told(holds)[LATE][0], told(expired)[MORE][0]) == ("Killed", "Survived")


def test_the_page_has_the_score_with_and_without_them(holds: Dossier, expired: Dossier) -> None:
    assert (holds.score.mutation_score.short, holds.without_accepted.short) == ("1/3", "1/2")
    lines = summary(holds).splitlines()
    assert [line for line in lines if "without accepted" in line and "1/2" in line]
    assert [line for line in lines if MORE in line and "A. Owner" in line and "2027-01-31" in line]
    assert "A. Owner" not in summary(expired)


def test_the_verification_log_has_every_acceptance_with_its_state(holds: Dossier, expired: Dossier) -> None:
    def states(dossier: Dossier) -> list[object]:
        (table,) = [table for table in verification_log(dossier) if table.title == "Accepted survivors"]
        return [row[1] for row in table.rows]

    assert (states(holds), states(expired)) == (["accepted"], ["expired"])
    assert "the goal is far from any wall" in to_markdown(holds)
    assert not [t for t in verification_log(dossier([*pool("T0O0W0D0H0")])) if t.title == "Accepted survivors"]


def test_what_is_detected_or_not_tested_is_no_accepted_survivor() -> None:
    more = [Disposition(name, "A. Owner", "known", LAST) for name in (LATE, NO)]
    made = _dossier(LAST, *more)
    assert set(made.accepted) == {MORE}
    assert made.without_accepted.short == "1/2"


HERE = "T0O0W0D0H0"
FLIGHTS = [*pool(HERE), *(outcome(id_, HERE, seed) for id_ in (LATE, NO) for seed in range(3))]


@pytest.mark.parametrize(
    ("style", "next_"),
    [("mutation-testing", "; next: "), ("markdown", "; next: "), ("sarif", "Next: "), ("junit", "; next: ")],
)
def test_the_find_is_the_next_step_of_its_survivor_which_needs_no_search(style: str, next_: str) -> None:
    text = FORMATS[style].content(dossier(FLIGHTS, known(found(LATE)))).decode().replace("\\", "")
    bare = FORMATS[style].content(dossier(FLIGHTS)).decode()
    assert f"{next_}{flies(LATE)}" in text
    assert flies(LATE) not in bare
    if style in ("sarif", "junit"):
        assert f"scaloft-fi seek {NO}" in text
        assert (f"scaloft-fi seek {LATE}" in bare, f"scaloft-fi seek {LATE}" in text) == (True, False)


@given(campaigns())
def test_a_data_frame_gets_back_every_row_of_the_export(outcomes: list[Outcome]) -> None:
    names = list(KINDS)
    rows = export_rows(outcomes, ROSTER, GRID, names)
    table = pyarrow.parquet.read_table(io.BytesIO(parquet(rows, columns(rows, names))))
    assert table.column_names == columns(rows, names)
    assert table.to_pylist() == rows


def test_a_list_stays_a_list_and_a_seed_a_whole_number() -> None:
    schema = pyarrow.parquet.read_table(io.BytesIO(parquet([], columns([], list(KINDS))))).schema
    assert str(schema.field("violated").type) == "list<element: string>"
    assert str(schema.field("seed").type) == "int64"
    assert str(schema.field("rho_SR1").type) == "double"
