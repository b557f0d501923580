"""REDRAW: how often the kill rule kills what does nothing, measured on the baselines that were flown anyway.

A fault that did nothing but redraw the noise would turn one baseline of a situation into another.  So of every two
baseline seeds of a situation the one is judged as a mutant of the other, as if it were infected: n seeds give n (n -
1) ordered pairs, and each kill among them is a false one.  PLACEBO cannot show this, because it draws the same noise
as its baseline; a mutant shares what it does not disturb, so its rate is the lower the less its fault does.  The
pairs overlap, which is why the rate has no interval.

The decisions are measured by leaving seeds out: each block of as many seeds as a look takes is judged as a mutant
beside the pool of the others, at the last look for which twice as many seeds were flown.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from scaloft_fi.results.flights import flight_of
from scaloft_fi.results.outcome import Outcome
from scaloft_fi.results.requirement import Kind
from scaloft_fi.results.rulings import Ruled, facts, ruled
from scaloft_fi.results.scoring.decision import LOOKS, Decision, Pool, PoolRates, decide
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.status import Status, counting, held_to_end

NO_PAIRS = "no situation has two baseline seeds"


@dataclass(frozen=True)
class Redraw:
    """The false kills of the pool's own flights.

    Attributes:
        pairs: per situation with two seeds, killed of the eligible ordered pairs.
        left_out: flights that a decision of `decided` takes; 0 where there are too few seeds for any.
        decided: blocks of left-out seeds that are killed in any situation, of all blocks.
    """

    pairs: Mapping[str, Ratio]
    left_out: int
    decided: Ratio

    @property
    def rate(self) -> Ratio:
        """Killed of the eligible ordered pairs, over the situations."""
        return Ratio(sum(pairs.part for pairs in self.pairs.values()), sum(p.whole for p in self.pairs.values()))

    def expected(self, eligible: Mapping[str, int]) -> tuple[float, int] | None:
        """False kills expected of so many eligible flights per situation: each situation's rate times its flights.

        Returns:
            Their number, and the flights it is about: those in situations with a rate; None without any.
        """
        known = {key: n for key, n in eligible.items() if n and key in self.pairs and self.pairs[key].whole}
        if not known:
            return None
        return sum((self.pairs[key].value or 0.0) * n for key, n in known.items()), sum(known.values())


def redraw(pool: Pool) -> Redraw:
    """Judge the pool's seeds by one another."""
    seeds = {key: _counted(baselines) for key, baselines in pool.items()}
    left_out = max((look for look in LOOKS if any(len(listed) >= 2 * look for listed in seeds.values())), default=0)
    return Redraw(
        pairs={key: _pairs(listed) for key, listed in seeds.items() if len(listed) > 1},
        left_out=left_out,
        decided=_decided(seeds, left_out) if left_out else Ratio(0, 0),
    )


def _counted(baselines: Iterable[Outcome]) -> list[Outcome]:
    return sorted((b for b in baselines if not b.invalid), key=lambda baseline: baseline.seed)


def _pairs(seeds: Sequence[Outcome]) -> Ratio:
    clean = [baseline for baseline in seeds if held_to_end(baseline, Kind.SAFETY)]
    red = [_infected(baseline) for baseline in seeds if baseline.first_violation]
    killed = sum(flight_of(b, a).status is Status.KILLED for a in clean for b in red if a.seed != b.seed)
    return Ratio(killed, len(clean) * (len(seeds) - 1))


def _infected(baseline: Outcome) -> Outcome:
    return replace(baseline, carried=1, altered=1)


def _decided(seeds: Mapping[str, Sequence[Outcome]], look: int) -> Ratio:
    enough = {key: listed for key, listed in seeds.items() if len(listed) >= 2 * look}
    blocks = min(len(listed) for listed in enough.values()) // look
    killed = 0
    for block in range(blocks):
        start, end = block * look, (block + 1) * look
        rest = {key: [*listed[:start], *listed[end:]] for key, listed in enough.items()}
        said = decide({key: _beside(listed[start:end], rest[key]) for key, listed in enough.items()}, PoolRates(rest))
        killed += any(decided.decision is Decision.KILLED for decided in said.values())
    return Ratio(killed, blocks)


def _beside(left_out: Sequence[Outcome], rest: Sequence[Outcome]) -> list[Ruled]:
    """The left-out seeds, each beside a baseline of its own that stays in the pool."""
    return [
        ruled(flight.seed, facts(_infected(flight)), counting(baseline))
        for flight, baseline in zip(left_out, rest, strict=False)
    ]
