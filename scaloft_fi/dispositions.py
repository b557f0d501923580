"""The file of accepted survivors, `hazop/dispositions.yaml`: read it, and draft entries for people to complete."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from datetime import date
from pathlib import Path

from scaloft_fi.analysis.disposition import Disposition
from scaloft_fi.document import load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.item import Item
from scaloft_fi.mutants.derive import realise
from scaloft_fi.output import write_whole
from scaloft_fi.reading import is_there, read_text

HEADER = """\
# Accepted survivors; `scaloft-fi score --ratchet` fails on any other survivor.
# Each entry names the person responsible (owner), the reason, and the last day of its validity (expires);
# optional `situations` limit the entry: a survival in another situation is not accepted.
"""


def load_dispositions(path: Path, matrix: Matrix, situations: Collection[str]) -> tuple[Disposition, ...]:
    """Read the dispositions of a study; a study without the file has none.

    Args:
        path: `hazop/dispositions.yaml`.
        matrix: matrix of the study.
        situations: keys of its grids.

    Raises:
        InputError: a mutant, a situation or a date does not exist, a key is missing, empty or unknown, or a mutant
            occurs twice; the message names the place.
    """
    if not is_there(path):
        return ()
    dispositions: dict[str, Disposition] = {}
    for name, item in load(path).mapping().items():
        disposition = read_disposition(name, item, matrix, situations)
        if disposition.mutant in dispositions:
            first = dispositions[disposition.mutant].place
            raise InputError(f"{item.place}: mutant {name!r} is {disposition.mutant!r}, which is already at {first}")
        dispositions[disposition.mutant] = disposition
    return tuple(dispositions.values())


def read_disposition(name: str, item: Item, matrix: Matrix, situations: Collection[str]) -> Disposition:
    """Read one disposition.

    Args:
        name: the mutant, in any form.
        item: its entry.
        matrix: matrix of the study.
        situations: keys of its grids.

    Raises:
        InputError: a mutant, a situation or a date does not exist, or a key is missing, empty or unknown.
    """
    try:
        mutant = realise(matrix, name)
    except InputError as error:
        raise InputError(f"{item.place}: {error}") from None
    item.need("status").choice(("accepted",))
    only = item.get("situations")
    keys = tuple(_situation(entry, situations) for entry in only.items()) if only else ()
    if only is not None and not keys:
        raise only.error("a list of at least one, or left out")
    disposition = Disposition(
        mutant=mutant.id,
        owner=item.need("owner").text(),
        reason=item.need("reason").text(),
        expires=_date(item.need("expires")),
        situations=keys,
        place=item.place,
    )
    item.close()
    return disposition


def _situation(item: Item, situations: Collection[str]) -> str:
    if item.value not in situations:
        raise InputError(f"{item.place}: no situation {item.value!r}{did_you_mean(str(item.value), situations)}")
    return str(item.value)


def _date(item: Item) -> date:
    day = parse_date(str(item.value))
    if day is None:
        raise item.error("a date such as 2027-01-31")
    return day


def parse_date(text: str) -> date | None:
    """Parse a date in the form YYYY-MM-DD of ISO 8601; None for any other text.

    >>> parse_date("2027-01-31"), parse_date("2027-02-30"), parse_date("20270131")
    (datetime.date(2027, 1, 31), None, None)
    """
    if not re.fullmatch(r"\d{4}-\d{2}-\d{2}", text):
        return None
    try:
        return date.fromisoformat(text)
    except ValueError:
        return None


def append_drafts(path: Path, mutants: Iterable[str]) -> None:
    """Append an entry for each mutant to `hazop/dispositions.yaml`, which is made where it is missing.

    Raises:
        InputError: the file cannot be written.
    """
    before = read_text(path) if is_there(path) else HEADER
    try:
        write_whole(path, (before.rstrip("\n") + "\n" + draft(mutants)).encode())
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


def draft(mutants: Iterable[str]) -> str:
    """Draft the YAML entries of survivors that are not accepted yet.

    The keys that need a decision are empty; the file is refused until a person has filled them in.

    Args:
        mutants: canonical ids.
    """
    return "".join(f'\n{mutant}:\n  status: accepted\n  owner: ""\n  reason: ""\n  expires: ""\n' for mutant in mutants)
