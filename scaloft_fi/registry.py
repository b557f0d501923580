"""Things by name: declared ones, each name once, where a miss is answered with the nearest name; and groups."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from traceback import walk_stack, walk_tb
from typing import Generic, TypeVar

from scaloft_fi.aside import answers_apart
from scaloft_fi.errors import DeclaredError, InputError, did_you_mean

T = TypeVar("T")
Key = TypeVar("Key")

PLUGIN_GROUP = "scaloft_fi.plugins"


class Registry(Mapping[str, T], Generic[T]):
    """Entries by unique name, in the order they were declared.

    >>> colours = Registry[int]("colour")
    >>> colours.declare("red", 1)
    >>> colours["rad"]
    Traceback (most recent call last):
    scaloft_fi.errors.InputError: no colour 'rad'; did you mean 'red'?

    Args:
        noun: what an entry is.
        listed: the command that lists the entries, where there is one.

    Attributes:
        declared_in: by name the module whose import declares an entry, through whatever function; of a promised entry
            the module that holds it.
    """

    def __init__(self, noun: str, listed: str = "") -> None:
        self.noun, self._listed, self.declared_in = noun, listed, dict[str, str]()
        self._entries: dict[str, T] = {}
        self._promised: dict[str, str] = {}

    def declare(self, name: str, entry: T) -> None:
        """Add `entry` under `name`.

        Raises:
            ValueError: the name is taken.
        """
        self._refuse_taken(name)
        self._entries[name] = entry
        modules = (frame.f_globals["__name__"] for frame, _ in walk_stack(None) if frame.f_code.co_name == "<module>")
        self.declared_in[name] = next(modules, "")

    def promise(self, name: str, place: str) -> None:
        """Add the entry that stands at `place`, `module:attribute`, without importing it before it is asked for.

        Raises:
            ValueError: the name is taken.
        """
        self._refuse_taken(name)
        self._promised[name] = place
        self.declared_in[name] = place.partition(":")[0]

    def __getitem__(self, name: str) -> T:
        if name in self._promised:
            module, _, attribute = self._promised[name].partition(":")
            self._entries[name] = getattr(import_module(module), attribute)
            del self._promised[name]
        try:
            return self._entries[name]
        except KeyError:
            raise InputError(f"no {self.noun} {name!r}{self._remedy(name)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._entries or name in self._promised

    def __iter__(self) -> Iterator[str]:
        return iter((*self._promised, *self._entries))

    def __len__(self) -> int:
        return len(self._entries) + len(self._promised)

    def _remedy(self, name: str) -> str:
        """The near name; else what there is, and that a package which is not installed may declare the name."""
        hint = did_you_mean(name, list(self))
        if hint.endswith("?"):
            return hint
        there = f"; take one that `{self._listed}` lists" if self._listed else hint
        return f"{there}{', or' if there else ';'} install the package that declares it"

    def _refuse_taken(self, name: str) -> None:
        if name in self:
            raise ValueError(f"{self.noun} {name!r} is declared twice")


def grouped(items: Iterable[T], key: Callable[[T], Key]) -> defaultdict[Key, list[T]]:
    """The items by what a function says of each, in the order in which they come; any other key has none.

    >>> dict(grouped(["red", "green", "rose"], lambda colour: colour[0]))
    {'r': ['red', 'rose'], 'g': ['green']}
    """
    groups = defaultdict[Key, list[T]](list)
    for item in items:
        groups[key(item)].append(item)
    return groups


def plugins() -> tuple[EntryPoint, ...]:
    """What installed packages name in the entry-point group `scaloft_fi.plugins`, looked for once."""
    return _plugins_in(tuple(sys.path))


@lru_cache(maxsize=4)
def _plugins_in(_path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=PLUGIN_GROUP))


def load_plugins() -> None:
    """Import every module that an installed package names in the entry-point group `scaloft_fi.plugins`.

    Raises:
        InputError: a plugin cannot be imported, or declares a name that is taken; it names plugin and package.
    """
    for plugin in plugins():
        load_plugin(plugin)


def load_plugin(plugin: EntryPoint) -> None:
    """Import the module of one plugin.

    Raises:
        InputError: as `load_plugins`.
    """
    try:
        with answers_apart():
            plugin.load()
    except (Exception, SystemExit) as error:
        raise InputError(f"{_named(plugin)} cannot be loaded: {in_one_line(error)}; mend or uninstall it") from error


def in_one_line(error: BaseException) -> str:
    r"""Type and message of an error.

    >>> in_one_line(ValueError("odd\nvalue"))
    'ValueError: odd value'
    """
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def plugin_behind(error: BaseException) -> str:
    """The plugin, and its package, in whose modules an error, or what caused it, was raised; "" where in none.

    Of a `DeclaredError` it is the one that declares what is at fault.
    """
    named = {plugin.module: plugin for plugin in reversed(plugins())}
    packages = {module.partition(".")[0]: plugin for module, plugin in named.items()}
    cause: BaseException | None = error
    while cause is not None:
        raised_in = (str(frame.f_globals.get("__name__", "")) for frame, _ in walk_tb(cause.__traceback__))
        for module in (cause.declared_in, *raised_in) if isinstance(cause, DeclaredError) else raised_in:
            plugin = named.get(module) or packages.get(module.partition(".")[0])
            if plugin is not None:
                return _named(plugin)
        cause = cause.__cause__
    return ""


def _named(plugin: EntryPoint) -> str:
    return f"plugin {plugin.name!r} of package {(plugin.dist.name if plugin.dist else plugin.module)!r}"
