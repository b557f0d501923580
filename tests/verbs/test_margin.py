"""The verb `margin` and what `matrix --margins` shows of it, on the reference study without physics."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable

import pytest
from click.testing import Result
from forms import of_form
from printed import no_terms
from refusal import sentence

Call = Callable[..., Result]
HUMAN = ("--situation", "T0O0W0D0H1", "--jobs", "1", "--quiet")
THRICE = ("--seeds", "3", *HUMAN)


def test_a_fault_that_is_killed_at_every_magnitude_is_told_as_such_in_every_format(call: Call) -> None:
    told = of_form("margin", call("margin", "LATE-human", *THRICE, "--format", "json").stdout)
    (fault,), (situation,) = told["faults"], told["situations"]
    assert (fault["cell"], fault["unit"], fault["phase_s"]) == ("LATE-human", "s", 0.0)
    assert (situation["survives"], situation["kills"], situation["monotone"]) == (None, 0.0625, True)
    assert [entry["magnitude"] for entry in told["tried"]] == [0.0625, 0.125, 0.25, 0.5, 1.0, 3.0, 5.0]
    assert situation["requirements"] == ["SR2"]
    for style in ("table", "markdown", "latex"):
        text = call("margin", "LATE-human", *THRICE, "--format", style).stdout
        assert "T0O0W0D0H1" in text
        assert "0.0625 s" in text
        assert no_terms(text) == []
    shown = call("matrix", "--margins", "--format", "csv").stdout
    rows = {row["parameter"]: row for row in csv.DictReader(io.StringIO(shown))}
    assert (rows["human"]["LATE"], rows["human"]["NO"]) == ("<= 0.0625 s", "?")
    assert (rows["collision"]["EARLY"], rows["human"]["REVERSE"]) == ("-", "CONTROL")
    text = call("matrix", "--margins").stdout
    assert "<= 0.0625 s" in text
    assert max(map(len, text.splitlines())) <= 120
    cells = of_form("matrix", call("matrix", "--margins", "--parameter", "human", "--format", "json").stdout)["cells"]
    ((late,),) = [cell["margins"] for cell in cells if cell["cell"] == "LATE-human"]
    assert (late["unit"], late["survives"], late["kills"]) == ("s", None, 0.0625)


def test_one_seed_in_one_situation_is_seen_and_says_how_many_seeds_decide(call: Call) -> None:
    done = call("margin", "LATE-human", *HUMAN)
    assert "seen <= 0.0625 s" in done.stdout
    told = " ".join(done.stdout.split())
    assert re.search(r"`scaloft-fi margin --campaign .+ LATE-human@0\.0625s --seeds 5`", told)


@pytest.mark.parametrize(("words", "told"), [((), 0), (("--warnings",), 7)])
def test_violations_are_counted_and_told_only_when_asked(call: Call, words: tuple[str, ...], told: int) -> None:
    said = call("margin", "LATE-human", *HUMAN[:-1], *words).stderr.splitlines()
    assert sum(line.startswith("warning: SR2 violated at ") for line in said) == told
    assert any(line.startswith("violations: ") for line in said)


def test_operability_has_margins_of_its_own(call: Call) -> None:
    done = call("margin", "LATE-human", *THRICE, "--operability", "--format", "json")
    (fault,) = of_form("margin", done.stdout)["faults"]
    assert (fault["survives"], fault["kills"]) == (40.0, None)
    words = ("matrix", "--margins", "--operability", "--parameter", "human", "--format", "json")
    ((late,),) = [cell["margins"] for cell in json.loads(call(*words).stdout)["cells"] if cell["cell"] == "LATE-human"]
    assert (late["survives"], late["kills"]) == (40.0, None)


def test_when_a_fault_is_killed_is_shown_of_the_flights_of_a_campaign(call: Call) -> None:
    only = ("--mutant", "NO-velcmd@1s", "--situation", "T0O0W0D0H1", "--quiet", "--jobs", "1")
    assert call("run", *only).exit_code == 0
    command = "scaloft-fi run --mutant 'NO-velcmd@1s' --mutant 'NO-velcmd@1s#*'"
    assert command in sentence(call("margin", "NO-velcmd", "--when"))
    assert call("run", "--mutant", "NO-velcmd@1s#*", *only).exit_code == 0
    for style in ("table", "markdown", "latex", "json"):
        text = call("margin", "NO-velcmd", "--when", "--format", style).stdout.replace("\\", "")
        assert no_terms(text) == []
        assert all(phase in text for phase in ("#5s", "#10s", "#15s", "#sight", "#waypoint", "#recoil"))
    phases = of_form("margin", call("margin", "NO-velcmd", "--when", "--format", "json").stdout)["phases"]
    assert {phase["verdict"] for phase in phases} == {"not_tested"} or len(phases) > 4
    assert "Detected at 0 of 4 times" in call("margin", "NO-velcmd@1s#5s", "--when").stdout


def test_margins_of_a_campaign_that_does_not_exist_are_refused(call: Call) -> None:
    assert call("matrix", "--margins").exit_code == 2
