"""Answers, screens and refusals of all verbs: forms, widths, sentences; `RECORD=1` writes the sentences anew."""

from __future__ import annotations

import json
import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator, ValidationError
from options import usually
from printed import READERS, STUDY, Call, invoked, no_terms, of_form, one_table, sentence, told_by

import scaloft_fi
from scaloft_fi.analysis.score import By
from scaloft_fi.verbs.schema import answer_form


@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_json_has_the_form_that_the_verb_declares_and_csv_is_one_table(told: Call, words: tuple[str, ...]):
    assert of_form(words[0], told_by(told(*words, "--format", "json")))["version"] == answer_form(words[0]).version
    text = told(*words, "--format", "csv").stdout
    assert one_table(text) or words[-1] == "--flights"
    assert not text.startswith("#")
    assert no_terms(told(*words, "--format", "markdown").stdout) == [] or words[0] in ("matrix", "compare")


def test_a_run_answers_in_the_form_of_the_score(folder: Path, told: Call):
    run = of_form("run", (folder / "run.json").read_text(encoding="utf-8"))
    assert run == json.loads(told("score", "--format", "json").stdout)
    assert [mutant["verdict"] for mutant in run["mutants"]] == ["detected", "not_detected"]
    assert [control["id"] for control in run["controls"]] == ["REVERSE-velcmd"]


def test_an_export_has_the_columns_of_its_form(told: Call):
    rows = json.loads(told("export").stdout)
    Draft202012Validator(answer_form("export").schema).validate(rows)
    names = [*(name for name in rows[0] if not name.startswith("rho_"))]
    assert names == list(answer_form("export").keys)
    with pytest.raises(ValidationError):
        Draft202012Validator(answer_form("export").schema).validate([{**rows[0], "rows": 1}])


def test_what_is_merged_and_written_is_told(told: Call, folder: Path, tmp_path: Path):
    words = ["merge", str(folder), "--study", str(STUDY), "--campaign", str(tmp_path / "whole"), "--format", "json"]
    merged = of_form("merge", invoked(*words).stdout)
    assert merged["added"] == of_form("status", told("status", "--format", "json").stdout)["counted"]
    page = tmp_path / "page.html"
    report = of_form("report", told("report", "--output", str(page), "--format", "json").stdout)
    nothing = {"flights": 0, "reasons": [], "command": None, "differed": [], "invalid": [], "broken": 0}
    assert report == {"version": "1.1", "report": str(page), "bytes": page.stat().st_size, "stale": nothing}


def test_groups_of_every_kind_have_one_shape(told: Call):
    for by in map(str, By):
        groups = of_form("score", told("score", "--by", by, "--format", "json").stdout)["groups"]
        assert groups
        assert {group["by"] for group in groups} == {by}
        assert all((group["axis"] is None) == (group["value"] is None) == (by != "axis") for group in groups)
    assert {(group["axis"], group["value"]) for group in groups} >= {("H", "0"), ("H", "1")}
    assert of_form("score", told("score", "--format", "json").stdout)["groups"] == []


@pytest.mark.parametrize(
    ("words", "ask"),
    [
        (("status",), lambda campaign: campaign.status()),
        (("coverage",), lambda campaign: campaign.coverage()),
        (("worksheet",), lambda campaign: campaign.worksheet()),
        (("dispositions",), lambda campaign: campaign.dispositions()),
        (("diff", "CAMPAIGN", "CAMPAIGN"), lambda campaign: campaign.diff(campaign.name)),
        (
            ("kills", "MORE-goal", "--show", "survivors", "--situation", "T0O0W0D0H?"),
            lambda campaign: campaign.kills("MORE-goal", "T0O0W0D0H?", show="survivors"),
        ),
    ],
    ids=lambda one: one[0] if isinstance(one, tuple) else "",
)
def test_a_script_gets_what_the_verb_prints(
    told: Call, folder: Path, words: tuple[str, ...], ask: Callable[[scaloft_fi.OpenCampaign], scaloft_fi.Answer]
):
    answer = ask(scaloft_fi.open(STUDY).campaign(str(folder)))
    assert answer.record() == json.loads(told(*words, "--format", "json").stdout)
    for style in ("table", "markdown", "latex", "csv"):
        assert answer.text(style) == told(*words, "--format", style).stdout
    assert "<table>" in answer._repr_html_()
    assert {name: columns.rows for name, columns in answer.items()} == {
        name: len(one_table(text)) for name, text in answer.csv().items() if name != "summary"
    }


def test_a_script_saves_the_worksheet_that_the_verb_writes(told: Call, folder: Path, tmp_path: Path):
    sheet = scaloft_fi.open(STUDY).campaign(str(folder)).worksheet()
    for end, style in ((".txt", "table"), (".xlsx", "xlsx")):
        told("worksheet", "--format", style, "--output", f"{tmp_path}/verb{end}")
        assert sheet.save(tmp_path / f"script{end}").read_bytes() == (tmp_path / f"verb{end}").read_bytes()
    with pytest.raises(scaloft_fi.InputError, match=r"^path='sheet.ods' must end in \.xlsx, "):
        sheet.save("sheet.ods")


def test_a_script_merges(folder: Path, tmp_path: Path):
    whole = scaloft_fi.open(STUDY).campaign(str(tmp_path / "whole"))
    merged = whole.merge(str(folder))
    assert (merged.summary["added"], merged.summary["known"]) == (whole.status().summary["counted"], 0)
    assert str(merged) == f"{merged.summary['added']} flights added to {tmp_path}/whole, 0 known already\n"
    assert "flights added" in merged._repr_html_()


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda campaign: campaign.kills("LATE-humna"), "did you mean 'LATE-human'"),
        (lambda campaign: campaign.kills(show="survivor"), "^show='survivor' must be one of .*'survivors'"),
        (lambda campaign: campaign.diff("nowhere"), "no campaign was flown here"),
        (lambda campaign: campaign.when("LATE-human"), "has no phases"),
        (lambda campaign: campaign.margin("LATE-humna"), "did you mean 'LATE-human'"),
        (lambda campaign: campaign.margin("LATE-human", tolerance=0), "^tolerance=0 must be"),
        (
            lambda campaign: campaign.margin("LATE-human", tolerance=float("inf")),
            "^tolerance=inf must be .*, and finite",
        ),
        (lambda campaign: campaign.margin("LATE-human", seeds=0), "^seeds=0 must be"),
        (lambda campaign: campaign.seek("LATE-human", budget="1"), "^budget='1' must be"),
        (lambda campaign: campaign.seek("LATE-human", seed=-1), "^seed=-1 must be"),
        (lambda campaign: campaign.seek("LATE-human", grid="serach"), "^grid=serach must be|^grid='serach' must be"),
        (lambda campaign: campaign.seek(["baseline", "LATE-human"]), "must not stand beside 'baseline'"),
        (lambda campaign: campaign.merge([]), "^others="),
    ],
)
def test_a_script_that_asks_wrongly_gets_one_sentence(
    folder: Path, ask: Callable[[scaloft_fi.OpenCampaign], object], said: str
):
    with pytest.raises(scaloft_fi.InputError, match=said):
        ask(scaloft_fi.open(STUDY).campaign(str(folder)))


def test_every_table_of_the_score_is_a_file_with_the_numbers_of_the_json(told: Call, tmp_path: Path):
    whole = json.loads(told("score", "--by", "axis", "--format", "json").stdout)
    done = told_by(told("score", "--by", "axis", "--format", "csv", "--tables", str(tmp_path / "new" / "tables")))
    files = {path.stem: path.read_text(encoding="utf-8") for path in (tmp_path / "new" / "tables").iterdir()}
    assert done == files["mutants"]
    tables = {name: one_table(text) for name, text in files.items()}
    for name in ("mutants", "controls", "pairs", "baseline", "groups"):
        assert len(tables[name]) == len(whole[name])
    late = next(row for row in tables["mutants"] if row["id"] == "LATE-human@3s")
    mutant = next(one for one in whole["mutants"] if one["id"] == "LATE-human@3s")
    assert (late["kill_rate_part"], late["verdict"], float(late["p_SR2"])) == ("1", "detected", mutant["p"]["SR2"])
    assert tables["mutants_kills"] == [
        {"of_id": "LATE-human@3s", "situation": "T0O0W0D0H1", "requirement": "SR2", "violated": "3", "flights": "3"}
    ]
    summary = {row["what"]: row["value"] for row in tables["summary"]}
    assert (summary["ratios_mutation_score_part"], summary["pooled"]) == ("1", "true")
    assert tables["looks"] == []
    assert files["looks"].startswith("seeds,mutants,flights,detected,")


MARK = re.compile(r"\x1b\[[0-9;]*m")
AVAILABLE = re.compile(r"[\d.]+ GiB available")
"""Free memory, which `doctor` prints, is another one in each call."""
HELDS = re.compile(r"`[^`]*`")
"""A command, within which no line may end."""
SCREENS = (
    *(words for words in READERS if words != ("mutants", "--check")),
    ("seams", "person"),
    ("axes", "H"),
    ("map",),
    ("score", "--all"),
    ("kills", "LATE-human"),
)
"""`check` prints lines for editors, of any length."""


def _too_wide(text: str, width: int) -> list[str]:
    """The lines that are wider, without those of a single word or command, which is never broken."""
    lines = [line for line in text.splitlines() if len(line) > width and not line.startswith("    scaloft-fi ")]
    return [line for line in lines if " " in HELDS.sub("-", line.strip().removesuffix(" \\"))]


@pytest.mark.parametrize("words", SCREENS, ids=" ".join)
def test_a_screen_fits_the_terminal_and_says_the_same_without_colours(
    told: Call, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
):
    def shown(width: int, colours: str) -> str:
        with monkeypatch.context() as patch:
            patch.setenv("COLUMNS", str(width))
            patch.setenv(colours, "1")
            done = told(*words)
        assert done.exit_code == 0, done.output
        return AVAILABLE.sub("9.9 GiB available", done.stdout)

    plain = {width: shown(width, "NO_COLOR") for width in usually((60,), release=(60, 80, 160))}
    assert [line for width, text in plain.items() for line in _too_wide(text, width)] == []
    assert not any(map(MARK.search, plain.values()))
    assert MARK.sub("", shown(60, "FORCE_COLOR")) == plain[60]


RECORD = Path(__file__).with_suffix(".txt")
"""A line with the words, and a line with what is said of them."""
ALONE = ("new", "example", "completion", "matrx")
"""Verbs that take no study."""
HELD = ("run", "margin", "replay", "score", "kills", "worksheet", "dispositions", "report", "export", "seek")
"""Verbs that take a campaign."""


def _lines() -> list[str]:
    return RECORD.read_text(encoding="utf-8").splitlines()


def said_of(line: str, places: dict[str, str]) -> str:
    """The sentence about the words of a line, in which names stand for places."""
    verb, *words = [places.get(word, word) for word in shlex.split(line)]
    study = [] if verb in ALONE or "--study" in words else ["--study", str(STUDY)]
    campaign = ["--campaign", "./none"] if verb in HELD and "--campaign" not in words else []
    campaign += ["--into", "./none"] if verb == "seek" else []
    said = sentence(invoked(verb, *study, *campaign, *words))
    for name, place in places.items():
        said = said.replace(place, name)
    return said


def test_bad_words_are_one_sentence_and_nothing_is_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", lambda: pytest.fail("it flew"))
    Path("file").write_text("mine")
    lines = _lines()
    places = {"CAMPAIGN": str(folder), "HERE": str(tmp_path), "STUDY": str(STUDY)}
    said = {line: said_of(line, places) for line in lines[::2]}
    if os.environ.get("RECORD"):
        RECORD.write_text("".join(f"{line}\n{told}\n" for line, told in said.items()), encoding="utf-8")
    assert [path.read_text() for path in tmp_path.rglob("*")] == ["mine"]
    assert said == dict(zip(lines[::2], _lines()[1::2], strict=True)), "if it is right: RECORD=1"
