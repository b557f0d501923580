"""What a flight that was flown again was, and how it compares with the campaign's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Compliance, Kind, measured_rho
from scaloft_fi.sim.log import Ending
from scaloft_fi.views.flights.repeated import Comparison, Likeness
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import count, listing, number, optional, record, text, texts

REPLAY = Output(
    "replay",
    "1.0",
    "a flight that was flown again",
    {
        "mutant": text("`baseline`, `PLACEBO` or the id of the mutant"),
        "situation": text("key of the situation"),
        "words": texts("the situation in words"),
        "seed": count("seed of the flight"),
        "ending": text("how it ended", [ending.value for ending in Ending]),
        "duration_s": number("how long it lasted", "s"),
        "infected_at_s": optional(number("first altered sample", "s from take-off"), "no sample was altered"),
        "altered": count("samples that the fault altered"),
        "carried": count("samples that crossed its seam"),
        "stack_error": optional(text("the exception of the stack"), "there was none"),
        "digest": text("SHA-256 over the ground truth"),
        "readings": listing(
            "what each requirement says of it",
            record(
                "a reading",
                {
                    "requirement": text("name of the requirement"),
                    "kind": text("of the requirement", [kind.value for kind in Kind]),
                    "compliance": text("what it says", [compliance.value for compliance in Compliance]),
                    "robustness": optional(
                        number("distance to a violation, in the requirement's own unit; below 0 it is violated"),
                        "the flight does not put it to the test",
                    ),
                    "violated_at_s": optional(number("first violation", "s from take-off"), "it is not violated"),
                },
            ),
        ),
        "likeness": text("how it is like the campaign's", [likeness.value for likeness in Likeness]),
        "compared": text("the same in a sentence"),
        "written": optional(text("path of the file of --output"), "none was asked for"),
    },
    rows="readings",
)


def replay_values(outcome: Outcome, words: Sequence[str], compared: Comparison, written: str | None) -> dict[str, Any]:
    """Plain JSON values of the form `REPLAY`.

    Args:
        outcome: of the flight.
        words: its situation in words.
        compared: how it compares with the campaign's.
        written: path of the file that was written.
    """
    return {
        "mutant": outcome.mutant,
        "situation": outcome.situation,
        "words": list(words),
        "seed": outcome.seed,
        "ending": outcome.ending,
        "duration_s": outcome.duration_s,
        "infected_at_s": outcome.infected_at_s,
        "altered": outcome.altered,
        "carried": outcome.carried,
        "stack_error": outcome.stack_error or None,
        "digest": outcome.digest,
        "readings": [
            {
                "requirement": reading.requirement,
                "kind": reading.kind.value,
                "compliance": reading.compliance.value,
                "robustness": measured_rho(reading),
                "violated_at_s": reading.violated_at_s,
            }
            for reading in outcome.readings
        ],
        "likeness": compared.likeness.value,
        "compared": compared.told,
        "written": written,
    }
