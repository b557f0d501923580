"""RTAMT, the field's library for signal temporal logic, as an oracle; it does not install on Python 3.13."""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Mapping
from typing import Any

import pytest

from scaloft_fi.judge.stl import EXTREMES, Infix, Interval, Node, Number, Prefix, Signal

if sys.version_info >= (3, 13):
    pytest.importorskip("rtamt", reason="RTAMT does not install on Python 3.13")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import rtamt

_WORDS: Mapping[str, str] = {
    "Addition": "+",
    "Subtraction": "-",
    "Multiplication": "*",
    "Division": "/",
    "Conjunction": "and",
    "Disjunction": "or",
    "Implies": "implies",
    "Iff": "iff",
    "Neg": "not",
    "Abs": "abs",
    "Sqrt": "sqrt",
    "Rise": "rise",
    "Fall": "fall",
}


def specification(text: str, names: tuple[str, ...]) -> Any:
    """RTAMT's parsed formula over these signals at 20 Hz; raises any exception where RTAMT refuses the text."""
    parsed = rtamt.StlDiscreteTimeOfflineSpecification()
    for name in (*names, "out"):
        parsed.declare_var(name, "float")
    parsed.set_sampling_period(50, "ms", 0.1)
    # in brackets, so that RTAMT refuses text after a complete formula instead of dropping it
    parsed.spec = f"out = ( {text} )"
    logging.disable(logging.WARNING)
    try:
        parsed.parse()
    finally:
        logging.disable(logging.NOTSET)
    return parsed


def rtamt_tree(text: str, names: tuple[str, ...]) -> Node:
    """RTAMT's syntax tree of a text, as a tree of ours."""
    return _ours(specification(text, names).ast.specs[0])


def rtamt_robustness(text: str, signals: Mapping[str, list[float]]) -> list[float]:
    """RTAMT's robustness at each sample, (T,) of at least 2 samples."""
    (length,) = {len(column) for column in signals.values()}
    times = [0.05 * place for place in range(length)]
    pairs = specification(text, tuple(signals)).evaluate({"time": times, **signals})
    return [value for _, value in pairs]


def _ours(node: Any) -> Node:
    kind = type(node).__name__
    if kind == "Variable":
        return Signal(node.var)
    if kind == "Constant":
        return Number(node.val)
    if kind == "Previous":
        return Prefix("historically", _ours(node.children[0]), Interval(1, 1))
    if kind in ("Neg", "Abs", "Sqrt", "Rise", "Fall"):
        return Prefix(_WORDS[kind], _ours(node.children[0]))
    word = kind.removeprefix("Timed").lower()
    interval = Interval(int(node.begin * 20), int(node.end * 20)) if kind.startswith("Timed") else None
    if word in EXTREMES:
        return Prefix(word, _ours(node.children[0]), interval)
    operator = word if word in ("since", "until") else str(node.operator) if kind == "Predicate" else _WORDS[kind]
    return Infix(operator, *map(_ours, node.children[:2]), interval)
