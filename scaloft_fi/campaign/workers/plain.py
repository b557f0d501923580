"""Flyers, batches, outcomes and studies as plain values and bytes for other machines; what arrives is checked."""

from __future__ import annotations

import base64
import hashlib
import io
import lzma
import os
import shutil
import tarfile
import tempfile
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path, PurePosixPath
from typing import Any

from scaloft_fi.campaign.flight import Batch
from scaloft_fi.campaign.flights.fly import Flyer
from scaloft_fi.campaign.store.held import flight_named
from scaloft_fi.campaign.store.record import checked, to_row
from scaloft_fi.document import is_file, read_bytes
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import FOLDERS
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study

MOST_FILES = 10_000
"""Greatest number of files in a bundle."""
MOST_BYTES = 512 * 1024**2
"""Greatest size of an unpacked bundle."""
_MOST_MEMORY = 256 * 1024**2
"""Greatest memory of the decompressor."""


def packed(study: Path) -> bytes:
    """Pack the three folders of a study without hidden files; equal content gives equal bytes.

    Raises:
        InputError: a file cannot be read.
    """
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        for path in sorted(path for name in FOLDERS for path in (study / name).rglob("*")):
            name = path.relative_to(study)
            if is_file(path) and not any(part.startswith((".", "__")) for part in name.parts):
                entry = tarfile.TarInfo(name.as_posix())
                data = read_bytes(path, MOST_BYTES - content.tell())
                entry.size = len(data)
                archive.addfile(entry, io.BytesIO(data))
    return lzma.compress(content.getvalue())


def digest_of(bundle: bytes) -> str:
    """The name of a bundle: its hash."""
    return hashlib.sha256(bundle).hexdigest()


def unpacked(bundle: bytes, folder: Path) -> Path:
    """Unpack the study of `bundle` into `folder` once; other processes may do the same at the same time.

    Raises:
        InputError: the bundle is damaged, larger than the limits, or has anything but files in the folders of a study.
    """
    if not folder.is_dir():
        files = _files(bundle)
        begun = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=folder.parent))
        try:
            for name, data in files.items():
                path = begun / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
        except OSError as error:
            shutil.rmtree(begun, ignore_errors=True)
            raise InputError(f"{folder}: the study cannot be unpacked: {error.strerror}") from error
        try:
            os.rename(begun, folder)  # noqa: PTH104 - it must fail if another process was faster
        except OSError:
            shutil.rmtree(begun, ignore_errors=True)
    return folder


def _files(bundle: bytes) -> dict[str, bytes]:
    """The contents of the files of a bundle by name."""
    try:
        unpacking = lzma.LZMADecompressor(memlimit=_MOST_MEMORY)
        content = unpacking.decompress(bundle, MOST_BYTES)
        if not unpacking.eof:
            raise _refused(f"it is damaged, or larger than {MOST_BYTES} bytes")
        found: dict[str, bytes] = {}
        with tarfile.open(fileobj=io.BytesIO(content), mode="r:") as archive:
            for entry in archive:
                parts = PurePosixPath(entry.name).parts
                if not entry.isreg() or not parts or parts[0] not in FOLDERS or ".." in parts or entry.issparse():
                    raise _refused(f"{entry.name[:80]!r} is no file in {', '.join(FOLDERS)}")
                if len(found) == MOST_FILES:
                    raise _refused(f"it has more than {MOST_FILES} files")
                file = archive.extractfile(entry)
                found[entry.name] = file.read() if file else b""
    except (lzma.LZMAError, tarfile.TarError, ValueError, EOFError, OSError) as error:
        raise _refused(f"it is damaged ({error})") from error
    return found


def _refused(reason: str) -> InputError:
    return InputError(f"the bundle of the study is refused: {reason}")


Plain = Mapping[str, Any]


def flyer_to_plain(flyer: Flyer) -> Plain:
    """The name and the settings of a flyer."""
    names: list[str] = [field.name for field in fields(flyer)] if is_dataclass(flyer) else []
    settings = {name: getattr(flyer, name) for name in names}
    return {"name": f"{type(flyer).__module__}:{type(flyer).__qualname__}", "settings": settings}


def flyer_from_plain(plain: Plain) -> Flyer:
    """The flyer of a name and settings.

    Raises:
        ValueError: the name is not that of a flyer.
    """
    module, _, name = plain["name"].partition(":")
    kind = getattr(import_module(module), name, None)
    if not isinstance(kind, type) or not all(hasattr(kind, part) for part in ("prepare", "share")):
        raise ValueError(f"{plain['name']!r} is no flyer")
    flyer: Flyer = kind(**plain["settings"])
    return flyer


def batch_to_plain(batch: Batch) -> Plain:
    """The flights of a batch, each as mutant, situation and seed."""
    flights = [[flight.subject.id, flight.situation.key, flight.seed] for flight in batch.flights]
    return {"flights": flights, "shared": batch.shared}


def batch_from_plain(study: Study, plain: Plain) -> Batch:
    """The batch of the named flights of a study.

    Raises:
        InputError: a mutant or a situation is unknown.
    """
    return Batch(tuple(flight_named(study, *flight) for flight in plain["flights"]), shared=plain["shared"])


def outcome_to_plain(outcome: Outcome) -> Plain:
    """The columns of the store, and the track."""
    return {"row": list(to_row(outcome)), "track": base64.b64encode(outcome.track).decode()}


def outcome_from_plain(batch: Batch, plain: object) -> Outcome:
    """The outcome of a flight of `batch`.

    Raises:
        ValueError: a value is of another type or out of its range, or the flight is not in the batch.
    """
    if not isinstance(plain, dict) or plain.keys() != {"row", "track"} or not isinstance(plain["track"], str):
        raise ValueError("an outcome has a row and a track")
    outcome = checked(plain["row"], base64.b64decode(plain["track"], validate=True))
    flown = (outcome.subject, outcome.situation, outcome.seed)
    if flown not in [(flight.subject, flight.situation.key, flight.seed) for flight in batch.flights]:
        raise ValueError("the flight was not asked for")
    return outcome
