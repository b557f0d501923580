"""Merge campaigns that were flown in parts or on several machines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.plan.plan import held_requirements
from scaloft_fi.campaign.runs.run import write_log
from scaloft_fi.campaign.store.fingerprint import differences, fingerprint
from scaloft_fi.campaign.store.folder import STORE_NAME, existing, writable
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.campaign.store.tables import Planned
from scaloft_fi.errors import GateError
from scaloft_fi.judge.flights import baselines_of
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Merged:
    """The result of a merge.

    Attributes:
        added: number of flights that the campaign lacked.
        known: number of flights that it had already, with the same digests.
        warnings: warnings for the user.
    """

    added: int
    known: int
    warnings: tuple[str, ...]


def merge(study: Study, folder: Path, sources: Sequence[Path]) -> Merged:
    """Merge the campaigns in `sources` into the campaign in `folder`, which need not exist.

    Each part may have flown a control as its canary; the merge keeps the canary of an undivided run.

    Raises:
        GateError: a flight has two different outcomes on one platform; nothing is written.
        InputError: a folder holds no campaign, or cannot be written.
    """
    stores = [existing(source) for source in sources]  # every source is checked before anything is created
    with Store(writable(folder) / STORE_NAME) as target:
        rows, plans, warnings = dict(target.keyed()), list(target.planned()), list[str]()
        before = {key for key, outcome in rows.items() if not outcome.invalid}
        ours = target.meta()
        known, taken = 0, dict[str, Path]()
        for path in stores:
            with Store(path, create=False) as source:
                theirs = source.meta()
                ours = ours or theirs
                changed = differences(ours, theirs) if theirs else []
                if changed:
                    warnings.append(f"{path.parent} was flown on another platform: {', '.join(changed)}")
                for key, outcome in source.keyed():
                    clash = _clash(rows.get(key), outcome)
                    if clash and not changed:
                        raise GateError(f"{outcome.name} in {path.parent} is not the flight in {folder}: {clash}")
                    if clash and _violated(rows[key]) != _violated(outcome):
                        warnings.append(f"{outcome.name} violates other requirements in {path.parent}; it is left out")
                    known += key in rows
                    if key not in rows or rows[key].invalid:
                        rows[key], taken[key] = outcome, path
                plans += source.planned()
                target.set_notes(source.notes())
        dropped = _spare_canaries(study, rows, plans)
        target.set_meta(ours or fingerprint())
        target.plan(flight for flight in plans if flight.key not in dropped)
        for path in stores:
            with Store(path, create=False) as source:
                keys = [key for key, where in taken.items() if where == path and key not in dropped]
                target.put_all(source.rows(keys))
        write_log(study, folder, current_in(study, target))
    added = {key for key, outcome in rows.items() if not outcome.invalid} - before - dropped
    return Merged(len(added), known, tuple(warnings))


def _clash(first: Outcome | None, second: Outcome) -> str:
    """The difference of two outcomes with the same key; empty for equal outcomes."""
    if first is None or first.invalid or second.invalid:
        return ""
    if (first.digest, first.perceived_digest) != (second.digest, second.perceived_digest):
        return f"digest {second.digest[:12]} there, {first.digest[:12]} here"
    return ""


def _violated(outcome: Outcome) -> list[str]:
    return sorted(violation.requirement for violation in outcome.violations)


def _spare_canaries(study: Study, rows: dict[str, Outcome], plans: Sequence[Planned]) -> set[str]:
    """Keys of the superfluous canaries; per control the one whose baseline holds most is kept (first in the grid)."""
    asked = {flight.key for flight in plans if not flight.canary}
    canaries = {flight.key: flight for flight in plans if flight.canary and flight.key not in asked}
    baselines = baselines_of(rows.values())

    def rank(flight: Planned) -> tuple[int, tuple[int, str], int]:
        baseline = baselines.get((flight.situation, flight.seed))
        return (-held_requirements(baseline) if baseline else 0, study.space.rank(flight.situation), flight.seed)

    best: dict[str, Planned] = {}
    for flight in sorted(canaries.values(), key=rank):
        best.setdefault(flight.mutant, flight)
    return canaries.keys() - {flight.key for flight in best.values()}
