"""A margin as people read it."""

from __future__ import annotations

import math

from scaloft_fi.analysis.margin import Margin, Scale

UNKNOWN = "?"
"""What stands where the flights bound no threshold."""


def magnitude_text(scale: Scale, magnitude: float) -> str:
    """A magnitude with its unit.

    >>> magnitude_text(Scale("s"), 0.5)
    '0.5 s'
    """
    return f"{magnitude:g} {scale.unit}".rstrip()


def margin_text(margin: Margin) -> str:
    """The threshold in a cell of a table; `!` where the response is not monotone.

    >>> s = Scale("s", 1, 0.0)
    >>> [margin_text(Margin(s, *ends)) for ends in ((1.3, 1.4), (1.0, 3.0), (5.0, None), (None, 0.5), (None, None))]
    ['1.4 s', '1-3 s', '> 5 s', '<= 0.5 s', '?']
    >>> margin_text(Margin(Scale("m", -1), 0.1, None)), margin_text(Margin(s, 1.0, 3.0, again=(5.0,)))
    ('< 0.1 m', '1-3 s !')
    >>> margin_text(Margin(s, 1.0, None, 3.0)), margin_text(Margin(s, 0.5, 3.0, 1.0))
    ('seen 1-3 s', '0.5-3 s')
    """
    if not margin.known:
        return UNKNOWN
    scale, survives = margin.scale, margin.survives
    beyond, within = (">", "<=") if scale.sign > 0 else ("<", ">=")
    strong = margin.kills if margin.kills is not None else margin.seen
    if strong is None:
        text = f"{beyond} {magnitude_text(scale, survives or 0.0)}"
    elif survives is None:
        text = f"{within} {magnitude_text(scale, strong)}"
    elif scale.close(survives, strong):
        text = magnitude_text(scale, strong)
    else:
        text = f"{survives:g}-{magnitude_text(scale, strong)}"
    return "seen " * (margin.kills is None and margin.seen is not None) + text + " !" * bool(margin.again)


def finite(value: float | None) -> float | str | None:
    """A number of JSON, which has no infinite ones: those are texts.

    >>> finite(0.5), finite(math.inf), finite(None)
    (0.5, 'inf', None)
    """
    return value if value is None or math.isfinite(value) else f"{value:g}"
