"""Pack a study into bytes for machines without a shared disk."""

from __future__ import annotations

import hashlib
import io
import lzma
import os
import shutil
import tarfile
import tempfile
from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.folder import FOLDERS


def packed(study: Path) -> bytes:
    """Pack the three folders of a study without hidden files; equal content gives equal bytes.

    Raises:
        InputError: a file cannot be read.
    """
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        for path in sorted(path for name in FOLDERS for path in (study / name).rglob("*")):
            name = path.relative_to(study)
            if path.is_file() and not any(part.startswith((".", "__")) for part in name.parts):
                entry = tarfile.TarInfo(name.as_posix())
                data = _bytes(path)
                entry.size = len(data)
                archive.addfile(entry, io.BytesIO(data))
    return lzma.compress(content.getvalue())


def digest_of(bundle: bytes) -> str:
    """The name of a bundle: its hash."""
    return hashlib.sha256(bundle).hexdigest()


def unpacked(bundle: bytes, folder: Path) -> Path:
    """Unpack the study of `bundle` into `folder` once; other processes may do the same at the same time."""
    if not folder.is_dir():
        begun = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=folder.parent))
        with tarfile.open(fileobj=io.BytesIO(lzma.decompress(bundle))) as archive:
            archive.extractall(begun, filter="data")
        try:
            os.rename(begun, folder)  # noqa: PTH104 - it must fail if another process was faster
        except OSError:
            shutil.rmtree(begun, ignore_errors=True)
    return folder


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
