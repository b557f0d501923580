"""An open study: its parts, its campaigns, and single flights, for scripts and notebooks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.flown_grid import study_of
from scaloft_fi.checks.check import check_study
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.scripting.campaign import OpenCampaign
from scaloft_fi.scripting.flight import Figure, FlownFlight, described, in_python
from scaloft_fi.study import Study
from scaloft_fi.verbs.check import checked
from scaloft_fi.verbs.judge import JudgedFiles, RecordedIn, RecordMapping, judge
from scaloft_fi.verbs.map import plan_of
from scaloft_fi.verbs.replay import fly_with_log, ready_to_fly
from scaloft_fi.verbs.signals import signal_list
from scaloft_fi.views.output import Answer, Columns, ColumnType
from scaloft_fi.views.picture import draw_plan
from scaloft_fi.views.table import Table, html

if TYPE_CHECKING:
    from collections.abc import Sequence

TEXT, TEXTS = ColumnType.TEXT, ColumnType.TEXTS
MUTANT_COLUMNS = {
    **dict.fromkeys(("mutant", "guideword", "parameter", "magnitude", "seam", "operator"), TEXT),
    "counted": ColumnType.TRUTH,
}
SIGNAL_FACTS = {"unit": TEXT, "least": ColumnType.NUMBER, "most": ColumnType.NUMBER, "meaning": TEXT}
REQUIREMENT_COLUMNS = dict.fromkeys(("requirement", "kind", "formula", "unit", "title"), TEXT)


def open_study(study: Path | str | None = None, grid: str | None = None) -> OpenStudy:
    """Open a study.

    Args:
        study: folder with `hazop/`, `mutants/` and `sim/`; by default the nearest one upwards from the current folder,
            else the packaged study.
        grid: name of one of its grids; by default its own grid, or that of a campaign.

    Raises:
        InputError: the folder is no study, or has no such grid.

    >>> import scaloft_fi
    >>> study = scaloft_fi.open()
    >>> study.requirements["requirement"].tolist()
    ['SR1', 'SR2', 'SR2-literal', 'OP1']
    """
    with in_python():
        return OpenStudy(Study.open(study, grid).folder, grid)


@dataclass(frozen=True)
class OpenStudy:
    """An open study; each method reads the folder as it is when it is called.

    Attributes:
        folder: folder of the study.
        grid: name of the grid; None for the study's own, or that of a campaign.
    """

    folder: Path
    grid: str | None = None

    @property
    def definition(self) -> Study:
        """The study as plugins know it: every part of it, as `scaloft_fi.api.Study`.

        Raises:
            InputError: the folder is no study any more.
        """
        with in_python():
            return Study.open(self.folder, self.grid)

    @property
    def mutants(self) -> Columns:
        """The catalogue, one row for each mutant; `counted` marks those that the ratios of a score count."""
        with in_python():
            study = self.definition
            defaults = set(study.roster.defaults.values())
            rows = (
                {
                    "mutant": mutant.id,
                    "guideword": mutant.guideword,
                    "parameter": mutant.parameter,
                    "magnitude": mutant.magnitude,
                    "seam": mutant.seam,
                    "operator": mutant.operator,
                    "counted": mutant.id in defaults,
                }
                for mutant in study.catalogue
            )
            return Columns("Mutants", MUTANT_COLUMNS, rows)

    @property
    def situations(self) -> Columns:
        """The situations of the grid, one row each: key, other names, title of each axis's value."""
        with in_python():
            grid = self.definition.grid
            axes = [axis.id for axis in grid.axes]
            rows = (
                {
                    "situation": situation.key,
                    "aliases": list(grid.aliases_of(situation)),
                    **dict(zip(axes, grid.titles(situation), strict=False)),
                }
                for situation in grid.situations
            )
            return Columns("Situations", {"situation": TEXT, "aliases": TEXTS, **dict.fromkeys(axes, TEXT)}, rows)

    @property
    def requirements(self) -> Columns:
        """The requirements, one row each: name, kind, formula, unit of the robustness, title."""
        with in_python():
            rows = (
                {
                    "requirement": one.name,
                    "kind": one.kind.value,
                    "formula": one.text,
                    "unit": one.unit,
                    "title": one.title,
                }
                for one in self.definition.requirements
            )
            return Columns("Requirements", REQUIREMENT_COLUMNS, rows)

    @property
    def signals(self) -> Columns:
        """The signals that requirements and axes may use, one row each: name, unit, range (NaN: no bound), meaning."""
        with in_python():
            listed = signal_list(self.definition).entries
            rows = ({"signal": one.name, **{name: getattr(one, name) for name in SIGNAL_FACTS}} for one in listed)
            return Columns("Signals", {"signal": TEXT, **SIGNAL_FACTS}, rows)

    @property
    def campaigns(self) -> tuple[str, ...]:
        """Names of the campaigns in the folder of results, in alphabetical order."""
        stores = (self.definition.results_folder / "campaigns").glob(f"*/{STORE_NAME}")
        return tuple(sorted(store.parent.name for store in stores))

    def campaign(self, name: str | None = None) -> OpenCampaign:
        """A campaign, which need not exist yet.

        Args:
            name: a folder in the study's `results/campaigns/`, or with a `/` the path of a folder; by default the name
                of the grid, or `default` for a study that was opened without one.

        Raises:
            InputError: the campaign was flown over another grid.
        """
        with in_python():
            chosen = name if name is not None else self.grid or CAMPAIGN
            study_of(self.folder, chosen, self.grid)
            return OpenCampaign(self.folder, chosen, self.grid)

    def fly(self, mutant: str, situation: str, seed: int = 0) -> FlownFlight:
        """Fly one flight, in this process; nothing is stored.

        Args:
            mutant: `baseline`, `PLACEBO`, or name or id of a mutant.
            situation: key or alias of a situation.
            seed: seed of the noise.

        Raises:
            InputError: there is no such mutant or situation, or the study cannot be flown.
        """
        with in_python():
            study = self.definition
            return FlownFlight(fly_with_log(study, ready_to_fly(study, mutant, situation, seed, lambda _text: None)))

    def map(self, situation: str | None = None) -> Figure:
        """Mine, bodies, route and happenings of a situation, without flying it.

        Args:
            situation: key or alias of the situation; by default every axis has its benign value.

        Raises:
            InputError: there is no such situation, or the study cannot be read.
        """
        with in_python():
            study = self.definition
            one = study.grid.situation(situation) if situation else study.grid.situations[0]
            titles = ", ".join(study.grid.titles(one))
            return Figure(f"map of {one.key}", draw_plan(plan_of(study, one), title=one.key, subtitle=titles))

    @described
    def judge(self, files: JudgedFiles, *, record: RecordMapping = None, situation: RecordedIn = None) -> Answer:
        """What the study's requirements say of records of flights, from any drone or simulator.

        Raises:
            InputError: a file cannot be read, or there is no such situation.
        """
        with in_python():
            return judge(self.definition, files, record=record, situation=situation)

    def check(self, *, fly: bool = False) -> Columns:
        """Check the whole study; one row for each finding, errors first, with its place and remedy.

        Args:
            fly: whether to fly one baseline flight too, which shows the seams that the stack polls.
        """
        with in_python():
            return checked(check_study(self.folder, fly=fly))["findings"]

    def _repr_html_(self) -> str:
        study = self.definition
        rows: Sequence[tuple[str, str]] = (
            ("grid", f"{study.grid.name}, {len(study.grid.situations)} situations"),
            ("mutants", f"{len(study.catalogue)}, of which {len(study.roster.defaults)} count in the score"),
            ("requirements", ", ".join(requirement.name for requirement in study.requirements)),
            ("campaigns", ", ".join(self.campaigns) or "none"),
        )
        return html((Table(f"Study {self.folder}", ("what", ""), tuple(rows)),))
