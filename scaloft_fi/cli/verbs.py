"""The list of verbs: each has a file of its name in this folder, where `NAME_command` is declared by `@verb`."""

from __future__ import annotations

from importlib import import_module
from itertools import chain

import click

GROUPS: dict[str, dict[str, str]] = {
    "Begin": {
        "new": "write a small study to edit, or a plugin package",
    },
    "Look at the study": {
        "matrix": "show the deviation matrix, every cell with its reason",
        "mutants": "list the catalogue of mutants, derive it, check it",
        "signals": "list the signals that requirements and axes may use",
        "seams": "list the seams where faults can be patched in",
        "operators": "list the operators, and the seams that each fits",
        "axes": "list the axes of the situations",
        "map": "show mine, bodies and route of one situation",
        "schema": "print the JSON Schema of a YAML document, for editors",
        "check": "check the whole study without flying",
    },
    "Fly": {
        "run": "fly baseline and mutants over the grid, then score",
        "margin": "find the smallest magnitude that is killed, by bisection",
        "seek": "find a situation that would have shown a fault",
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
        "diff": "list the flights that differ between two campaigns",
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


def command_of(verb: str) -> click.Command:
    """The command of a verb; its file is imported only now."""
    command = getattr(import_module(f"scaloft_fi.cli.{verb}"), f"{verb}_command")
    assert isinstance(command, click.Command)
    return command
