"""RTAMT's discrete-time monitor.  Import this module only to parse a formula, because the import is slow."""

from __future__ import annotations

import warnings
from typing import Any

with warnings.catch_warnings():
    # warnings of RTAMT's dependencies do not concern the user
    warnings.simplefilter("ignore")
    from rtamt.semantics.abstract_discrete_time_offline_interpreter import discrete_time_offline_interpreter_factory
    from rtamt.semantics.enumerations.comp_oper import StlComparisonOperator
    from rtamt.semantics.stl.discrete_time.offline.ast_visitor import StlDiscreteTimeOfflineAstVisitor
    from rtamt.spec.abstract_specification import AbstractOfflineSpecification
    from rtamt.syntax.ast.parser.stl.specification_parser import StlAst

OUT = "robustness_"
"""Name of the result; no signal has this name."""

_UPPER = (StlComparisonOperator.LESS.value, StlComparisonOperator.LEQ.value)


class _Visitor(StlDiscreteTimeOfflineAstVisitor):  # type: ignore[misc]
    """Looks up the comparison operator once; RTAMT does so at every sample, which takes 5 % of a flight's time."""

    def visitPredicate(self, node: Any, *args: Any, **kwargs: Any) -> list[float]:  # noqa: N802 - RTAMT's name
        left, right = (self.visit(child, *args, **kwargs) for child in node.children)
        if node.operator.value in _UPPER:
            return [limit - value for value, limit in zip(left, right, strict=True)]
        return [value - limit for value, limit in zip(left, right, strict=True)]


_Interpreter = discrete_time_offline_interpreter_factory(_Visitor)


def specification(text: str, names: tuple[str, ...], sample_ms: int) -> Any:
    """Parse a formula over these signals, sampled every `sample_ms` [ms].

    Raises:
        Exception: any error of RTAMT's parser for a text that is no formula.
    """
    parsed = AbstractOfflineSpecification(StlAst(), _Interpreter())
    for name in (*names, OUT):
        parsed.declare_var(name, "float")
    parsed.set_sampling_period(sample_ms, "ms", 0.1)
    # in brackets, so that RTAMT refuses text after a complete formula instead of dropping it
    parsed.spec = f"{OUT} = ( {text} )"
    parsed.parse()
    return parsed
