"""The folder of a campaign, and an archive: a campaign's record in open formats, which is read as a campaign is.

`campaign.json` has what the store keeps beside flights, and the SHA-256 of every other file; `outcomes.parquet` and
`tracks.parquet` the flights; `hazop/`, `mutants/` and `sim/` the study.  Without these folders it is a record of the
study that it is opened with, such as the published campaign of this repository.  Its flights count as they stand.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial
from importlib import import_module
from itertools import chain
from operator import attrgetter, itemgetter
from pathlib import Path
from sys import intern
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import numpy as np

from scaloft_fi import document
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store import platforms, record
from scaloft_fi.campaign.store.held import Keys, flight_named
from scaloft_fi.campaign.store.record import BadCellError, Cell, Origin, Planned, TooLargeError, decoded, most_flights
from scaloft_fi.campaign.store.store import CHUNK, NOTE, FlownFlight, Stands, Store, read_store
from scaloft_fi.document import FILE_BYTES, is_file, is_folder, most_unpacked, read_apart, read_bytes
from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.hazop.load import FOLDERS
from scaloft_fi.hazop.matrix import parse
from scaloft_fi.judge.outcome import BASELINE, TRACK_COLUMNS, Outcome, Subject, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.judge.status import Brief, brief
from scaloft_fi.output import writing
from scaloft_fi.sim.grid import grid_names
from scaloft_fi.study import Study

if TYPE_CHECKING:
    import pyarrow


MOST_ROW_BYTES = 131_072
"""Greatest mean size of a row in memory; the trajectory of a flight of 15 minutes has 126,000 bytes."""
TEXT, WHOLE, NUMBER = "string", "int64", "double"
TEXTS, WHOLES, NUMBERS, FLOATS = "list<string>", "list<int64>", "list<double>", "list<float>"
"""Types of columns, as Arrow names them."""
_SHOWN = 200
"""Characters of Arrow's own message that a message shows."""


def read_columns(path: Path, content: bytes, types: Mapping[str, str]) -> pyarrow.Table:
    """Columns of a file, read in a process of its own: a value that stands once may be meant a million times.

    Args:
        path: path of the file, for messages.
        content: its bytes.
        types: the type of each column that is needed; others are not read.

    Raises:
        InputError: pyarrow is not installed, or the file is damaged, lacks a column or is too large.
    """
    try:
        import pyarrow.parquet  # noqa: F401 - the process of its own has it then
    except ImportError as error:
        raise InputError(f"{path}: reading it needs pyarrow: pip install 'scaloft-fi[parquet]'") from error
    table: pyarrow.Table = read_apart(path, lambda: _columns(path, content, types))
    return table


def _columns(path: Path, content: bytes, types: Mapping[str, str]) -> pyarrow.Table:
    import pyarrow.parquet

    most = most_flights()
    pyarrow.set_memory_pool(pyarrow.system_memory_pool())  # the other pools take room in advance, which no limit sees
    try:
        file = pyarrow.parquet.ParquetFile(pyarrow.BufferReader(content))
        there = {field.name: _named(field.type) for field in file.schema_arrow}
        for name, kind in types.items():
            if there.get(name) != kind:
                raise ValueError(f"column {name!r} must be {kind}, and is {there.get(name, 'missing')}")
        groups = (file.metadata.row_group(number) for number in range(file.metadata.num_row_groups))
        if file.metadata.num_rows > most or sum(group.total_byte_size for group in groups) > most * MOST_ROW_BYTES:
            raise TooLargeError(path.name)
        parts, size = [], 0
        for part in file.iter_batches(CHUNK, columns=list(types), use_threads=False):
            parts.append(part)
            size += part.nbytes
            if size > most * MOST_ROW_BYTES:  # a value that is repeated is larger than its file says
                raise TooLargeError(path.name)
        return pyarrow.Table.from_batches(parts, pyarrow.schema(file.schema_arrow.field(name) for name in types))
    except TooLargeError as error:
        raise InputError(f"{path}: {error}") from error
    except MemoryError:  # Arrow's own is an ArrowException too
        raise
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        own = ascii(str(error).partition("\n")[0])[1:-1][:_SHOWN]
        raise InputError(f"{path}: the file holds no flights of an archive: {own}") from error


def _named(kind: Any) -> str:
    """The name of a type; a list is named by its members."""
    member = getattr(kind, "value_type", None)
    return str(kind) if member is None else f"list<{member}>"


STORE_NAME = "outcomes.sqlite"
LONGEST_NAME = 255
"""Longest name of a file on the usual file systems [bytes]."""
LOG_NAME = "mission_log.json"
MANIFEST, ZIP = "campaign.json", ".zip"
"""The file that makes a folder an archive; the end of the name of an archive in one file."""
RECORD = "an archive is a record, into which nothing is flown or merged; name another --campaign"


def campaign_folder(study: Study, name: str) -> Path:
    """The folder of campaign `name`: in the study's results, or the path `name` itself if it has a separator.

    An archive may be one file, whose name ends in `.zip`; such a name is a path.

    Raises:
        InputError: the name is no valid name of a folder.
    """
    if "/" in name or os.sep in name or name.endswith(ZIP):
        try:
            folder = Path(name).expanduser()
            with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
                folder.stat()  # raises where the system refuses the name
        except (OSError, RuntimeError, ValueError) as error:
            reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
            raise InputError(f"--campaign: name={shown(name)} must be the path of a folder: {reason}") from error
        return folder
    if not name.strip() or name in {".", ".."} or "\0" in name or len(os.fsencode(name)) > LONGEST_NAME:
        raise InputError(f"--campaign: name={shown(name)} must be the name of a folder, such as 'default'")
    return study.results_folder / "campaigns" / name


def is_archive(folder: Path) -> bool:
    """Whether a campaign's folder is an archive: a ZIP file, or a folder with the record of one and no store."""
    if folder.suffix == ZIP:
        return is_file(folder)
    return is_file(folder / MANIFEST) and not is_file(folder / STORE_NAME)


def flown_in(campaign: str) -> str:
    """The campaign that gets further flights: of an archive, which gets none, one of its name."""
    folder = Path(campaign)
    return folder.stem if folder.suffix == ZIP or (folder.name != campaign and is_archive(folder)) else campaign


def promising(folder: Path) -> None:
    """Check early, without writing, whether `writable` can succeed.

    Raises:
        InputError: the nearest existing parent cannot be written, or is no folder; or the folder is an archive.
    """
    if is_archive(folder):
        raise InputError(f"{folder}: {RECORD}")
    above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        reason = "permission denied" if above.is_dir() else f"{above} is no folder"
        raise InputError(f"{folder}: the results folder cannot be written: {reason}")


def writable(folder: Path) -> Path:
    """Create `folder` if it is missing, and check that files can be written there.

    Raises:
        InputError: files cannot be written there, or the folder is an archive.
    """
    if is_archive(folder):
        raise InputError(f"{folder}: {RECORD}")
    probe = folder / f".writable-{os.getpid()}"
    with writing(f"{folder}: the results folder cannot be written"):
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    return folder


def existing(folder: Path) -> Path:
    """The store of the campaign in `folder`.

    Raises:
        InputError: the folder has no store.
    """
    if is_archive(folder):
        raise InputError(f"{folder}: an archive is a record, which lends no flights; name a campaign")
    store = folder / STORE_NAME
    if not store.is_file():
        others = [entry.parent.name for entry in folder.parent.glob(f"*/{STORE_NAME}")]
        hint = did_you_mean(folder.name, others) or "; `scaloft-fi run` flies one"
        raise InputError(f"{folder}: no campaign was flown here{hint}")
    return store


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


_CHECKS: Mapping[str, tuple[str, Cell]] = {
    **dict.fromkeys(("mutant", "situation", "ending", "ended_by"), (TEXT, record.LABEL)),
    **dict.fromkeys(("digest", "invalid", "stack_error", "perceived_digest"), (TEXT, record.TEXT)),
    **dict.fromkeys(("violated", "held", "triggered", "realised", "violation_bodies"), (TEXTS, record.LABEL)),
    **dict.fromkeys(("violation_times_s", "violation_x", "violation_y", "violation_z"), (NUMBERS, record.NUMBER)),
    "seed": (WHOLE, record.SEED),
    **dict.fromkeys(("carried", "altered"), (WHOLE, record.WHOLE)),
    "episodes": (WHOLES, record.WHOLE),
    "infected_at_s": (NUMBER, record.OPTIONAL),
    "duration_s": (NUMBER, record.NUMBER),
}
"""The columns that are read: the type, and what the cells, or the members of lists, may hold."""
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
    subjects = {id_: subject_of(id_) for id_ in set(columns["mutant"])}
    rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    return tuple(outcome_of(row, subjects[row["mutant"]], kinds, axes) for row in rows)


def _check(columns: Mapping[str, Sequence[Any]], kinds: Mapping[str, Kind]) -> None:
    """Refuse what no store holds.

    Raises:
        BadCellError: a cell has a value that no outcome has.
    """
    for name, column in columns.items():
        kind, cell = _CHECKS.get(name, (NUMBER, record.OPTIONAL))
        if kind in (TEXTS, WHOLES, NUMBERS):
            if None in column:
                raise BadCellError(name, "a list")
            column = list(chain.from_iterable(column))
        if not cell.holds(column):
            raise BadCellError(name, cell.allowed)
    for name, other in _ALONG.items():
        if list(map(len, columns[name])) != list(map(len, columns[other])):
            raise BadCellError(name, f"as long as {other}")
    if not kinds.keys() >= set(chain.from_iterable(columns["violated"])):
        raise BadCellError("violated", f"names of {', '.join(kinds)}")


def subject_of(id_: str) -> Subject:
    """The subject of an id."""
    try:
        name = parse(id_)
    except InputError:  # the baseline and PLACEBO
        return Subject(id_)
    return Subject(id_, name.guideword, name.parameter, name.magnitude)


def outcome_of(row: Mapping[str, Any], subject: Subject, kinds: Mapping[str, Kind], axes: Sequence[str]) -> Outcome:
    """The outcome of a row with the columns of `_CHECKS` and, for each requirement, its robustness."""
    at = dict(zip(row["violated"], row["violation_times_s"], strict=True))
    episodes = dict(zip(row["triggered"], row["episodes"], strict=True))
    places = zip(row["violation_x"], row["violation_y"], row["violation_z"], row["violation_bodies"], strict=True)
    readings = (
        Reading(
            name,
            kind,
            row[RHO + name] or 0.0,
            at.get(name),
            episodes.get(name, 0),
            open=name not in at and name not in row["held"],
        )
        for name, kind in kinds.items()
    )
    came_true = ((axis, axis in row["realised"]) for axis in axes)
    return Outcome(
        subject=subject,
        situation=intern(row["situation"]),
        ending=intern(row["ending"]),
        readings=() if row["invalid"] else tuple(readings),
        violations=tuple(
            Violation(name, kinds[name], t_s, x, y, z, intern(body))
            for (name, t_s), (x, y, z, body) in zip(at.items(), places, strict=True)
        ),
        struck=intern(row["ended_by"]),
        realised=tuple(came_true) if subject.id == BASELINE and not row["invalid"] else (),
        **{name: row[name] for name in _AS_THEY_ARE},
    )


_AS_THEY_ARE = (
    *("seed", "invalid", "carried", "altered", "infected_at_s", "duration_s"),
    *("digest", "perceived_digest", "stack_error"),
)
"""The columns that are fields of an outcome."""


class Trajectories:
    """The trajectories in a file, by the digest of the flights that flew them; each is packed when it is asked for.

    Args:
        path: path of the file, for messages.
        content: its bytes.

    Raises:
        InputError: pyarrow is not installed, or the file is damaged or has columns of unequal length.
    """

    def __init__(self, path: Path, content: bytes) -> None:
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
        row = self._rows.get(digest)
        if row is None or not digest:
            return b""
        start, end = self._ends[row], self._ends[row + 1]
        samples = np.column_stack([values[start:end] for values in self._values]).astype(np.float32)
        return zlib.compress(samples.tobytes(), _LEVEL)


OUTCOMES, TRACKS = "outcomes.parquet", "tracks.parquet"
VERSION = 1
"""Version of the files; an archive of another version is refused."""
MOST_FILES = 10_000
"""Greatest number of files of an archive."""


@dataclass(frozen=True)
class Manifest:
    """What `campaign.json` says.

    Attributes:
        study, campaign: names at the time of archiving.
        platform: fingerprint of the platform that flew first.
        notes: notes of the campaign's store.
        requirements: kind of each requirement by which the flights were judged, by its name.
        axes: the axes of their situations.
        files: SHA-256 of every other file, by its path in the archive.
    """

    study: str
    campaign: str
    platform: Mapping[str, str]
    notes: Mapping[str, str]
    requirements: Mapping[str, str]
    axes: tuple[str, ...]
    files: Mapping[str, str]

    @classmethod
    def read(cls, text: bytes, path: Path) -> Manifest:
        """Read the text of the file at `path`.

        Raises:
            InputError: the text says something else.
        """
        try:
            content = decoded(text.decode())
            version = content.pop("archive")
            if version != VERSION:
                raise InputError(f"{path}: archive={shown(version)} must be {VERSION}: another version wrote it")
            made = cls(**{**content, "axes": tuple(content["axes"])})
            named = (made.platform, made.notes, made.requirements, made.files)
            "".join((made.study, made.campaign, *made.axes, *(text for each in named for text in each.values())))
            _ = [Kind(kind) for kind in made.requirements.values()]
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(f"{path}: the file must be as `export --format archive` writes it") from error
        return made


class Archive(Store):
    """An open archive, read as a store; every flight has the key that it has in the study now, so all of them count.

    Args:
        place: the archive, as the user names it.
        study: what was flown, where the archive has no documents.

    Attributes:
        place: the archive, as the user names it.
        study: what was flown: the archive's documents, else the study that it is opened with.
        manifest: what the archive says of itself.

    Raises:
        InputError: the archive cannot be read, or a file was changed after it was made.
    """

    is_record = True

    def __init__(self, place: Path, study: Study) -> None:
        self.place, self.path, self._folder = place, place / MANIFEST, place
        if not is_folder(place):  # a ZIP file, whose files lie in a folder until the process ends
            state = place.stat()
            self._folder = _unpacked(place.resolve(), state.st_mtime_ns, state.st_size)
        self._text = self._bytes(MANIFEST)
        self.manifest = Manifest.read(self._text, self.path)
        documents = [name for name in self.manifest.files if name.partition("/")[0] in FOLDERS]
        if documents:
            self._check(documents)
            study = Study.open(self._folder)
        self.study = replace(study, archived_name=self.manifest.study)

    def _check(self, documents: Collection[str]) -> None:
        """Refuse an archive whose documents are not those that were archived."""
        there = {path.relative_to(self._folder).as_posix() for path in study_files(self._folder)}
        for name in sorted(there.symmetric_difference(documents)):
            raise self._changed(name)
        for name in documents:
            self._content(name)

    def _bytes(self, name: str) -> bytes:
        if not is_file(self._folder / name):
            raise InputError(f"{self.place}: the archive has no {name}")
        return read_bytes(self._folder / name)

    def _changed(self, name: str) -> InputError:
        return InputError(f"{self.place}: {name} is not what was archived; an archive is a record, and is not edited")

    def _content(self, name: str) -> bytes:
        """The bytes of a file, which are those that were archived.

        Raises:
            InputError: the file cannot be read, or has other bytes.
        """
        content = self._bytes(name)
        if hashlib.sha256(content).hexdigest() != self.manifest.files.get(name):
            raise self._changed(name)
        return content

    @cached_property
    def digest(self) -> str:
        """SHA-256 of `campaign.json`, and so of all that it lists: what a paper cites."""
        return hashlib.sha256(self._text).hexdigest()

    @cached_property
    def _flown(self) -> Mapping[str, tuple[FlownFlight, Outcome]]:
        """The flights by key, ordered by mutant, situation, seed."""
        path, said, study = self.place / OUTCOMES, self.manifest, self.study
        listed = read_outcomes(path, self._content(OUTCOMES), tuple(said.requirements.items()), said.axes)
        flown = {(one.subject.id, one.situation, one.seed): one for one in listed}
        if len(flown) < len(listed):
            raise InputError(f"{path}: a flight occurs twice")
        _ = study.grid, study.matrix  # read here, so that an error in them is raised
        keys, origins = Keys(study), dict[tuple[str, str], Origin | None]()
        for place in {name[:2]: None for name in flown}:
            try:
                flight = flight_named(study, *place, 0)
            except InputError:  # the study has no such flight any more
                origins[place] = None
            else:
                origins[place] = keys.origin(flight)
        found = {}
        for name, outcome in sorted(flown.items(), key=itemgetter(0)):
            origin = origins[name[:2]]
            key = outcome.name if origin is None else origin.key(outcome.seed)
            found[key] = FlownFlight(key, *name, None), outcome
        return found

    @cached_property
    def _trajectories(self) -> Trajectories | None:
        if TRACKS not in self.manifest.files:
            return None
        return Trajectories(self.place / TRACKS, self._content(TRACKS))

    def close(self) -> None:
        """Nothing is open."""

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """An archive does not change."""
        yield

    @contextmanager
    def transaction(self) -> Iterator[NoReturn]:
        """Refuse to write."""
        raise InputError(f"{self.place}: {RECORD}")
        yield

    def rows(self, keys: Iterable[str] | None = None) -> Iterator[tuple[str, Outcome]]:
        """Yield every outcome, or those with `keys`, with key and track, ordered by key."""
        for key in sorted(self._flown if keys is None else self._flown.keys() & set(keys)):
            outcome = self._flown[key][1]
            track = self._trajectories.of(outcome.digest) if self._trajectories and not outcome.invalid else b""
            yield key, replace(outcome, track=track)

    def known(self, keys: Iterable[str]) -> set[str]:
        """The `keys` with a valid outcome."""
        return {flight.key for flight, outcome in self._flown.values() if not outcome.invalid}.intersection(keys)

    def flights(self, *, one_each: bool = False) -> list[FlownFlight]:
        """The flights, ordered by mutant, situation, seed."""
        return [flight for flight, _ in self._flown.values()]

    def broken(self) -> dict[FlownFlight, str]:
        """The flights with an invalid outcome, each with the reason."""
        return {flight: outcome.invalid for flight, outcome in self._flown.values() if outcome.invalid}

    def keyed(self, keys: Iterable[str] | None = None) -> list[tuple[str, Outcome]]:
        """All outcomes, or those with `keys`, each with its key, in the order of `outcomes`."""
        wanted = self._flown if keys is None else self._flown.keys() & set(keys)
        return [(key, self._flown[key][1]) for key in self._flown if key in wanted]

    def standing(self, stands: Stands, subjects: Collection[str] | None = None) -> tuple[Outcome, ...]:
        """The outcomes of the current flights, without their tracks, ordered by mutant, situation, seed."""
        flown = (pair for pair in self._flown.values() if subjects is None or pair[0].mutant in subjects)
        return tuple(outcome for flight, outcome in flown if stands(flight))

    def standing_mutants(self, stands: Stands) -> Iterator[Brief]:
        """The current flights of mutants and PLACEBO."""
        return map(brief, (outcome for outcome in self.standing(stands) if outcome.mutant != BASELINE))

    def origins(self) -> dict[int, Origin]:
        """None: why a flight would be stale is not asked of a record."""
        return {}

    def planned(self, *, unflown: bool = False) -> list[Planned]:
        """None: what was planned and not flown is not in a record."""
        return []

    def _facts(self) -> list[tuple[str, str]]:
        notes = {NOTE + name: text for name, text in self.manifest.notes.items()}
        return sorted({**self.manifest.platform, **notes}.items())


def study_files(folder: Path) -> list[Path]:
    """The documents of a study: every file of its three folders but hidden ones, in the order of their paths."""
    paths = (path for name in FOLDERS for path in sorted((folder / name).rglob("*")))
    return [path for path in paths if is_file(path) and "/." not in path.relative_to(folder).as_posix()]


@cache
def _unpacked(path: Path, _changed_ns: int, _size: int) -> Path:
    """A folder with the files of a ZIP file.

    Raises:
        InputError: the file is damaged, too large, or has a file that no archive has.
    """
    folder = Path(tempfile.mkdtemp(prefix="scaloft-fi-archive-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    try:
        with document.opened(path) as file, zipfile.ZipFile(file) as archive:
            entries = [entry for entry in archive.infolist() if not entry.is_dir()]
            # no more is read of a file than the list of files says
            most = min(FILE_BYTES, most_unpacked(_size))
            if len(entries) > MOST_FILES or sum(entry.file_size for entry in entries) > most:
                raise InputError(f"{path}: the archive has more than {MOST_FILES} files or {most:,} bytes")
            for entry in entries:
                target = _target(folder, entry.filename)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(archive.read(entry))
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError, ValueError) as error:
        own = ascii(str(error))[1:-1][:_SHOWN]
        raise InputError(f"{path}: the file is no archive that `export --format archive` wrote: {own}") from error
    return folder


def _target(folder: Path, name: str) -> Path:
    """The place of a file of an archive.

    Raises:
        ValueError: no archive has a file of this name.
    """
    parts = name.split("/")
    plain = all(part not in ("", ".", "..") and not set(part) & set("\\:\0") for part in parts)
    known = name in (MANIFEST, OUTCOMES, TRACKS) if len(parts) == 1 else parts[0] in FOLDERS
    if not (plain and known):
        raise ValueError(f"it has a file {shown(name)}")
    return folder.joinpath(*parts)


GRID_NOTE, SUITE_NOTE = "grid", "suite"
"""Prefixes of the names of the records."""


def study_of(folder: Path | str | None, campaign: str, grid: str | None = None) -> Study:
    """Open the study in `folder` with the grid of a campaign.

    Args:
        folder: the study, as for `Study.open`.
        campaign: name of the campaign, which need not exist.
        grid: the grid that the user names; None for that of the campaign.

    Raises:
        InputError: there is no such study or grid, or the campaign was flown over another grid.
    """
    archived = is_archive(campaign_folder(Study.open(folder), campaign))
    study = Study.open(folder, None if archived else grid)  # an archive may have its own grids
    flown = _flown(study, campaign)
    if flown is not None and grid is not None and grid != flown.grid.name:
        other = f"campaign {shown(campaign)} was flown over grid {flown.grid.name!r}"
        raise InputError(f"--grid={grid}: {other}; name another --campaign")
    return flown or study


def study_of_all(folder: Path | str | None, campaigns: Sequence[str]) -> Study:
    """Open the study in `folder` with the grid of all of these campaigns; those without flights have any grid.

    Raises:
        InputError: there is no such study, or two campaigns were flown over different grids.
    """
    study = Study.open(folder)
    flown = {name: there for name in campaigns if (there := _flown(study, name)) is not None}
    for name, there in flown.items():
        first, over = next(iter(flown.items()))
        if there.grid_name != over.grid_name:
            grids = f"{shown(name)} was flown over grid {there.grid.name!r}, and {shown(first)} over {over.grid.name!r}"
            raise InputError(f"campaign {grids}; only campaigns of one grid have the same situations")
    return next(iter(flown.values()), study)


def opened(study: Study, folder: Path) -> tuple[Study, Store]:
    """Open the campaign in a folder, or an archive, to read; the caller closes it.

    Args:
        study: the study, with any of its grids.
        folder: the folder of the campaign, or an archive.

    Returns:
        what was flown, with the grid of the campaign: of an archive with documents these; and the open store.

    Raises:
        InputError: there is no campaign, it cannot be read, or the study lacks its grid.
    """
    if is_archive(folder):
        archive = Archive(folder, study)
        archive.study = with_grid(archive.study, archive)
        return archive.study, archive
    store = Store(existing(folder), create=False)
    try:
        return with_grid(study, store), store
    except BaseException:
        store.close()
        raise


def with_grid(study: Study, store: Store) -> Study:
    """The study with the grid of a campaign.

    Raises:
        InputError: the study has no such grid.
    """
    suites = store.records(SUITE_NOTE, dict)
    if suites:  # by name: who reads flights waits for no simulator
        tested: Study = import_module("scaloft_fi.campaign.flights.suite").SuiteStudy.of(study, suites[0])
        return tested
    wanted = flown_grid(store)
    if wanted is not None:
        names = grid_names(study.folder / "sim")
        if wanted not in names:
            lost = f"{store.path.parent}: the campaign was flown over grid {shown(wanted)}, which the study lacks"
            raise InputError(f"{lost}{did_you_mean(wanted, names)}")
        wanted = None if wanted == names[0] else wanted
    return study if wanted == study.grid_name else replace(study, grid_name=wanted)


def remember_grid(store: Store, study: Study) -> None:
    """Record the grid, or the suite, of a campaign; a campaign over the study's own grid needs no record."""
    if noted := study.noted():
        store.remember(SUITE_NOTE, noted, "tested")
        return
    if study.grid_name is not None and flown_grid(store) != study.grid_name:
        store.remember(GRID_NOTE, study.grid_name, "flown")


def _flown(study: Study, campaign: str) -> Study | None:
    """The study with the grid of a campaign; None for a campaign without planned flights."""
    folder = campaign_folder(study, campaign)
    if is_archive(folder):
        return opened(study, folder)[0]
    with read_store(folder / STORE_NAME) as store:
        if store is None or not (flown_grid(store) or store.records(SUITE_NOTE, bool) or store.planned()):
            return None
        return with_grid(study, store)


def flown_grid(store: Store) -> str | None:
    """The name of the campaign's grid in its store; None for the study's own.

    Raises:
        InputError: the record is no name.
    """
    return next(iter(store.records(GRID_NOTE, _name)), None)


def _name(content: object) -> str:
    if not isinstance(content, str):
        raise TypeError("a name is a text")
    return content


def borrowed(study: Study, campaign: str, situations: Iterable[str]) -> tuple[Outcome, ...]:
    """The baselines of `situations` in a campaign, which stays unchanged.

    Raises:
        InputError: there is no such campaign, it was flown on another platform, some of its baselines were flown with
            other data or code, or a situation has no baseline.
    """
    folder = campaign_folder(study, campaign)
    place, keys = f"--baseline-from={campaign!r}", Keys(study)
    with Store(existing(folder), create=False) as store:
        theirs = with_grid(study, store).grid
        if theirs.name != study.grid.name:
            raise InputError(f"{place} was flown over grid {theirs.name!r}, not over grid {study.grid.name!r}")
        wanted = dict.fromkeys(situations)
        flown = {f.key: f for f in store.flights() if f.mutant == BASELINE and f.situation in wanted}
        flights = [Flight(None, study.grid.situation(f.situation), f.seed) for f in flown.values()]
        now = {keys.key(flight): flight for flight in flights}
        lent = tuple(outcome for outcome in store.outcomes(now) if not outcome.invalid)
        changed = platforms.Platforms(store).unproved(platforms.fingerprint(), lent, only_bits=True)
    if changed:
        raise InputError(f"{place} was flown on another platform, its digests may differ: {'; '.join(changed)}")
    stale = [flight for key, flight in now.items() if key not in flown]
    if stale:
        raise InputError(f"{place}: {stale[0].name} was flown with other data or code; fly it again there")
    missing = [situation for situation in wanted if situation not in {outcome.situation for outcome in lent}]
    if missing:
        raise InputError(f"{place} has no baseline of {missing[0]}; fly it there with `run --baseline-seeds`")
    return lent
