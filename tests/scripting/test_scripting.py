"""A script and the verbs do the same; no physics."""

from __future__ import annotations

import inspect
import json
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, cast

import click
import numpy as np
import pytest
from options import cases
from paper_flyer import Paper
from printed import STUDY, invoked

import scaloft_fi
from scaloft_fi.campaign.plan import Seeds, parse_seeds
from scaloft_fi.errors import GateError, InputError
from scaloft_fi.hazop.load import named_study
from scaloft_fi.scripting.flight import Figure, argument, in_python, number, python_words
from scaloft_fi.scripting.study import CampaignScore, OpenCampaign
from scaloft_fi.verbs.options import Option, several


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> scaloft_fi.OpenCampaign:
    """A campaign of the reference study; the current folder is empty."""
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", Paper)
    monkeypatch.chdir(tmp_path)
    return scaloft_fi.open(STUDY).campaign(f"{tmp_path}/script/c")


def _verb(*words: str) -> bytes:
    result = invoked(*words, "--study", str(STUDY))
    assert result.exit_code == 0, result.output
    return result.stdout_bytes


def test_a_script_and_the_verb_fly_the_same_and_export_the_same_bytes(
    campaign: scaloft_fi.OpenCampaign, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    told: list[tuple[int, int]] = []
    score = campaign.run(
        ["LATE-human*", "MORE-goal"],
        "T0O0W0D0H?",
        seeds=3,
        baseline_seeds="0-9",
        jobs=2,
        progress=lambda done, flights: told.append((done, flights)),
    )
    assert capfd.readouterr() == ("", "")
    assert told
    assert told[-1][0] == told[-1][1] == len(told)

    words = ("--mutant", "LATE-human*", "--mutant", "MORE-goal", "--situation", "T0O0W0D0H?", "--seeds", "3")
    theirs = ("--campaign", f"{tmp_path}/verb/c")
    ran = _verb("run", *words, "--baseline-seeds", "0-9", "--jobs", "1", "--quiet", "--format", "json", *theirs)
    assert score.record() == json.loads(ran)
    for name in ("csv", "junit", "sace"):
        with named_study(STUDY):  # as the verb is called
            exported = campaign.export(name)
        assert exported == _verb("export", "--format", name, *theirs), name
    by_parameter = _verb("score", "--by", "parameter", "--format", "json", *theirs)
    assert campaign.score().record(by="parameter") == json.loads(by_parameter)
    ours = f"{tmp_path}/script/c"
    with named_study(STUDY):
        assert campaign.score().text(everything=True).encode() == _verb("score", "--all", "--campaign", ours)
        campaign.report("script.html")
    _verb("report", "--output", "verb.html", "--campaign", ours)
    assert Path("script.html").read_bytes() == Path("verb.html").read_bytes()

    flights = campaign.flights()
    listed = json.loads(campaign.export())
    assert list(flights) == list(listed[0])
    assert flights.rows == len(listed)
    for name in ("mutant", "seed", "status", "violated", "digest"):
        assert list(flights[name]) == [row[name] for row in listed]
    rho = [None if value != value else value for value in flights["rho_SR2"].tolist()]
    assert rho == [row["rho_SR2"] for row in listed]

    assert score.mutants["mutant"].tolist() == [one["id"] for one in score.record()["mutants"]]
    assert score.mutants["killed_in"].tolist() == [one["kill_rate"]["part"] for one in score.record()["mutants"]]
    assert dict(zip(score.mutants["mutant"], score.mutants["verdict"], strict=True))["LATE-human@3s"] == "detected"
    assert score.controls["mutant"].tolist() == ["REVERSE-velcmd"]
    assert score.mutation_score.short == "1/2"
    assert set(score.pairs["state"]) <= {"steady", "unknown", "vacuous"}
    assert "Detected: " in score._repr_html_()
    assert "<script" not in score._repr_html_()
    assert "baseline" in campaign._repr_html_()
    assert repr(score).endswith("1/2 = 50 % detected>")


def test_the_same_call_resumes_what_the_user_interrupted(campaign: scaloft_fi.OpenCampaign):
    with pytest.raises(scaloft_fi.Interrupted, match="saved in"):
        campaign.run(
            "LATE-human", "T0O0W0D0H?", seeds=3, jobs=1, progress=lambda *_: signal.raise_signal(signal.SIGINT)
        )
    held = campaign.flights().rows
    told: list[int] = []
    campaign.run("LATE-human", "T0O0W0D0H?", seeds=3, jobs=1, progress=lambda done, _: told.append(done))
    assert 0 < held < campaign.flights().rows
    assert len(told) <= campaign.flights().rows - held + 1  # a gate flies one flight again


def test_a_campaign_that_was_never_flown_says_so(campaign: scaloft_fi.OpenCampaign):
    assert "Nothing was flown here yet." in campaign._repr_html_()
    for ask in (campaign.score, campaign.flights, campaign.export, campaign.report):
        with pytest.raises(scaloft_fi.InputError, match="no campaign was flown here"):
            ask()


@cases("arguments", "said")
def test_bad_arguments_are_one_sentence_that_names_them_and_nothing_is_written(
    campaign: scaloft_fi.OpenCampaign, tmp_path: Path, arguments: dict[str, object], said: str
):
    with pytest.raises(scaloft_fi.InputError, match=said) as refused:
        campaign.run(**arguments)  # type: ignore[arg-type]
    assert "--" not in str(refused.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("baseline", "T0O0W0D0H0", -1), "seed=-1 must be a whole number from 0"),
        (("baseline", "T0O0W0D0H0", 1.5), "seed=1.5 must be a whole number from 0"),
        (("baseline", "T0O0W0D0H0", True), "seed=True must be a whole number from 0"),
        (("baseline", ["T0O0W0D0H0"]), "situation=['T0O0W0D0H0'] must be a text"),
        ((3, "T0O0W0D0H0"), "mutant=3 must be a text"),
    ],
)
def test_a_flight_with_arguments_of_other_types_is_refused_by_study_and_campaign(
    study: scaloft_fi.OpenStudy, campaign: scaloft_fi.OpenCampaign, arguments: tuple[Any, ...], said: str
):
    for fly in (study.fly, campaign.replay):
        with pytest.raises(scaloft_fi.InputError, match=f"^{re.escape(said)}$"):
            fly(*arguments)


def test_every_method_of_a_script_holds_each_argument_against_its_type(campaign: scaloft_fi.OpenCampaign):
    study, score = scaloft_fi.open(STUDY), CampaignScore(cast(Any, None))
    methods = [
        getattr(owner, name)
        for owner in (study, campaign, score, Figure("", ""))
        for name, kept in vars(type(owner)).items()
        if callable(kept) and not name.startswith("_") and signature(getattr(owner, name)).parameters
    ]
    assert len(methods) > 20
    for method in (scaloft_fi.open, *methods):
        odd = {name: object() for name in signature(method).parameters}
        first = next(iter(odd))
        with pytest.raises(scaloft_fi.InputError, match=rf"^{first}=<object object at \w+> must be "):
            method(**odd)


@pytest.mark.parametrize(
    ("value", "hint"),
    [
        (np.int64(3), int),
        (3, float),
        (np.array(["a", "b"]), str | Sequence[str]),
        (Path("a"), str | Path),
        ("a", Path),
        (None, Annotated[int | None, Option(type=click.IntRange(min=1))]),
        (range(3), Seeds),
        (print, bool | Callable[[int, int], object]),
    ],
)
def test_what_is_of_the_declared_type_is_taken(value: Any, hint: Any):
    assert argument("it", value, hint) is value or argument("it", value, hint) == 3


def test_an_unknown_format_or_grouping_names_the_nearest(campaign: scaloft_fi.OpenCampaign):
    with pytest.raises(scaloft_fi.InputError, match="did you mean 'parquet'"):
        campaign.export("parkett")
    campaign.run("PLACEBO", "T0O0W0D0H0", jobs=1)
    with pytest.raises(scaloft_fi.InputError, match="did you mean 'guideword'"):
        campaign.score().record(by="guidewords")


def test_a_gate_that_fails_is_an_error_of_its_own(campaign: scaloft_fi.OpenCampaign, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", lambda: Paper(tame=True))
    with pytest.raises(scaloft_fi.GateError, match="a control shows nothing"):
        campaign.run("LATE-human", "T0O0W0D0H1", jobs=1)


@pytest.fixture(scope="module")
def study() -> scaloft_fi.OpenStudy:
    return scaloft_fi.open(STUDY)


def test_the_parts_of_a_study_are_columns(study: scaloft_fi.OpenStudy):
    assert study.requirements["requirement"].tolist() == ["SR1", "SR2", "SR2-literal", "OP1"]
    assert study.situations.rows == 32
    assert list(study.situations) == ["situation", "aliases", "T", "O", "W", "D", "H"]
    defaults = study.mutants["mutant"][study.mutants["counted"]]
    assert sorted(defaults) == sorted(study.definition.roster.defaults.values())
    assert study.folder == STUDY
    units = dict(zip(study.signals["signal"], study.signals["unit"], strict=True))
    assert (units["x_m"], units["qw"]) == ("m", "")


def test_a_notebook_shows_what_a_study_has(study: scaloft_fi.OpenStudy):
    assert "paper, 32 situations" in study._repr_html_()


def test_what_check_and_map_show_is_there_as_columns_and_as_a_figure(study: scaloft_fi.OpenStudy, tmp_path: Path):
    findings = study.check()
    assert list(findings) == ["severity", "file", "line", "what", "situation", "remedy"]
    assert "error" not in findings["severity"].tolist()
    figure = study.map("T1O0W0D0H1")
    assert figure._repr_svg_().startswith("<svg")
    assert figure.save(tmp_path / "plan.PNG").read_bytes().startswith(b"\x89PNG")
    assert figure.save(f"{tmp_path}/plan.svg").read_text() == figure.svg
    with pytest.raises(scaloft_fi.InputError, match=r"must end in .svg or .png"):
        figure.save("plan.pdf")


def test_another_grid_has_its_own_situations_and_names_its_campaign():
    wide = scaloft_fi.open(STUDY, grid="wide")
    assert wide.situations.rows != 32
    assert wide.campaign().name == "wide"
    assert scaloft_fi.open(STUDY).campaign().name == "default"
    assert wide.campaign("mine").folder == STUDY / "results" / "campaigns" / "mine"


@pytest.mark.parametrize(
    ("study", "grid", "said"),
    [("/nowhere", None, "^study='/nowhere' must be a folder"), (STUDY, "wise", "^grid='wise' must be")],
)
def test_what_is_no_study_is_one_sentence(study: Path | str, grid: str | None, said: str):
    with pytest.raises(scaloft_fi.InputError, match=said):
        scaloft_fi.open(study, grid)


def test_a_flight_of_nobody_is_refused_before_anything_is_prepared(
    study: scaloft_fi.OpenStudy, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("scaloft_fi.campaign.flights.physics.Physics", lambda: pytest.fail("it was prepared"))
    with pytest.raises(scaloft_fi.InputError, match="LATE-humna"):
        study.fly("LATE-humna", "T0O0W0D0H1")
    with pytest.raises(scaloft_fi.InputError, match="no situation 'T9'"):
        study.fly("LATE-human", "T9")


def test_the_package_itself_imports_nothing_heavy():
    heavy = "{'numpy', 'click', 'yaml', 'pandas', 'scaloft_fi.api', 'scaloft_fi.study'}"
    program = f"import sys, scaloft_fi; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_name_that_the_package_lacks_is_an_ordinary_error():
    assert set(scaloft_fi.__all__) <= set(dir(scaloft_fi))
    with pytest.raises(AttributeError, match="'scaloft_fi' has no attribute 'opne'"):
        _ = scaloft_fi.opne  # type: ignore[attr-defined]


@pytest.mark.parametrize("bad", [0, -1, 100_001, True, 2.5, (), [1, 1], [-1], ["1"], [True], "x", "3-1", {1}])
def test_seeds_that_are_none_are_one_sentence_with_the_name_of_the_argument(bad: object):
    with pytest.raises(InputError, match="baseline_seeds="):
        parse_seeds(bad, "baseline_seeds")  # type: ignore[arg-type]


def test_one_text_is_one_name():
    assert several("LATE-human", "mutants") == ("LATE-human",)
    assert several(["a", "b"], "mutants") == ("a", "b")
    with pytest.raises(InputError, match="mutants=3 must be a text"):
        several(["a", 3], "mutants")  # type: ignore[list-item]
    with pytest.raises(InputError, match="mutants=3 must be a text"):
        several(3, "mutants")  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan"), "1", True])
def test_a_number_outside_its_range_is_refused(bad: object):
    with pytest.raises(InputError, match="max_invalid="):
        number(bad, "max_invalid", 0.0, 1.0)  # type: ignore[arg-type]


def test_an_error_keeps_its_kind_and_names_arguments():
    with pytest.raises(GateError, match=r"^name another campaign, or `run --campaign NAME`$"), in_python():
        raise GateError("name another --campaign, or `run --campaign NAME`")


def test_a_dash_that_is_no_option_stays():
    assert python_words("a -- b, LATE-human, x--y, --mutant='a'") == "a -- b, LATE-human, x--y, mutants='a'"


def test_a_method_has_the_texts_and_plain_types_of_the_options_of_its_verb():
    about, signature = OpenCampaign.kills.__doc__ or "", str(inspect.signature(OpenCampaign.kills))
    assert "    by_requirement: Subsumption tells kills by different requirements of a situation apart.\n" in about
    assert signature.startswith("(self, mutants: 'str | Sequence[str]' = (), situations:")
    assert "those of choose." in (OpenCampaign.run.__doc__ or "")
