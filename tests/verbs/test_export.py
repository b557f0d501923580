"""`export`: the rows of every flight, files, formats of others, which their own readers read."""

from __future__ import annotations

import csv
import io
import json
import random
import re
import shlex
from collections import Counter
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import jsonschema
import pyarrow.parquet
import pytest
import yaml
from builders import CLASSED, GRID, KINDS, ROSTER, campaigns, outcome, pool, seeded
from finding import found, known
from hypothesis import given, settings
from hypothesis import strategies as st
from junitparser import Error, Failure, JUnitXml, Skipped
from options import as_recorded, usually
from printed import Call, told_by
from published_flights import ROOT
from sarif_pydantic import Sarif
from studies import copied

from scaloft_fi.analysis.detection import Pool, Spending, Verdict
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.hazop.matrix import Cell, CellStatus, Guideword, Matrix, Parameter
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.requirement import Requirement
from scaloft_fi.output import line
from scaloft_fi.study import NO_FINDS, KnownFinds, Study
from scaloft_fi.verbs.export.dossier import (
    FORMATS,
    Dossier,
    FlightRow,
    columns,
    csv_rows,
    export_format,
    export_rows,
    parquet,
    to_csv,
    to_json,
)
from scaloft_fi.verbs.export.formats import gsn, junit, mutation_testing, sarif, to_markdown
from scaloft_fi.verbs.export.formats import to_json as sace_json
from scaloft_fi.verbs.first_screen import Screen, answers

HOSTILE = "<script>alert('1')</script> \"&\" =cmd|' /C calc'!A0 ]]> 人 \\textbf{x} " + "long " * 60
WORDS, PARAMETERS = ("NO", "LATE", "MORE", "REVERSE"), ("human", "goal")
LINES = {(word, parameter): 3 + i for parameter in PARAMETERS for i, word in enumerate(WORDS)}

MATRIX = Matrix(
    guidewords=tuple(Guideword(word, word.lower(), "") for word in WORDS),
    parameters=tuple(Parameter(name, name, "", "", "") for name in PARAMETERS),
    cells={
        (word, name): Cell(
            word,
            name,
            CellStatus.CONTROL if word == "REVERSE" else CellStatus.CREDIBLE,
            deviation=f"{word} {name} {HOSTILE}",
            effect=HOSTILE,
            place=f"/elsewhere/hazop/matrix/{name}.yaml:{line}",
        )
        for (word, name), line in LINES.items()
    },
)
SOURCES = {f"hazop/matrix/{name}.yaml": "".join(f"line {i}\n" for i in range(20)) for name in PARAMETERS}


def dossier(
    outcomes: list[Outcome],
    finds: KnownFinds = NO_FINDS,
    dispositions: tuple[Disposition, ...] = (),
    today: date | None = None,
) -> Dossier:
    return Dossier(
        study="reference",
        campaign=HOSTILE,
        version="0",
        platform={"system": "Linux", "numpy": "2"},
        matrix=MATRIX,
        space=GRID,
        roster=ROSTER,
        requirements=tuple(Requirement(name, kind, "always(x > 0)", title=HOSTILE) for name, kind in KINDS.items()),
        outcomes=tuple(outcomes),
        spending=Spending(),
        sources=SOURCES,
        finds=finds,
        dispositions=dispositions,
        today=today,
    )


def dossiers() -> st.SearchStrategy[Dossier]:
    """Of campaigns without a pool, and with one."""
    return st.one_of(campaigns(), seeded()).map(dossier)


M = "LATE-human@3s"
RHO = [f"rho_{name}" for name in KINDS]
COLUMNS = [
    *("mutant", "situation", "seed", "status", "ending", "violated", *RHO),
    *("infected_at_s", "violated_at_s", "x", "y", "z", "struck", "duration_s", "digest"),
    *("held", "revealed_by", "violation_times_s", "violation_bodies", "triggered", "realised", "carried", "altered"),
]


def csv_of(rows: list[FlightRow]) -> str:
    return to_csv((row.values() for row in rows), columns(rows))


def test_a_row_has_the_columns_of_the_contract_in_their_order():
    (row,) = export_rows([outcome()], ROSTER, GRID)
    assert list(row) == COLUMNS
    assert columns([], list(KINDS)) == COLUMNS


def test_a_flight_that_reveals_its_fault_says_when_where_and_what_was_struck():
    flown = outcome(M, violated={"SR1": 20.0, "OP1": 5.0}, struck="")
    (_, row) = export_rows([outcome(), flown], ROSTER, GRID)
    assert (row["status"], row["violated"]) == ("revealed", ["SR1", "OP1"])
    assert (row["violated_at_s"], row["x"], row["y"], row["z"], row["struck"]) == (20.0, 1.0, 2.0, 1.65, "")
    (_, row) = export_rows([outcome(), outcome(M, violated={"SR1": 20.0}, struck="wall")], ROSTER, GRID)
    assert (row["struck"], row["ending"], row["duration_s"]) == ("wall", "struck", 20.0)


def test_a_flight_whose_baseline_does_not_count_waits_and_is_not_invalid():
    rows = export_rows([outcome(M), outcome(M, seed=1, invalid="the worker died")], ROSTER, GRID)
    assert [row["status"] for row in rows] == ["waiting", "invalid"]


def test_rows_are_ordered_baseline_placebo_catalogue_then_off_the_ladder_situation_seed():
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


def test_csv_joins_lists_and_leaves_what_there_is_not_empty():
    text = csv_of(export_rows([outcome(), outcome(M, violated={"SR1": 20.0, "SR2": 9.0})], ROSTER, GRID))
    held, revealed = csv.DictReader(io.StringIO(text))
    assert (held["violated"], held["violated_at_s"], held["infected_at_s"], held["status"]) == ("", "", "", "held")
    assert (revealed["violated"], revealed["violated_at_s"]) == ("SR1;SR2", "9.0")


def test_a_row_says_what_the_figures_of_the_score_follow_from():
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
def test_the_pool_of_a_campaign_follows_from_its_rows(outcomes: list[Outcome]):
    rows = [row for row in export_rows(outcomes, ROSTER, GRID) if row["mutant"] == BASELINE and row["ending"]]
    for (situation, name), pair in Pool.of(outcomes).pairs.items():
        own = [row for row in rows if row["situation"] == situation]
        violated = [name in row["violated"] for row in own]
        held = [name in row["held"] for row in own]
        triggered = [name in (*row["violated"], *row["triggered"]) for row in own]
        counts = (len(own), sum(violated), len(own) - sum(violated) - sum(held), sum(triggered))
        assert (pair.flights, pair.violated, pair.open, pair.triggered) == counts


def test_an_export_of_nothing_is_an_empty_list_and_a_header():
    assert json.loads(to_json([])) == []
    assert to_csv([], columns([], list(KINDS))) == ",".join(COLUMNS) + "\n"


@given(dossiers())
def test_csv_has_the_values_of_the_rows(told: Dossier):
    assert csv_rows(told) == to_csv((row.values() for row in told.rows), told.columns)


@given(campaigns(), st.randoms())
def test_an_export_does_not_depend_on_the_order_of_flights(outcomes: list[Outcome], chance: random.Random):
    shuffled = list(outcomes)
    chance.shuffle(shuffled)
    rows = export_rows(outcomes, ROSTER, GRID)
    again = export_rows(shuffled, ROSTER, GRID)
    assert to_json(rows) == to_json(again)
    assert csv_of(rows) == csv_of(again)


@given(campaigns())
def test_json_and_csv_say_the_same_of_every_flight(outcomes: list[Outcome]):
    rows = export_rows(outcomes, ROSTER, GRID)
    assert json.loads(to_json(rows)) == rows
    parsed = list(csv.DictReader(io.StringIO(csv_of(rows))))
    assert len(parsed) == len(outcomes)
    for row, other in zip(rows, parsed, strict=True):
        assert all(str(row[name]) == other[name] for name in ("mutant", "situation", "seed", "status", "digest"))
        assert (row["status"] == "revealed") <= bool(row["violated"])


@given(campaigns())
def test_a_data_frame_gets_back_every_row_of_the_export(outcomes: list[Outcome]):
    names = list(KINDS)
    rows = export_rows(outcomes, ROSTER, GRID, names)
    table = pyarrow.parquet.read_table(io.BytesIO(parquet(rows, columns(rows, names))))
    assert table.column_names == columns(rows, names)
    assert table.to_pylist() == rows


def test_a_list_stays_a_list_and_a_seed_a_whole_number():
    schema = pyarrow.parquet.read_table(io.BytesIO(parquet([], columns([], list(KINDS))))).schema
    assert str(schema.field("violated").type) == "list<element: string>"
    assert str(schema.field("seed").type) == "int64"
    assert str(schema.field("rho_SR1").type) == "double"


def test_an_export_has_one_row_per_flight_in_order_and_csv_says_the_same(call: Call):
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--baseline-seeds", "1", "--quiet")
    rows = json.loads(call("export").stdout)
    assert [(row["mutant"], row["situation"]) for row in rows] == [
        (mutant, f"T0O0W0D0H{h}") for mutant in ("baseline", "PLACEBO", "LATE-human@3s") for h in (0, 1)
    ] + [("REVERSE-velcmd", "T0O0W0D0H0")]
    assert (rows[-2]["violated"], rows[-2]["status"], rows[-2]["revealed_by"]) == (["SR2"], "revealed", ["SR2"])
    table = list(csv.DictReader(io.StringIO(call("export", "--format", "csv").stdout)))
    assert [row["digest"] for row in table] == [row["digest"] for row in rows]


def test_a_campaign_that_grew_spends_alpha_by_looks_in_every_format(call: Call):
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


def test_an_export_can_go_to_a_file(call: Call, tmp_path: Path):
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    assert call("export", "--output", str(tmp_path / "e.json")).stdout == ""
    assert json.loads((tmp_path / "e.json").read_text())[0]["mutant"] == "baseline"


def test_the_help_lists_every_format(call: Call):
    listed = call("export", "--help").stdout
    assert all(f"\n  {name} " in listed for name in FORMATS)


def test_a_format_that_somebody_else_declares_is_listed_and_written(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
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


HERE, THERE, RED = "T0O0W0D0H0", "T0O0W0D0H1", "T0O0W0D1H1"
LATE, MORE, NO, CONTROL = "LATE-human@3s", "MORE-goal@0.6m", "NO-human@100%", "REVERSE-human"
BOTH = {"SR1": 20.0, "SR2": 20.0}
LAST = date(2027, 1, 31)
ACCEPTED = [Disposition(id_, "A. Owner", "the goal is far from any wall", LAST) for id_ in (MORE, LATE, NO)]


def flown(id_: str, *keys: str, seeds: int = 3, **how: Any) -> list[Outcome]:
    return [outcome(id_, key, seed, **how) for key in keys or (HERE,) for seed in range(seeds)]


def made(*flights: Outcome, pooled: tuple[str, ...] = (HERE,), **how: Any) -> Dossier:
    """A dossier of a study whose texts are short."""
    told = replace(dossier([*pool(*pooled), *flights]), campaign="mine", **how)
    short = {"deviation": "what differs", "effect": "why it matters"}
    cells = {key: replace(cell, **short) for key, cell in told.matrix.cells.items()}
    requirements = tuple(replace(one, title="in words") for one in told.requirements)
    return replace(told, matrix=replace(told.matrix, cells=cells), requirements=requirements)


IDLE = outcome()
IDLE = replace(
    IDLE, readings=tuple(replace(r, rho=24.0, triggered=0) if r.requirement == "SR2" else r for r in IDLE.readings)
)
THREE = (*flown(LATE, violated={"SR2": 7.0}, seeds=10), *flown(MORE, seeds=10), outcome(NO, altered=0))
FIND = (*flown(LATE), *flown(NO))
ALL = ("gsn", "junit", "markdown", "mutation-testing", "sace", "sarif")
CASES = {
    "one is detected, one accepted, one not tested": (made(*THREE, dispositions=tuple(ACCEPTED), today=LAST), ALL),
    "the day after": (
        made(*THREE, dispositions=(ACCEPTED[0],), today=date(2027, 2, 1)),
        ("gsn", "junit", "markdown", "sace", "sarif"),
    ),
    "every survivor is accepted": (made(*flown(MORE, seeds=10), dispositions=(ACCEPTED[0],), today=LAST), ("gsn",)),
    "a survivor with a find, and one without": (
        made(*FIND, finds=known(found(LATE))),
        ("junit", "markdown", "mutation-testing", "sarif"),
    ),
    "without a pool": (
        made(outcome(), outcome(LATE, violated={"SR2": 7.0}), outcome("LATE-human@1s"), outcome(NO), pooled=()),
        ALL,
    ),
    "the second of three flights says most": (
        made(*(outcome(LATE, HERE, seed, violated={"SR2": 7.0} if seed == 1 else {}) for seed in range(3))),
        ("junit", "sarif"),
    ),
    "a control that operability detects": (made(*flown(CONTROL, violated={"OP1": 9.0})), ("junit",)),
    "a control flown once shows itself": (made(outcome(CONTROL, violated={"SR2": 9.0})), ("junit",)),
    "a control flown once shows itself by operability": (made(outcome(CONTROL, violated={"OP1": 9.0})), ("junit",)),
    "a control flown once shows nothing": (made(outcome(CONTROL)), ("junit", "mutation-testing")),
    "a control that was tested shows nothing": (made(*flown(CONTROL)), ("junit",)),
    "a control without a verdict shows itself": (
        made(*flown(BASELINE, seeds=2), *flown(CONTROL, seeds=2, violated={"SR1": 9.0}), pooled=()),
        ("junit", "mutation-testing"),
    ),
    "killed in one of two situations that test it, and flown in a red one": (
        made(
            *(one for id_ in (LATE, NO, MORE) for one in flown(id_, RED)),
            *(*flown(LATE, THERE, violated={"SR2": 7.0}), *flown(LATE), *flown(NO), outcome(NO, seed=5)),
            *pool(RED, red=9, violated=BOTH),
            pooled=(HERE, THERE),
        ),
        ("markdown", "mutation-testing", "sace"),
    ),
    "classes of severity": (made(*map(outcome, (NO, LATE, MORE)), roster=CLASSED), ("gsn", "markdown", "sarif")),
    "all situations": (made(outcome(LATE), pooled=tuple(key for key, _ in GRID.points)), ("gsn",)),
    "two opposite situations": (made(outcome(LATE), pooled=(HERE, "T1O1W1D1H1")), ("gsn",)),
    "many flights of the unmutated drone, one of which violates": (
        made(*flown("baseline", HERE, THERE, seeds=20), outcome(seed=99, violated={"SR1": 5.0}), pooled=()),
        ("sace",),
    ),
    "a requirement that nothing puts to the test": (made(IDLE, pooled=()), ("sace",)),
    "no default was flown": (made(*flown("LATE-human@1s"), *flown(CONTROL)), ("gsn", "markdown", "sace", "sarif")),
    "a gate failed": (made(*THREE, invalid=("no score is valid, because 3 flights are invalid",)), ALL),
    "a search, without a pool": (
        made(outcome(LATE), pooled=(), invalid=("no score is valid: a search",)),
        ("markdown",),
    ),
    "an id that XML cannot carry": (made(*flown("LATE-human@\x003s")), ("junit",)),
}


def test_what_a_format_says_is_as_recorded():
    cases = ((name, case, style) for name, (case, styles) in CASES.items() for style in styles)
    as_recorded(__file__, {f"{name}: {style}": FORMATS[style].content(case).decode() for name, case, style in cases})


UNEVEN = made(
    *(*flown(LATE, seeds=5), *flown(MORE, seeds=1), *flown(NO, seeds=1), outcome(NO, seed=1, invalid="it failed")),
    *(*flown(CONTROL, seeds=1), outcome(PLACEBO_ID, seed=7), *flown(LATE, THERE, seeds=2)),
    pooled=(HERE, THERE),
)


def test_no_export_claims_seeds_that_were_not_flown():
    cases = sace_json(UNEVEN)["Test case details"]["rows"]
    assert [(row["mutants"], row["seeds of the mutants"]) for row in cases] == [(4, f"0; {LATE}: 0-4"), (1, "0-1")]
    assert {row["seeds of the unmutated drone"] for row in cases} == {"0-9"}
    context = read_gsn(gsn(UNEVEN))["C3"]["text"]
    assert context.startswith("3 mutants from a HAZOP deviation matrix, 3 of them the defaults of their cells")
    assert context.endswith(", 1 to 5 seeds each in a situation")
    answered = dict(answers(UNEVEN.score, Study.open(ROOT), "mine"))
    assert "1 to 5 seeds beside 10 baseline flights a situation." in answered["How sure"]


def test_a_mild_magnitude_beside_the_default_is_no_test_of_junit():
    (suite,) = read_junit(junit(made(*flown(LATE, violated={"SR2": 7.0}), *flown("LATE-human@0.5s")))).values()
    assert suite == {LATE: []}


def test_the_argument_and_the_log_name_the_campaign_in_their_commands():
    said = gsn(UNEVEN) + gsn(made(*flown(LATE, violated={"SR2": 7.0}))) + to_markdown(UNEVEN)
    commands = re.findall(r"scaloft-fi (?:score|export|replay)[^;\n']*", " ".join(said.split()))
    assert len(commands) == 8
    assert all("--campaign mine" in command for command in commands)


def test_the_log_counts_the_flights_that_trigger_a_requirement_and_not_its_episodes():
    twice = replace(UNEVEN.outcomes[0], readings=tuple(replace(r, triggered=2) for r in UNEVEN.outcomes[0].readings))
    told = replace(UNEVEN, outcomes=(twice, *UNEVEN.outcomes[1:]))
    rows = sace_json(told)["Sufficiency of coverage (1): safety requirements"]["rows"]
    clean = [row for row in told.rows if row["mutant"] == BASELINE]
    of_rows = [sum(name in row["triggered"] for row in clean) for name in ("SR1", "SR2")]
    assert [row["flights that trigger it"] for row in rows] == of_rows == [20, 20]


def test_a_reader_of_sarif_finds_the_file_of_a_study_below_the_root_of_its_repository(call: Call, tmp_path: Path):
    study = copied(tmp_path / "repo" / "safety" / "mine", "found.yaml")
    (tmp_path / "repo" / ".git").mkdir()
    told_by(call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H0", "--quiet", study=study))
    (result,) = json.loads(told_by(call("export", "--format", "sarif", study=study)))["runs"][0]["results"]
    place = result["locations"][0]["physicalLocation"]["artifactLocation"]
    assert place == {"uri": "safety/mine/hazop/matrix/human.yaml"}


def test_of_more_than_four_mutants_with_other_seeds_the_log_has_the_number():
    ids = [f"LATE-human@{number}s" for number in range(11)]
    told = made(*(one for id_ in ids[:6] for one in flown(id_, seeds=1)), *(one for i in ids[6:] for one in flown(i)))
    assert sace_json(told)["Test case details"]["rows"][0]["seeds of the mutants"] == "0; 5 mutants: 0-2"


def test_the_log_has_the_trigger_of_each_requirement_and_every_definition_that_is_used():
    near, slow = ("near", "person_m < 6"), ("slow", "speed_mps < 1")
    plain, first, *others = UNEVEN.requirements
    used = replace(first, text="always(trigger implies slow)", trigger="once(near)", definitions=(near, slow))
    told = replace(UNEVEN, requirements=(plain, used, *(replace(one, definitions=(near,)) for one in others)))
    log = sace_json(told)
    assert [row["trigger"] for row in log["Required results"]["rows"][:2]] == ["none", "once(near)"]
    assert [tuple(row.values()) for row in log["Definitions in the required results"]["rows"]] == [near, slow]
    assert "Definitions in the required results" not in sace_json(UNEVEN)


def test_the_log_names_the_version_that_flew_once_and_its_own_where_that_is_another():
    def parts(platform: dict[str, str]) -> list[tuple[str, str]]:
        rows = sace_json(replace(UNEVEN, platform=platform))["Test environment"]["rows"]
        return [(row["part"], row["version"]) for row in rows]

    assert parts({"scaloft-fi": "0", "numpy": "2"}) == [("scaloft-fi", "0"), ("numpy", "2")]
    assert parts({"scaloft-fi": "9"}) == [("scaloft-fi", "9"), ("scaloft-fi of this log", "0")]


@given(dossiers())
def test_a_control_passes_where_the_screen_counts_it_as_shown_and_says_by_what(dossier: Dossier):
    screen = Screen(Study.open(ROOT), dossier.score, dossier.coverage)
    suite = next((suite for suite in JUnitXml.fromstring(junit(dossier).encode()) if suite.name == "controls"), ())
    passed = [case.system_out for case in suite if not case.result]
    assert f"{len(passed)} of {len(dossier.score.controls)} show" in screen._controls
    assert all(re.fullmatch(r"shows itself by \S.*", told) for told in passed)


def read_junit(text: str) -> dict[str, dict[str, list[type]]]:
    """Per suite and test case the kinds of its results, as a reader of JUnit files sees them."""
    return {
        suite.name: {case.name: [type(result) for result in case.result] for case in suite}
        for suite in JUnitXml.fromstring(text.encode())
    }


def kinds(mutant: MutantScore) -> list[type]:
    if not mutant.flown:
        return [Error]
    return {Verdict.DETECTED: [], Verdict.NOT_DETECTED: [Failure]}.get(mutant.verdict, [Skipped])


@given(dossiers())
def test_a_detected_mutant_passes_and_every_other_case_carries_the_replay_and_the_next_step(dossier: Dossier):
    text = junit(dossier)
    suites = read_junit(text)
    listed = [one for one in dossier.score.mutants if dossier.roster.counts(one.subject)] or dossier.score.mutants
    assert sum(len(own) for name, own in suites.items() if name != "controls") == len(listed)
    for mutant in listed:
        assert suites[mutant.subject.parameter][mutant.subject.id] == kinds(mutant)
    assert set(suites.get("controls", {})) == {control.subject.id for control in dossier.score.controls}
    flown = {outcome.name for outcome in dossier.outcomes}
    scores = {mutant.subject.id: mutant for mutant in (*dossier.score.mutants, *dossier.score.controls)}
    whole = JUnitXml.fromstring(text.encode())
    for case in (case for suite in whole for case in suite):
        for result in case.result:
            first, *_ = (shlex.split(told.partition(": ")[2]) for told in result.text.splitlines())
            assert first[:2] == ["scaloft-fi", "replay"]
            assert first[2] in flown
            assert first[2].startswith(f"{case.name}/")
            assert line(f"; next: {dossier.next_command(scores[case.name])}") in result.message
    said = (whole.tests, whole.failures, whole.errors, whole.skipped)
    whole.update_statistics()
    assert said == (whole.tests, whole.failures, whole.errors, whole.skipped)


@given(dossiers())
def test_a_reader_of_sarif_finds_each_mutant_that_is_not_detected_on_the_line_of_its_cell(dossier: Dossier):
    plain = sarif(dossier)
    (run,) = Sarif.model_validate_json(json.dumps(plain, allow_nan=False)).runs
    rules = run.tool.driver.rules or []
    assert sorted({result.rule_id for result in run.results}) == sorted(rule.id for rule in rules)
    mutants = [mutant for mutant in dossier.score.faults if not mutant.detected]
    flown = {outcome.name for outcome in dossier.outcomes}
    for result, raw, mutant in zip(run.results, plain["runs"][0]["results"], mutants, strict=True):
        assert result.partial_fingerprints["mutant/v1"] == mutant.subject.id
        place = result.locations[0].physical_location
        assert place.artifact_location.uri == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert place.region.start_line == LINES[mutant.subject.guideword, mutant.subject.parameter]
        rule, steps = rules[result.rule_index], raw["properties"]
        assert rule.id == result.rule_id == f"{mutant.subject.guideword}-{mutant.subject.parameter}"
        assert HOSTILE in rule.short_description.text
        program, verb, name, *campaign = shlex.split(steps["replay"])
        assert (program, verb, campaign) == ("scaloft-fi", "replay", ["--campaign", dossier.campaign])
        assert name in flown
        assert name.startswith(f"{mutant.subject.id}/")
        assert shlex.split(steps["next"])[0] == "scaloft-fi"
        assert shlex.split(steps["seek"]) == ["scaloft-fi", "seek", mutant.subject.id]
        assert all(command in result.message.text for command in (steps["replay"], steps["next"]))
        assert all(command in rule.help.text for command in steps.values())


SCHEMA = json.loads((Path(__file__).parents[1] / "support" / "mutation-testing-report-schema-3.8.4.json").read_text())


@given(dossiers())
def test_the_report_of_mutation_testing_fits_its_schema_and_its_readers_compute_our_score(dossier: Dossier):
    report = mutation_testing(dossier)
    jsonschema.Draft7Validator(SCHEMA).validate(json.loads(json.dumps(report, allow_nan=False)))
    found = {m["id"]: (name, m) for name, file in report["files"].items() for m in file["mutants"]}
    counts = Counter(mutant["status"] for _, mutant in found.values())
    killed, survived, uncovered = counts["Killed"], counts["Survived"], counts["NoCoverage"]
    scored = dossier.score
    assert Ratio(killed, killed + survived + uncovered) == scored.mutation_score
    if scored.pooled:
        assert Ratio(killed, killed + survived) == Ratio(scored.mutation_score.part, scored.tested.part)
    tests = {test["id"] for file in report["testFiles"].values() for test in file["tests"]}
    flown = (*scored.mutants, *scored.controls)
    assert sorted(found) == sorted(mutant.subject.id for mutant in flown)
    for mutant in flown:
        name, entry = found[mutant.subject.id]
        assert name == f"hazop/matrix/{mutant.subject.parameter}.yaml"
        assert entry["location"]["start"]["line"] == LINES[mutant.subject.guideword, mutant.subject.parameter]
        assert HOSTILE in entry["description"]
        assert set(entry["killedBy"]) <= set(entry["coveredBy"]) <= tests
        assert not entry["killedBy"] or entry["status"] in ("Killed", "Ignored")
        assert entry["coveredBy"] or entry["status"] not in ("Killed", "Survived")


PREFIX = re.compile(r"(CG|CSn|Sn|G|S|C|A|J)\d+")
SUPPORTERS = {"G": {"G", "S", "Sn"}, "S": {"G", "S", "Sn"}, "CG": {"CG", "CSn", "S"}}
"""By which kinds of nodes a node may be supported."""


def read_gsn(text: str) -> dict[str, Any]:
    found = yaml.safe_load(text)
    assert set(found.pop("module")) == {"name", "brief"}
    return dict(found)


def kind(name: str) -> str:
    match = PREFIX.fullmatch(name)
    assert match, name
    return match[1]


@given(dossiers())
def test_every_node_has_a_kind_and_a_text_and_hangs_on_one_root_or_challenges_it(dossier: Dossier):
    nodes = read_gsn(gsn(dossier))
    referred = set[str]()
    for name, node in nodes.items():
        assert node["text"]
        supporters, context = node.get("supportedBy", []), node.get("inContextOf", [])
        assert len({*supporters, *context}) == len(supporters) + len(context)
        assert name not in supporters
        assert {*supporters, *context, *([node["challenges"]] if "challenges" in node else [])} <= nodes.keys()
        assert all(kind(other) in SUPPORTERS[kind(name)] for other in supporters)
        assert all(kind(other) in {"C", "A", "J"} for other in context)
        if kind(name) in {"G", "S", "CG"}:
            assert node.get("undeveloped", False) is not bool(supporters)
        referred |= {*supporters, *context}
    assert {name for name, node in nodes.items() if name not in referred and "challenges" not in node} == {"G1"}
    challenges = [node["text"].split(" ")[0] for node in nodes.values() if node.get("challenges") == "G3"]
    assert challenges == [mutant.subject.id for mutant in dossier.score.faults if not mutant.detected]
    decided = dossier.score.pooled and dossier.score.counted
    assert nodes["G4"].get("undeveloped", False) is bool(challenges or not decided)


@given(dossiers())
def test_the_log_has_the_same_headings_as_a_page_and_as_json(dossier: Dossier):
    page = to_markdown(dossier)
    headings = [line.removeprefix("### ") for line in page.splitlines() if line.startswith("### ")]
    assert list(json.loads(json.dumps(sace_json(dossier), allow_nan=False))) == headings
