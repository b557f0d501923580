"""`suite`: a planted suite of tests of known behaviour, told right by the default numbers; what is refused."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import pickle
import random
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from options import cases
from pages import embedded
from printed import of_form, run

import scaloft_fi
from scaloft_fi.analysis.detection import LEAST, Pool, Sample, Spending, State, detect
from scaloft_fi.analysis.score import score
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.flights.suite import Looked, SuiteStudy, outcome_of
from scaloft_fi.campaign.plan import canary
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.wire import SeamCount
from scaloft_fi.outside.command import finished
from scaloft_fi.outside.exchange import Processes
from scaloft_fi.outside.suite import Colour, Ran, Result
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study
from scaloft_fi.verbs.first_screen import answers
from scaloft_fi.verbs.suite import STATES, asked_mutants
from scaloft_fi.views.table import of_tests_words

ROOT = Path(__file__).parents[2]
WHOLE = Study.open(ROOT)
PLANTED = """
import json, os, random, signal, sys, time
which, seed, fault, junit = sys.argv[1:]
effects = json.load(open("effects.json"))

def red(test):
    # the salt gives the test that is flaky at 0.1 a red run in ten, without which ten runs cannot tell it from steady
    chance = {"flaky01": 0.1, "flaky03": 0.3, "red": 1.0}.get(test, 0.0)
    return test in effects.get(fault, ()) or random.Random(f"3 {test} {seed} {fault}").random() < chance

if which == "many":
    cases = "".join(
        f'<testcase classname="t.planted" name="{name}">' + '<failure message="no"/>' * red(name) + "</testcase>"
        for name in effects["tests"]
    )
    open(junit, "w").write(f"<testsuites><testsuite>{cases}</testsuite></testsuites>")
print(json.dumps({"altered": 3, "carried": 9}), flush=True)
if which == "alone":
    if "hang" in effects.get(fault, ()):
        time.sleep(60)
    if "crash" in effects.get(fault, ()):
        os.kill(os.getpid(), signal.SIGSEGV)
    if "odd" in effects.get(fault, ()):
        sys.exit(9)
    sys.exit(1 if red("alone") else 0)
"""
TESTS = (
    "steady1",
    "steady2",
    "steady3",
    "redundant1",
    "redundant2",
    "blind1",
    "blind2",
    "blind3",
    "flaky01",
    "flaky03",
)
THREE, ONE = ("steady1", "redundant1", "redundant2"), ("steady2",)


class Planted(NamedTuple):
    """A folder with the planted suite, and the tests that each of twenty faults turns red."""

    folder: Path
    effects: Mapping[str, Sequence[str]]


def suite_text(seams: Sequence[str]) -> str:
    """The suite's file: one command with many tests, one that is a test."""
    return f"""tests:
  many:
    run: ["{{python}}", -I, planted.py, many, "{{seed}}", "{{mutant}}", "{{junit}}"]
    inputs: [planted.py]
    seams: &seams [{", ".join(seams)}]
  alone:
    run: ["{{python}}", -I, planted.py, alone, "{{seed}}", "{{mutant}}", "-"]
    seams: *seams
    limit_s: 3
"""


@pytest.fixture(scope="module")
def planted(tmp_path_factory: pytest.TempPathFactory) -> Planted:
    """A folder with the planted suite, and the tests that each of twenty faults turns red."""
    folder, study = tmp_path_factory.mktemp("suite"), Study.open(ROOT)
    control = canary(study)
    assert control is not None
    faults = [one for one in asked_mutants(study, ()) if one.seam != control.seam][:20]
    kinds = [THREE] * 6 + [ONE] * 4 + [("alone",)] * 2 + [("hang",), ("crash",), ("odd",)] + [()] * 5
    effects: dict[str, Sequence[str]] = {one.id: kind for one, kind in zip(faults, kinds, strict=True)}
    seams = sorted({one.seam for one in (*faults, control)})
    (folder / "planted.py").write_text(PLANTED)
    told = {**effects, control.id: ["steady1", "steady3"], "tests": [*TESTS, "red"]}
    (folder / "effects.json").write_text(json.dumps(told))
    (folder / "suite.yaml").write_text(suite_text(seams))
    return Planted(folder, effects)


def suite(folder: Path, *words: object) -> int:
    """Run `suite` in a folder."""
    return run("suite", folder / "suite.yaml", "--study", ROOT, "--campaign", folder / "flown", "--quiet", *words)


def options(effects: Mapping[str, Sequence[str]]) -> list[str]:
    return [word for id_ in effects for word in ("--mutant", id_)]


@pytest.fixture(scope="module")
def told(planted: Planted) -> dict[str, Any]:
    """What the suite answers."""
    folder, effects = planted
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert suite(folder, "--format", "json", "--jobs", 2, *options(effects)) == 0
    return of_form("suite", out.getvalue())


def test_each_test_has_its_class_and_each_fault_its_kills(told: dict[str, Any], planted: Planted):
    _, effects = planted
    states = {one["test"].removeprefix("planted::"): one["state"] for one in told["tests"]}
    assert states == dict.fromkeys((*TESTS, "alone"), "steady") | {"flaky01": "flaky", "flaky03": "flaky", "red": "red"}
    shown = {one["test"].removeprefix("planted::"): one["shows"] for one in told["tests"]}
    kills = {id_: {test for test, shows in shown.items() if id_ in shows} for id_ in effects}
    never = {"hang", "crash", "odd"}
    assert kills == {id_: set(red) - never for id_, red in effects.items()}
    verdicts = {one["id"]: one["verdict"] for one in told["score"]["mutants"]}
    assert {id_ for id_, verdict in verdicts.items() if verdict == "detected"} == {
        id_ for id_, own in kills.items() if own
    }


def test_the_kills_of_the_score_are_those_that_the_tests_show_a_flaky_test_s_by_three_runs_or_more(
    told: dict[str, Any], planted: Planted, capsys: pytest.CaptureFixture[str]
):
    shown = {(id_, one["test"]) for one in told["tests"] for id_ in one["shows"]}
    assert run("kills", "--study", ROOT, "--campaign", planted.folder / "flown", "--format", "json") == 0
    kills = of_form("kills", capsys.readouterr().out)
    assert {(id_, one["situation"]) for one in kills["situations"] for id_ in one["killed"]} == shown
    results = {(one["mutant"], one["situation"]): one for one in kills["results"]}
    assert {place for place, one in results.items() if one["kills"]} == shown
    assert kills["suite"]["situations"] == told["smallest"]
    score = told["score"]["mutants"]
    assert {(one["id"], kill["situation"]) for one in score for kill in one["kills"]} == shown
    lucky = results["LESS-human@0.8", "planted::flaky01"]
    assert (lucky["flown"], lucky["seen"], lucky["kills"]) == (1, ["green"], [])


def test_redundant_tests_are_not_needed_and_blind_ones_show_nothing(told: dict[str, Any]):
    tests = {one["test"].removeprefix("planted::"): one for one in told["tests"]}
    assert {name for name, one in tests.items() if one["needed"]} == {"steady1", "steady2", "alone"}
    assert {name for name, one in tests.items() if one["shows"]} == {*THREE, *ONE, "alone"}
    assert len(told["smallest"]) == 3


def test_every_fault_that_no_test_shows_is_told_with_its_seam_the_worst_first(told: dict[str, Any]):
    missed = told["missed"]
    assert {one["mutant"] for one in missed} == {
        one["id"] for one in told["score"]["mutants"] if one["verdict"] != "detected"
    }
    order = {one.id: one.rank for one in Study.open(ROOT).matrix.severities.values()}
    ranks = [order[one["severity"]] for one in missed]
    assert ranks == sorted(ranks)
    assert all(one["seam"] and one["deviation"] and one["effect"] for one in missed)


def test_a_command_that_hangs_crashes_or_ends_oddly_is_no_verdict(
    told: dict[str, Any], planted: Planted, capsys: pytest.CaptureFixture[str]
):
    folder, effects = planted
    assert run("export", "--study", ROOT, "--campaign", folder / "flown") == 0
    rows = json.loads(capsys.readouterr().out)
    odd = [id_ for id_, red in effects.items() if set(red) & {"hang", "crash", "odd"}]
    assert {row["status"] for row in rows if row["mutant"] in odd and row["situation"] == "alone"} == {"invalid"}


@pytest.mark.parametrize("verb", ["score", "kills", "coverage", "worksheet", "status", "export", "dispositions"])
def test_a_verb_that_reads_a_campaign_reads_one_of_tests(
    told: dict[str, Any], planted: Planted, verb: str, capsys: pytest.CaptureFixture[str]
):
    folder, _ = planted
    assert run(verb, "--study", ROOT, "--campaign", folder / "flown") == 0
    assert capsys.readouterr().out


def test_the_first_screen_speaks_of_tests_and_of_no_flight(
    told: dict[str, Any], planted: Planted, capsys: pytest.CaptureFixture[str]
):
    assert run("score", "--study", ROOT, "--campaign", planted.folder / "flown") == 0
    screen = capsys.readouterr().out
    assert "by your tests" in screen
    step = f"`scaloft-fi suite {planted.folder / 'suite.yaml'} --campaign {planted.folder / 'flown'}`"
    assert step in " ".join(screen.replace("\\\n", " ").split())
    for word in ("situation", "seed", "drone", "flown"):
        assert word not in screen.replace("/flown", ""), word
    assert run("score", "--study", ROOT, "--campaign", planted.folder / "flown", "--all") == 0
    legend = " ".join(capsys.readouterr().out.split()).partition(" killed in: ")[2]
    assert legend.startswith("tests that most runs of the fault turn red")


def plain(text: str) -> str:
    """A text without commands, names of tests and paths."""
    return re.sub(r"`[^`]*`|scaloft-fi \S.*|\S*[/:]\S*", "", text).lower()


@pytest.mark.parametrize(
    "verb",
    [
        *(("score", "--all"), ("kills",), ("kills", "--show", "survivors"), ("status",), ("dispositions",)),
        *(("export", "--format", name) for name in ("markdown", "junit", "sarif")),
    ],
)
def test_what_is_said_of_tests_has_no_word_of_flights_and_no_command_that_flies(
    told: dict[str, Any], planted: Planted, verb: Sequence[str], capsys: pytest.CaptureFixture[str]
):
    assert run(*verb, "--study", ROOT, "--campaign", planted.folder / "flown") == 0
    out = capsys.readouterr().out
    for word in ("situation", "seed", "flight", "flown", "flies", "safety requirement", "unmutated", "pair"):
        assert not re.search(rf"\b{word}s?\b", plain(out)), (word, re.findall(rf".*\b{word}s?\b.*", out)[:3])
    for flying in ("replay", "seek", "margin", "run"):
        assert f"scaloft-fi {flying} " not in out


def test_the_page_of_a_campaign_of_tests_has_its_words_and_one_of_flights_none(
    told: dict[str, Any], planted: Planted, tmp_path: Path
):
    report = tmp_path / "report.html"
    assert run("report", "--study", ROOT, "--campaign", planted.folder / "flown", "--output", report) == 0
    content = embedded(report.read_text(), "figures")
    assert dict(content["words"]) == of_tests_words()
    assert (content["axes"], content["besides"]) == ([], [])
    assert "operability" not in {one["name"] for one in content["ratios"]}
    assert {one["next"] for one in content["survivors"]} == {"test"}
    called = {pair["situation"]: STATES[State(pair["called"])] for pair in content["pairs"]}
    assert called.items() <= {one["test"]: one["state"] for one in told["tests"]}.items()
    assert called["planted::flaky01"] == called["planted::flaky03"] == "flaky"


def test_tables_call_tests_as_the_suite_does_and_the_next_step_names_the_campaign(
    told: dict[str, Any], planted: Planted, capsys: pytest.CaptureFixture[str]
):
    assert run("score", "--all", "--study", ROOT, "--campaign", planted.folder / "flown") == 0
    out = capsys.readouterr().out
    said = " ".join(out.replace("\\\n", " ").split())
    assert (
        f"/suite.yaml --campaign {planted.folder / 'flown'}` lists below its score what each test has to see." in said
    )
    _, _, table = out.partition("Tests that are not steady without a fault")
    listed = {line.split()[0]: line.split()[1:] for line in table.splitlines() if line.startswith("planted::")}
    states = {one["test"]: one["state"] for one in told["tests"]}
    assert {test: words[1] for test, words in listed.items()} == {k: v for k, v in states.items() if v != "steady"}
    assert "1/10" in listed["planted::flaky01"]


def test_an_archive_of_the_campaign_is_read_without_the_tests(
    told: dict[str, Any], planted: Planted, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder, _ = planted
    archive = tmp_path / "a" / "archive"
    assert (
        run("export", "--format", "archive", "--output", archive, "--campaign", folder / "flown", "--study", ROOT) == 0
    )
    capsys.readouterr()
    assert run("score", "--campaign", archive, "--study", ROOT, "--format", "json") == 0
    again = json.loads(capsys.readouterr().out)
    assert again["ratios"] == told["score"]["ratios"]


@pytest.mark.parametrize("verb", [("run",), ("replay", "baseline/alone/0"), ("margin", "NO-goal"), ("propose",)])
def test_a_verb_that_flies_refuses_a_campaign_of_tests(
    told: dict[str, Any], planted: Planted, verb: Sequence[str], capsys: pytest.CaptureFixture[str]
):
    folder, _ = planted
    assert run(*verb, "--study", ROOT, "--campaign", folder / "flown") == 2
    assert "suite.yaml" in capsys.readouterr().err


def test_the_same_command_again_runs_only_the_first_look_at_the_commands(
    told: dict[str, Any], planted: Planted, capsys: pytest.CaptureFixture[str]
):
    folder, effects = planted
    (folder / "planted.py").touch()
    sound = [id_ for id_, red in effects.items() if not set(red) & {"hang", "crash", "odd"}]
    before = (folder / "flown" / "outcomes.sqlite").stat().st_size
    assert suite(folder, "--format", "json", *options(dict.fromkeys(sound, ()))) == 0
    assert (folder / "flown" / "outcomes.sqlite").stat().st_size == before
    assert json.loads(capsys.readouterr().out)["score"]["ratios"] == told["score"]["ratios"]


@given(st.integers(1, 9))
def test_the_shards_of_the_faults_are_all_of_them_each_once(shards: int):
    parts = [asked_mutants(WHOLE, (), f"{number}/{shards}") for number in range(1, shards + 1)]
    assert sorted(one.id for part in parts for one in part) == sorted(one.id for one in asked_mutants(WHOLE, ()))


def test_a_suite_travels_without_what_was_read_of_it_and_is_run_again_by_a_command_for_a_shell(tmp_path: Path):
    study = SuiteStudy(ROOT, None, "", tmp_path / "my suite.yaml", "tests: {a: {run: [sh]}}")
    assert study.suite.tests.keys() == {"a"}
    travelled = pickle.loads(pickle.dumps(study))
    assert vars(travelled).keys() == {one.name for one in dataclasses.fields(study)}
    assert (travelled, travelled.suite.tests) == (study, study.suite.tests)
    assert shlex.split(study.again) == ["scaloft-fi", "suite", str(study.file)]


def test_shards_join_to_what_an_undivided_run_tells(
    told: dict[str, Any], planted: Planted, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder, effects = planted
    asked = {id_: () for id_, red in effects.items() if not set(red) & {"hang", "crash", "odd"}}
    for part in ("1/2", "2/2"):
        where = ("--study", ROOT, "--campaign", tmp_path / part[0], "--quiet", "--jobs", 2)
        assert run("suite", folder / "suite.yaml", *where, "--shard", part, *options(asked)) == 0
    assert run("merge", "--study", ROOT, "--campaign", tmp_path / "all", tmp_path / "1", tmp_path / "2") == 0
    capsys.readouterr()
    assert run("score", "--study", ROOT, "--campaign", tmp_path / "all", "--format", "json") == 0
    verdicts = {one["id"]: one["verdict"] for one in json.loads(capsys.readouterr().out)["mutants"]}
    assert verdicts == {one["id"]: one["verdict"] for one in told["score"]["mutants"] if one["id"] in asked}


@pytest.mark.release
def test_ten_kills_leave_a_campaign_that_ends_as_one_that_nobody_killed(planted: Planted, tmp_path: Path):
    folder, effects = planted
    asked = {id_: () for id_, red in effects.items() if not set(red) & {"hang", "crash", "odd"}}
    moments = random.Random(0)

    def command(campaign: str) -> list[str]:
        where = ("--study", ROOT, "--campaign", tmp_path / campaign, "--quiet", "--jobs", "2", "--format", "json")
        return [
            *map(str, (sys.executable, "-m", "scaloft_fi", "suite", folder / "suite.yaml", *where)),
            *options(asked),
        ]

    killed = 0
    for _ in range(10):
        with subprocess.Popen(command("killed"), cwd=ROOT, stdout=subprocess.DEVNULL) as process:
            time.sleep(moments.uniform(1.0, 4.0))
            killed += process.poll() is None
            process.kill()
    assert killed == 10
    whole, again = (
        json.loads(subprocess.run(command(name), cwd=ROOT, capture_output=True, check=True).stdout)
        for name in ("whole", "killed")
    )
    for part in ("tests", "missed", "smallest", "unreached"):
        assert again[part] == whole[part], part
    assert again["score"]["ratios"] == whole["score"]["ratios"]


def test_python_gives_the_answer_of_the_verb(told: dict[str, Any], planted: Planted, tmp_path: Path):
    one = next(id_ for id_, red in planted.effects.items() if red == THREE)
    found = scaloft_fi.open(ROOT).suite(planted.folder / "suite.yaml", campaign=str(tmp_path / "c"), mutants=one)
    assert sorted(found["tests"]["test"]) == sorted(test["test"] for test in told["tests"])
    shows = {test["test"].removeprefix("planted::") for test in found.record()["tests"] if test["shows"]}
    assert shows == set(THREE)
    with pytest.raises(InputError, match=r"shard='21/21' may have at most 1 shard"):
        scaloft_fi.open(ROOT).suite(planted.folder / "suite.yaml", mutants=one, shard="21/21")


def test_a_campaign_of_flights_takes_no_runs_of_tests(
    planted: Planted, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    flown = tmp_path / "flown" / STORE_NAME
    flown.parent.mkdir()
    Store(flown).close()
    before = flown.read_bytes()
    (tmp_path / "suite.yaml").write_text("tests:\n  a: {run: [sh, -c, 'exit 0']}\n")
    assert suite(tmp_path, "--mutant", "NO-goal") == 2
    assert "flights" in capsys.readouterr().err
    assert flown.read_bytes() == before


def test_reach_says_which_faults_reach_a_command_and_runs_none(
    planted: Planted, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder, effects = planted
    words = ("--study", ROOT, "--campaign", tmp_path / "none", "--quiet", "--reach", "--format", "csv")
    assert run("suite", folder / "suite.yaml", *words, *options(effects)) == 0
    assert f"many,11,{len(effects)}," in capsys.readouterr().out
    assert not (tmp_path / "none").exists()


def test_since_runs_only_commands_with_a_changed_input(
    planted: Planted, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder, effects = planted
    for name in ("planted.py", "effects.json", "suite.yaml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    identity = ("-c", "user.name=a", "-c", "user.email=a@b")
    for words in (("init", "-q"), ("add", "-A"), (*identity, "commit", "-qm", "x")):
        subprocess.run(["git", *words], cwd=tmp_path, check=True)
    one = next(id_ for id_, red in effects.items() if red == THREE)
    assert suite(tmp_path, "--since", "HEAD", "--mutant", one) == 0
    assert not (tmp_path / "flown").exists()
    (tmp_path / "planted.py").write_text(PLANTED + "\n# changed\n")
    assert suite(tmp_path, "--since", "HEAD", "--mutant", one, "--format", "json") == 0
    told = json.loads(capsys.readouterr().out)
    assert {pair["situation"] for pair in told["score"]["pairs"]} == {f"planted::{name}" for name in (*TESTS, "red")}


def test_a_control_that_turns_no_test_red_fails_the_gate(
    planted: Planted, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder, effects = planted
    for name in ("planted.py", "suite.yaml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "effects.json").write_text(json.dumps({"tests": ["steady1"]}))
    words = ("--study", ROOT, "--campaign", tmp_path / "flown", "--mutant", next(iter(effects)))
    assert run("suite", tmp_path / "suite.yaml", *words) == 4
    told = capsys.readouterr().err
    assert "control" in told
    assert "\nmany " in told, "what reaches which test is a table"
    assert re.search(r"\n\d+ of \d+ runs done in ", told)


@cases("text", "said")
def test_a_suite_that_cannot_run_is_refused_in_a_sentence_before_anything_is_written(
    tmp_path: Path, text: str, said: str, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "suite.yaml").write_text(text)
    assert suite(tmp_path, "--mutant", "NO-goal") == 2
    told = capsys.readouterr().err
    assert "suite.yaml" in told
    assert said in told
    assert not (tmp_path / "flown").exists()


CART = """
import sys
from scaloft_fi.outside.client import connect
border, place_m = connect(publishes=["/cmd_raw"]), 0.0
for _ in range(60):
    border.send("/cmd_raw", {"stamp_s": 0.0, "velocity": [0.5, 0.0, 0.0], "yaw_rad": 0.0})
    order = next(message for message in border if message.get("topic") == "/cmd")
    place_m += order["data"]["velocity"][0] / 20
sys.exit(abs(place_m - 1.5) > 0.1)
"""


def test_a_relay_carries_a_fault_into_the_topics_of_a_system_that_a_shell_script_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "cart.py").write_text(CART)
    (tmp_path / "check.sh").write_text('exec "$1" cart.py\n')
    relay = "relays: {velcmd: {from: /cmd_raw, to: /cmd, border: lines}}\n"
    (tmp_path / "suite.yaml").write_text(relay + 'tests:\n  drives: {run: [sh, check.sh, "{python}"]}\n')
    faults = ("--mutant", "MORE-velcmd@1.5x", "--mutant", "NO-goal")
    assert suite(tmp_path, "--format", "json", "--jobs", 2, *faults) == 0
    told = json.loads(capsys.readouterr().out)
    (test,) = told["tests"]
    assert (test["state"], test["shows"]) == ("steady", ["MORE-velcmd@1.5x"])
    assert told["unreached"] == ["NO-goal"]


BROKEN = """
from scaloft_fi.outside.suite import injecting
with injecting("baseline", "baseline") as (subject, tell):
    assert subject == "NO-a"
    raise RuntimeError("no server")
"""
FAULT = Mutant("NO-a", "NO", "a", "", 0.0, "a", "drop")


def ran(mutant: Mutant | None, test: str, seed: int, *, red: bool = False, colour: Colour = Colour.GREEN) -> Any:
    situation = Situation(test, (("Test", 0),))
    counts = {mutant.seam: SeamCount(9, 3, 1.0)} if mutant else {}
    return outcome_of(Flight(mutant, situation, seed), Ran({test: Result(Colour.RED if red else colour)}, "", counts))


@pytest.mark.parametrize(("colour", "kills", "trivial"), [(Colour.SKIPPED, "1/1", True), (Colour.GREEN, "1/2", False)])
def test_a_test_that_a_fault_skips_is_not_put_to_the_test_and_a_fault_that_half_the_tests_show_is_not_trivial(
    tmp_path: Path, colour: Colour, kills: str, *, trivial: bool
):
    looked = {"a": Looked(("a", "b"), {}, 1.0)}
    study = SuiteStudy(ROOT, None, "", tmp_path / "suite.yaml", "tests: {a: {run: [sh]}}", looked)
    (late,) = asked_mutants(study, ["LATE-human@3s"])
    pool = [ran(None, test, seed) for test in "ab" for seed in range(LEAST)]
    faulty = [
        ran(late, test, seed, colour=of) for test, of in {"a": Colour.RED, "b": colour}.items() for seed in range(5)
    ]
    scored = score([*pool, *faulty], study.roster, study.space)
    (fault,) = scored.counted
    assert (fault.detected, fault.kill_rate.short, scored.trivial) == (True, kills, (late.id,) * trivial)
    skipped = score([*pool, ran(late, "a", 0, colour=Colour.SKIPPED)], study.roster, study.space)
    assert answers(skipped, study, "c")[1].text == "1 never put to the test."
    assert skipped.without_effect == ()


def test_flaky_tests_call_faults_without_effect_detected_at_most_as_often_as_alpha_says():
    chances, found = {"a": 0.1, "b": 0.3, "c": 0.1, "d": 0.3, "e": 0.2, "f": 0.0}, 0
    for draw in range(1000):
        noise = np.random.default_rng(draw)
        pool = Pool.of(ran(None, t, s, red=noise.random() < p) for t, p in chances.items() for s in range(LEAST))
        own = {t: [ran(FAULT, t, s, red=noise.random() < p) for s in range(10)] for t, p in chances.items()}
        samples = [Sample.of(runs) for runs in own.values()]
        spending = Spending(0.01, frozenset({FAULT.id}))
        found += detect(FAULT.id, samples, pool, spending, Kind.SAFETY).detected
    assert found <= 10


def test_a_flight_that_fails_in_the_harness_is_told_and_is_no_red_test(tmp_path: Path):
    (tmp_path / "check.py").write_text(BROKEN)
    (tmp_path / "suite.yaml").write_text("tests:\n  a: {run: ['{python}', check.py]}\n")
    study = SuiteStudy(ROOT, None, "", tmp_path / "suite.yaml", (tmp_path / "suite.yaml").read_text())
    told = study.run("a", FAULT, "a", 0)
    assert (told.of("a").colour, told.of("a").why) == (Colour.UNKNOWN, "RuntimeError: no server")


@pytest.mark.parametrize(("said", "why"), [('"5"', "altered='5', which"), ("-5", "altered=-5, which")])
def test_a_last_line_with_a_wrong_count_makes_that_run_alone_invalid(tmp_path: Path, said: str, why: str):
    line = json.dumps(f'{{"altered": {said}}}')
    text = f"tests:\n  a: {{run: [echo, {line}], seams: [a]}}\n"
    told = SuiteStudy(ROOT, None, "", tmp_path / "suite.yaml", text).run("a", FAULT, "a", 0).of("a")
    assert told.colour is Colour.UNKNOWN
    assert told.why == f"the last line says {why} must be a whole number >= 0"


def test_a_test_whose_runs_with_faults_are_all_invalid_is_not_said_to_show_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "check.sh").write_text('echo "{\\"altered\\": 1}"; [ "$1" != NO-goal ] || exit $2\n')
    (tmp_path / "suite.yaml").write_text(
        'tests:\n  a: {run: [sh, check.sh, "{mutant}", 9], seams: [goal]}\n'
        '  b: {run: [sh, check.sh, "{mutant}", 0], seams: [goal]}\n'
    )
    assert suite(tmp_path, "--mutant", "NO-goal") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "1 of 2 tests show no fault: b." in out
    assert "1 could not be judged, as each run with a fault is invalid: a." in out


def test_a_command_that_has_ended_before_anybody_looked_was_started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    listen = Processes._listen

    def late(self: Processes, wait_s: float) -> None:
        time.sleep(0.5)
        listen(self, wait_s)

    monkeypatch.setattr(Processes, "_listen", late)
    assert finished(["sh", "-c", "exit 3"], {}, tmp_path, 9.0, tmp_path)[0] == "ended with code 3"


def test_a_junit_case_is_red_by_failure_unknown_by_error_and_vacuous_when_skipped():
    from scaloft_fi.outside.suite import _cases

    cases = _cases(
        b'<testsuite><testcase name="a"/><testcase name="b"><failure message="x"/></testcase>'
        b'<testcase name="c"><error message="y"/></testcase><testcase classname="k.T" name="d"><skipped/></testcase>'
        b'<testcase name="a"><failure/></testcase></testsuite>'
    )
    colours = {name: result.colour for name, result in cases.items()}
    assert colours == {"a": Colour.RED, "b": Colour.RED, "c": Colour.UNKNOWN, "T::d": Colour.SKIPPED}
