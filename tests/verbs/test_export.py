"""`export`: the rows of every flight, files, formats of others."""

from __future__ import annotations

import csv
import io
import json
import random
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet
import pytest
from builders import GRID, KINDS, ROSTER, campaigns, outcome, seeded
from click.testing import Result
from effort import usually
from hypothesis import given, settings
from hypothesis import strategies as st

from scaloft_fi.analysis.pool import Pool
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.verbs.export.dossier import (
    FORMATS,
    Dossier,
    FlightRow,
    columns,
    export_format,
    export_rows,
    parquet,
    to_csv,
    to_json,
)

M = "LATE-human@3s"
RHO = [f"rho_{name}" for name in KINDS]
COLUMNS = [
    *("mutant", "situation", "seed", "status", "ending", "violated", *RHO),
    *("infected_at_s", "violated_at_s", "x", "y", "z", "struck", "duration_s", "digest"),
    *("held", "revealed_by", "violation_times_s", "violation_bodies", "triggered", "realised", "carried", "altered"),
]


def csv_of(rows: list[FlightRow]) -> str:
    return to_csv(rows, columns(rows))


def test_a_row_has_the_columns_of_the_contract_in_their_order() -> None:
    (row,) = export_rows([outcome()], ROSTER, GRID)
    assert list(row) == COLUMNS
    assert columns([], list(KINDS)) == COLUMNS


def test_a_flight_that_reveals_its_fault_says_when_where_and_what_was_struck() -> None:
    flown = outcome(M, violated={"SR1": 20.0, "OP1": 5.0}, struck="")
    (_, row) = export_rows([outcome(), flown], ROSTER, GRID)
    assert (row["status"], row["violated"]) == ("revealed", ["SR1", "OP1"])
    assert (row["violated_at_s"], row["x"], row["y"], row["z"], row["struck"]) == (20.0, 1.0, 2.0, 1.65, "")
    (_, row) = export_rows([outcome(), outcome(M, violated={"SR1": 20.0}, struck="wall")], ROSTER, GRID)
    assert (row["struck"], row["ending"], row["duration_s"]) == ("wall", "struck", 20.0)


def test_a_flight_whose_baseline_does_not_count_waits_and_is_not_invalid() -> None:
    rows = export_rows([outcome(M), outcome(M, seed=1, invalid="the worker died")], ROSTER, GRID)
    assert [row["status"] for row in rows] == ["waiting", "invalid"]


def test_rows_are_ordered_baseline_placebo_catalogue_then_off_the_ladder_situation_seed() -> None:
    mutants = [
        "LATE-human@2.5s",
        "MORE-goal@0.6m",
        PLACEBO_ID,
        "LATE-human@3s",
        BASELINE,
        "LATE-human@1s",
        "NO-human@100%",
    ]
    flown = [outcome(m, key, seed) for m in mutants for seed in (1, 0) for key in ("T0O0W0D0H1", "T0O0W0D0H0")]
    rows = export_rows(flown, ROSTER, GRID)
    assert list(dict.fromkeys(row["mutant"] for row in rows)) == [
        *(BASELINE, PLACEBO_ID, "NO-human@100%", "LATE-human@1s", "LATE-human@3s", "LATE-human@2.5s", "MORE-goal@0.6m")
    ]
    assert [(row["situation"][-2:], row["seed"]) for row in rows[:4]] == [("H0", 0), ("H0", 1), ("H1", 0), ("H1", 1)]


def test_csv_joins_lists_and_leaves_what_there_is_not_empty() -> None:
    text = csv_of(export_rows([outcome(), outcome(M, violated={"SR1": 20.0, "SR2": 9.0})], ROSTER, GRID))
    held, revealed = csv.DictReader(io.StringIO(text))
    assert (held["violated"], held["violated_at_s"], held["infected_at_s"], held["status"]) == ("", "", "", "held")
    assert (revealed["violated"], revealed["violated_at_s"]) == ("SR1;SR2", "9.0")


def test_a_row_says_what_the_figures_of_the_score_follow_from() -> None:
    struck = outcome(M, violated={"SR1": 20.0, "SR2": 9.0, "OP1": 5.0})
    base, row = export_rows([outcome(), struck], ROSTER, GRID)
    assert (base["held"], base["realised"], base["revealed_by"]) == (list(KINDS), ["T", "O", "W", "D", "H"], [])
    assert (row["held"], row["revealed_by"]) == (["SR2-literal"], ["SR2", "SR1", "OP1"])
    assert (row["violated"], row["violation_times_s"]) == (["SR1", "SR2", "OP1"], [20.0, 9.0, 5.0])
    cut = outcome(M, violated={"SR1": 20.0}, struck="wall")
    (_, row) = export_rows([outcome(), cut], ROSTER, GRID)
    assert (row["held"], row["violation_bodies"], row["carried"], row["altered"]) == ([], ["wall"], 100, 5)


@given(seeded())
@settings(deadline=None, max_examples=usually(25, release=30))
def test_the_pool_of_a_campaign_follows_from_its_rows(outcomes: list[Outcome]) -> None:
    rows = [row for row in export_rows(outcomes, ROSTER, GRID) if row["mutant"] == BASELINE and row["ending"]]
    for (situation, name), pair in Pool.of(outcomes).pairs.items():
        own = [row for row in rows if row["situation"] == situation]
        violated = [name in row["violated"] for row in own]
        held = [name in row["held"] for row in own]
        triggered = [name in (*row["violated"], *row["triggered"]) for row in own]
        counts = (len(own), sum(violated), len(own) - sum(violated) - sum(held), sum(triggered))
        assert (pair.flights, pair.violated, pair.open, pair.triggered) == counts


def test_an_export_of_nothing_is_an_empty_list_and_a_header() -> None:
    assert json.loads(to_json([])) == []
    assert to_csv([], columns([], list(KINDS))) == ",".join(COLUMNS) + "\n"


@given(campaigns(), st.randoms())
def test_an_export_does_not_depend_on_the_order_of_flights(outcomes: list[Outcome], chance: random.Random) -> None:
    shuffled = list(outcomes)
    chance.shuffle(shuffled)
    rows = export_rows(outcomes, ROSTER, GRID)
    again = export_rows(shuffled, ROSTER, GRID)
    assert to_json(rows) == to_json(again)
    assert csv_of(rows) == csv_of(again)


@given(campaigns())
def test_json_and_csv_say_the_same_of_every_flight(outcomes: list[Outcome]) -> None:
    rows = export_rows(outcomes, ROSTER, GRID)
    assert json.loads(to_json(rows)) == rows
    parsed = list(csv.DictReader(io.StringIO(csv_of(rows))))
    assert len(parsed) == len(outcomes)
    for row, other in zip(rows, parsed, strict=True):
        assert all(str(row[name]) == other[name] for name in ("mutant", "situation", "seed", "status", "digest"))
        assert (row["status"] == "revealed") <= bool(row["violated"])


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


Call = Callable[..., Result]


def test_an_export_has_one_row_per_flight_in_order_and_csv_says_the_same(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--baseline-seeds", "1", "--quiet")
    rows = json.loads(call("export").stdout)
    assert [(row["mutant"], row["situation"]) for row in rows] == [
        (mutant, f"T0O0W0D0H{h}") for mutant in ("baseline", "PLACEBO", "LATE-human@3s") for h in (0, 1)
    ] + [("REVERSE-velcmd", "T0O0W0D0H0")]
    assert (rows[-2]["violated"], rows[-2]["status"], rows[-2]["revealed_by"]) == (["SR2"], "revealed", ["SR2"])
    table = list(csv.DictReader(io.StringIO(call("export", "--format", "csv").stdout)))
    assert [row["digest"] for row in table] == [row["digest"] for row in rows]


def test_a_campaign_that_grew_spends_alpha_by_looks_in_every_format(call: Call) -> None:
    for seeds in ("1", "3"):
        words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--seeds", seeds, "--baseline-seeds", "10")
        call("run", *words, "--jobs", "1", "--quiet")
    assert "| mutation score | 0/1 = 0 % |" in " ".join(call("export", "--format", "markdown").stdout.split())
    (row,) = csv.DictReader(io.StringIO(call("dispositions", "--format", "csv").stdout))
    assert (row["mutant"], row["verdict"]) == ("LATE-human@3s", "undecided")
    sheet = csv.DictReader(io.StringIO(call("worksheet", "--format", "csv").stdout))
    assert next(row["needed"] for row in sheet if row["cell"] == "LATE-human") == "5 seeds"
    (survivor,) = json.loads(call("kills", "--show", "survivors", "--format", "json").stdout)["survivors"]
    assert (survivor["verdict"], "alpha 0.0025" in survivor["why"]) == ("undecided", True)


def test_an_export_can_go_to_a_file(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    assert call("export", "--output", str(tmp_path / "e.json")).stdout == ""
    assert json.loads((tmp_path / "e.json").read_text())[0]["mutant"] == "baseline"


def test_the_help_lists_every_format(call: Call) -> None:
    listed = call("export", "--help").stdout
    assert all(f"\n  {name} " in listed for name in FORMATS)


def test_a_format_that_somebody_else_declares_is_listed_and_written(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(FORMATS, "_entries", dict(FORMATS._entries))

    @export_format("flown", "the flights, counted")
    def flown(dossier: Dossier) -> dict[str, int]:
        return {"flights": len(dossier.rows)}

    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--baseline-seeds", "1", "--quiet")
    assert "the flights, counted" in call("export", "--help").stdout
    written = json.loads(call("export", "--format", "flown").stdout)["flights"]
    assert written == len(json.loads(call("export").stdout))
    with pytest.raises(ValueError, match="export format 'flown' is declared twice"):
        export_format("flown", "again")(flown)
