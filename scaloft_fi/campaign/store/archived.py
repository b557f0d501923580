"""The outcomes and trajectories in the Parquet files of an archive: the columns of `export`, and what only it keeps."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from itertools import chain
from operator import attrgetter
from pathlib import Path
from sys import intern
from typing import Any, NamedTuple

from scaloft_fi.campaign.store.cells import MOST_SEED, BadCellError, Check, labels, numbers, texts, wholes
from scaloft_fi.campaign.store.parquet import FLOATS, NUMBER, NUMBERS, TEXT, TEXTS, WHOLE, WHOLES, read_columns
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.name import parse
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading

RHO = "rho_"
"""Beginning of the names of the columns of robustness."""


_LEVEL = 1
"""Level of compression of a track that is unpacked at once."""


class Extra(NamedTuple):
    """A column of an archive that `export` does not have: its type, and its value for a flight."""

    type: str
    value: Callable[[Outcome], Any]


def _places(axis: str, outcome: Outcome) -> list[float]:
    """A coordinate of each violation, in the order of the readings."""
    place = {violation.requirement: getattr(violation, axis) for violation in outcome.violations}
    return [place.get(reading.requirement, 0.0) for reading in outcome.readings if reading.violated]


EXTRA: Mapping[str, Extra] = {
    "invalid": Extra(TEXT, attrgetter("invalid")),
    "ended_by": Extra(TEXT, attrgetter("struck")),
    "stack_error": Extra(TEXT, attrgetter("stack_error")),
    "perceived_digest": Extra(TEXT, attrgetter("perceived_digest")),
    "episodes": Extra(WHOLES, lambda one: [reading.triggered for reading in one.readings if reading.triggered]),
    **{f"violation_{axis}": Extra(NUMBERS, partial(_places, axis)) for axis in "xyz"},
}
"""Why the harness failed; the body of the contact that ended the flight; the exception of the stack; the digest of its
beliefs; for each of `triggered` the number of episodes; for each of `violated` the place [m, world]."""


def _seeds(name: str, column: Sequence[Any]) -> None:
    wholes(name, column, MOST_SEED)


_CHECKS: Mapping[str, tuple[str, Check]] = {
    "mutant": (TEXT, labels),
    "situation": (TEXT, labels),
    "seed": (WHOLE, _seeds),
    "ending": (TEXT, labels),
    "violated": (TEXTS, labels),
    "infected_at_s": (NUMBER, lambda name, column: numbers(name, column, none=True)),
    "duration_s": (NUMBER, numbers),
    "digest": (TEXT, texts),
    "held": (TEXTS, labels),
    "violation_times_s": (NUMBERS, numbers),
    "violation_bodies": (TEXTS, labels),
    "triggered": (TEXTS, labels),
    "realised": (TEXTS, labels),
    "carried": (WHOLE, wholes),
    "altered": (WHOLE, wholes),
    "invalid": (TEXT, texts),
    "ended_by": (TEXT, labels),
    "stack_error": (TEXT, texts),
    "perceived_digest": (TEXT, texts),
    "episodes": (WHOLES, wholes),
    "violation_x": (NUMBERS, numbers),
    "violation_y": (NUMBERS, numbers),
    "violation_z": (NUMBERS, numbers),
}
"""The columns that are read: the type, and the check of the cells, or of the members of lists."""
_ALONG: Mapping[str, str] = {
    **dict.fromkeys(("violation_times_s", "violation_bodies", "violation_x", "violation_y", "violation_z"), "violated"),
    "episodes": "triggered",
}
"""Columns of lists that are as long as another column's."""
TRACK_TYPES: Mapping[str, str] = {"digest": TEXT, **dict.fromkeys(TRACK_COLUMNS, FLOATS)}
"""The columns of the trajectories: the digest of the flights that flew it, and the samples of each signal."""


@lru_cache(maxsize=2)
def read_outcomes(
    path: Path, content: bytes, requirements: tuple[tuple[str, str], ...], axes: tuple[str, ...]
) -> tuple[Outcome, ...]:
    """The outcomes in a file, without trajectories; where a flight did not test a requirement, rho is 0.

    A page of many tables reads an archive many times, so the last ones are kept.

    Args:
        path: path of the file, for messages.
        content: its bytes.
        requirements: name and kind of each requirement by which the flights were judged.
        axes: the axes of their situations.

    Raises:
        InputError: pyarrow is not installed, or the file is damaged or holds what no store holds.
    """
    rhos = dict.fromkeys((RHO + name for name, _ in requirements), NUMBER)
    table = read_columns(path, content, {name: kind for name, (kind, _) in _CHECKS.items()} | rhos)
    columns = {name: table.column(name).to_pylist() for name in table.column_names}
    kinds = {name: Kind(kind) for name, kind in requirements}
    try:
        _check(columns, kinds)
    except BadCellError as error:
        raise InputError(f"{path}: column {error.column} must be {error.allowed}") from error
    read = Rows(kinds, axes)
    return tuple(read(dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True))


def _check(columns: Mapping[str, Sequence[Any]], kinds: Mapping[str, Kind]) -> None:
    """Refuse what no store holds.

    Raises:
        BadCellError: a cell has a value that no outcome has.
    """
    for name, column in columns.items():
        kind, check = _CHECKS.get(name, (NUMBER, lambda name, column: numbers(name, column, none=True)))
        if kind in (TEXTS, WHOLES, NUMBERS):
            if None in column:
                raise BadCellError(name, "a list")
            column = list(chain.from_iterable(column))
        if column:
            check(name, column)
    for name, other in _ALONG.items():
        if list(map(len, columns[name])) != list(map(len, columns[other])):
            raise BadCellError(name, f"as long as {other}")
    if not kinds.keys() >= set(chain.from_iterable(columns["violated"])):
        raise BadCellError("violated", f"names of {', '.join(kinds)}")


class Rows:
    """Makes outcomes of rows.

    Args:
        kinds: kind of each requirement, by its name.
        axes: the axes of the situations.
    """

    def __init__(self, kinds: Mapping[str, Kind], axes: Sequence[str]) -> None:
        self._kinds, self._axes = kinds, axes
        self._subjects: dict[str, Subject] = {}

    def __call__(self, row: Mapping[str, Any]) -> Outcome:
        """The outcome of a row with the columns of `_CHECKS` and, for each requirement, its robustness."""
        invalid, baseline = row["invalid"], row["mutant"] == BASELINE
        at = dict(zip(row["violated"], row["violation_times_s"], strict=True))
        episodes = dict(zip(row["triggered"], row["episodes"], strict=True))
        places = zip(row["violation_x"], row["violation_y"], row["violation_z"], row["violation_bodies"], strict=True)
        readings = [
            Reading(
                name,
                kind,
                row[RHO + name] or 0.0,
                at.get(name),
                episodes.get(name, 0),
                open=name not in at and name not in row["held"],
            )
            for name, kind in self._kinds.items()
        ]
        came_true = ((axis, axis in row["realised"]) for axis in self._axes)
        return Outcome(
            subject=self._subject(row["mutant"]),
            situation=intern(row["situation"]),
            seed=row["seed"],
            ending=intern(row["ending"]),
            invalid=invalid,
            readings=() if invalid else tuple(readings),
            violations=tuple(
                Violation(name, self._kinds[name], t_s, x, y, z, intern(body))
                for (name, t_s), (x, y, z, body) in zip(at.items(), places, strict=True)
            ),
            carried=row["carried"],
            altered=row["altered"],
            infected_at_s=row["infected_at_s"],
            struck=intern(row["ended_by"]),
            duration_s=row["duration_s"],
            digest=row["digest"],
            perceived_digest=row["perceived_digest"],
            stack_error=row["stack_error"],
            realised=tuple(came_true) if baseline and not invalid else (),
        )

    def _subject(self, id_: str) -> Subject:
        if id_ not in self._subjects:
            try:
                name = parse(id_)
                self._subjects[id_] = Subject(id_, name.guideword, name.parameter, name.magnitude)
            except InputError:  # the baseline and PLACEBO
                self._subjects[id_] = Subject(id_)
        return self._subjects[id_]


class Trajectories:
    """The trajectories in a file, by the digest of the flights that flew them; each is packed when it is asked for.

    Args:
        path: path of the file, for messages.
        content: its bytes.

    Raises:
        InputError: pyarrow is not installed, or the file is damaged or has columns of unequal length.
    """

    def __init__(self, path: Path, content: bytes) -> None:
        import numpy as np

        table = read_columns(path, content, TRACK_TYPES).combine_chunks()
        self._rows = {digest: row for row, digest in enumerate(table.column("digest").to_pylist())}
        lists = [table.column(name).combine_chunks() for name in TRACK_COLUMNS]
        if any(one.null_count or one.values.null_count or not one.offsets.equals(lists[0].offsets) for one in lists):
            raise InputError(f"{path}: the columns of a trajectory must be numbers and of equal length")
        self._ends = lists[0].offsets.to_pylist()
        # Arrow's own way to an array imports pandas, which takes a second
        self._values = [np.frombuffer(one.values.buffers()[1] or b"", np.float32)[one.values.offset :] for one in lists]

    def of(self, digest: str) -> bytes:
        """The packed track of the flights with a digest; empty without one."""
        import numpy as np

        row = self._rows.get(digest)
        if row is None or not digest:
            return b""
        start, end = self._ends[row], self._ends[row + 1]
        samples = np.column_stack([values[start:end] for values in self._values]).astype(np.float32)
        return zlib.compress(samples.tobytes(), _LEVEL)
