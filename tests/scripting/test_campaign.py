"""A script and the verbs do the same; no physics."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest
from click.testing import CliRunner
from paper_flyer import Paper

import scaloft_fi
from scaloft_fi.cli import main

STUDY = Path(__file__).parents[2]


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> scaloft_fi.OpenCampaign:
    """A campaign of the reference study; the current folder is empty."""
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.Physics", Paper)
    monkeypatch.chdir(tmp_path)
    return scaloft_fi.open(STUDY).campaign(f"{tmp_path}/script/c")


def _verb(*words: str) -> bytes:
    result = CliRunner().invoke(main, [*words, "--study", str(STUDY)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout_bytes


def test_a_script_and_the_verb_fly_the_same_and_export_the_same_bytes(
    campaign: scaloft_fi.OpenCampaign, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
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
        assert campaign.export(name) == _verb("export", "--format", name, *theirs), name
    by_parameter = _verb("score", "--by", "parameter", "--format", "json", *theirs)
    assert campaign.score().record(by="parameter") == json.loads(by_parameter)
    ours = f"{tmp_path}/script/c"
    assert campaign.score().text(everything=True).encode() == _verb("score", "--all", "--campaign", ours)
    _verb("report", "--output", "verb.html", "--campaign", ours)
    campaign.report("script.html")
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


def test_the_same_call_resumes_what_the_user_interrupted(campaign: scaloft_fi.OpenCampaign) -> None:
    with pytest.raises(scaloft_fi.Interrupted, match="saved in"):
        campaign.run(
            "LATE-human", "T0O0W0D0H?", seeds=3, jobs=1, progress=lambda *_: signal.raise_signal(signal.SIGINT)
        )
    held = campaign.flights().rows
    told: list[int] = []
    campaign.run("LATE-human", "T0O0W0D0H?", seeds=3, jobs=1, progress=lambda done, _: told.append(done))
    assert 0 < held < campaign.flights().rows
    assert len(told) <= campaign.flights().rows - held + 1  # a gate flies one flight again


def test_a_campaign_that_was_never_flown_says_so(campaign: scaloft_fi.OpenCampaign) -> None:
    assert "Nothing was flown here yet." in campaign._repr_html_()
    for ask in (campaign.score, campaign.flights, campaign.export, campaign.report):
        with pytest.raises(scaloft_fi.InputError, match="no campaign was flown here"):
            ask()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"mutants": "LATE-humna"}, "did you mean 'LATE-human'?"),
        ({"situations": ["X*"]}, r"no situation 'X\*'"),
        ({"seeds": 0}, "^seeds=0 must be"),
        ({"baseline_seeds": "x"}, "^baseline_seeds='x' must be"),
        ({"jobs": 0}, "^jobs=0 must be"),
        ({"shard": "3/2"}, "^shard='3/2' must be K/N"),
        ({"choose": "most"}, "^choose='most' must be all, random:N"),
        ({"budget_s": -1}, "^budget_s=-1 must be"),
        ({"max_invalid": 2}, "^max_invalid=2 must be"),
        ({"executor": "cloud"}, "^executor='cloud' must be 'local'"),
        ({"progress": 3}, "^progress=3 must be"),
        ({"sequential": True, "seeds": 3}, "^sequential and seeds=0-2 do not go together"),
        ({"baseline_from": "nowhere"}, "no campaign was flown here"),
    ],
)
def test_bad_arguments_are_one_sentence_that_names_them_and_nothing_is_written(
    campaign: scaloft_fi.OpenCampaign, tmp_path: Path, arguments: dict[str, object], said: str
) -> None:
    with pytest.raises(scaloft_fi.InputError, match=said) as refused:
        campaign.run(**arguments)  # type: ignore[arg-type]
    assert "--" not in str(refused.value)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_format_or_grouping_names_the_nearest(campaign: scaloft_fi.OpenCampaign) -> None:
    with pytest.raises(scaloft_fi.InputError, match="did you mean 'parquet'"):
        campaign.export("parkett")
    campaign.run("PLACEBO", "T0O0W0D0H0", jobs=1)
    with pytest.raises(scaloft_fi.InputError, match="did you mean 'guideword'"):
        campaign.score().record(by="guidewords")


def test_a_gate_that_fails_is_an_error_of_its_own(
    campaign: scaloft_fi.OpenCampaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.runs.run.Physics", lambda: Paper(tame=True))
    with pytest.raises(scaloft_fi.GateError, match="a control shows nothing"):
        campaign.run("LATE-human", "T0O0W0D0H1", jobs=1)
