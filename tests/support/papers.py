"""Campaigns for the report: the reference study, flights by a rule, with tracks, no physics."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from paper_flyer import made

from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, TRACK_COLUMNS, Outcome, Subject, pack_track
from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import Evidence

STUDY = Path(__file__).parents[2]
MUTANTS = ("LATE-human@3s", "LATE-human@1s", "MORE-goal@0.6m", "NO-depth@3s", "REVERSE-velcmd", "LESS-goal@0.05m")
SEEDS, POOL = range(3), range(10)
BAR, SHAKY, ONCE = "T1O1W1D1H0", "T1O0W0D0H0", "T0O0W0D0H0"
"""Where the unmutated drone strikes the bar; where it strikes a wall with three seeds; where LESS-goal does once."""
FINGERPRINT = {"system": "Paper", "python": "3.11"}


def track(duration_s: float, drift: float, from_s: float, climb_m: float = 1.6) -> bytes:
    """Take off, up the corridor and back; from `from_s` on a drift to the side."""
    times = [0.05 * i for i in range(round(duration_s / 0.05) + 1)]
    y = [3.0 - 3.0 * math.cos(2 * math.pi * t / duration_s) for t in times]
    x = [drift * max(0.0, t - from_s) / duration_s for t in times]
    return pack_track(
        {
            "elapsed_s": times,
            "x_m": x,
            "y_m": y,
            "z_m": [0.05 + min(climb_m, t) for t in times],
            "speed_mps": [0.3 + 0.2 * math.sin(t) for t in times],
            "clearance_m": [1.0 - abs(value) for value in x],
            "person_sight_m": [100.0 if value > 4 else 4.0 - 0.9 * value for value in y],
        }
    )


def flight(study: Study, mutant: str, situation: str, seed: int) -> Outcome:
    """Late persons are detected where a person is in the light, one second late with two of three seeds only.

    In the dark a person is always passed too fast (SR2 is red); without a person SR2 is vacuous; at `BAR` SR1 is red
    and OP1 open; at `SHAKY` SR1 is unsteady, and violated by MORE-goal, whose own baselines hold it.
    NO-human is detected in straight missions only.
    """
    human = situation.endswith("H1")
    violated: dict[str, float] = {}
    struck, carried, altered, from_s, drift, masked = "", 100, 0, math.inf, 0.0, False
    if situation.endswith("D1H1"):
        violated["SR2"] = 12.0
    if situation == BAR:
        violated, struck = {"SR1": 20.0}, "bar"
    if situation == SHAKY and (3 <= seed <= 5 or mutant.startswith("MORE-goal")):
        violated, struck = {"SR1": 21.0}, "wall"
    if mutant == "REVERSE-velcmd":
        violated, struck, altered, from_s, drift = {"SR1": 5.0}, "wall", 90, 0.0, 12.0
    elif mutant.startswith("LATE-human") and human:
        altered, from_s, drift = 60, 8.0, 1.0 + 0.1 * seed
        if mutant.endswith("3s") or seed > 0:
            violated = {"SR2": 9.5}
    elif mutant.startswith("NO-human") and human and "T0" in situation:
        violated, altered, from_s, drift = {"SR2": 7.0}, 50, 6.0, 1.5
    elif mutant.startswith("MORE-goal"):
        altered, from_s, drift = 40, 2.0, 0.7 + 0.05 * seed
        masked = situation.startswith("T0") and situation.endswith("D1H0")
        if "T1" in situation and not struck:
            violated = violated | {"OP1": 30.0}
    elif mutant.startswith("NO-depth") and human:
        carried = 0
    elif mutant.startswith("LESS-goal"):
        altered, from_s, drift = 20, 3.0, 0.3
        if situation == ONCE and seed == 1:
            violated, struck = {"SR1": 15.0}, "wall"
    duration_s = violated["SR1"] if struck else 40.0
    plain = BASELINE if masked or not altered else mutant
    guideword, _, parameter = mutant.partition("@")[0].partition("-")
    named = mutant in (BASELINE, PLACEBO_ID)
    kinds = {r.name: r.kind for r in study.requirements}
    return made(
        Subject(mutant) if named else Subject(mutant, guideword, parameter, mutant.partition("@")[2]),
        *(situation, seed, kinds, {name: violated[name] for name in kinds if name in violated}),
        rho=(-0.25, 0.5),
        idle=() if human else [name for name in kinds if name.startswith("SR2")],
        place=(0.25, 1.5, 1.65),
        struck=struck,
        carried=0 if named else carried,
        altered=altered,
        infected_at_s=from_s if altered else None,
        duration_s=duration_s,
        digest=f"{plain}/{situation}/{seed}",
        perceived_digest=f"{plain}/{situation}/{seed}",
        realised=tuple((axis.id, True) for axis in study.grid.axes) if mutant == BASELINE else (),
        track=track(duration_s, drift + 0.01 * seed, math.inf if masked else from_s),
    )


def campaign(
    study: Study, mutants: Sequence[str] = MUTANTS, seeds: Iterable[int] = SEEDS, pool: Iterable[int] = POOL
) -> tuple[Outcome, ...]:
    """Every mutant with the baseline and PLACEBO in every situation, then the baseline alone with the pool's seeds."""
    keys, seeds = [key for key, _ in study.space.points], list(seeds)
    flown = [(mutant, seed) for seed in seeds for mutant in (BASELINE, PLACEBO_ID, *mutants)]
    flown += [(BASELINE, seed) for seed in pool if seed not in seeds]
    return tuple(flight(study, mutant, key, seed) for mutant, seed in flown for key in keys)


def evidence_of(study: Study, outcomes: Sequence[Outcome], name: str = "paper") -> Evidence:
    return Evidence(study, name, tuple(outcomes), fingerprint=FINGERPRINT)


HOSTILE = (
    "</script><script>document.title='pwned'</script>",
    "<img src=x onerror=\"document.title='pwned'\">",
    "\"'`&amp;&lt;b&gt; @FLIGHTS@ @SCRIPT@ \\u003c <!-- -->",
    '=HYPERLINK("http://example.com","x")',
    "Überlänge " + "x" * 300,
    "人間の検出 🚁 \u202eright-to-left",
)


def column(name: str) -> int:
    return TRACK_COLUMNS.index(name)


def jitter(outcome: Outcome, seed: int) -> Outcome:
    """The same flight with another noise: a track that does not compress away."""
    draw = random.Random(f"{outcome.name}/{seed}")
    noise = [draw.gauss(0, 0.02) for _ in range(250)]
    steps = [0.2 * i for i in range(250)]
    path = [sum(noise[: i + 1]) for i in range(250)]
    signals = dict.fromkeys(TRACK_COLUMNS, path) | {"elapsed_s": steps, "z_m": noise}
    return replace(outcome, seed=seed, digest=f"{outcome.name}/{seed}", track=pack_track(signals))
