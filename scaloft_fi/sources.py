"""Source files of packages: what a module imports, and a hash of their code.

An entry is found by the hash of a file's whole content, so none can grow old.  Where the user's cache folder cannot be
read or written, every process parses.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib.machinery import ModuleSpec
from importlib.metadata import Distribution, distributions
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from scaloft_fi.document import FILE_BYTES, MIB, digest, is_file, read_bytes
from scaloft_fi.errors import InputError
from scaloft_fi.output import write_whole

MOST_BYTES = 4 * MIB
Meaning = tuple[str, tuple[str, ...]]
"""Hash of a file's code, and the names that the file may import."""


class SourceCache:
    """The meanings of sources by content.

    Args:
        reader: the code that finds a meaning; another reader finds other meanings.
    """

    def __init__(self, reader: bytes) -> None:
        self._reader = hashlib.sha256(reader)
        self._kept: dict[str, Meaning] | None = None
        self._new: dict[str, Meaning] = {}

    def get(self, content: bytes) -> Meaning | None:
        """The meaning of a file with this content; None where it is not known."""
        if self._kept is None:
            self._kept = dict(_read(_path()))
        return self._kept.get(self._key(content))

    def put(self, content: bytes, meaning: Meaning) -> None:
        """Keep a meaning until `save`."""
        self._new[self._key(content)] = meaning

    def save(self) -> None:
        """Write what is new, if anything is."""
        if not self._new:
            return
        self._kept, self._new = {**(self._kept or {}), **self._new}, {}
        text = json.dumps(self._kept).encode()
        with suppress(OSError, ValueError, RuntimeError):
            path = _path()
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, text if len(text) <= MOST_BYTES else b"{}")

    def _key(self, content: bytes) -> str:
        digest = self._reader.copy()
        digest.update(content)
        return digest.hexdigest()


def _path() -> Path:
    """The file, of this version of Python, whose syntax trees differ from those of others."""
    folder = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(folder).expanduser() / "scaloft-fi" / f"sources-{sys.implementation.cache_tag}-{sys.hexversion:x}.json"


def _read(path: Path) -> Mapping[str, Meaning]:
    with suppress(InputError, OSError, ValueError, TypeError, AttributeError, RuntimeError):
        kept = json.loads(read_bytes(path, MOST_BYTES))
        return {str(key): (str(meaning), tuple(map(str, imports))) for key, (meaning, imports) in kept.items()}
    return {}


PACKAGE = __name__.partition(".")[0]
NUMERIC = ("numpy", "numba", "llvmlite", "filterpy", "scipy", "pybullet")
"""Packages whose versions can change the last bit of a flight or a reading; a platform's fingerprint has them."""
_NAMED_ELSEWHERE = frozenset((PACKAGE, *NUMERIC, *sys.stdlib_module_names))
_ROOT = Path(__file__).resolve().parents[1]
_CACHE = SourceCache(Path(__file__).read_bytes())


@dataclass(frozen=True)
class SourceFile:
    """A source file, another file of a package, or a package from an index.

    Attributes:
        path: path of it.
        meaning: hash of the code without comments, docstrings and layout; of another file hash of its bytes; of a
            package its version.
        imports: names that the file may import; relative names keep their dots.
    """

    path: Path
    meaning: str
    imports: tuple[str, ...]


def digest_of(sources: Mapping[str, SourceFile]) -> str:
    """A hash of the code of the sources."""
    meanings = {name: source.meaning for name, source in sources.items()}
    return hashlib.sha256(json.dumps(meanings, sort_keys=True).encode()).hexdigest()


def closure(entries: Iterable[str], beside: Collection[str] = ()) -> Mapping[str, SourceFile]:
    """The entries and the modules of this package that they import, at the top of a file or inside a function.

    An entry in another package includes every file of that package, because code may import any module by name and read
    any file.  The packages that it imports are included too: of one from an index the version, of any other the files,
    and what they import.  Excluded are imports for type checkers, the standard library, and packages that the
    fingerprint of the platform names; and the `__init__` of this package, which only names what scripts use.

    Args:
        entries: names of modules, such as `scaloft_fi.sim.flight`.
        beside: names of sources that are left out, with what only they import.

    Returns:
        Sources by name of the module, by path in its package of a file that is none, by package of one from an index.

    Raises:
        InputError: the files of a package cannot be read, or are too large.
        ModuleNotFoundError: there is no such entry.
    """
    waiting: dict[str, Path | SourceFile] = dict(
        pair for entry in entries for pair in _entry(entry) if pair[0] not in beside
    )
    seen, tops = {*waiting, *beside}, {*_NAMED_ELSEWHERE, *(entry.partition(".")[0] for entry in entries)}
    sources: dict[str, SourceFile] = {}
    while waiting:
        name, found = waiting.popitem()
        sources[name] = source = read(found) if isinstance(found, Path) else found
        imports = _imported(name, source.path.name == "__init__.py", source.imports)
        for imported in imports:
            if imported not in seen and (own := _source(imported)) is not None:
                waiting[imported] = own
            seen.add(imported)
        if not source.imports or name.startswith(f"{PACKAGE}."):
            continue
        for top in {imported.partition(".")[0] for imported in imports} - tops:
            tops.add(top)
            waiting |= {member: one for member, one in _members(top) if member not in beside}
    _CACHE.save()
    return sources


def _source(name: str) -> Path | None:
    """The source of a module; None when `name` is no module of this package."""
    if not name.startswith(f"{PACKAGE}."):
        return None
    place = os.path.join(_ROOT, *name.split("."))  # noqa: PTH118 - thousands of names are asked for
    return next((Path(file) for file in (f"{place}.py", f"{place}/__init__.py") if os.path.isfile(file)), None)  # noqa: PTH113


def _entry(name: str) -> Iterator[tuple[str, Path]]:
    top = name.partition(".")[0]
    spec = find_spec(top) if top != PACKAGE else None
    if top == PACKAGE and (path := _source(name)) is not None:
        yield name, path
    elif spec is None:
        raise ModuleNotFoundError(f"no module named {name!r}")
    else:
        yield from _files(top, spec)


def _members(top: str) -> Iterator[tuple[str, Path | SourceFile]]:
    """What counts of a package that is imported, by name; nothing where it is not installed."""
    spec = None
    with suppress(ImportError, ValueError):  # no name of a module; `__main__`
        spec = find_spec(top)
    if spec is None:
        return
    place = Path(next(iter(spec.submodule_search_locations or ()), spec.origin or ""))
    if version := _version(top, place.parent):
        yield top, SourceFile(place, version, ())
    else:
        yield from _files(top, spec)


@lru_cache(maxsize=1024)
def _version(top: str, folder: Path) -> str:
    """Name and version of what an index has installed as `top` in a folder; "" where nothing from an index is."""
    if folder.name not in ("site-packages", "dist-packages"):
        return ""
    lines = [f"\n{top}{end}" for end in "/.\n"]
    owners = [one for one, listed in _installed(folder) if any(line in listed for line in lines)]
    if any(one.read_text("direct_url.json") and "conda" not in (one.read_text("INSTALLER") or "") for one in owners):
        return ""  # from a folder or a commit, whose version need not tell an edit; conda names its own folders
    return ", ".join(sorted(f"{one.name} {one.version}" for one in owners))


@lru_cache(maxsize=4)
def _installed(folder: Path) -> list[tuple[Distribution, str]]:
    """What is installed in a folder, each with the lines that name its files and modules.

    `packages_distributions` takes a second for it.
    """

    def listed(one: Distribution) -> str:
        return "\n".join(("", one.read_text("RECORD") or "", one.read_text("top_level.txt") or "", ""))

    return [(one, listed(one)) for one in distributions(path=[str(folder)])]


def _files(top: str, spec: ModuleSpec) -> Iterator[tuple[str, Path]]:
    """The files of a package by name, without caches, hidden files and campaigns.

    Raises:
        InputError: those that are no source are too large to be hashed by each command.
    """
    if spec.submodule_search_locations is None and spec.origin:
        yield top, Path(spec.origin)
    left = FILE_BYTES
    for place in spec.submodule_search_locations or ():
        for folder, inner, names in os.walk(place):
            no = {"__pycache__", "campaigns"} if Path(folder).name == "results" else {"__pycache__"}
            inner[:] = [name for name in inner if name[0] != "." and name not in no]
            for path in (Path(folder, name) for name in names if name[0] != "."):
                within = (top, *path.relative_to(place).parts)
                if not is_file(path):
                    continue
                if path.suffix == ".py":
                    yield ".".join(within).removesuffix(".py"), path
                else:
                    yield "/".join(within), path
                    left -= path.stat().st_size
        if left < 0:
            raise InputError(
                f"{place}: its files enter the keys of the flights of {top!r}, and are more than "
                f"{FILE_BYTES // MIB} MiB: keep what no flight needs outside the package"
            )


@lru_cache(maxsize=4096)
def _imported(name: str, is_package: bool, imports: tuple[str, ...]) -> tuple[str, ...]:
    """The names that a module imports, and their parent packages, whose `__init__` runs first."""
    package = name if is_package else name.rpartition(".")[0]
    absolute = (_absolute(imported, package).split(".") for imported in (name, *imports))
    return tuple(dict.fromkeys(".".join(parts[:end]) for parts in absolute for end in range(1, len(parts) + 1)))


def _absolute(name: str, package: str) -> str:
    """The absolute name of a relative import in `package`."""
    rest = name.lstrip(".")
    dots = len(name) - len(rest)
    above = package.split(".")[: -dots + 1 or None] if dots else []
    return ".".join((*above, rest))


def read(path: Path) -> SourceFile:
    """Read a source file; equal bytes are parsed once.  Of a file that is no source the bytes count.

    Raises:
        UnreadableError: a file that is no source cannot be read.
    """
    if path.suffix != ".py":
        return SourceFile(path, _digest(path, path.stat().st_mtime_ns), ())
    content = path.read_bytes()
    return SourceFile(path, *_meaning(content, path))


@lru_cache(maxsize=4096)
def _digest(path: Path, _changed_ns: int) -> str:
    return digest(path)


@lru_cache(maxsize=4096)
def _meaning(content: bytes, path: Path) -> Meaning:
    known = _CACHE.get(content)
    if known is None:
        known = _parsed(content, path)
        _CACHE.put(content, known)
    return known


def _parsed(content: bytes, path: Path) -> Meaning:
    try:
        tree = ast.parse(content, path)
    except (SyntaxError, ValueError):  # a template, or Python of another version
        return hashlib.sha256(content).hexdigest(), ()
    imports: list[str] = []
    blocks: list[Any] = [tree]
    while blocks:  # not `ast.walk`, which also visits every expression
        block = blocks.pop()
        if hasattr(block, "body"):  # a string as a statement has no effect
            block.body = [entry for entry in block.body if not _is_text(entry)]
        if isinstance(block, ast.Import):
            imports += [alias.name for alias in block.names]
        elif isinstance(block, ast.ImportFrom):
            module = "." * block.level + (f"{block.module}." if block.module else "")
            imports += [module + alias.name for alias in block.names]
        names = ("orelse",) if _for_types_only(block) else _BLOCKS
        blocks += [inner for name in names for inner in getattr(block, name, ())]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(imports)


_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")
"""Fields of a statement that hold statements."""


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _for_types_only(statement: ast.AST) -> bool:
    test = statement.test if isinstance(statement, ast.If) else None
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"
