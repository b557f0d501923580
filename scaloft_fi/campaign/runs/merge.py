"""Merge campaigns that were flown in parts or on several machines."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.campaign.plan import held_requirements
from scaloft_fi.campaign.runs.run import write_log
from scaloft_fi.campaign.store import platforms
from scaloft_fi.campaign.store.archive import STORE_NAME, existing, writable
from scaloft_fi.campaign.store.held import current_in
from scaloft_fi.campaign.store.platforms import Pair, Platform, Platforms, pair_of
from scaloft_fi.campaign.store.record import Planned
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.space import Rank
from scaloft_fi.judge.status import agreement, baselines_of, digests
from scaloft_fi.study import Study


@dataclass(frozen=True)
class Merged:
    """What a merge of campaigns added.

    Attributes:
        campaign: folder of the campaign that got the flights.
        added: flights added to it.
        known: flights that it held already.
        warnings: what a reader must know of the platforms of the flights.
    """

    campaign: Path
    added: int
    known: int
    warnings: tuple[str, ...]


def merge(study: Study, folder: Path, sources: Sequence[Path], *, same_platform: bool = False) -> Merged:
    """Merge the campaigns in `sources` into the campaign in `folder`, which need not exist.

    Each part may have flown a control as its canary; the merge keeps the canary of an undivided run.  Where two
    platforms flew the same situation and seed with other baselines, the flights of the campaign that comes first stay.

    Args:
        study: the current study.
        folder: folder of the campaign.
        sources: folders of the campaigns that are merged.
        same_platform: whether flights of another platform must have equal digests.

    Raises:
        GateError: a flight has other digests on one platform, or other facts on two; nothing is written.
        InputError: a folder holds no campaign, or cannot be written.
    """
    stores = [existing(source) for source in sources]  # every source is checked before anything is created
    with Store(writable(folder) / STORE_NAME) as target:
        joined = _Joined(study, target, folder, same_platform=same_platform)
        before = joined.valid
        plans, notes, known, warnings = list(target.planned()), dict[str, str](), 0, list[str]()
        for path in stores:
            with Store(path, create=False) as source:
                known += len(joined.rows.keys() & {flight.key for flight in source.flights()})
                warnings += joined.join(source, path)
                plans += [*source.planned(), *platforms.set_apart(source)]
                notes |= source.notes()
        dropped = _spare_canaries(study, joined.rows, plans)
        target.set_meta(joined.own or platforms.fingerprint())
        target.set_notes({name: text for name, text in notes.items() if not platforms.is_pair_note(name)})
        target.plan(flight for flight in plans if flight.key not in dropped)
        now = Platforms(target)  # the platforms of the pairs of situation and seed
        for theirs in {tuple(sorted(platform.items())): platform for platform in joined.pairs.values()}.values():
            pairs = [pair for pair, platform in joined.pairs.items() if platform == theirs]
            platforms.claim(target, [pair for pair in pairs if not now.equal(now.of(pair), theirs)], theirs)
        for path in stores:
            with Store(path, create=False) as source:
                keys = [key for key, where in joined.taken.items() if where == path and key not in dropped]
                target.put_all(source.rows(keys))
        write_log(study, folder, current_in(study, target))
    return Merged(folder, len(joined.valid - before - dropped), known, tuple(warnings))


class _Joined:
    """The flights of the merged campaign so far.

    Attributes:
        rows: outcomes by key.
        taken: path of the store from which an outcome comes, by key; without those of the merged campaign itself.
        own: platform of the merged campaign.
        pairs: platforms by situation and seed.
    """

    def __init__(self, study: Study, target: Store, folder: Path, *, same_platform: bool) -> None:
        self._study, self._folder, self._same_platform = study, folder, same_platform
        self.rows, self.taken = dict(target.keyed()), dict[str, Path]()
        self._noisy = not study.stack.deterministic
        self._known = Platforms(target)
        self.own = self._known.own
        self._apart = {flight.key for flight in platforms.set_apart(target)}
        self._current = {outcome.name: outcome for outcome in current_in(study, target)}
        self.pairs = {pair_of(o): self._known.of(pair_of(o)) for o in self._current.values() if not o.invalid}

    @property
    def valid(self) -> set[str]:
        """Keys of the valid outcomes that were not set apart."""
        return {key for key, outcome in self.rows.items() if not outcome.invalid} - self._apart

    def join(self, source: Store, path: Path) -> list[str]:
        """Add the flights of a store; returns the warnings.

        Raises:
            GateError: a flight has other digests on one platform, or other facts on two.
        """
        rows, known = dict(source.keyed()), Platforms(source)
        apart = {flight.key for flight in platforms.set_apart(source)}
        self._apart |= apart
        self.own = self.own or known.own
        pairs = {pair_of(o): known.of(pair_of(o)) for key, o in rows.items() if not o.invalid and key not in apart}
        other = {
            pair: theirs
            for pair, theirs in pairs.items()
            if pair in self.pairs and not self._equal(self.pairs[pair], theirs, known)
        }
        for key, outcome in rows.items():
            if pair_of(outcome) not in other:
                self._hold_equal(key, outcome, path)
        current = current_in(self._study, source)
        warnings = self._compare(current, other, known, path)
        kept = _other_baselines(self.rows, rows, other)
        apart = self._apart | self.rows.keys()
        if out := [key for key, outcome in rows.items() if pair_of(outcome) in kept and key not in apart]:
            warnings.append(
                f"{len(out)} flights of {path.parent} are left out, because {self._folder} has flights of another "
                f"platform in the same situations and seeds ({len(kept)}); `run` flies what is missing there"
            )
        for key, outcome in rows.items():
            if pair_of(outcome) not in kept and (key not in self.rows or self.rows[key].invalid):
                self.rows[key], self.taken[key] = outcome, path
        self._current |= {o.name: o for o in current if pair_of(o) not in kept and not self._has(o)}
        self.pairs = pairs | self.pairs
        return warnings

    def _has(self, outcome: Outcome) -> bool:
        return outcome.name in self._current and not self._current[outcome.name].invalid

    def _equal(self, mine: Platform, theirs: Platform, known: Platforms) -> bool:
        return self._noisy or self._known.equal(mine, theirs) or known.equal(mine, theirs)

    def _hold_equal(self, key: str, outcome: Outcome, path: Path) -> None:
        """Refuse a flight that has other digests on the same platform, where flights repeat their bits."""
        first = self.rows.get(key)
        if self._noisy or first is None or first.invalid or outcome.invalid or digests(first) == digests(outcome):
            return
        clash = f"digest {outcome.digest[:12]} there, {first.digest[:12]} here"
        raise GateError(
            f"{outcome.name} in {path.parent} is not the flight in {self._folder}: {clash}, on the same platform"
        )

    def _compare(
        self, current: Sequence[Outcome], other: Mapping[Pair, Platform], known: Platforms, path: Path
    ) -> list[str]:
        """Compare the flights of a store with those of other platforms that the merged campaign has."""
        flown = [(self.own, theirs) for theirs, _ in known.by_platform(current)]
        flown += [(self.pairs[pair], theirs) for pair, theirs in other.items()]
        changed = {", ".join(platforms.differences(ours, theirs)) for ours, theirs in flown} - {""}
        if not changed:
            return []
        compared = agreement([outcome for outcome in current if pair_of(outcome) in other], self._current.values())
        platform = f"{path.parent} was flown on another platform than {self._folder} ({'; '.join(sorted(changed))})"
        if compared.facts:
            raise GateError(
                f"{platform}, and {len(compared.facts)} of the flights that both have differ in more than bits: "
                f"{compared.named()}; nothing was merged"
            )
        both = len(compared.equal) + len(compared.bits)
        if self._same_platform and (compared.bits or not both):
            why = f"other digests: {', '.join(compared.bits[:3])}" if both else "no flight in both to compare"
            raise GateError(f"{platform}, and --same-platform allows equal digests only: {why}; nothing was merged")
        if not both:
            return [f"{platform}; no flight is in both, so nothing could be compared"]
        told = f"{len(compared.equal)} have equal digests, and {len(compared.bits)} differ in bits only"
        return [f"{platform}: of {both} flights in both {told}, with the same status, ending and violations"]


def _other_baselines(mine: Mapping[str, Outcome], theirs: Mapping[str, Outcome], pairs: Collection[Pair]) -> set[Pair]:
    """The `pairs` in which flights of two platforms may not be judged together: those without equal baselines."""
    equal: dict[Pair, bool] = {}
    for key, outcome in theirs.items():
        pair = pair_of(outcome)
        if outcome.mutant == BASELINE and not outcome.invalid and pair in pairs:
            same = key in mine and digests(mine[key]) == digests(outcome)
            equal[pair] = equal.get(pair, True) and same
    return {pair for pair in pairs if not equal.get(pair, False)}


def _spare_canaries(study: Study, rows: dict[str, Outcome], plans: Sequence[Planned]) -> set[str]:
    """Keys of the superfluous canaries; per control the one whose baseline holds most is kept (first in the grid)."""
    asked = {flight.key for flight in plans if not flight.canary}
    canaries = {flight.key: flight for flight in plans if flight.canary and flight.key not in asked}
    baselines = baselines_of(rows.values())

    def rank(flight: Planned) -> tuple[int, Rank, int]:
        baseline = baselines.get((flight.situation, flight.seed))
        return (-held_requirements(baseline) if baseline else 0, study.space.rank(flight.situation), flight.seed)

    best: dict[str, Planned] = {}
    for flight in sorted(canaries.values(), key=rank):
        best.setdefault(flight.mutant, flight)
    return canaries.keys() - {flight.key for flight in best.values()}
