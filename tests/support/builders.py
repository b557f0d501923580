"""Spaces, ranges and outcomes made by hand and by hypothesis, for the tests of what follows from them."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

from hypothesis import strategies as st
from paper_flyer import made

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.document import Item
from scaloft_fi.hazop.matrix import SeverityClass, cell_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome, Subject
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.sim.log import signal_names
from scaloft_fi.sim.situation import Range, Shape
from scaloft_fi.stack.reference.messages import BELIEFS

KINDS = {"SR1": Kind.SAFETY, "SR2": Kind.SAFETY, "SR2-literal": Kind.REPORTED, "OP1": Kind.OPERABILITY}

AXES = ("T", "O", "W", "D", "H")
WORDS = (("straight", "corner"), ("clear", "obstacle"), ("wide", "wall"), ("light", "dark"), ("nobody", "human"))


def key_of(point: tuple[str, ...]) -> str:
    return "".join(axis + value for axis, value in zip(AXES, point, strict=True))


SIGNALS = signal_names(("wall", "bar", "obstacle", "person", "ground"), BELIEFS)

GRID = Space(
    axes=AXES,
    values=(("0", "1"),) * 5,
    words=WORDS,
    points=tuple((key_of(point), point) for point in product("01", repeat=5)),
)

ROSTER = Roster(
    defaults={"LATE-human": "LATE-human@3s", "NO-human": "NO-human@100%", "MORE-goal": "MORE-goal@0.6m"},
    controls=frozenset({"REVERSE-human"}),
    ids=("NO-human@100%", "REVERSE-human", "LATE-human@1s", "LATE-human@3s", "MORE-goal@0.6m"),
)

WORST, LEAST = SeverityClass(0, "injury", "a person may be hurt", ""), SeverityClass(1, "delay", "time is lost", "")
CLASSED = replace(ROSTER, severities={"NO-human": LEAST, "MORE-goal": WORST})
"""The same study with classes of severity: of the last mutant the worst, of LATE-human none."""


def subject_of(mutant: str) -> Subject:
    if mutant in (BASELINE, PLACEBO_ID):
        return Subject(mutant)
    guideword, parameter = cell_of(mutant).split("-")
    return Subject(mutant, guideword, parameter, mutant.partition("@")[2])


def outcome(
    mutant: str = BASELINE,
    situation: str = "T0O0W0D0H0",
    seed: int = 0,
    *,
    violated: dict[str, float] | None = None,
    struck: str = "",
    duration_s: float = 60.0,
    altered: int | None = None,
    carried: int = 100,
    digest: str | None = None,
    invalid: str = "",
    realised: bool = True,
    vacuous: Collection[str] = (),
) -> Outcome:
    """A flight that violates these requirements at these times; one that strikes something is cut short there."""
    violated = violated or {}
    end_s = min(violated.values()) if struck else duration_s
    clean = mutant in (BASELINE, PLACEBO_ID)
    return made(
        *(subject_of(mutant), situation, seed, KINDS, violated),
        rho=(-0.1, 0.3),
        idle=vacuous,
        place=(1.0, 2.0, 1.65),
        struck=struck,
        **({"ending": ""} if invalid else {}),
        invalid=invalid,
        carried=carried,
        altered=(0 if clean else 5) if altered is None else altered,
        infected_at_s=None if clean else 3.0,
        duration_s=end_s,
        digest=digest or ("clean" if clean else mutant),
        realised=tuple((axis, realised) for axis in AXES) if mutant == BASELINE else (),
    )


def pool(*situations: str, seeds: int = 10, red: int = 0, **how: Any) -> list[Outcome]:
    """The baseline in these situations; the last `red` of its seeds violate what `how` says, the others nothing."""
    told = {name: how.pop(name) for name in ("violated", "struck") if name in how}
    return [
        outcome(BASELINE, key, seed, **how, **(told if seed >= seeds - red else {}))
        for key in situations
        for seed in range(seeds)
    ]


times = st.integers(1, 59).map(float)
violations = st.dictionaries(st.sampled_from(list(KINDS)), times, max_size=4)
subjects = st.sampled_from([PLACEBO_ID, *ROSTER.ids, "LATE-human@2.5s"])


@st.composite
def flights(draw: st.DrawFn, mutants: st.SearchStrategy[str] = subjects) -> Outcome:
    violated = draw(violations)
    struck = draw(st.sampled_from(["", "wall"])) if violated else ""
    if struck:
        violated = {name: t_s for name, t_s in violated.items() if t_s == min(violated.values()) or name != "SR1"}
    return outcome(
        draw(mutants),
        draw(st.sampled_from([key for key, _ in GRID.points[:6]])),
        draw(st.integers(0, 2)),
        violated=violated,
        struck=struck,
        altered=draw(st.sampled_from([0, 5])),
        carried=draw(st.sampled_from([0, 100])),
        digest=draw(st.sampled_from(["clean", "other"])),
        invalid=draw(st.sampled_from(["", "", "", "the worker died"])),
        realised=draw(st.booleans()),
    )


@st.composite
def campaigns(draw: st.DrawFn) -> list[Outcome]:
    """Outcomes of a campaign: at most one per subject, situation and seed; baselines for most."""
    drawn = draw(st.lists(flights(), max_size=25))
    baselines = [draw(flights(st.just(BASELINE))) for _ in range(draw(st.integers(0, 4)))]
    paired = [flown for flown in drawn if draw(st.sampled_from([True, True, True, False]))]
    baselines += [replace(draw(flights(st.just(BASELINE))), situation=f.situation, seed=f.seed) for f in paired]
    unique = {flown.name: flown for flown in [*baselines, *drawn]}
    return list(unique.values())


@st.composite
def seeded(draw: st.DrawFn) -> list[Outcome]:
    """A campaign of several seeds: enough for verdicts and REDRAW, with noise, invalid and cut-short flights."""
    chance = random.Random(draw(st.integers(0, 10**6)))
    keys = [key for key, _ in GRID.points[: draw(st.integers(1, 4))]]
    seeds = draw(st.sampled_from([2, 3, 6, 10, 12]))
    rates = {key: chance.choice([0, 0, 0.02, 0.1, 0.5, 1]) for key in keys}
    idle = {key: chance.choice([(), (), ("SR2",)]) for key in keys}
    outcomes = []
    for mutant in (BASELINE, PLACEBO_ID, *ROSTER.ids):
        for key in keys:
            kill = rates[key] if mutant in (BASELINE, PLACEBO_ID) else chance.choice([0, 0.3, 0.9, 1])
            for seed in range(seeds if mutant == BASELINE else min(seeds, chance.choice([1, 3, 5, 11, 11]))):
                violated = {name: float(chance.randrange(1, 59)) for name in KINDS if chance.random() < kill}
                struck = chance.choice(["", "", "wall", "bar"]) if "SR1" in violated else ""
                if struck:
                    violated = {n: t for n, t in violated.items() if n == "SR1" or t < violated["SR1"]}
                    end = min(violated.values())
                    violated = {n: t for n, t in violated.items() if t == end}
                outcomes.append(
                    outcome(
                        *(mutant, key, seed),
                        violated=violated,
                        struck=struck,
                        altered=chance.choice([0, 5, 5, 5]),
                        invalid=chance.choice(["", *[""] * 20, "the worker died"]),
                        digest=chance.choice(["clean", *["other"] * 5]),
                        vacuous=idle[key] if chance.random() < 0.9 else (),
                    )
                )
    return outcomes


def thrice(
    mutant: str,
    *situations: str,
    violated: dict[str, float] | None = None,
    altered: int | None = None,
    carried: int = 100,
    digest: str | None = None,
) -> list[Outcome]:
    """Three seeds of a mutant in each situation: enough to detect it in one, beside a pool that holds all."""
    told = {"violated": violated, "altered": altered, "carried": carried, "digest": digest}
    return [outcome(mutant, key, seed, **told) for key in situations for seed in range(3)]


def space_of(sizes: list[int], allowed: Callable[[Point], bool] = lambda _: True) -> Space:
    """Axes with so many values each, without the points that are not allowed."""
    axes = tuple(f"A{chr(97 + number)}" for number in range(len(sizes)))
    values = tuple(tuple(map(str, range(size))) for size in sizes)
    points = [point for point in product(*values) if allowed(point)]
    keyed = tuple(("".join(a + v for a, v in zip(axes, point, strict=True)), point) for point in points)
    return Space(axes, values, values, keyed)


def keys_of(space: Space) -> list[str]:
    return [key for key, _ in space.points]


FIVE = space_of([2] * 5)


@st.composite
def spaces(draw: st.DrawFn, most: int = 40) -> Space:
    """Small grids, some with points taken out."""
    sizes = draw(st.lists(st.integers(2, 3), min_size=2, max_size=4).filter(lambda s: len(s) < 4 or sum(s) < 11))
    whole = space_of(sizes)
    left = draw(st.lists(st.sampled_from(whole.points), min_size=2, max_size=most, unique=True))
    if draw(st.booleans()):
        return whole
    chosen = {point for _, point in left}
    return space_of(sizes, lambda point: point in chosen)


CRUISE = """
  C:
    title: cruise speed
    category: operational domain, speed
    range:
      set: mission.cruise_mps
      from: 0.4
      to: 1.2
      unit: m/s
      distribution: uniform
      bins: 4
      benign: 0.5
    realised: eventually(speed_mps >= 0.8 * number)
"""


def with_range(folder: Path, axis: str = CRUISE, *, first: bool = False) -> Path:
    """Add an axis to the situations of a study, or of a `sim` folder, as the last or the first; returns the folder."""
    path = next(path for path in (folder / "situations.yaml", folder / "sim" / "situations.yaml") if path.exists())
    text = path.read_text(encoding="utf-8")
    old, new = ("axes:\n", f"axes:{axis}") if first else ("\naliases:", f"{axis}\naliases:")
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return folder


UNIT = Range(
    path="world.light",
    low=0.0,
    high=1.0,
    unit="lx",
    benign=0.25,
    shape=Shape.UNIFORM,
    bins=2,
    item=Item(Path("situations.yaml"), 1, "set", "light"),
)
RANGED = replace(GRID, ranges=(("H", UNIT),))
"""The paper's grid with an axis H that draws numbers from 0 to 0.5 (0) and 0.5 to 1 (1)."""


def drawn(key: str, share: float) -> str:
    """A situation of `RANGED` with a number drawn from its bin of H."""
    return f"{key}={UNIT.draw(int(key[-1]), share):g}"
