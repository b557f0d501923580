"""The verbs of the command line, one module a verb: what it asks, what it answers, how it prints."""

from __future__ import annotations

from itertools import chain

GROUPS: dict[str, dict[str, str]] = {
    "Begin": {
        "new": "write a small study to edit, or a plugin package",
        "example": "list the examples, or copy one",
    },
    "Look at the study": {
        "matrix": "show the deviation matrix, every cell with its reason",
        "mutants": "list the catalogue of mutants, derive it, check it",
        "signals": "list the signals that requirements and axes may use",
        "seams": "list the seams where faults can be patched in",
        "operators": "list the operators, and the seams that each fits",
        "axes": "list the axes of the situations",
        "map": "show mine, bodies and route of one situation",
        "schema": "show the keys of a YAML document, or of an answer",
        "check": "check the whole study without flying",
        "hazop": "bring a HAZOP or STPA sheet in, and what people edited",
    },
    "Fly": {
        "run": "fly baseline and mutants over the grid, then score",
        "margin": "find the smallest magnitude that is killed, by bisection",
        "seek": "find a situation that would have shown a fault",
        "propose": "find a requirement that would have shown a fault",
        "suite": "put the faults to your own tests, and score them",
        "merge": "join campaigns that were flown in parts",
        "replay": "fly one flight again, bit for bit, and draw it",
    },
    "Read what was flown": {
        "status": "show which flights a campaign holds",
        "score": "print the score of a campaign, without flying",
        "kills": "show where mutants are killed, and what to do next",
        "coverage": "show what the situations cover",
        "worksheet": "print the HAZOP worksheet with the findings",
        "dispositions": "list the survivors beside the accepted ones",
        "report": "write one HTML file with the whole campaign",
        "compare": "show what only one of two campaigns shows",
        "diff": "list the flights that differ, as `compare --flights`",
    },
    "Exchange with other tools": {
        "export": "write one row per flight, or a file for another tool",
        "judge": "judge records of flights with the study's requirements",
    },
    "This machine": {
        "completion": "print the script by which a shell completes names",
        "doctor": "show what decides the bits of a flight, and what is installed",
    },
}
"""What each verb does, in groups, in the order in which a user needs them."""

VERBS: dict[str, str] = dict(chain.from_iterable(group.items() for group in GROUPS.values()))
"""What each verb does."""
_MODULES = {
    **dict.fromkeys(("seams", "operators", "mutants"), "listing"),
    **dict.fromkeys(("status", "merge", "compare", "diff"), "campaigns"),
    **dict.fromkeys(("axes", "coverage", "map"), "situations"),
    "dispositions": "score",
    "example": "new",
}
"""The file of a verb, where it is not named after the verb."""


def module_of(verb: str) -> str:
    """The module of a verb below this package; it is not imported here, so that a verb is read when it is called."""
    return _MODULES.get(verb, verb)
