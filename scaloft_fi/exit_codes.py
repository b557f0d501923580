"""The exit codes of every verb, each with what it means."""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """How a verb ended; `meaning` says it in a sentence.

    >>> ExitCode.BAD_INPUT.value, ExitCode(3).name
    (2, 'BELOW')
    """

    DONE = 0
    BAD_INPUT = 2
    BELOW = 3
    GATE = 4
    INTERNAL = 70
    INTERRUPTED = 130

    @property
    def meaning(self) -> str:
        """What the code means, in a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    ExitCode.DONE: "The verb did what was asked; violations, survivors and red baselines are results, not failures.",
    ExitCode.BAD_INPUT: "An option, a file or the environment was refused: one sentence on standard error says where, "
    "what is allowed and what to change; no result was written.",
    ExitCode.BELOW: "The score is below `--fail-under`, or `--ratchet` found a survivor that nobody accepted or an "
    "acceptance that has expired.",
    ExitCode.GATE: "A gate failed, so the campaign gives no valid score: PLACEBO or a repeated flight differs, a "
    "control shows nothing, the stack raises in a baseline, a baseline never leaves the ground, no pair of a flown "
    "situation is steady, or the harness failed in too many flights.",
    ExitCode.INTERNAL: "An error of scaloft-fi or of a plugin, whatever was typed; SCALOFT_DEBUG=1 shows where.",
    ExitCode.INTERRUPTED: "Ctrl-C or a signal ended the verb; flights that had ended are saved, and the same command "
    "resumes.",
}
