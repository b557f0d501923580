"""Arguments of the Python API: how they are read, and how an error names them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from scaloft_fi.campaign.plan import MOST_SEEDS
from scaloft_fi.campaign.plan import parse_seeds as seeds_in
from scaloft_fi.errors import InputError, ScaloftError

Seeds = int | str | range | list[int] | tuple[int, ...]
"""`3` or `"3"` for seeds 0 to 2, `"4-6"` for seeds 4 to 6, or the seeds themselves."""
NAMES = {"mutant": "mutants", "situation": "situations", "budget": "budget_s", "output": "path"}
"""Arguments that have another name than the option of the verb."""
_OPTION = re.compile(r"(?<![\w-])--([a-z]+(?:-[a-z]+)*)")


@contextmanager
def in_python(**names: str) -> Iterator[None]:
    """In this context an error names arguments of Python, not options of the command line.

    Args:
        names: arguments by option, where they are not those of `NAMES`.
    """
    try:
        yield
    except ScaloftError as error:
        error.args = (python_words(str(error), names),)
        raise


def python_words(sentence: str, names: Mapping[str, str] = NAMES) -> str:
    """A sentence with arguments instead of options; commands, which stand in backticks, keep their options.

    >>> python_words("--baseline-seeds='x' must be N; see `run --mutant ID`; another --mutant")
    "baseline_seeds='x' must be N; see `run --mutant ID`; another mutants"
    """
    known = {**NAMES, **names}
    parts = sentence.split("`")
    parts[::2] = [_OPTION.sub(lambda it: known.get(it[1], it[1].replace("-", "_")), part) for part in parts[::2]]
    return "`".join(parts)


def names(given: str | Sequence[str], name: str) -> tuple[str, ...]:
    """One text, or several.

    Raises:
        InputError: there is something else.
    """
    several: object = given  # whatever a script gives
    listed = tuple(several) if isinstance(several, Iterable) and not isinstance(several, str) else (given,)
    for one in listed:
        if not isinstance(one, str):
            raise InputError(f"{name}={one!r} must be a text, or a sequence of texts")
    return listed


def seeds(given: Seeds | None, name: str) -> tuple[int, ...] | None:
    """The seeds; None stays None.

    >>> seeds(3, "seeds"), seeds("4-6", "seeds"), seeds([7, 9], "seeds")
    ((0, 1, 2), (4, 5, 6), (7, 9))

    Raises:
        InputError: the argument names no seeds.
    """
    if given is None:
        return None
    if isinstance(given, str):
        return seeds_in(given, name)
    allowed = f"a number of seeds from 1 to {MOST_SEEDS}, a text such as '4-6', or different seeds, none below 0"
    if isinstance(given, int):
        listed = () if isinstance(given, bool) else tuple(range(min(given, MOST_SEEDS + 1)))
    else:
        listed = tuple(given) if isinstance(given, range | list | tuple) else ()
    whole = all(isinstance(one, int) and not isinstance(one, bool) and one >= 0 for one in listed)
    if not 0 < len(set(listed)) == len(listed) <= MOST_SEEDS or not whole:
        raise InputError(f"{name}={given!r} must be {allowed}")
    return listed


def number(given: float, name: str, least: float, most: float) -> float:
    """A number from `least` to `most`.

    Raises:
        InputError: it is not.
    """
    if isinstance(given, bool) or not isinstance(given, int | float) or not least <= given <= most:
        raise InputError(f"{name}={given!r} must be a number from {least:g} to {most:g}")
    return given
