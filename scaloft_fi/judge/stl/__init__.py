"""Signal temporal logic over sampled signals: words, tree, parser, evaluator, and `Formula`, which joins them."""

from scaloft_fi.judge.stl.formula import LARGEST, Formula, Samples, Signals
from scaloft_fi.judge.stl.tree import SAMPLE_MS
from scaloft_fi.judge.stl.words import (
    ARITHMETIC,
    FUTURE,
    LOGIC,
    LONGEST,
    PAST,
    WORDS,
    FormulaError,
    inside_always,
    tokenize,
)

__all__ = [
    "ARITHMETIC",
    "FUTURE",
    "LARGEST",
    "LOGIC",
    "LONGEST",
    "PAST",
    "SAMPLE_MS",
    "WORDS",
    "Formula",
    "FormulaError",
    "Samples",
    "Signals",
    "inside_always",
    "tokenize",
]
