"""The JSON Schemas of `sim/requirements.yaml` and of `sim/found.yaml`, which speaks of requirements."""

from __future__ import annotations

from collections.abc import Mapping

from scaloft_fi.judge.requirement import MOST, Kind
from scaloft_fi.judge.stl import LONGEST
from scaloft_fi.sim.found import MOST_FINDS, Again, Break, Evidence, Find
from scaloft_fi.views.documents.build import (
    Schema,
    choice,
    listed,
    mapping,
    named,
    number,
    numbers,
    text,
    whole,
)
from scaloft_fi.views.documents.declared import Declared
from scaloft_fi.views.documents.docstrings import attributes_of

KINDS: Mapping[str, str] = {
    Kind.SAFETY: "a violation can kill a mutant",
    Kind.OPERABILITY: "a violation counts in a score of its own",
    Kind.REPORTED: "a violation is shown and decides nothing",
}


def requirements(_: Declared) -> Schema:
    """`sim/requirements.yaml`."""
    past = "over the present and the past: historically, once, since, not, and, or, implies, iff, comparisons, + - * /"
    definition = text(f"a formula {past}", "person_sight_m / 3 <= 1") | {"maxLength": LONGEST}
    requirement = mapping(
        "A requirement, judged from the log of every flight.",
        {
            "formula": text(
                f"always( ... ), inside it a formula {past}; `scaloft-fi signals` lists the signals",
                "always(clearance_m > 0)",
            )
            | {"pattern": r"^\s*always\s*\("},
            "kind": choice("what a violation means", KINDS),
        },
        {
            "trigger": text(
                "condition under which it applies; a flight without it is vacuous",
                "elapsed_s / 2 >= 1 and historically[0:2](near)",
            ),
            "unit": text("unit of the robustness", "m"),
            "title": text("the requirement in a sentence", "The drone touches nothing."),
            "source": text("where the requirement comes from"),
        },
    )
    about = "the requirements by name, at least one of kind safety"
    return mapping(
        "The requirements of a flight in signal temporal logic over the flight log (20 Hz).",
        {"requirements": named(about, requirement, least=1, most=MOST)},
        {
            "definitions": named(
                "formulas by name, which the requirements and later definitions use", definition, most=MOST
            )
        },
    )


def found(_: Declared) -> Schema:
    """`sim/found.yaml`."""
    shows = named("the evidence by the id of each mutant that it shows", _evidence(), least=1, most=MOST_FINDS)
    told = attributes_of(Find)
    find = mapping(
        "A situation that shows mutants.",
        {**_situation(told), "mutant": text(told["mutant"], "LATE-pose@0.5s"), "shows": shows},
    )
    about = "the situations that show mutants, by name"
    return mapping(
        "The situations that searches found; `scaloft-fi seek` writes this file.",
        {"grid": text("name of the grid whose keys they have", "search"), "finds": named(about, find, most=MOST_FINDS)},
        {"breaks": named("the situations that break the unmutated drone, by name", _break(), most=MOST_FINDS)},
    )


def _situation(told: Mapping[str, str]) -> dict[str, Schema]:
    return {
        "situation": text(told["situation"], "T1O0W0D0H1Cs=0.871"),
        "words": listed(told["words"], text("a value in words")),
        "seed": whole(told["seed"]),
    }


def _evidence() -> Schema:
    told = attributes_of(Evidence)
    return mapping(
        "The evidence from seeds that the search never flew.",
        {
            "requirement": text(told["requirement"], "SR2"),
            "candidate": whole(told["candidate"], least=1),
            "p": number(told["p"], least=0, most=1),
            "alpha": number("what p was compared with", above=0, most=1),
            "violated": whole("flights of the mutant that violate the requirement"),
            "flights": whole("flights of the mutant, with the seeds 0, 1, ...", least=1),
            "held": whole("baselines that hold the requirement with a robustness above `spread`"),
            "baselines": whole("baselines, with the seeds 0, 1, ...", least=1),
            "margin": number("robustness that nine in ten baselines reach"),
            "spread": number("standard deviation of the robustness over the baselines", least=0),
            "mission": whole("baselines that hold every operability requirement and meet the value of every axis"),
        },
        {
            "struck": text(told["struck"], "wall"),
            "again": mapping(
                "The evidence of a replication, `seek --replicate`: flights on seeds that nothing before used.",
                {
                    "seed": whole("the first seed of them"),
                    "p": number(attributes_of(Again)["p"], least=0, most=1),
                    "violated": whole("flights of the mutant that violate the requirement"),
                    "flights": whole("flights of the mutant", least=1),
                    "held": whole("baselines that hold the requirement with a robustness above their spread"),
                    "baselines": whole("baselines", least=1),
                    "mission": whole("baselines that do their mission"),
                },
            ),
        },
    )


def _break() -> Schema:
    told = attributes_of(Break)
    return mapping(
        "A situation in which the unmutated drone violates a safety requirement.",
        {
            **_situation(told),
            "requirement": text(told["requirement"], "SR1"),
            "leg": text(told["leg"], "corner to end"),
            "near": text(told["near"], "corner"),
            "error": number("how far from the truth that belief was, in `unit`", least=0),
            "violated": whole("flights that violate the requirement, more than half"),
            "flights": whole("flights, with the seeds 0, 1, ...", least=1),
            "alike": whole(told["alike"], least=1),
            "flight": whole(told["flight"]),
            "t_s": number("time of the violation from take-off", "s", least=0),
            "place": numbers("centre of the vehicle then x, y, z", 3, "m, world"),
        },
        {
            "struck": text(told["struck"], "bar"),
            "belief": text(told["belief"], "pose"),
            "unit": text("unit of the error", "m"),
        },
    )
