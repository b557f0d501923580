"""Read the YAML documents of users: regular files up to a size, into items that know their places.

No other module of the package opens such a file, because a pipe, a device or an endless file must never hang a verb or
fill the memory.  A record, a mesh or a sheet of some kilobytes may unpack to gigabytes, and no library of its format
can be trusted to look at what it unpacks to: such a file is read in a process of its own, bounded in memory, time and
disk.
"""

from __future__ import annotations

import difflib
import errno
import hashlib
import json
import math
import os
import pickle
import re
import select
import shutil
import signal
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import date
from functools import lru_cache
from importlib import import_module
from io import BufferedReader
from itertools import pairwise
from pathlib import Path
from textwrap import indent
from typing import Any, NoReturn, TypeVar

import yaml

from scaloft_fi.errors import InputError, did_you_mean, shown
from scaloft_fi.marks import LARGEST, MOST

MIB = 1 << 20
DOCUMENT_BYTES = 4 * MIB
"""Largest YAML file; those of the reference study have at most 25 kB."""
CATALOGUE_BYTES = 16 * MIB
"""Largest catalogue: some 60,000 mutants."""
FILE_BYTES = 1024 * MIB
"""Largest file of any other kind in a study."""

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


class UnreadableError(InputError):
    """A file cannot be read.  path: the file; reason: why, without the name of the file."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(path, reason)
        self.path = path
        self.reason = reason

    def __str__(self) -> str:
        """The sentence."""
        return f"{self.path}: cannot be read: {self.reason}"


def read_bytes(path: Path, most_bytes: int = FILE_BYTES) -> bytes:
    """The content of a file.

    Raises:
        UnreadableError: the file is no regular file, is larger than `most_bytes`, or cannot be opened.
    """
    with opened(path, most_bytes) as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:  # it has grown since it was opened, or its file system gives no sizes
        raise UnreadableError(path, _too_large(most_bytes))
    return content


def read_text(path: Path, most_bytes: int = DOCUMENT_BYTES, *, other: str = "") -> str:
    """The content of a text file.

    Args:
        path: the file.
        most_bytes: how large it may be.
        other: encoding of a content that is not UTF-8; "" = there is none.

    Raises:
        UnreadableError: as `read_bytes`, or the content is not UTF-8.
    """
    content = read_bytes(path, most_bytes)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        if other:
            return content.decode(other)
        raise UnreadableError(path, "not UTF-8 text") from error


def digest(path: Path, most_bytes: int = FILE_BYTES) -> str:
    """SHA-256 of a file, read piece by piece.

    Raises:
        UnreadableError: as `read_bytes`.
    """
    with opened(path, most_bytes) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_file(path: Path) -> bool:
    """Whether `path` is a regular file; False also where the system refuses the name (`Path.is_file` would raise)."""
    return os.path.isfile(path)  # noqa: PTH113


def is_folder(path: Path) -> bool:
    """Whether `path` is a folder; False also where the system refuses the name."""
    return os.path.isdir(path)  # noqa: PTH112


def is_there(path: Path) -> bool:
    """Whether `path` names anything, a link that leads nowhere included: such a link is refused, not overlooked."""
    return os.path.lexists(path)


@contextmanager
def opened(path: Path, most_bytes: int = FILE_BYTES) -> Iterator[BufferedReader]:
    """The file, open for reading; the open file itself is checked, so that nobody can exchange it after the check.

    Raises:
        UnreadableError: as `read_bytes`.
    """
    try:
        # Without O_NONBLOCK, opening a pipe waits for a writer.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    try:
        _check(path, os.fstat(number), most_bytes)
    except UnreadableError:
        os.close(number)
        raise
    try:
        with open(number, "rb") as file:  # noqa: PTH123 - it is open
            yield file
    except OSError as error:
        raise _unreadable(path, error) from error


def _check(path: Path, status: os.stat_result, most_bytes: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "of another kind")
        raise UnreadableError(path, f"it is {kind}, and must be a regular file")
    if status.st_size > most_bytes:
        raise UnreadableError(path, _too_large(most_bytes))


def _unreadable(path: Path, error: OSError | ValueError) -> UnreadableError:
    """The refusal of the system; a ValueError is a NUL in the name."""
    return UnreadableError(path, (error.strerror if isinstance(error, OSError) else None) or str(error))


def _too_large(most_bytes: int) -> str:
    return f"it is larger than {most_bytes:,} bytes"


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


ITEMS = 30_000
"""Most values of a document, those that an alias repeats included."""

Scalar = str | int | float | bool | None


@dataclass(frozen=True)
class Item:
    """One YAML value with its place.  `value` is a scalar, a tuple of items, or a mapping of items by key."""

    path: Path
    line: int
    name: str
    value: Scalar | tuple[Item, ...] | dict[str, Item]

    @property
    def place(self) -> str:
        """`file:line`, the beginning of every error message."""
        return f"{self.path}:{self.line}"

    def error(self, allowed: str) -> InputError:
        """The error for a value that is not allowed here."""
        return InputError(f"{self.place}: {self.name}={self._written()} must be {allowed}")

    def _written(self) -> str:
        """The value as a message shows it; a mapping or a list is only named as one."""
        return (
            "{...}" if isinstance(self.value, dict) else "[...]" if isinstance(self.value, tuple) else shown(self.value)
        )

    def mapping(self, *, most: int = ITEMS) -> dict[str, Item]:
        """The entries of a mapping by key, at most `most` of them."""
        if not isinstance(self.value, dict):
            raise self.error("a mapping of keys to values")
        if len(self.value) > most:
            raise self.error(f"a mapping of at most {most:,} keys")
        return self.value

    def items(self, *, most: int = ITEMS) -> tuple[Item, ...]:
        """The entries of a list, at most `most` of them."""
        if not isinstance(self.value, tuple):
            raise self.error("a list")
        if len(self.value) > most:
            raise self.error(f"a list of at most {most:,} values")
        return self.value

    def __iter__(self) -> Iterator[Item]:
        return iter(self.items())

    def text(self) -> str:
        """A non-empty string."""
        if not isinstance(self.value, str) or not self.value.strip():
            raise self.error("a text")
        return " ".join(self.value.split())

    def number(
        self, *, least: float = -LARGEST, most: float = LARGEST, above: float = -math.inf, infinite: bool = False
    ) -> float:
        """A number within `least` <= value <= `most` and value > `above`; `infinite` allows the infinities too."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or math.isnan(self.value):
            raise self.error("a number")
        if math.isinf(self.value):
            if infinite:
                return self.value
            raise self.error("a finite number")
        if not (least <= self.value <= most and self.value > above):
            lowest = (f"> {above:g}", above) if above >= least else (f">= {least:g}", least)
            beyond = abs(self.value) > LARGEST
            told = [text for text, bound in (lowest, (f"<= {most:g}", most)) if beyond or abs(bound) < LARGEST]
            raise self.error(" and ".join(told))
        return float(self.value)

    def whole(self, *, least: int = 0, most: int = int(LARGEST)) -> int:
        """A whole number within `least` <= value <= `most`."""
        if isinstance(self.value, bool) or not isinstance(self.value, int) or not least <= self.value <= most:
            within = f" and <= {most}" if isinstance(self.value, int) and self.value > most else ""
            raise self.error(f"a whole number >= {least}{within}")
        return self.value

    def flag(self) -> bool:
        """Either true or false."""
        if not isinstance(self.value, bool):
            raise self.error("true or false")
        return self.value

    def choice(self, allowed: Sequence[str]) -> str:
        """One of `allowed`."""
        if str(self.value) not in allowed:
            hint = did_you_mean(str(self.value), allowed)
            raise InputError(f"{self.place}: {self.name}={self._written()} is not known{hint}")
        return str(self.value)

    def plain(self, *, infinite: bool = False) -> Any:
        """The bare Python value: dicts, lists and scalars.

        Raises:
            InputError: a number is not finite, unless `infinite` allows it.
        """
        if isinstance(self.value, dict):
            return {key: item.plain(infinite=infinite) for key, item in self.value.items()}
        if isinstance(self.value, tuple):
            return [item.plain(infinite=infinite) for item in self.value]
        if isinstance(self.value, float) and not math.isfinite(self.value) and not infinite:
            raise self.error("a finite number")
        return self.value

    def get(self, key: str) -> Item | None:
        """The entry of a mapping under `key`, or None."""
        return self.mapping().get(key)

    def need(self, key: str, meaning: str = "") -> Item:
        """The entry of a mapping under `key`.

        Args:
            key: the key.
            meaning: what it is to hold, for those who left it out.

        Raises:
            InputError: there is none.
        """
        entry = self.get(key)
        if entry is None:
            entries = self.mapping()
            for near in difflib.get_close_matches(key, sorted(entries)[:MOST], n=1, cutoff=0.75):
                raise InputError(f"{entries[near].place}: unknown key {near!r} in {self.name}; did you mean {key!r}?")
            raise InputError(f"{self.place}: {self.name} lacks the key {key!r}{f': {meaning}' if meaning else ''}")
        return entry


DEPTH = 50
"""Deepest nesting of a document."""
DIGITS = 100
"""Most characters of a number."""
KEY = 200
"""Most characters of a key."""
KEPT = 1 << 16
"""Documents of at most so many characters are parsed once for as long as they are used."""

_TOO_DEEP = f"the file must be nested at most {DEPTH} deep"
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TEXTS = ("tag:yaml.org,2002:str", "tag:yaml.org,2002:timestamp")
"""A date stays a text, which is checked where a date is wanted."""
_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
_NOBODY_MEANS = re.compile(r"[-+]?0[0-9_]|.*:")
"""Numbers to the base of 8 or 60, which look like other numbers, or like times."""


def load(path: Path) -> Item:
    """Read one YAML file.

    Raises:
        InputError: the file cannot be read, is not YAML, repeats a key, has a tag, or exceeds a limit.
    """
    return parsed(read_text(path), path)


def parsed(text: str, path: Path) -> Item:
    """The item of a YAML document; `path` is where it stands, for errors.

    Raises:
        InputError: the text is not YAML, repeats a key, has a tag, or exceeds a limit.
    """
    try:
        return (_parsed_once if len(text) <= KEPT else _parsed)(text, path)
    except _FlawError as flaw:
        raise InputError(f"{path}:{flaw.line}: {flaw}") from flaw


class _FlawError(Exception):
    """What is wrong with a document, at a line."""

    def __init__(self, line: int, sentence: str) -> None:
        super().__init__(sentence)
        self.line = line


def _parsed(text: str, path: Path) -> Item:
    """The item of a document.

    Args:
        text: the document.
        path: where it is from.

    Raises:
        _FlawError: the document is not YAML, or not of the kind that `load` allows.
    """
    loader = _LOADER(text)
    try:
        return _Document(loader, path).item()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        line = mark.line + 1 if mark else 1
        if error.problem and "nesting depth" in error.problem:  # libyaml has a limit too, and reads ahead of its events
            raise _FlawError(line, _TOO_DEEP) from error
        written, column = "".join(text.splitlines()[line - 1 : line]), mark.column if mark else 0
        raise _FlawError(line, f"not valid YAML: {_remedy(written, column, error.problem or '')}") from error
    except yaml.YAMLError as error:
        raise _FlawError(1, f"not valid YAML: {' '.join(str(error).split())}") from error
    finally:
        loader.dispose()


def _remedy(written: str, column: int, problem: str) -> str:
    """What the parser says of a line, at a column; of the mistakes that are made most, what to change."""
    if "\t" in (*written[: len(written) - len(written.lstrip())], written[column : column + 1]):
        return "a tab stands where YAML takes only spaces; write spaces instead"
    if problem.startswith("mapping values are not allowed"):
        return "': ' stands where no key can; put a text with ': ' in quotes, and a key below the keys beside it"
    return problem


_parsed_once = lru_cache(maxsize=128)(_parsed)


class _Document:
    """Builds the items of one document from the events of the parser, so that every limit holds before memory is used.

    Aliases are allowed: an alias stands for a copy of the anchored value, and the copies count against `ITEMS`.
    """

    def __init__(self, loader: Any, path: Path) -> None:
        self._loader, self._path = loader, path
        self._left = ITEMS
        self._anchors: dict[str, Item | None] = {}
        """The value of each anchor; None while the value is being read."""

    def item(self) -> Item:
        """The one value of the document."""
        next_event = self._loader.get_event
        next_event()  # the start of the stream
        if isinstance(next_event(), yaml.StreamEndEvent):
            raise _FlawError(1, "the file is empty")
        item = self._read(next_event(), self._path.name, 0, 0)
        next_event()  # the end of the document
        if not isinstance(event := next_event(), yaml.StreamEndEvent):
            raise self._error(event, "a second document must stand in a file of its own")
        return item

    def _read(self, event: Any, name: str, key_line: int, depth: int) -> Item:
        """The item that begins with `event`; the place of a mapping or list under a key is the place of the key."""
        line = _line(event)
        self._count(event, depth)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._anchors:
                raise self._error(event, f"alias {shown(event.anchor)} has no anchor above it")
            anchored = self._anchors[event.anchor]
            if anchored is None:
                raise self._error(event, f"{name} contains itself")
            return self._copy(event, anchored, name, key_line, depth)
        if event.tag is not None:
            raise self._error(event, f"{name} has the tag {shown(event.tag)}; write the value without a tag")
        if event.anchor is not None:
            self._anchors[event.anchor] = None
        if isinstance(event, yaml.ScalarEvent):
            item = Item(self._path, line, name, self._scalar(event, name))
        else:
            inner = self._entries if isinstance(event, yaml.MappingStartEvent) else self._list
            item = Item(self._path, key_line or line, name, inner(name, depth + 1))
        if event.anchor is not None:
            self._anchors[event.anchor] = item
        return item

    def _entries(self, name: str, depth: int) -> dict[str, Item]:
        entries: dict[str, Item] = {}
        next_event: Any = self._loader.get_event
        while not isinstance(event := next_event(), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent) or event.tag is not None:
                raise self._error(event, f"a key of {name} must be a single word")
            # Keys are the text of the event, because YAML would read a bare NO as false.
            key: str = event.value
            if len(key) > KEY:
                raise self._error(event, f"key {shown(key)} must have at most {KEY} characters")
            if key in entries:
                raise self._error(event, f"key {key!r} occurs twice in {name}")
            entries[key] = self._read(next_event(), key, _line(event), depth)
        return entries

    def _list(self, name: str, depth: int) -> tuple[Item, ...]:
        items: list[Item] = []
        while not isinstance(event := self._loader.get_event(), yaml.SequenceEndEvent):
            items.append(self._read(event, f"{name}[{len(items)}]", 0, depth))
        return tuple(items)

    def _scalar(self, event: Any, name: str) -> Scalar:
        text: str = event.value
        tag = self._loader.resolve(yaml.ScalarNode, text, event.implicit)
        if tag in _TEXTS:
            return text
        if tag in _NUMBERS and len(text) > DIGITS:
            raise self._error(event, f"{name}={shown(text)} must have at most {DIGITS} digits")
        try:
            value = self._loader.construct_object(yaml.ScalarNode(tag, text, event.start_mark, event.end_mark))
        except ValueError as error:  # a value that looks like a number but is none, as 0x_
            raise self._error(event, f"{name}={shown(text)} cannot be read: {error}") from error
        if tag in _NUMBERS and _NOBODY_MEANS.match(text):
            allowed = f"a number in decimal digits: YAML 1.1 takes it for {value}; write {value}, or the text in quotes"
            raise self._error(event, f"{name}={text} must be {allowed}")
        return value if value is None or isinstance(value, int | float) else text

    def _copy(self, event: Any, item: Item, name: str, key_line: int, depth: int) -> Item:
        """A copy of an anchored item under another name."""
        if isinstance(item.value, dict):
            entries = {key: self._again(event, entry, key, depth) for key, entry in item.value.items()}
            return Item(item.path, key_line or item.line, name, entries)
        if isinstance(item.value, tuple):
            items = (self._again(event, entry, f"{name}[{i}]", depth) for i, entry in enumerate(item.value))
            return Item(item.path, key_line or item.line, name, tuple(items))
        return Item(item.path, item.line, name, item.value)

    def _again(self, event: Any, entry: Item, name: str, depth: int) -> Item:
        self._count(event, depth + 1)
        return self._copy(event, entry, name, 0, depth + 1)

    def _count(self, event: Any, depth: int) -> None:
        self._left -= 1
        if self._left < 0:
            raise self._error(event, f"the file must have at most {ITEMS:,} values, those that aliases repeat included")
        if depth > DEPTH:
            raise self._error(event, _TOO_DEEP)

    def _error(self, event: Any, sentence: str) -> _FlawError:
        return _FlawError(_line(event), sentence)


def _line(event: Any) -> int:
    line: int = event.start_mark.line + 1
    return line


Steps = Sequence[str | int]
"""The way to a value of a document: keys, and numbers of list entries."""


def edited(text: str, steps: Steps, value: str | Mapping[str, Any] | None, place: str) -> str:
    """A document with one value changed in place, added to its mapping or its list, or taken out (None).

    Everything else stays as people wrote it, comments and folds included.

    Args:
        text: the document.
        steps: the way to the value; an entry after the last one is added.
        value: a text, or a mapping that replaces another.
        place: names the document in errors.

    Raises:
        InputError: the change cannot be made without touching something else.
    """
    wanted = _parsed(text, Path(place)).plain(infinite=True)
    _set(wanted, steps, value)
    flow = json.dumps(value, ensure_ascii=False)
    block = value if isinstance(value, str) else _block(value or {}, len(steps))
    for form in (block, flow) if value is not None else (None,):
        with suppress(_FlawError, InputError, yaml.YAMLError, LookupError):
            changed = _changed(text, yaml.compose(text, Loader=yaml.SafeLoader), steps, form, 0)
            if _parsed(changed, Path(place)).plain(infinite=True) == wanted:
                return changed
    raise InputError(f"{place}: {'.'.join(map(str, steps))} cannot be changed in place; edit it by hand")


def dumped(value: object) -> str:
    """A value as YAML, a key a line."""
    written: str = yaml.safe_dump(value, sort_keys=False, allow_unicode=True, width=120)
    return written


def _block(value: Mapping[str, Any], depth: int) -> str:
    """A mapping below its key, which stands so deep."""
    return "\n" + indent(dumped(value), "  " * depth).rstrip("\n")


def _set(whole: Any, steps: Steps, value: object) -> None:
    last = steps[-1]
    for step, inner in pairwise(steps):
        lacking: Any = [] if isinstance(inner, int) else {}
        whole = whole.setdefault(step, lacking) if isinstance(whole, dict) else whole[step]
    if value is None:
        del whole[last]
    elif isinstance(whole, list) and last == len(whole):
        whole.append(value)
    else:
        whole[last] = value


def _changed(text: str, node: Any, steps: Steps, form: str | None, column: int) -> str:
    """The text with the value at `steps` below `node` changed; `column`: where the collection around `node` begins."""
    begin = int(node.start_mark.index)
    if not steps:
        before = text[:begin].rstrip() if str(form).startswith("\n") else text[:begin]
        return before + str(form) + text[_end(text, node, column) :]
    step, own = steps[0], int(node.start_mark.column)
    pairs = node.value if isinstance(node, yaml.MappingNode) else [(entry, entry) for entry in node.value]
    names = [key.value for key, _ in pairs] if isinstance(node, yaml.MappingNode) else list(range(len(pairs)))
    if step in names:
        at = names.index(step)
        key, inner = pairs[at]
        if form is not None or len(steps) > 1:
            return _changed(text, inner, steps[1:], form, own)
        end = _end(text, inner, own)
        if len(pairs) == 1:
            return f"{text[:begin].rstrip()} {{}}{text[int(node.end_mark.index) if node.flow_style else end :]}"
        if node.flow_style:
            first, last = (
                (pairs[at - 1][1].end_mark, inner.end_mark) if at else (key.start_mark, pairs[1][0].start_mark)
            )
            return text[: first.index] + text[last.index :]
        return text[: text.rfind("\n", 0, int(key.start_mark.index)) + 1] + text[_line_end(text, end) :]
    added = f"{step}: " * isinstance(step, str) + _nested(steps[1:], str(form))
    if node.flow_style:
        end = _end(text, pairs[-1][1], own) if pairs else begin + 1
        return f"{text[:end]}{', ' * bool(pairs)}{added}{text[end:]}"
    at, mark = _line_end(text, _end(text, pairs[-1][1], own)), "" if isinstance(step, str) else "- "
    return text[:at] + "\n" * (text[at - 1] != "\n") + " " * own + mark + added + "\n" + text[at:]


def _nested(steps: Steps, form: str) -> str:
    """A value below keys, and in lists, that the document lacks."""
    if not steps:
        return form
    inner = _nested(steps[1:], form)
    return f"{{{steps[0]}: {inner}}}" if isinstance(steps[0], str) else f"[{inner}]"


def _line_end(text: str, at: int) -> int:
    """Where the line after that of a place begins."""
    return len(text) if (found := text.find("\n", at)) < 0 else found + 1


def _end(text: str, node: Any, column: int) -> int:
    """Where the text of a value ends, without the comments and blank lines that the parser counts to it."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1][1] if isinstance(node, yaml.MappingNode) else node.value[-1]
        return _end(text, last, node.start_mark.column)
    begin, end = node.start_mark.index, int(node.end_mark.index)
    if isinstance(node, yaml.ScalarNode) and node.style in ("|", ">"):
        lines = text[begin:end].splitlines(keepends=True)
        body = [k for k, line in enumerate(lines) if k and line.strip() and len(line) - len(line.lstrip()) > column]
        return int(begin + len("".join(lines[: (body[-1] if body else 0) + 1]).rstrip("\n")))
    return end


T = TypeVar("T")
_LINUX = sys.platform.startswith("linux")
APART_BYTES, BYTES_A_BYTE = 512 * MIB, 16
"""What reading a file apart may take in memory, or write into a file, and for each of its bytes besides [bytes]."""
APART_S, BYTES_A_S = 15.0, 1 << 20
"""How long it may take [s, wall], and how many bytes more of the file allow a second more."""
PLAIN = frozenset({".bin", ".tlog", ".ulg", ".csv", ".obj", ".stl", ".off"})
"""Ends of the names of files that pack nothing.  Of any other file only bytes that were read allow more time: little of
a bomb is read while it unpacks."""
NO_ROOM = "Failed to resize buffer"
"""What lz4 says, in a plain RuntimeError, where there is no memory."""
LOOK_S = 0.1
"""How often it is looked at how much was read [s, wall]."""


def most_unpacked(size: int) -> int:
    """What a file of this size may unpack to [bytes]."""
    return APART_BYTES + BYTES_A_BYTE * size


def read_apart(path: Path, work: Callable[[], T]) -> T:
    """What `work` makes of a file, in a process of its own whose memory and time are bounded.

    What a file unpacks to is bounded so whatever it declares; the bounds grow with its size on the disk.  What it is
    unpacked to on the disk is removed with the process.  Where a process cannot be forked, `work` runs in this one.

    Raises:
        InputError: as `work`; or it takes too much memory, time or disk, or ends its process.
    """
    if not hasattr(os, "fork"):
        return work()
    files = [path, *path.iterdir()] if is_folder(path) else [path]
    size = sum(file.stat().st_size for file in files if is_file(file))
    most_bytes, most_s = most_unpacked(size), APART_S + size / BYTES_A_S
    folder = tempfile.mkdtemp(prefix="scaloft-")
    end, other_end = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(end)
        _work_apart(other_end, path, work, most_bytes, most_s, folder)
    os.close(other_end)
    content, began_s, late_s = bytearray(), time.monotonic(), 0.0
    try:
        while not late_s:
            if select.select([end], [], [], min(LOOK_S, APART_S))[0]:
                if not (piece := os.read(end, MIB)):
                    break
                content += piece
            elif (past_s := time.monotonic() - began_s) > APART_S:
                read = size if path.suffix.lower() in PLAIN else min(size, _read_by(pid))
                late_s = past_s if past_s > APART_S + read / BYTES_A_S else 0.0
    finally:
        os.close(end)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        shutil.rmtree(folder, ignore_errors=True)
    if late_s:
        raise InputError(f"{path}: reading it takes more than {late_s:.0f} s, which what was read of it may take")
    if not content:
        code = os.waitstatus_to_exitcode(status)
        raise InputError(f"{path}: reading it ended its process ({code}); it may be damaged, or unpack to too much")
    done, told = pickle.loads(content)
    if not done:
        raise InputError(told)
    made: T = told
    return made


def _read_by(pid: int) -> int:
    """The bytes that a process has read, as far as the system tells it."""
    try:
        return int(Path(f"/proc/{pid}/io").read_text().split()[1])
    except (OSError, ValueError):
        return sys.maxsize


def _work_apart(end: int, path: Path, work: Callable[[], Any], most_bytes: int, most_s: float, folder: str) -> NoReturn:
    """Do `work` in a forked process, whose temporary files are in a folder of its own, and send what it makes."""
    silent = os.open(os.devnull, os.O_WRONLY)  # libraries print what they skip, some of them beside Python
    for stream in (1, 2):
        os.dup2(silent, stream)
    limits = import_module("resource")
    used = int(Path("/proc/self/statm").read_text().split()[0]) * limits.getpagesize() if _LINUX else 0
    before, cpu_s = limits.getrlimit(limits.RLIMIT_AS), 2 * math.ceil(most_s)  # for the case that nobody waits for it
    memory = used + most_bytes if _LINUX else limits.RLIM_INFINITY
    too_much = False, f"{path}: it unpacks to more than {most_bytes // MIB:,} MiB, which a file of its size may take"
    try:
        for what, most in ((limits.RLIMIT_FSIZE, most_bytes), (limits.RLIMIT_CPU, cpu_s), (limits.RLIMIT_AS, memory)):
            soft, hard = limits.getrlimit(what)
            limits.setrlimit(
                what, (min((one for one in (most, soft, hard) if one != limits.RLIM_INFINITY), default=soft), hard)
            )
        tempfile.tempdir = folder
        try:
            told = True, work()
        except InputError as error:
            told = too_much if lacks_room(error) else (False, str(error))
        except MemoryError:
            told = too_much
        limits.setrlimit(limits.RLIMIT_AS, before)  # to tell it takes memory too
        with os.fdopen(end, "wb") as file:
            pickle.dump(told, file)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(0)


def lacks_room(error: BaseException | None) -> bool:
    """Whether the cause of an error is a file that became too large, or want of memory."""
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.EFBIG):
            return True
        if NO_ROOM in str(error):
            return True
        error = error.__cause__ or error.__context__
    return False
