"""Pack a study into bytes for machines without a shared disk; what is unpacked is checked and bounded."""

from __future__ import annotations

import hashlib
import io
import lzma
import os
import shutil
import tarfile
import tempfile
from pathlib import Path, PurePosixPath

from scaloft_fi.document import is_file, read_bytes
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import FOLDERS

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
