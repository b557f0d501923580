"""What `margin` answers: by a search that flies, or of the flights that a campaign holds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scaloft_fi.analysis.margin import whens
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.runs.margin import find, target
from scaloft_fi.campaign.runs.request import choose_situations
from scaloft_fi.campaign.store.archive import campaign_folder
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import realise, source_of
from scaloft_fi.study import Study
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.snapshot import snapshot
from scaloft_fi.views.worksheet.margin_record import MARGIN, margin_values, when_values
from scaloft_fi.views.worksheet.margins import margin_tables
from scaloft_fi.views.worksheet.when import when_tables


def margin(
    study: Study,
    campaign: str,
    mutants: Sequence[str],
    options: RunOptions,
    *,
    situations: Sequence[str] = (),
    seeds: Sequence[int] = (0,),
    tolerance: float | None = None,
    operability: bool = False,
    progress: Callable[[], Progress],
) -> Answer:
    """The smallest magnitude of each fault that is killed, situation by situation; flies what the campaign lacks.

    Args:
        study: the study, with the grid of the campaign.
        campaign: name of the campaign, which need not exist.
        mutants: names of cells, or ids, whose faults are searched.
        options: options of the run.
        situations: keys, aliases or patterns; by default the whole grid, or what the grid chooses.
        seeds: seeds of the flights.
        tolerance: the width of the interval at which the search ends, in the unit of the magnitude; by default a tenth
            of the strong end's distance from no fault.
        operability: whether violations of operability requirements kill, instead of those of safety requirements.
        progress: makes the progress display of a round.

    Raises:
        GateError: a gate failed.
        InputError: there is no such mutant or situation, a fault has no order, or the study cannot be flown.
        Interrupted: the user stopped the search; all outcomes are saved.
    """
    study.check()
    targets = {one.subject: one for one in (target(study.matrix, text, tolerance) for text in mutants)}
    chosen = study.grid.select(situations)
    if not situations:
        chosen = choose_situations(study.grid.choose, chosen, seeds, 0, study.space, study.grid.chosen_at).situations
    by_fault = find(
        study,
        tuple(targets.values()),
        chosen,
        seeds,
        campaign_folder(study, campaign),
        options,
        kind=_kind(operability),
        progress=progress,
    )
    return Answer(
        MARGIN,
        lambda: margin_values(by_fault),
        lambda: margin_tables(by_fault, study.requirements, len(seeds), campaign, study.space.grid),
    )


def when(study: Study, campaign: str, mutants: Sequence[str], *, operability: bool = False) -> Answer:
    """At which times and events of the flight faults are killed, of the flights that a campaign holds.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        mutants: names of cells, or ids.
        operability: as of `margin`.

    Raises:
        InputError: a mutant has no phases, or the campaign fewer than two of them.
    """
    asked = {text: realise(study.matrix, text) for text in mutants}
    for text, mutant in asked.items():
        if not source_of(study.matrix, mutant)[0].phases:
            raise InputError(f"mutant {text!r} has no phases: {mutant.cell} strikes all the time, or at one time")
    with snapshot(study, campaign) as now:
        flown, campaign = whens(now.outcomes, now.score, _kind(operability)), now.name
    found = []
    for text, mutant in asked.items():
        bare = mutant.id.partition("#")[0]
        own = [one for one in flown if one.fault == bare or (text == mutant.cell and cell_of(one.fault) == text)]
        if not own:
            command = f"scaloft-fi run --mutant '{bare}' --mutant '{bare}#*' --campaign {campaign}"
            raise InputError(f"campaign {campaign!r} has fewer than two phases of {bare}; fly them: {command}")
        found += own
    return Answer(MARGIN, lambda: when_values(found), lambda: when_tables(found))


def _kind(operability: bool) -> Kind:
    return Kind.OPERABILITY if operability else Kind.SAFETY
