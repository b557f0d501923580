"""Records of PX4: ULog, read by `pyulog`.  A topic is the name of a message, "name/1" its second instance."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.document import opened
from scaloft_fi.errors import InputError
from scaloft_fi.outside.records.kind import RecordKind
from scaloft_fi.outside.records.messages import topics_of
from scaloft_fi.outside.records.source import MOST_MESSAGES, Series, Source, Timing, damaged, lacks, number, too_many

TIME = "timestamp"
"""Field with the time of a message [us]."""


def read_ulog(path: Path, sources: Sequence[Source], timing: Timing) -> Mapping[Source, Series]:
    """Read the fields of messages; their times are their own, so `timing` has no clock.

    Raises:
        InputError: as `Read`.
    """
    sets = _sets(path, list({source.topic.partition("/")[0] for source in sources}))
    topics_of(path, sources, timing, sets)
    if sum(len(one[TIME]) for one in sets.values()) > MOST_MESSAGES:
        raise too_many(path)
    return {source: _series(path, source, sets[source.topic]) for source in sources}


def names_in_ulog(path: Path) -> Sequence[str]:
    """The fields of each topic.

    Raises:
        InputError: the record cannot be read.
    """
    return [f"{topic}: {field}" for topic, data in _sets(path, None).items() for field in data if field != TIME]


def _series(path: Path, source: Source, data: Mapping[str, Any]) -> Series:
    if source.field not in data:
        raise lacks(path, source, f"field of {source.topic!r}", source.field, data)
    times_s, values = np.asarray(data[TIME]) * 1e-6, np.asarray(data[source.field], dtype=np.float64)
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        number(path, source, f"{source.topic} at {times_s[wrong[0]]:.6f} s", values[wrong[0]])
    order = np.argsort(times_s, kind="stable")
    return Series(times_s[order], values[order])


def _sets(path: Path, names: list[str] | None) -> dict[str, Mapping[str, Any]]:
    """The fields of each topic by name; `names` = which messages to read, None = all.

    Raises:
        InputError: the record cannot be read, or the library is missing.
    """
    try:
        from pyulog import ULog
    except ImportError as error:
        raise InputError(f"{path}: an .ulg file needs pyulog: pip install 'scaloft-fi[records]'") from error
    with opened(path) as file, contextlib.redirect_stdout(io.StringIO()):  # it prints what it skips
        try:
            log = ULog(file, names)
        except Exception as error:
            raise damaged(path, error) from error
    if log.file_corruption:
        raise InputError(f"{path}: the record is damaged")
    found = {f"{one.name}/{one.multi_id}" if one.multi_id else one.name: one.data for one in log.data_list}
    return {topic: data for topic, data in found.items() if TIME in data}


ULOG = RecordKind(read_ulog, names_in_ulog)
