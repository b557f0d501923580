"""The JSON Schemas of `hazop/`, of `sim/requirements.yaml` and of `sim/found.yaml`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from scaloft_fi.analysis.detection import ALPHA, MOST_ALPHA
from scaloft_fi.hazop.load import MOST_ENTRIES
from scaloft_fi.hazop.matrix import PERIODS, Worse
from scaloft_fi.judge.requirement import MOST, Kind
from scaloft_fi.judge.stl import LONGEST
from scaloft_fi.mutants.operator import Argument, Operator
from scaloft_fi.sim.found import MOST_FINDS, Again, Break, Evidence, Find
from scaloft_fi.verbs.documents.schema import (
    Declared,
    Schema,
    anything,
    attributes_of,
    choice,
    either,
    fixed,
    flag,
    listed,
    mapping,
    named,
    number,
    numbers,
    text,
    whole,
)
from scaloft_fi.verbs.operators import argument_facts

GUIDEWORD, PARAMETER = "[A-Z][A-Z0-9]*", "[a-z][a-z0-9_]*"
SEVERITY = "[a-z][a-z0-9_]*"
UNIT, NAMED_MAGNITUDE = "[A-Za-z%][A-Za-z0-9%]*|", "[A-Za-z][A-Za-z0-9_.]*"
SEAM = "the seam whose samples the fault changes; `scaloft-fi seams` lists them"
PHASES = "also flown shifted by 1/4, 1/2, 3/4 of that time, and at events of the flight"
DAY = r"\d{4}-\d{2}-\d{2}"


def guidewords(_: Declared) -> Schema:
    """`hazop/guidewords.yaml`."""
    title = text("name of the guideword for people", "late")
    meaning = text("what the guideword asks of a parameter, in a few words", "later than intended")
    no = fixed(False, "a guideword of IEC 61882")
    yes = fixed(True, "a guideword that IEC 61882 does not have; `reason` says why the study has it")
    reason = text("why the study has this guideword beside those of IEC 61882")
    word = either(
        "A guideword; its name stands in the ids of mutants.",
        mapping("A guideword of the standard.", {"title": title, "meaning": meaning}, {"extension": no}),
        mapping(
            "A guideword of the study's own.",
            {"title": title, "meaning": meaning, "extension": yes, "reason": reason},
        ),
    )
    return named("The guidewords by name, in the order of the columns of the matrix.", word, pattern=GUIDEWORD)


def parameters(_: Declared) -> Schema:
    """`hazop/parameters.yaml`."""
    keys = {
        "title": text("name of the parameter for people", "human detection"),
        "intent": text("design intent: what the parameter should be when nothing is wrong"),
        "node": text("the part of the drone where the parameter flows"),
        "unit": text("unit of the parameter, or what one of its samples is", "m/s"),
    }
    parameter = mapping("A parameter; `hazop/matrix/<name>.yaml` has its cells.", keys)
    return named("The parameters by name, in the order of the rows of the matrix.", parameter, pattern=PARAMETER)


def severities(_: Declared) -> Schema:
    """`hazop/severities.yaml`."""
    keys = {
        "title": text("name of the class for people", "a person may be hurt"),
        "meaning": text("which consequences belong to the class"),
    }
    one = mapping("A class of severity; `severity` of a credible cell names it.", keys)
    return named(
        "The study's own classes of severity by name, the worst first; they enter no ratio.", one, pattern=SEVERITY
    )


def matrix(declared: Declared) -> Schema:
    """`hazop/matrix/<parameter>.yaml`."""
    not_meaningful = mapping(
        "A cell that makes no sense.",
        {
            "status": fixed("not_meaningful", "the guideword makes no sense for this parameter"),
            "reason": text("why it makes no sense"),
        },
    )
    statuses = {"credible": "a fault that could occur", "control": "a crude fault that the tests must detect"}
    tested = mapping(
        "A cell with faults.",
        {
            "status": choice("how the study classifies the cell", statuses),
            "deviation": text("how the parameter deviates, in a sentence", "Detection delivered late."),
            "causes": listed("what could bring the deviation about", text("a cause"), least=1, most=MOST_ENTRIES),
            "effect": text("the effect on the next stage, then on the flight"),
            "requirements": listed(
                "the requirements at risk, by their names in sim/requirements.yaml",
                text("name of a requirement", "SR1"),
                least=1,
                most=MOST_ENTRIES,
            ),
            "faults": listed(
                "what produces the deviation; the first is the default, and with several each needs a unit of its own",
                _fault(declared),
                least=1,
                most=MOST_ENTRIES,
            ),
        },
        {
            "severity": text("of a credible cell: a class of hazop/severities.yaml", "injury", pattern=SEVERITY),
            "predicted": text("what the study expects of the flights, written before they are flown"),
        },
    )
    cell = either("A cell: the guideword asked of this parameter.", not_meaningful, tested)
    return named("The cells of one parameter, one for each guideword.", cell, pattern=GUIDEWORD)


def _fault(declared: Declared) -> Schema:
    operators = declared.operators
    value = {"type": ["number", "string", "boolean"]}
    fault = mapping(
        "An operator at a seam.",
        {
            "seam": choice(SEAM, declared.seams) if declared.seams else text(SEAM, "person", "velcmd"),
            "operator": either("the change; `scaloft-fi operators` lists them", *_operators(operators)),
        },
        {
            "arguments": named("fixed arguments of the operator, by name", {**value, "description": "an argument"}),
            "magnitude": _magnitude(),
            "phases": flag(f"with {' or '.join(PERIODS)}: {PHASES}", default=False),
            "expected": _expected(),
        },
    )
    fault["allOf"] = [_of_operator(name, operator) for name, operator in operators.items()]
    return fault


def _operators(operators: Mapping[str, Operator]) -> Iterator[Schema]:
    return (fixed(name, operator.summary) for name, operator in operators.items())


def _magnitude() -> Schema:
    rung = _rung("a magnitude: a number, or a name where the operator's argument is one")
    return mapping(
        "The argument that varies, in the unit of an engineer.",
        {
            "argument": text("the operator's argument that the magnitude sets", "delay_s"),
            "ladder": listed(
                "the magnitudes in the catalogue, from mild to strong, all numbers or all names",
                rung,
                least=1,
                most=MOST_ENTRIES,
                examples=([0.5, 1, 3, 5],),
            ),
            "default": _rung("the magnitude, on the ladder, that the name of the cell alone stands for"),
        },
        {
            "unit": text(
                "of the numbers on the ladder, as in a mutant's id; empty for none", "s", "m", "%", pattern=UNIT
            ),
            "scale": number("the argument is scale x magnitude", "", 0.001, 0.01, default=1),
            "worse": choice(
                "the order of the ladder; left out: as its numbers run",
                {
                    Worse.LARGER: "a larger magnitude is worse",
                    Worse.SMALLER: "a smaller magnitude is worse",
                    Worse.UNORDERED: "no magnitude is more than another",
                },
            ),
            "neutral": number("the magnitude that changes nothing; left out: it follows from unit and order"),
        },
    )


def _rung(about: str) -> Schema:
    return {
        "description": about,
        "anyOf": [{"type": "number"}, {"type": "string", "pattern": f"^(?:{NAMED_MAGNITUDE})$"}],
    }


def _expected() -> Schema:
    return mapping(
        "The expectation that the fault changes no sample in this grid; a run that shows otherwise says so.",
        {
            "status": fixed("not_infected", "no sample differs, or the seam carries none"),
            "reason": text("why the fault changes nothing"),
        },
        {
            "magnitudes": listed(
                "the magnitudes of the ladder for which it holds; left out: all",
                _rung("a magnitude of the ladder"),
                least=1,
                most=MOST_ENTRIES,
            )
        },
    )


def _of_operator(name: str, operator: Operator) -> Schema:
    """Under an operator's name its own arguments, and no others."""
    arguments = {key: _argument(argument) for key, argument in operator.arguments.items()}
    then: dict[str, Any] = {
        "arguments": {"properties": arguments, "additionalProperties": False},
        "magnitude": {"properties": {"argument": {"enum": list(arguments)}}},
    }
    return {
        "if": {"properties": {"operator": {"const": name}}, "required": ["operator"]},
        "then": {"properties": then},
    }


def _argument(argument: Argument) -> Schema:
    facts = argument_facts(argument)
    unit = f" [{facts['unit']}]" if facts["unit"] else ""
    told: Schema = {"description": f"{facts['range'] or facts['kind']}{unit}"}
    if not argument.required:
        told["default"] = argument.default
    if argument.kind in (float, int):
        bounds = {"minimum": facts["least"], "exclusiveMinimum": facts["above"], "maximum": facts["most"]}
        return told | {"type": "number"} | {key: bound for key, bound in bounds.items() if bound is not None}
    if argument.kind is bool:
        return told | {"type": "boolean"}
    if argument.choices:
        return told | {"enum": list(argument.choices)}
    return told | ({"type": "string"} if argument.kind is str else {"type": ["number", "string", "boolean"]})


def score(_: Declared) -> Schema:
    """`hazop/score.yaml`."""
    alpha = number(
        "accepted chance that a fault which does nothing is called detected",
        "",
        0.01,
        above=0,
        most=MOST_ALPHA,
        default=ALPHA,
    )
    return mapping("How sure a score has to be; without the file alpha is 0.01.", {"alpha": alpha})


def dispositions(_: Declared) -> Schema:
    """`hazop/dispositions.yaml`."""
    keys = {
        "status": fixed("accepted", "a survivor that the team accepts"),
        "owner": text("who answers for it", "A. Engineer"),
        "reason": text("why the team accepts it"),
        "expires": {**text("last day of its validity", "2027-01-31", pattern=DAY), "format": "date"},
    }
    only = listed(
        "keys of the situations in which it is accepted; left out: in all",
        anything("key of a situation, such as T0O0W0D0H1"),
        least=1,
    )
    entry = mapping("An accepted survivor.", keys, {"situations": only})
    return named("The accepted survivors by a mutant's id; a bare cell name is its default.", entry)


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
