"""A study: the folder of everything a user edits, opened part by part, with the checks only the whole can make."""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scaloft_fi.document import load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.folder import find_study
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.registry import load_plugins, plugin_sources
from scaloft_fi.stack.seam import SEAMS

if TYPE_CHECKING:
    from scaloft_fi.analysis.disposition import Disposition
    from scaloft_fi.analysis.roster import Roster
    from scaloft_fi.judge.requirement import Requirement
    from scaloft_fi.judge.space import Realisation, Space
    from scaloft_fi.mutants.mutant import Mutant
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.load import SimConfig
    from scaloft_fi.sim.scenario import Scenario
    from scaloft_fi.sim.situation import Situation

PACKAGE = Path(__file__).resolve().parent
FLYING_CODE = (
    *("stack", "sim", "mutants", "campaign/flights/fly.py", "campaign/flights/fork.py", "campaign/flights/share.py"),
    *("judge/outcome.py", "judge/requirement.py", "judge/space.py", "judge/stl.py", "judge/monitor.py"),
    *("judge/track.py", "streams.py"),
)
"""The sources that can change an outcome."""
FLYING_DATA = ("world", "vehicle", "sensors", "stack")
"""The documents of `sim/` that enter every flight; of `situations.yaml` only the situation's own values do."""


_APART = (".yaml", ".md")
"""Files of `sim/` that do not enter a flight as they are: documents enter as they are parsed, words for readers not."""


@dataclass(frozen=True)
class Study:
    """A study; each part is read when it is first asked for.

    Attributes:
        folder: holds `hazop/`, `mutants/` and `sim/`.
    """

    folder: Path

    @classmethod
    def open(cls, folder: Path | str | None = None) -> Study:
        """The study in `folder`, else the nearest one upwards, else the packaged one.

        Raises:
            InputError: it is none.
        """
        load_plugins()
        return cls(find_study(folder))

    @property
    def packaged(self) -> bool:
        """Whether it is the one that came with the installed package, where no results can be written."""
        return self.folder.resolve() == PACKAGE / "_study"

    @property
    def results_folder(self) -> Path:
        """Where campaigns are."""
        return (Path.cwd() if self.packaged else self.folder) / "results"

    @cached_property
    def matrix(self) -> Matrix:
        """The deviation matrix."""
        return load_matrix(self.folder / "hazop", SEAMS)

    @cached_property
    def catalogue(self) -> tuple[Mutant, ...]:
        """Every mutant, proved to be what the matrix gives."""
        from scaloft_fi.mutants.catalogue import check

        return check(self.folder / "mutants", self.matrix)

    @cached_property
    def sim(self) -> SimConfig:
        """Mine, vehicle, sensors, stack and situations."""
        from scaloft_fi.sim.load import load as load_sim

        return load_sim(self.folder / "sim", grid=self.grid)

    @cached_property
    def grid(self) -> Grid:
        """The situations; whoever reads results needs no more of `sim`, which brings the compiler.

        Raises:
            InputError: a predicate of an axis asks for more of a signal than is measured.
        """
        from scaloft_fi.judge.caps import check_caps
        from scaloft_fi.judge.stl import FormulaError
        from scaloft_fi.sim.grid import load_grid

        grid = load_grid(self.folder / "sim")
        for axis in grid.axes:
            for value in axis.values:
                try:
                    check_caps(value.realised)
                except FormulaError as error:
                    raise InputError(
                        f"{self._place(axis.id, value.id)}: realised of {axis.id}{value.id} {error}"
                    ) from error
        return grid

    def _place(self, axis: str, value: int) -> str:
        """File and line of the predicate of a value of an axis."""
        axes = load(self.folder / "sim" / "situations.yaml").need("axes")
        return axes.need(axis).need("values").items()[value].need("realised").place

    @cached_property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that requirements and situations may speak of."""
        from scaloft_fi.sim.signals import signal_names

        return signal_names(self.grid.world(()).surfaces)

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """What flights are judged by, as it is written; that every formula is one is for `check` to say."""
        from scaloft_fi.judge.caps import within_caps
        from scaloft_fi.judge.requirement import load_requirements
        from scaloft_fi.judge.stl import Formula

        return load_requirements(self._requirements_path, self.signals, within_caps(Formula.spelt))

    @property
    def _requirements_path(self) -> Path:
        return self.folder / "sim" / "requirements.yaml"

    @cached_property
    def roster(self) -> Roster:
        """The mutants as scores count them."""
        from scaloft_fi.analysis.roster import Roster
        from scaloft_fi.hazop.cell import CellStatus
        from scaloft_fi.mutants.derive import default_of

        credible = [cell for cell in self.matrix if cell.status is CellStatus.CREDIBLE]
        controls = frozenset(cell.name for cell in self.matrix if cell.status is CellStatus.CONTROL)
        defaults = {cell.name: default_of(cell).id for cell in credible}
        return Roster(defaults, controls, tuple(mutant.id for mutant in self.catalogue))

    @cached_property
    def alpha(self) -> float:
        """Accepted chance that a fault which does nothing is called detected: `hazop/score.yaml`, else 0.01.

        Raises:
            InputError: naming the place of a number that is not above 0 and at most 0.1.
        """
        from scaloft_fi.analysis.scoring.detection import ALPHA, MOST_ALPHA

        path = self.folder / "hazop" / "score.yaml"
        if not path.exists():
            return ALPHA
        document = load(path)
        alpha = document.need("alpha").number(above=0.0, most=MOST_ALPHA)
        document.close()
        return alpha

    @property
    def dispositions_path(self) -> Path:
        """Where the accepted survivors are; the file need not exist."""
        return self.folder / "hazop" / "dispositions.yaml"

    @cached_property
    def dispositions(self) -> tuple[Disposition, ...]:
        """The accepted survivors."""
        from scaloft_fi.analysis.disposition import load_dispositions

        return load_dispositions(self.dispositions_path, self.matrix, self.space.point)

    @cached_property
    def space(self) -> Space:
        """The situations as scores and coverage see them."""
        from scaloft_fi.judge.space import Space

        axes = self.grid.axes
        return Space(
            axes=tuple(axis.id for axis in axes),
            values=tuple(tuple(str(value.id) for value in axis.values) for axis in axes),
            words=tuple(tuple(value.title for value in axis.values) for axis in axes),
            points=tuple((s.key, tuple(str(level) for _, level in s.levels)) for s in self.grid.situations),
        )

    @cached_property
    def realisation(self) -> Realisation:
        """Judges whether a flight met its situation.

        Raises:
            InputError: a predicate of an axis is no formula over the log.
        """
        from scaloft_fi.judge.space import Realisation
        from scaloft_fi.judge.stl import Formula, FormulaError

        def parsed(text: str, value: str) -> Formula | None:
            try:
                return Formula.parse(text, self.signals) if text else None
            except FormulaError as error:
                path = self.folder / "sim" / "situations.yaml"
                raise InputError(f"{path}: realised of {value} {error}") from error

        predicates = [[parsed(v.realised, f"{axis.id}{v.id}") for v in axis.values] for axis in self.grid.axes]
        return Realisation(self.space, tuple(map(tuple, predicates)))

    def scenario(self, situation: Situation) -> Scenario:
        """What stands before a flight in the situation."""
        return self.sim.scenario(situation)

    def expected_s(self, situation: Situation) -> float:
        """How long a flight in the situation is expected to last: its nominal mission time [s]."""
        return self.scenario(situation).nominal_s

    def changes(self, situation: Situation) -> dict[str, Any]:
        """What the situation changes in the world's document, by dotted path."""
        values = [axis.value(situation[axis.id]) for axis in self.grid.axes]
        return {path: item.plain() for value in values for path, item in value.changes.items()}

    def realised(self, situation: Situation) -> dict[str, Any]:
        """By which formulas the situation's values come true: per axis its value's, else those of the others."""
        values = [(axis, axis.value(situation[axis.id])) for axis in self.grid.axes]
        return {axis.id: value.realised or [other.realised for other in axis.values] for axis, value in values}

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """Content hashes of what decides an outcome, by part; comments and the order of keys are no content."""
        sim = self.folder / "sim"
        documents = {name: load(sim / f"{name}.yaml").plain() for name in FLYING_DATA}
        others = {path.relative_to(sim).as_posix(): _bytes(path) for path in _files(sim) if path.suffix not in _APART}
        judged = [(r.name, r.kind, r.text, r.trigger, r.definitions) for r in self.requirements]
        return {
            "sim": _digest([documents, others]),
            "requirements": _digest(judged),
            "code": _with_plugins(_code(FLYING_CODE)),
        }

    def check(self, situations: Iterable[Situation] | None = None) -> None:
        """Read every part and hold it against the others.

        Args:
            situations: those whose worlds are made as well; all when None.

        Raises:
            InputError: naming the place of the first thing that does not fit.
        """
        from scaloft_fi.judge.caps import within_caps
        from scaloft_fi.judge.requirement import load_requirements
        from scaloft_fi.judge.stl import Formula

        proved = load_requirements(self._requirements_path, self.signals, within_caps(Formula.parse))
        known = [requirement.name for requirement in proved]
        for cell in self.matrix:
            for name in cell.requirements:
                if name not in known:
                    hint = did_you_mean(name, known)
                    raise InputError(f"{cell.requirements_place}: {name!r} of {cell.name} is no requirement{hint}")
        # each of these reads a part, and refuses what is wrong with it
        _ = (
            self.catalogue,
            self.realisation,
            [self.scenario(situation) for situation in situations or self.grid.situations],
        )


def _files(folder: Path) -> Iterator[Path]:
    return (path for path in sorted(folder.rglob("*")) if path.is_file() and not path.name.startswith("."))


def _code(names: Iterable[str]) -> str:
    """A hash of what sources of the package say to the interpreter: no comment, docstring or layout is in it."""
    paths = [path for name in names for path in _sources(PACKAGE / name)]
    return _digest({path.relative_to(PACKAGE).as_posix(): _meaning(path) for path in paths})


def _with_plugins(code: str) -> str:
    """The hash `code`, with the sources of third parties in it where there are any."""
    plugins = plugin_sources()
    return _digest([code, {name: _meaning(path) for name, path in plugins.items()}]) if plugins else code


def _sources(path: Path) -> list[Path]:
    return sorted(path.rglob("*.py")) if path.is_dir() else [path]


def _meaning(path: Path) -> str:
    """The syntax tree of a source without its docstrings, hashed."""
    tree = ast.parse(path.read_bytes(), path)
    blocks: list[Any] = [tree]
    while blocks:  # not `ast.walk`, which looks into every expression too
        block = blocks.pop()
        if hasattr(block, "body"):  # a string that stands alone does nothing, wherever it stands
            block.body = [entry for entry in block.body if not _is_text(entry)]
        blocks += [inner for name in _BLOCKS for inner in getattr(block, name, ())]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")
"""Where statements have statements in them."""


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _bytes(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error


def _digest(content: Any) -> str:
    """A hash of plain JSON values."""
    text = json.dumps(content, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()
