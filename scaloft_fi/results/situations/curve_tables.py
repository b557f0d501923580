"""Coverage against kills as tables and as plain JSON values."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from scaloft_fi.results.situations.curves import Band, Curve, Curves
from scaloft_fi.results.situations.prediction import Prediction
from scaloft_fi.results.telling.table import Table

SHOWN = (1, 2, 4, 6, 8, 10, 12, 16, 24, 32)
"""Sizes k in the tables; JSON has all."""


def curves_json(found: Curves, prediction: Prediction) -> dict[str, Any]:
    """All points of all curves.  Lists over k begin with k = 1; a strategy's lists may be shorter than `situations`.

    `strategies[].kills`, `.difference` and `spread` are {mean, low, high}; `difference` (to random order, at equal k,
    paired) is null for random order itself; `distinct` is the same where mutants with equal kill sets count once;
    `t_way` has a list of shares for each strength.
    """
    trial = found.trial
    return {
        "mutants": len(trial.mutants),
        "killed": int(trial.kills.any(axis=1).sum()),
        "kill_sets": len(trial.kill_sets),
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
    answer = Table(
        "Coverage against kills",
        ("finding",),
        tuple((sentence,) for sentence in prediction.answer),
        ("Of this campaign's grid and mutants only; intervals are over mutants, the situations are all there are.",)
        if len(trial.situations) == len(trial.space.points)
        else ("Of this campaign's mutants and the situations flown only; intervals are over mutants.",),
    )
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
    differences = Table(
        "Killed more than by k random situations",
        ("strategy", *(f"k={k}" for k in sizes)),
        tuple((curve.name, *_between(curve.difference, sizes)) for curve in found.curves if curve.difference),
        ("In brackets 95 % intervals over mutants, resampled within their parameter, paired; the situations stand.",),
    )
    return (answer, kills, differences, _coverage(found, sizes), _orders(found), _correlations(prediction, sizes))


def _coverage(found: Curves, sizes: tuple[int, ...]) -> Table:
    rows = [
        (curve.name, f"{strength}-way", *_at([100 * share for share in shares], sizes, "{:.1f}"))
        for curve in found.curves
        for strength, shares in curve.t_way
    ]
    headers = ("strategy", "combinations", *(f"k={k}" for k in sizes))
    return Table("Combinations covered by k situations [%]", headers, tuple(rows))


def _orders(found: Curves) -> Table:
    never = int((~found.trial.kills.any(axis=1)).sum())
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
        f"APFD (average percentage of faults detected) leaves out the {never} mutants that no situation kills.",
        "It has a value for orders of all situations only.",
        "Area: mean share of all mutants killed at k = 1 to the last; compare it with random order over the same k.",
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
        "Kendall's tau-b over random suites of k situations; n/a where all of them cover, or kill, the same number.",
        "Pooled over all sizes it measures the size of the suites: it is shown beside the others, not to be used.",
    )
    return Table("Coverage and kills within one size", ("coverage", *(f"k={k}" for k in sizes), "pooled"), rows, notes)


def _sizes(situations: int) -> tuple[int, ...]:
    return (*(k for k in SHOWN if k < situations), situations)


def _at(values: Iterable[float | None], sizes: tuple[int, ...], shape: str) -> list[str]:
    listed = list(values)
    return [
        "" if k > len(listed) else "n/a" if (value := listed[k - 1]) is None else shape.format(value) for k in sizes
    ]


def _between(band: Band | None, sizes: tuple[int, ...]) -> list[str]:
    if band is None:
        return [""] * len(sizes)
    return [
        f"{band.mean[k - 1]:+z.1f} [{band.low[k - 1]:+z.1f}, {band.high[k - 1]:+z.1f}]" if k <= len(band.mean) else ""
        for k in sizes
    ]
