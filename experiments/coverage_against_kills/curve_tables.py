"""Coverage against kills as tables and as plain JSON values."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from experiments.coverage_against_kills.curves import Band, Curve, Curves
from experiments.coverage_against_kills.prediction import Prediction, interval
from experiments.coverage_against_kills.redrawn import RESAMPLES
from scaloft_fi.views.table import Table

SHOWN = (1, 2, 4, 6, 8, 10, 16, 24, 32)
"""Sizes k in the tables; JSON has all."""
COMPARED = (4, 8, 16)
"""Those at which orders are compared with random order; an array at its own size."""


def curves_json(found: Curves, prediction: Prediction) -> dict[str, Any]:
    """All points of all curves.  Lists over k begin with k = 1; a strategy's lists may be shorter than `situations`.

    `strategies[].kills` (mutants), `.kill_sets` (mutants with equal kill sets count once) and `spread` are {mean, low,
    high}; `difference` and `distinct` are those of both to random order, at equal k, paired, and null for random order
    itself; `t_way` has a list of shares for each strength.  `seeds` are those that all mutants have in common; they are
    resampled where `seeds_resampled`, while flights with `more_seeds` stand.
    """
    trial = found.trial
    return {
        "mutants": len(trial.mutants),
        "killed": trial.killed,
        "kill_sets": len(trial.kill_sets),
        "unkilled": list(trial.unkilled),
        "seeds": list(trial.seeds),
        "more_seeds": list(trial.more_seeds),
        "seeds_resampled": bool(trial.seed_sets),
        "left_out": list(trial.left_out),
        "situations": len(trial.situations),
        "grid": len(trial.space.points),
        "strategies": [_curve(curve) for curve in found.curves],
        "spread": _band(found.spread),
        "missing": [{"name": name, "reason": reason} for name, reason in found.missing],
        "correlation": [
            {"strength": one.strength, "within": list(one.within), "median": one.median, "pooled": one.pooled}
            for one in prediction.correlations
        ],
        "sub_cubes": [{"axes": axes, "mutants": count} for axes, count in prediction.sub_cubes],
        "answer": list(prediction.answer),
    }


def _curve(curve: Curve) -> dict[str, Any]:
    return {
        "id": curve.id,
        "name": curve.name,
        "about": curve.about,
        "oracle": curve.oracle,
        "kills": _band(curve.kills),
        "kill_sets": _band(curve.kill_sets),
        "difference": _band(curve.difference) if curve.difference else None,
        "distinct": _band(curve.distinct) if curve.distinct else None,
        "t_way": {str(strength): list(shares) for strength, shares in curve.t_way},
        "apfd": curve.apfd,
        "area": curve.area,
        "random_area": curve.random_area,
        "matched": curve.matched,
    }


def _band(band: Band) -> dict[str, list[float]]:
    return {"mean": list(band.mean), "low": list(band.low), "high": list(band.high)}


def curve_tables(found: Curves, prediction: Prediction) -> tuple[Table, ...]:
    """What a person reads: the answer, kills and coverage at k, differences to random, whole orders, correlations."""
    trial = found.trial
    sizes = _sizes(len(trial.situations))
    answer = Table("Coverage against kills", ("finding",), tuple((sentence,) for sentence in prediction.answer))
    kills = Table(
        "Mutants killed by k situations",
        ("strategy", *(f"k={k}" for k in sizes)),
        tuple((curve.name, *_at(curve.kills.mean, sizes, "{:.1f}")) for curve in found.curves),
        (
            f"Expected kills of {len(trial.mutants)} default mutants in {len(trial.situations)} situations.",
            *(f"{curve.name}: {curve.about}." for curve in found.curves),
            *(f"{name} is missing: {reason}." for name, reason in found.missing),
            *([f"Left out, not flown in all of these situations: {', '.join(trial.left_out)}."] * bool(trial.left_out)),
        ),
    )
    told = _coverage(found, sizes), _orders(found), _correlations(prediction, sizes)
    return (answer, _differences(found), kills, *told)


def _differences(found: Curves) -> Table:
    rows = tuple(
        (
            curve.name,
            k,
            f"{curve.kill_sets.mean[k - 1]:.1f}",
            interval(curve.distinct, k),
            f"{curve.kills.mean[k - 1]:.1f}",
            interval(curve.difference, k),
        )
        for curve in found.curves
        if curve.distinct and curve.difference and not curve.oracle
        for k in _compared(curve)
    )
    trial = found.trial
    seeds = "Seeds are not resampled."
    if trial.seed_sets:
        seeds = (
            f"Each is judged by the seeds that come out of {len(trial.seeds)} draws, mostly fewer than were flown, so "
            "intervals need not be centred."
        )
    notes = [
        "More: than as many random situations, paired.  Kill sets: mutants with equal kill sets count once.",
        f"In brackets 95 % intervals over {RESAMPLES} redrawn campaigns.",
        seeds,
        "Mutants are resampled within their parameter, kill sets among each other.",
    ]
    if trial.more_seeds:
        notes.append("Seeds that only some of the mutants were flown with are not resampled.")
    headers = ("strategy", "k", "kill sets", "more kill sets", "mutants", "more mutants")
    return Table("Compared with k random situations", headers, rows, tuple(notes))


def _compared(curve: Curve) -> tuple[int, ...]:
    """The sizes at which a strategy is compared with random order."""
    size = len(curve.kills.mean)
    return tuple(k for k in COMPARED if k < size) if curve.matched is None else (size,)


def _coverage(found: Curves, sizes: tuple[int, ...]) -> Table:
    rows = [
        (curve.name, f"{strength}-way", *_at([100 * share for share in shares], sizes, "{:.1f}"))
        for curve in found.curves
        for strength, shares in curve.t_way
    ]
    headers = ("strategy", "combinations", *(f"k={k}" for k in sizes))
    return Table("Combinations covered by k situations [%]", headers, tuple(rows))


def _orders(found: Curves) -> Table:
    never = len(found.trial.mutants) - found.trial.killed
    rows = tuple(
        (
            curve.name,
            "n/a" if curve.apfd is None else f"{curve.apfd:.3f}",
            f"{curve.area:.3f}",
            f"{curve.random_area:.3f}",
            len(curve.kills.mean),
        )
        for curve in found.curves
    )
    notes = (
        f"APFD (average percentage of faults detected) leaves out the {never} mutants killed in no situation.",
        "It has a value for orders of all situations only.",
        "Area: mean share of all mutants killed at k = 1 to the last; compare it with the random area.",
    )
    return Table("Orders as a whole", ("strategy", "APFD", "area", "random area", "last k"), rows, notes)


def _correlations(prediction: Prediction, sizes: tuple[int, ...]) -> Table:
    rows = tuple(
        (
            f"{one.strength}-way",
            *_at([*one.within], sizes, "{:.2f}"),
            "n/a" if one.pooled is None else f"{one.pooled:.2f}",
        )
        for one in prediction.correlations
    )
    notes = (
        "Kendall's tau-b of coverage and mutants killed over random suites of k situations.",
        "n/a: all suites of that size cover, or kill, the same number.",
        "Pooled over all sizes it measures the size of the suites: shown beside the others, not to be used.",
    )
    return Table("Coverage and kills within one size", ("coverage", *(f"k={k}" for k in sizes), "pooled"), rows, notes)


def _sizes(situations: int) -> tuple[int, ...]:
    return (*(k for k in SHOWN if k < situations), situations)


def _at(values: Iterable[float | None], sizes: tuple[int, ...], shape: str) -> list[str]:
    listed = list(values)
    return [
        "" if k > len(listed) else "n/a" if (value := listed[k - 1]) is None else shape.format(value) for k in sizes
    ]
