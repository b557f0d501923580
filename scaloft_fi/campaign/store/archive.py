"""An archive: a campaign's record in open formats, as a folder or one ZIP file, which is read as a campaign is.

`campaign.json` has what the store keeps beside flights, and the SHA-256 of every other file; `outcomes.parquet` and
`tracks.parquet` the flights; `hazop/`, `mutants/` and `sim/` the study.  Without these folders it is a record of the
study that it is opened with, such as the published campaign of this repository.  Its flights count as they stand.
"""

from __future__ import annotations

import atexit
import hashlib
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import NoReturn

from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.store.archived import Trajectories, read_outcomes
from scaloft_fi.campaign.store.cells import decoded
from scaloft_fi.campaign.store.folder import MANIFEST, RECORD
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.store.key import Keys
from scaloft_fi.campaign.store.origin import Origin
from scaloft_fi.campaign.store.selection import Flown, Stands
from scaloft_fi.campaign.store.store import NOTE, Store
from scaloft_fi.campaign.store.tables import Planned
from scaloft_fi.document import FILE_BYTES, is_file, is_folder, opened, read_bytes
from scaloft_fi.errors import InputError, shown
from scaloft_fi.hazop.load import FOLDERS
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.study import Study

OUTCOMES, TRACKS = "outcomes.parquet", "tracks.parquet"
VERSION = 1
"""Version of the files; an archive of another version is refused."""
MOST_FILES = 10_000
"""Greatest number of files of an archive."""
_SHOWN = 200
"""Characters of another module's message that a message shows."""


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

    def __init__(self, place: Path, study: Study) -> None:
        self.place, self.path, self._folder = place, place / MANIFEST, _folder_of(place)
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
    def _flown(self) -> Mapping[str, tuple[Flown, Outcome]]:
        """The flights by key, ordered by mutant, situation, seed."""
        path, keys, said = self.place / OUTCOMES, _KeysNow(self.study), self.manifest
        listed = read_outcomes(path, self._content(OUTCOMES), tuple(said.requirements.items()), said.axes)
        flown = {(one.mutant, one.situation, one.seed): one for one in listed}
        if len(flown) < len(listed):
            raise InputError(f"{path}: a flight occurs twice")
        return {(key := keys(flown[name])): (Flown(key, *name, None), flown[name]) for name in sorted(flown)}

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

    def flights(self, *, one_each: bool = False) -> list[Flown]:
        """The flights, ordered by mutant, situation, seed."""
        return [flight for flight, _ in self._flown.values()]

    def keyed(self, keys: Iterable[str] | None = None) -> list[tuple[str, Outcome]]:
        """All outcomes, or those with `keys`, each with its key, in the order of `outcomes`."""
        wanted = self._flown if keys is None else self._flown.keys() & set(keys)
        return [(key, self._flown[key][1]) for key in self._flown if key in wanted]

    def standing(self, stands: Stands) -> tuple[Outcome, ...]:
        """The outcomes of the current flights, without their tracks, ordered by mutant, situation, seed."""
        return tuple(outcome for flight, outcome in self._flown.values() if stands(flight))

    def origins(self) -> dict[int, Origin]:
        """None: why a flight would be stale is not asked of a record."""
        return {}

    def planned(self) -> list[Planned]:
        """None: what was planned and not flown is not in a record."""
        return []

    def _facts(self) -> list[tuple[str, str]]:
        notes = {NOTE + name: text for name, text in self.manifest.notes.items()}
        return sorted({**self.manifest.platform, **notes}.items())


class _KeysNow:
    """The keys of outcomes in a study; a flight that the study does not have any more gets its name."""

    def __init__(self, study: Study) -> None:
        self._study, self._keys = study, Keys(study)
        _ = study.grid, study.matrix  # read here, so that an error in them is raised
        self._flights: dict[tuple[str, str], Flight | None] = {}

    def __call__(self, outcome: Outcome) -> str:
        place = outcome.mutant, outcome.situation
        if place not in self._flights:
            try:
                self._flights[place] = flight_named(self._study, *place, 0)
            except InputError:
                self._flights[place] = None
        flight = self._flights[place]
        return outcome.name if flight is None else self._keys.origin(flight).key(outcome.seed)


def study_files(folder: Path) -> list[Path]:
    """The documents of a study: every file of its three folders but hidden ones, in the order of their paths."""
    paths = (path for name in FOLDERS for path in sorted((folder / name).rglob("*")))
    return [path for path in paths if is_file(path) and "/." not in path.relative_to(folder).as_posix()]


def _folder_of(place: Path) -> Path:
    """The folder with the files of an archive; those of a ZIP file lie there until the process ends."""
    if is_folder(place):
        return place
    state = place.stat()
    return _unpacked(place.resolve(), state.st_mtime_ns, state.st_size)


@cache
def _unpacked(path: Path, _changed_ns: int, _size: int) -> Path:
    """A folder with the files of a ZIP file.

    Raises:
        InputError: the file is damaged, too large, or has a file that no archive has.
    """
    folder = Path(tempfile.mkdtemp(prefix="scaloft-fi-archive-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    try:
        _unpack(path, folder)
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError, ValueError) as error:
        own = ascii(str(error))[1:-1][:_SHOWN]
        raise InputError(f"{path}: the file is no archive that `export --format archive` wrote: {own}") from error
    return folder


def _unpack(path: Path, folder: Path) -> None:
    """Write the files of a ZIP file into a folder.

    Raises:
        InputError: the archive is too large.
        ValueError: it has a file that no archive has.
    """
    with opened(path) as file, zipfile.ZipFile(file) as archive:
        entries = [entry for entry in archive.infolist() if not entry.is_dir()]
        # no more is read of a file than the list of files says
        if len(entries) > MOST_FILES or sum(entry.file_size for entry in entries) > FILE_BYTES:
            raise InputError(f"{path}: the archive has more than {MOST_FILES} files or {FILE_BYTES:,} bytes")
        for entry in entries:
            target = _target(folder, entry.filename)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(archive.read(entry))


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
