"""Measure what formulas cost: parsing, evaluation over a flight's log, beside RTAMT; processor time, in turn.

    python benchmarks/stl.py [--rounds N]

The formulas are those of the reference study, with their definitions and triggers; the log is that of the flight that
`scaloft-fi doctor` flies.  RTAMT (extra `test`, Python before 3.13) parses and evaluates the same texts over the same
samples.  The longest window is `since[0:600]` over the same log, which RTAMT would not end.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split
import logging
import time
import warnings
from collections.abc import Callable
from importlib import import_module
from statistics import median
from typing import Any

import numpy as np

import scaloft_fi
from scaloft_fi.judge.requirement import TRIGGER, judge_signals
from scaloft_fi.judge.stl import Formula, inside_always, parse

Texts = list[tuple[str, str]]
"""Formulas of a requirement in the order of their evaluation, each with the name under which later ones read it."""


def main() -> None:
    """Print the figures."""
    options = checkout.parser(__doc__)
    options.add_argument("--rounds", type=int, default=20)
    rounds = options.parse_args().rounds
    study = scaloft_fi.open(checkout.ROOT).definition
    log = scaloft_fi.open(checkout.ROOT).fly("baseline", "T0O0W0D0H1").log
    signals = {name: np.array(log[name], dtype=np.float64) for name in log}
    formulas = [_texts(requirement) for requirement in study.requirements]
    pairs: dict[str, tuple[Callable[[], object], Callable[[], object]]] = {
        "parse": (lambda: _parse(formulas), lambda: _rtamt(formulas, signals, evaluate=False)),
        "judge": (
            lambda: [judge_signals(one, signals, cut_short=False) for one in study.requirements],
            lambda: _rtamt(formulas, signals, evaluate=True),
        ),
    }
    print(f"{sum(map(len, formulas))} formulas, {len(signals['elapsed_s'])} samples")
    for name, (ours, theirs) in pairs.items():
        ours(), theirs()
        times = [(_cpu_s(ours), _cpu_s(theirs)) for _ in range(rounds)]
        mine, rtamts = (1000 * median(column) for column in zip(*times, strict=True))
        print(f"{name}: {mine:.2f} ms, RTAMT {rtamts:.1f} ms, 1/{rtamts / mine:.0f}")
    longest = Formula.parse("(speed_mps > 0) since[0:600] (clearance_m > 0)", signals)
    print(f"since[0:600]: {1000 * _cpu_s(lambda: longest.robustness(signals)):.0f} ms")


def _texts(requirement: Any) -> Texts:
    trigger = [(TRIGGER, requirement.trigger)] if requirement.trigger else []
    return [*requirement.definitions, *trigger, ("", inside_always(requirement.text) or "")]


def _parse(formulas: list[Texts]) -> None:
    for texts in formulas:
        for _, text in texts:
            parse(Formula.parse(text, _Any()).text.split(" "))


class _Any(set[str]):
    def __contains__(self, name: object) -> bool:
        return True


_PARSED: dict[str, Any] = {}


def _rtamt(formulas: list[Texts], signals: dict[str, Any], *, evaluate: bool) -> None:
    """Parse with RTAMT, or evaluate what it has parsed, as a requirement is judged."""
    for texts in formulas:
        known = dict(signals)
        for name, text in texts:
            names = Formula.parse(text, _Any()).names
            if not evaluate or text not in _PARSED:
                _PARSED[text] = _specification(text, names)
            if evaluate:
                columns = {one: known[one].tolist() for one in names}
                times = [0.05 * place for place in range(len(columns[names[0]]))]
                known[name] = np.array([value for _, value in _PARSED[text].evaluate({"time": times, **columns})])


def _specification(text: str, names: tuple[str, ...]) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rtamt = import_module("rtamt")
    logging.disable(logging.WARNING)
    parsed = rtamt.StlDiscreteTimeOfflineSpecification()
    for name in (*names, "out"):
        parsed.declare_var(name, "float")
    parsed.set_sampling_period(50, "ms", 0.1)
    parsed.spec = f"out = ( {text} )"
    parsed.parse()
    return parsed


def _cpu_s(task: Callable[[], object]) -> float:
    start = time.process_time()
    task()
    return time.process_time() - start


if __name__ == "__main__":
    main()
