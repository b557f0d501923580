"""RTAMT's discrete-time monitor.  Imported only where a formula is parsed, for it is slow to import."""

from __future__ import annotations

import warnings
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
"""Name of the result; no signal has this name."""

_UPPER = (StlComparisonOperator.LESS.value, StlComparisonOperator.LEQ.value)


class _Visitor(StlDiscreteTimeOfflineAstVisitor):  # type: ignore[misc]
    """RTAMT's own comparison asks at every sample which operator it is, which takes a twentieth of a flight's time."""

    def visitPredicate(self, node: Any, *args: Any, **kwargs: Any) -> list[float]:  # noqa: N802 - RTAMT's name
        left, right = (self.visit(child, *args, **kwargs) for child in node.children)
        if node.operator.value in _UPPER:
            return [limit - value for value, limit in zip(left, right, strict=True)]
        return [value - limit for value, limit in zip(left, right, strict=True)]


_Interpreter = discrete_time_offline_interpreter_factory(_Visitor)


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
