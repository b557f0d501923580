"""RTAMT's discrete-time monitor, its slow steps made fast.  Imported only where a formula is parsed, for it is slow."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

with warnings.catch_warnings():
    # of its own dependencies, which is no concern of the user's
    warnings.simplefilter("ignore")
    from rtamt.semantics.abstract_discrete_time_offline_interpreter import discrete_time_offline_interpreter_factory
    from rtamt.semantics.enumerations.comp_oper import StlComparisonOperator
    from rtamt.semantics.stl.discrete_time.offline.ast_visitor import StlDiscreteTimeOfflineAstVisitor
    from rtamt.spec.abstract_specification import AbstractOfflineSpecification
    from rtamt.syntax.ast.parser.stl.specification_parser import StlAst

OUT = "robustness_"
"""Name of the result; no signal is called so."""


_UPPER = (StlComparisonOperator.LESS.value, StlComparisonOperator.LEQ.value)


class _Visitor(StlDiscreteTimeOfflineAstVisitor):  # type: ignore[misc]
    """RTAMT asks anew at every sample which comparison it is, and looks at every window as a whole."""

    def visitPredicate(self, node: Any, *args: Any, **kwargs: Any) -> list[float]:  # noqa: N802 - RTAMT's name
        left, right = (self.visit(child, *args, **kwargs) for child in node.children)
        if node.operator.value in _UPPER:
            return [limit - value for value, limit in zip(left, right, strict=True)]
        return [value - limit for value, limit in zip(left, right, strict=True)]

    def visitTimedHistorically(self, node: Any, *args: Any, **kwargs: Any) -> list[float]:  # noqa: N802 - RTAMT's name
        return self._within(node, min, math.inf, *args, **kwargs)

    def visitTimedOnce(self, node: Any, *args: Any, **kwargs: Any) -> list[float]:  # noqa: N802 - RTAMT's name
        return self._within(node, max, -math.inf, *args, **kwargs)

    def _within(self, node: Any, most: Callable[..., float], before: float, *args: Any, **kwargs: Any) -> list[float]:
        """At each sample the `most` of those within the node's interval before it; `before` stands for what was not."""
        (child,) = node.children
        samples = self.visit(child, *args, **kwargs)
        begin, end = self.time_unit_transformer(node)
        return slid(most, [before] * end + samples, end - begin + 1)[: len(samples)]


def slid(most: Callable[..., float], samples: list[float], width: int) -> list[float]:
    """The `most` of `width` neighbours, for each that has so many, by windows that double; of equals the first."""
    reach = 1
    while 2 * reach <= width:
        samples = list(map(most, samples, samples[reach:]))
        reach *= 2
    return list(map(most, samples, samples[width - reach :]))


class _Interpreter(discrete_time_offline_interpreter_factory(_Visitor)):  # type: ignore[misc]
    """RTAMT's own looks at the time between any two samples, to keep the last, and makes a pair of each value."""

    def evaluate(self, dataset: Mapping[str, Sequence[float]]) -> list[float]:
        """The robustness at each sample."""
        self.exist_ast()
        self.set_variable_to_ast_from_dataset(dataset)
        times = self.ast.offline_results["time"] = dataset["time"]
        *_, values = self.visitAst(self.ast, len(times))
        return list(map(float, values))


def specification(text: str, names: tuple[str, ...], sample_ms: int) -> Any:
    """Parse a formula over these signals, sampled every `sample_ms` [ms].

    Raises:
        Exception: whatever RTAMT's parser makes of a text that is no formula.
    """
    parsed = AbstractOfflineSpecification(StlAst(), _Interpreter())
    for name in (*names, OUT):
        parsed.declare_var(name, "float")
    parsed.set_sampling_period(sample_ms, "ms", 0.1)
    # in brackets, so that what follows a complete formula is refused and not dropped
    parsed.spec = f"{OUT} = ( {text} )"
    parsed.parse()
    return parsed
