"""The noise of a stack that is not deterministic, in a line."""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.analysis.detection import Noise


def noise_line(noise: Sequence[Noise]) -> str:
    """What the stack alone does to the robustness of each requirement, beside what the seeds do.

    >>> noise_line([Noise("SR1", 6, 0.0123, 0.2, 0), Noise("SR2", 0, None, None, 0)])
    'one flight varies by the stack alone (and between seeds): SR1 0.012 (0.2) by 6 pairs, SR2 not measured.'
    """
    told = ", ".join(_one(one) for one in noise)
    apart = [f"{one.requirement} in {one.apart} of {one.pairs}" for one in noise if one.apart]
    verdicts = f"  A pair has two verdicts: {', '.join(apart)}." if apart else ""
    return f"one flight varies by the stack alone (and between seeds): {told}.{verdicts}"


def _one(one: Noise) -> str:
    if one.stack is None:
        return f"{one.requirement} not measured"
    seeds = f" ({one.seeds:.2g})" if one.seeds is not None else ""
    return f"{one.requirement} {one.stack:.2g}{seeds} by {one.pairs} pairs"
