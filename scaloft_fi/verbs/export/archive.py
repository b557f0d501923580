"""A campaign whole, as one ZIP file that every verb opens years later: what a paper cites.

The same campaign gives the same bytes: no clock is in the file.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from array import array
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from functools import partial
from pathlib import Path

from scaloft_fi.campaign.store.archive import (
    EXTRA,
    MANIFEST,
    NUMBERS,
    OUTCOMES,
    TEXT,
    TRACKS,
    VERSION,
    WHOLES,
    study_files,
)
from scaloft_fi.defaults import SEARCHED
from scaloft_fi.document import is_there, read_bytes, read_text
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, track_values
from scaloft_fi.sim.grid import FOLDER
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.dossier import (
    Dossier,
    column_type,
    columns,
    export_format,
    export_rows,
    ordered,
    parquet_file,
)
from scaloft_fi.verbs.snapshot import Snapshot, snapshot
from scaloft_fi.version import __version__
from scaloft_fi.views.output import Columns, ColumnType, needed_pyarrow

EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of every file: the earliest that ZIP knows."""
_TYPES = {TEXT: ColumnType.TEXT, WHOLES: ColumnType.WHOLES, NUMBERS: ColumnType.NUMBERS}
"""Types of columns by their names in Arrow."""


@export_format("archive", "all flights with their study, in a new folder or a .zip (extra: parquet)", text=False)
def whole(dossier: Dossier) -> bytes:
    """The ZIP file of a campaign."""
    return zipped(dossier.archive())


def zipped(files: Mapping[str, bytes]) -> bytes:
    """A ZIP file; Parquet is compressed already."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as target:
        for name, content in files.items():
            kind = zipfile.ZIP_STORED if name.endswith(".parquet") else zipfile.ZIP_DEFLATED
            target.writestr(zipfile.ZipInfo(name, EPOCH), content, kind)
    return made.getvalue()


def unzipped(content: bytes) -> dict[str, bytes]:
    """The files of `zipped`, by their paths."""
    with zipfile.ZipFile(io.BytesIO(content)) as source:
        return {name: source.read(name) for name in source.namelist()}


def archive_files(
    study: Study, campaign: str, *, documents: bool = True, kept: Callable[[bytes], array[float]] = track_values
) -> dict[str, bytes]:
    """The files of the archive of a campaign, by their paths: `campaign.json` first.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        documents: whether the study is in it.
        kept: the values of `TRACK_COLUMNS` that are kept of a packed track, row by row.

    Raises:
        InputError: there is no campaign, it holds no flight that counts, or pyarrow is not installed.
    """
    with snapshot(study, campaign) as now:
        study = now.study
        files = {OUTCOMES: outcome_file(now.outcomes, study), TRACKS: _tracks(now, kept)}
        platform, notes = now.store.meta(), now.store.notes()
        campaign = Path(now.name).name
    if documents:
        files |= {path.relative_to(study.folder).as_posix(): read_bytes(path) for path in study_files(study.folder)}
    content = {
        "archive": VERSION,
        "study": study.name,
        "campaign": campaign,
        "platform": platform,
        "notes": notes,
        "requirements": {one.name: one.kind.value for one in study.requirements},
        "axes": list(study.space.axes),
        "files": {name: hashlib.sha256(file).hexdigest() for name, file in files.items()},
    }
    return {MANIFEST: (json.dumps(content, indent=1) + "\n").encode(), **files}


def outcome_file(outcomes: Sequence[Outcome], study: Study) -> bytes:
    """A file of flights: the rows of `export`, and what it leaves out.

    Raises:
        InputError: pyarrow is not installed.
    """
    names = [requirement.name for requirement in study.requirements]
    rows = export_rows(outcomes, study.roster, study.space, names)
    types = {name: column_type(name) for name in columns(rows, names)}
    types |= {name: _TYPES[extra.type] for name, extra in EXTRA.items()}
    listed = ordered(outcomes, study.roster, study.space)
    more = ({name: extra.value(one) for name, extra in EXTRA.items()} for one in listed)
    return parquet_file(Columns("Flights", types, (row | extra for row, extra in zip(rows, more, strict=True))).arrow())


def _tracks(now: Snapshot, kept: Callable[[bytes], array[float]]) -> bytes:
    """The trajectories of the flights, of flights with equal digests one."""
    # flights that begin alike stand beside each other, which makes the file small
    alike = sorted(now.outcomes, key=lambda one: (one.situation, one.seed, one.mutant != BASELINE, one.mutant))
    first: dict[str, Outcome] = {}
    for outcome in alike:
        if outcome.digest:
            first.setdefault(outcome.digest, outcome)
    flown = now.with_tracks(first.values(), {outcome.mutant for outcome in first.values()})
    return track_file({one.digest: kept(one.track) for one in flown if one.track})


def track_file(tracks: Mapping[str, array[float]]) -> bytes:
    """A file of trajectories.

    Args:
        tracks: by digest of a flight the values of `TRACK_COLUMNS`, row by row, as single floats.

    Raises:
        InputError: pyarrow is not installed.
    """
    import numpy as np

    pyarrow, width = needed_pyarrow(), len(TRACK_COLUMNS)
    ends = np.cumsum([0, *(len(track) // width for track in tracks.values())])
    samples = np.concatenate([*tracks.values(), np.empty(0, np.float32)]).reshape(-1, width)
    columns = {
        name: pyarrow.ListArray.from_arrays(pyarrow.array(ends, pyarrow.int32()), pyarrow.array(samples[:, number]))
        for number, name in enumerate(TRACK_COLUMNS)
    }
    return parquet_file(pyarrow.table({"digest": pyarrow.array(list(tracks), pyarrow.string()), **columns}))


def dossier(study: Study, campaign: str, today: date | None = None) -> Dossier:
    """The dossier of a campaign.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        today: the day by which dispositions expire; by default the system's date.

    Raises:
        InputError: there is no campaign, or it holds no outcome that counts.
    """
    with snapshot(study, campaign) as now:
        study = now.study
        outcomes, platform, spending = now.outcomes, now.platform, now.spending
    item, cells = study.grid.item, sorted((study.folder / "hazop").rglob("*.yaml"))
    return Dossier(
        study=study.name,
        campaign=Path(now.name).name,
        version=__version__,
        platform=platform,
        matrix=study.matrix,
        space=study.space,
        roster=study.roster,
        requirements=study.requirements,
        outcomes=outcomes,
        spending=spending,
        sources={path.relative_to(study.folder).as_posix(): read_text(path) for path in cells},
        grid_file=item.path.relative_to(study.folder).as_posix() if item else "",
        finds=study.finds,
        deterministic=study.stack.deterministic,
        archive=partial(archive_files, study, campaign),
        searchable=not study.packaged and is_there(study.folder / "sim" / FOLDER / f"{SEARCHED}.yaml"),
        dispositions=study.dispositions,
        today=today or date.today(),  # noqa: DTZ011 - the user's own day
    )
