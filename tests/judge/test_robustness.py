"""A requirement that a flight did not put to the test prints no robustness, wherever robustness is printed."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet
import pytest
from builders import GRID, KINDS, ROSTER, outcome, pool

from scaloft_fi.analysis.detection import tallies
from scaloft_fi.analysis.margin import margins
from scaloft_fi.analysis.score import score
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind, Reading, measured_rho
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.verbs.export.dossier import columns, export_rows, parquet, to_csv, to_json
from scaloft_fi.verbs.first_screen import requirement_table
from scaloft_fi.verbs.margin import Margins, margin_tables

SENTINEL = 24.0
HUMAN = "T0O0W0D0H1"


def untested(flown: Outcome, name: str = "SR2") -> Outcome:
    """The flight in which the condition of a requirement never came true."""
    return replace(
        flown,
        readings=tuple(replace(r, rho=SENTINEL, triggered=0) if r.requirement == name else r for r in flown.readings),
    )


@pytest.mark.parametrize(
    ("reading", "compliance", "told"),
    [
        (Reading("SR2", Kind.SAFETY, 0.3, None, 1, open=False), Compliance.HELD, 0.3),
        (Reading("SR2", Kind.SAFETY, 0.3, None, 1, open=True), Compliance.OPEN, 0.3),
        (Reading("SR2", Kind.SAFETY, SENTINEL, None, 0, open=False), Compliance.VACUOUS, None),
        (Reading("SR2", Kind.SAFETY, SENTINEL, None, 0, open=True), Compliance.OPEN, None),
        (Reading("SR2", Kind.SAFETY, -0.1, 5.0, 0, open=False), Compliance.VIOLATED, -0.1),
    ],
)
def test_robustness_is_told_of_what_was_put_to_the_test_or_violated(
    reading: Reading, compliance: Compliance, told: float | None
):
    assert reading.compliance is compliance
    assert measured_rho(reading) == told


def test_a_row_of_the_export_has_nothing_there_in_every_format():
    rows = export_rows([untested(outcome())], ROSTER, GRID)
    (as_json,) = json.loads(to_json(rows))
    (as_csv,) = csv.DictReader(io.StringIO(to_csv(rows, columns(rows))))
    assert (as_json["rho_SR1"], as_json["rho_SR2"]) == (0.3, None)
    assert (as_csv["rho_SR1"], as_csv["rho_SR2"]) == ("0.3", "")
    assert as_json["held"] == list(KINDS)


def test_a_column_of_nothing_is_still_one_of_numbers_in_parquet():
    rows = export_rows([untested(outcome())], ROSTER, GRID)
    table = pyarrow.parquet.read_table(io.BytesIO(parquet(rows, columns(rows))))
    assert str(table.schema.field("rho_SR2").type) == "double"
    assert table.column("rho_SR2").to_pylist() == [None]


def test_the_least_robustness_is_that_of_the_flights_that_put_it_to_the_test():
    flights = [outcome(seed=0), untested(outcome(seed=1)), untested(outcome(seed=1), "OP1")]
    assert {t.requirement: t.least_rho for t in tallies(flights)}["SR2"] == 0.3
    alone = [untested(outcome())]
    assert {t.requirement: t.least_rho for t in tallies(alone)}["SR2"] is None
    rows = {row[0]: row[-1] for row in requirement_table(tallies(alone)).rows}
    assert (rows["SR1"], rows["SR2"]) == ("0.300", "n/a")


def test_an_end_of_a_margin_that_tests_nothing_has_no_robustness():
    matrix = load_matrix(Path(__file__).parents[2] / "hazop", REFERENCE.by_name)
    kills = [outcome("LATE-human@3s", HUMAN, seed, violated={"SR2": 8.0}) for seed in range(3)]
    flights = [*pool(HUMAN), untested(outcome("LATE-human@1s", HUMAN)), *kills]
    found = margins(flights, score(flights, ROSTER, GRID), matrix)
    (table,) = margin_tables(found, (), 1)
    assert table.rows[0][6] == "SR2 ? / -0.1"
    assert ["SR2" in tried.rho for tried in Margins.of(found).tried] == [False, True]
