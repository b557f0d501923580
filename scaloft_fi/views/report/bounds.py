"""What a requirement demands, taken apart: bounds on signals, those that always hold and those of its trigger.

Only a formula that is a conjunction of such bounds is taken apart; any other stays whole: its bounds
alone would say something else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from scaloft_fi.judge.requirement import TRIGGER, Requirement
from scaloft_fi.judge.stl import inside_always, tokenize
from scaloft_fi.views.report.limits import COMPARISON, bound_of

_FOR = re.compile(r"historically \[ 0 : (?P<seconds>[\d.]+) \] (?P<rest>\(.*\))")
_JOINED = {"or", "implies", "iff", "since", "->"}
"""Words that bind otherwise than `and`, which only brackets may separate from it here."""


@dataclass(frozen=True)
class Bound:
    """A comparison of a signal with a number.

    Attributes:
        signal: its name.
        sense: of the comparison, as it is written.
        bound: in the signal's own unit.
        for_s: for so long without a break [s]; None where a sample is enough.
        triggered: whether it binds only while the requirement's trigger is true.
    """

    signal: str
    sense: str
    bound: float
    for_s: float | None = None
    triggered: bool = False


def bounds_of(requirements: Iterable[Requirement]) -> list[dict[str, Any]]:
    """Per requirement its `demands` and `when` it applies, as bounds; both empty where a formula is no conjunction."""
    return [_entry(requirement) for requirement in requirements]


def _entry(requirement: Requirement) -> dict[str, Any]:
    defined = dict(requirement.definitions)
    demands = _demands(inside_always(requirement.text) or "", defined)
    when = _bounds(requirement.trigger, defined) if requirement.trigger else []
    whole = demands is not None and when is not None
    return {
        "name": requirement.name,
        "demands": [asdict(bound) for bound in demands or ()] if whole else [],
        "when": [asdict(bound) for bound in when or ()] if whole else [],
    }


def _demands(text: str, defined: Mapping[str, str]) -> list[Bound] | None:
    limits: list[Bound] = []
    for part in _conjuncts(text):
        triggered = part.startswith(f"{TRIGGER} implies ")
        demanded = part.removeprefix(f"{TRIGGER} implies ")
        bounds = _bounds(demanded, defined)
        if bounds is None or (triggered and len(bounds) > 1 and not demanded.startswith("(")):
            return None
        limits += [Bound(b.signal, b.sense, b.bound, b.for_s, triggered) for b in bounds]
    return limits


def _bounds(text: str, defined: Mapping[str, str], for_s: float | None = None) -> list[Bound] | None:
    """A conjunction as bounds; None where it is something else."""
    conjunction: list[Bound] = []
    for part in _conjuncts(text):
        lasting = _FOR.fullmatch(part)
        if part in defined:
            inner = _bounds(defined[part], defined, for_s)
        elif lasting and for_s is None:
            inner = _bounds(lasting["rest"], defined, float(lasting["seconds"]))
        else:
            inner = _bound(part, for_s)
        if inner is None:
            return None
        conjunction += inner
    return conjunction


def _bound(part: str, for_s: float | None) -> list[Bound] | None:
    match = COMPARISON.fullmatch(part.replace("- ", "-"))
    return [Bound(match["signal"], match["sense"], bound_of(match), for_s)] if match else None


def _conjuncts(text: str) -> Iterator[str]:
    """The parts that `and` joins outside all brackets, without the brackets around them.

    >>> list(_conjuncts("((trigger implies (a > 0 and b > 0)) and c > 1)"))
    ['trigger implies ( a > 0 and b > 0 )', 'c > 1']
    """
    tokens = _bare(tokenize(text))
    parts: list[list[str]] = [[]]
    outside = set()
    depth = 0
    for token in tokens:
        depth += (token == "(") - (token == ")")
        outside |= {token} if depth == 0 else set()
        if token == "and" and depth == 0:
            parts.append([])
        else:
            parts[-1].append(token)
    if len(parts) == 1 or outside & _JOINED:
        yield " ".join(tokens)
        return
    for part in parts:
        yield from _conjuncts(" ".join(part))


def _bare(tokens: list[str]) -> list[str]:
    """Without a pair of brackets around everything."""
    while tokens and tokens[0] == "(" and tokens[-1] == ")":
        depth = 0
        for place, token in enumerate(tokens):
            depth += (token == "(") - (token == ")")
            if depth == 0 and place < len(tokens) - 1:
                return tokens
        tokens = tokens[1:-1]
    return tokens
