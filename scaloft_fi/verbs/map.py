"""`scaloft-fi map`: mine, bodies and route of one situation, without flying."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from scaloft_fi.console import say
from scaloft_fi.errors import InputError
from scaloft_fi.verbs.names import situations
from scaloft_fi.verbs.options import GridOfStudy, Option, StudyFolder, TableFormat, answer, check_writable, write
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, listing, number, optional, record, text, texts
from scaloft_fi.views.picture import png, scene_of
from scaloft_fi.views.plan import FloorPlan, Happens, draw_plan
from scaloft_fi.views.table import Table

if TYPE_CHECKING:
    from scaloft_fi.sim.happenings import Happening
    from scaloft_fi.sim.scenario import Scenario
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.study import Study


_X, _Y, _Z = number("east", "m"), number("north", "m"), number("height", "m")
MAP = Output(
    "map",
    "1.0",
    "what stands and happens in one situation, without flying it",
    {
        "situation": text("key of the situation"),
        "values": texts("the values of its axes, in words"),
        "nominal_s": number("time of the nominal flight", "s"),
        "limit_s": number("time limit of a flight", "s"),
        "mine": record(
            "the box around walls and floor",
            {
                f"{end}_{axis}_m": number(f"{word} of it, {way}", "m")
                for end, word in (("least", "lowest"), ("most", "highest"))
                for axis, way in (("x", "east"), ("y", "north"), ("z", "height"))
            },
        ),
        "places": listing(
            "home, then the waypoints in order; it lands at the last one",
            record("a place", {"place": text("its name"), "x_m": _X, "y_m": _Y, "z_m": _Z}),
        ),
        "bodies": listing(
            "the bodies that are there",
            record("a body", {"body": text("its name"), "role": text("its role"), "x_m": _X, "y_m": _Y, "z_m": _Z}),
        ),
        "happenings": listing(
            "what happens",
            record(
                "a happening",
                {
                    "happening": text("its name"),
                    "moves": text("the body that it moves; empty for none"),
                    "at_s": number("earliest time", "s"),
                    "near_x_m": optional(number("east of the place that starts it", "m"), "a time starts it"),
                    "near_y_m": optional(number("north of the place that starts it", "m"), "a time starts it"),
                    "within_m": number("distance from that place", "m"),
                    "lasts_s": optional(number("how long it lasts", "s"), "to the end"),
                },
            ),
        ),
    },
    rows="places",
)
"""The form of `map --format json`."""


def plan_of(study: Study, situation: Situation) -> FloorPlan:
    """The plan of a situation.

    Raises:
        InputError: the values of the situation contradict each other.
    """
    scenario = study.scenario(situation)
    world = scenario.world
    places = tuple((name, world.waypoints[name][:2]) for name in world.mission.route)
    happenings = tuple(_happens(one) for one in world.happenings)
    mission = world.mission
    speeds = f"cruise {mission.cruise_mps:g} m/s, near a person {mission.slow_mps:g} m/s"
    facts = (
        f"altitude {mission.altitude_m:g} m, {speeds}, light {world.light:g}",
        f"nominal flight {scenario.nominal_s:.0f} s, time limit {scenario.t_max_s:.0f} s",
    )
    return FloorPlan(scene_of(world), places, happenings, facts)


def _happens(one: Happening) -> Happens:
    start = one.start
    when = f"near ({start.near[0]:g}, {start.near[1]:g}) within {start.within_m:g} m" if start.near else ""
    if start.at_s or not when:
        when = (
            f"{when}, not before {start.at_s:g} s"
            if when
            else f"at {start.at_s:g} s"
            if start.at_s
            else "from take-off"
        )
    lasts = f", for {one.lasts_s:g} s" if math.isfinite(one.lasts_s) else ""
    moves = f", moves {one.effect.moved}" if one.effect.moved else ""
    return Happens(f"{one.name}: {when}{lasts}{moves}", start.near, start.within_m)


def map_values(study: Study, situation: Situation) -> dict[str, Any]:
    """The plain JSON values of the form `MAP`."""
    scenario = study.scenario(situation)
    world = scenario.world
    return {
        "situation": situation.key,
        "values": list(study.grid.titles(situation)),
        "nominal_s": scenario.nominal_s,
        "limit_s": scenario.t_max_s,
        "mine": {
            f"{end}_{axis}_m": value
            for end, corner in zip(("least", "most"), world.mine.extents.tolist(), strict=True)
            for axis, value in zip("xyz", corner, strict=True)
        },
        "places": [{"place": name, "x_m": x, "y_m": y, "z_m": z} for name, (x, y, z) in _stops(scenario)],
        "bodies": [
            dict(zip(("body", "role", "x_m", "y_m", "z_m"), (body.name, body.role, *body.centre), strict=True))
            for body in world.present
        ],
        "happenings": [
            {
                "happening": one.name,
                "moves": one.effect.moved,
                "at_s": one.start.at_s,
                "near_x_m": one.start.near[0] if one.start.near else None,
                "near_y_m": one.start.near[1] if one.start.near else None,
                "within_m": one.start.within_m,
                "lasts_s": one.lasts_s if math.isfinite(one.lasts_s) else None,
            }
            for one in world.happenings
        ],
    }


def map_table(study: Study, situation: Situation) -> Table:
    """The facts of a situation in words."""
    scenario = study.scenario(situation)
    world = scenario.world
    legs = ", ".join(f"{name} ({x:g}, {y:g}, {z:g})" for name, (x, y, z) in _stops(scenario))
    bodies = ", ".join(
        f"{body.name} ({body.role}) at ({body.centre[0]:g}, {body.centre[1]:g})" for body in world.present
    )
    plan = plan_of(study, situation)
    rows = [
        ("situation", ", ".join(study.grid.titles(situation))),
        ("mine [m]", world.mine.extents_text),
        ("route [m]", legs),
        ("bodies [m]", bodies or "none"),
        *(("happens", happens.words) for happens in plan.happenings),
        *(("", fact) for fact in plan.facts),
    ]
    return Table(situation.key, ("what", ""), tuple(rows))


def _stops(scenario: Scenario) -> list[tuple[str, tuple[float, float, float]]]:
    world = scenario.world
    return [("home", world.waypoints["home"]), *((name, world.waypoints[name]) for name in world.mission.route)]


PICTURES = (".svg", ".png")


@verb(
    "map",
    examples=(
        ("Tell what stands and happens in the benign situation", "scaloft-fi map"),
        ("Draw a situation with a corner and a person", "scaloft-fi map T1O0W0D0H1 --output map.svg"),
        ("Draw a situation of the grid `wide`", "scaloft-fi map --grid wide --output map.png"),
    ),
)
def map_command(
    *,
    situation: Annotated[str | None, Option("", "", complete=situations)] = None,
    study_folder: StudyFolder,
    grid: GridOfStudy,
    output: Annotated[
        Path | None,
        Option(
            "Draw the map: mine, bodies, route, waypoints and happenings with their names and a scale (.svg, .png).",
            metavar="FILE",
        ),
    ],
    style: TableFormat,
) -> None:
    """Show mine, bodies, route and happenings of one situation, without flying it.

    SITUATION is a key or another name of it; by default every axis has its benign value.
    """
    if output is not None and output.suffix.lower() not in PICTURES:
        raise InputError(f"--output={str(output)!r} must end in .svg or .png")
    check_writable(output)
    from scaloft_fi.study import Study

    study = Study.open(study_folder, grid)
    one = study.grid.situation(situation) if situation else study.grid.situations[0]
    answer(Answer(MAP, lambda: map_values(study, one), lambda: (map_table(study, one),)), style)
    if output is not None:
        drawn = draw_plan(plan_of(study, one), title=one.key, subtitle=", ".join(study.grid.titles(one)))
        write(output, png(drawn) if output.suffix.lower() == ".png" else drawn.encode())
        say(f"map: {output}")
