from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.cli.replay import _facts
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.sim.log import NEVER_S, Ending, FlightLog
from scaloft_fi.study import Study

STUDY = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("LATE-human",), "must be MUTANT/SITUATION/SEED"),
        (("LATE-human/T0O0W0D0H1/x",), "must be MUTANT/SITUATION/SEED"),
        (("LATE-humna/T0O0W0D0H1/0",), "LATE-humna"),
        (("LATE-human/T0O0W0D0H7/0",), "no situation 'T0O0W0D0H7'"),
        (("baseline/T0O0W0D0H1/0", "--output", "map.pdf"), "must end in .svg, .png or .mcap"),
        (("baseline/T0O0W0D0H1/0", "--output", "no/where/map.svg"), "cannot be written"),
    ],
)
def test_bad_words_are_one_sentence_before_anything_flies(
    call: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], said: str
) -> None:
    monkeypatch.setattr("scaloft_fi.campaign.flights.fly.fly_log", lambda *_: pytest.fail("it flew"))
    result = call("replay", *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_window_needs_a_display(call: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    result = call("replay", "baseline/T0O0W0D0H1/0", "--gui")
    assert result.exit_code == 2
    assert "--gui needs a display" in result.stderr


def test_a_requirement_that_the_flight_did_not_put_to_the_test_has_no_robustness() -> None:
    study = Study.open(STUDY)
    flight = flight_named(study, "baseline", "T0O0W0D0H0", 0)
    readings = (
        Reading("SR1", Kind.SAFETY, 0.3, None, 1, open=False),
        Reading("SR2", Kind.SAFETY, 24.0, None, 0, open=False),
    )
    flown = Outcome(flight.subject, "T0O0W0D0H0", 0, ending="landed", readings=readings)
    log = FlightLog({"elapsed_s": np.array([0.0, 40.0])}, Ending.LANDED, "", NEVER_S, "", {}, 60.0)
    said = [" ".join(line.split()) for line in _facts(study, flight, flown, log).splitlines()]
    assert "SR1 held, robustness 0.300" in said
    assert "SR2 vacuous" in said
