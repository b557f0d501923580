from __future__ import annotations

from scaloft_fi.mutants.operators import OPERATORS


def test_a_false_contact_comes_with_each_period_and_leaves_a_true_one() -> None:
    from scaloft_fi.outside import faults  # noqa: F401 - it declares the operator

    operator = OPERATORS["false_contact"]
    example = operator.example
    context = example.context()
    tap = operator.tap(context, operator.check("contact", example.message, example.arguments))
    arrived = tuple(tap(k * context.period_s, sample) for k, sample in enumerate(example.before))
    assert arrived == example.after
    assert tap(0.15, example.before[0]._replace(hull=True)).hull
    assert tap(0.2, None) is None
