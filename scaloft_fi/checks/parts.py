"""Each part of a study: its matrix, its requirements, world, vehicle and sensors; whether the vehicle fits its route.

The hull is an upright disc that holds it in every heading, and one that every heading fills; both as high as the hull.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from scaloft_fi.checks import Finding, Findings, Severity, finding_of
from scaloft_fi.document import Item, is_there, load
from scaloft_fi.errors import InputError, did_you_mean, refused
from scaloft_fi.hazop import matrix as matrices
from scaloft_fi.hazop.load import SHEETS, load_guidewords, load_parameters, misnamed_cells, misnamed_sheets, read_cell
from scaloft_fi.judge import requirement as bounds
from scaloft_fi.judge.stl import Formula, inside_always, tokenize
from scaloft_fi.model import read
from scaloft_fi.mutants.catalogue import derive
from scaloft_fi.sim.happenings import misfits
from scaloft_fi.sim.load import Scenario
from scaloft_fi.sim.mesh import COST, MANY_TRIANGLES, Array, hull, stated
from scaloft_fi.sim.mine import UNITS_M, Corner, Mine, flaws_of, read_mine
from scaloft_fi.sim.sensors import read_sensors
from scaloft_fi.sim.vehicle import Vehicle
from scaloft_fi.sim.world import GROUND, WALL, Body, Point, World, assembled, misplaced
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.study import Study

USUAL_M = 3.0
"""A usual height of a drift, by which a unit is guessed [m]."""
MOST_TIMES, LEAST_WAY_M = 10.0, 10.0
"""A mesh more than this many times as large, in every direction, as the way is long, or as this [m], is told of."""


def check_world(path: Path, findings: Findings) -> World | None:
    """Read a world; None where it cannot be read.

    Args:
        path: `sim/world.yaml`.
        findings: takes the findings.
    """
    mine: Mine | None = None
    with findings.collecting():
        document = load(path)
        if (rock := document.mapping().get("mine")) is not None:
            with findings.collecting():
                check_mesh(rock, findings)
                mine = read_mine(rock)
                if (named := rock.get("mesh")) is not None:
                    check_reading(named, rock, mine, findings)
        world = assembled(document, mine)
        if findings.all_of(misplaced(world, document)):
            check_size(world, document, findings)
            if findings.all_of(misfits(world)):
                return world
    return None


def check_mesh(mine: Item, findings: Findings) -> None:
    """The flaws of the mesh of a mine; the flaws that may be harmless are notes.

    Raises:
        InputError: the mesh cannot be read.
    """
    for flaw in flaws_of(mine):
        findings.add(finding_of(str(flaw), Severity.ERROR if flaw.grave else Severity.NOTE))


def check_reading(mesh: Item, mine: Item, rock: Mine, findings: Findings) -> None:
    """A note for unit and axis of a mesh where they are not stated, and for a mesh that costs time."""
    path = mesh.path.parent / str(mesh.value)
    said, told = stated(path), []
    if mine.get("up") is None:
        told.append(f"{said.up or 'z'} of the file is up, {'as the file says' if said.up else 'by default'}")
    if mine.get("scale_m") is None:
        told.append(f"its unit is {said.unit_m or 1:g} m, {'as the file says' if said.unit_m else 'by default'}")
    count = len(rock.wall.faces) + len(rock.ground.faces)
    if count > MANY_TRIANGLES:
        findings.note(mesh.place, f"the mesh has {count:,} triangles; {COST}", "`decimate_to: 50000` makes fewer")
    if told:
        keys = " and ".join(f"`{key}`" for key in ("up", "scale_m") if mine.get(key) is None)
        remedy = f"state {keys} beside `mesh` where that is wrong"
        findings.note(mesh.place, f"{', and '.join(told)}, so the mine is {rock.size_text()}", remedy)


def check_size(world: World, item: Item, findings: Findings) -> None:
    """A note for a mesh so large beside the route that it may be in another unit."""
    mesh = item.need("mine").get("mesh")
    if mesh is None:
        return
    low, high = world.mine.extents
    places = [place[:2] for place in world.waypoints.values()]
    way_m = max(math.dist(one, other) for one in places for other in places)
    if min(high - low) > MOST_TIMES * max(way_m, LEAST_WAY_M):
        mine, edges = world.mine.extents_text, high - low
        smaller = [(name, one) for name, one in UNITS_M.items() if one < 1.0]
        unit, factor = min(smaller, key=lambda one: abs(math.log(one[1] * min(edges) / USUAL_M)))
        findings.note(
            mesh.place,
            f"the mine reaches from {mine} m, and no two waypoints are more than {way_m:.3g} m apart",
            f"`scale_m` is metres per unit of the file: with {factor:g} ({unit}) it is {world.mine.size_text(factor)}",
        )


def check_vehicle(folder: Path, findings: Findings) -> None:
    """Vehicle and sensors, each on its own."""
    with findings.collecting():
        read(Vehicle, load(folder / "vehicle.yaml"))
    with findings.collecting():
        read_sensors(load(folder / "sensors.yaml"))


MOST_PIECES = 50
"""Pieces of a leg that climbs; each piece is as high as it climbs."""
SLACK_M = 0.02
"""A gap is smaller than a radius if it is smaller by this [m]: walls are rough."""


@dataclass
class RouteCheck:
    """Looks at the routes of the situations of a grid, at each place once.

    Attributes:
        findings: takes the findings.
        looked_at: number of places and legs so far.
    """

    findings: Findings
    looked_at: int = 0
    _seen: set[object] = field(default_factory=set)

    def check(self, scenario: Scenario, document: Item) -> None:
        """Compare the hull with everything that stands around the route of a situation.

        Args:
            scenario: the scenario of the situation.
            document: its `world.yaml`, with the changes of the situation.
        """
        world, hull_m = scenario.world, scenario.vehicle.hull_m
        names = ["home", *world.mission.route]
        for name in dict.fromkeys(names):
            home = name == "home"
            item = document.need("mission").need("home") if home else document.need("waypoints").need(name)
            told = "home" if home else f"waypoint {name!r}"
            self._look(scenario, [world.waypoints[name]], hull_m, item, told)
            if home or name == names[-1]:
                x, y, z = world.waypoints[name]
                foot = (x, y, world.mine.floor_m(x, y) + 0.5 * hull_m[2] + SLACK_M)
                if math.isfinite(foot[2]):
                    self._look(scenario, [foot, (x, y, z)], hull_m, item, f"the way down to {name!r}", ground=False)
        for start, end in pairwise(names):
            ends = sorted((world.waypoints[start], world.waypoints[end]))
            if ends[0] != ends[1]:
                self._leg(scenario, ends, hull_m, document, f"the straight leg from {start!r} to {end!r}")

        self._bodies(scenario, document)

    def _bodies(self, scenario: Scenario, document: Item) -> None:
        """Note each body that reaches into rock or another body where it stands, or on its way."""
        world = scenario.world
        paths = {body.name: world.path_of(body) for body in world.present}
        if not self._is_new(world, sorted(paths.items())):
            return
        for body in world.present:
            place = document.need("bodies").need(body.name).place
            if not world.mine.holds(body.centre):
                remedy = "move it into the open space, unless the rock is meant to hold it"
                sentence = f"the centre of body {body.name!r} is in rock or outside"
                self.findings.note(place, sentence, remedy, situation=scenario.key)
            if body.name in (moved := {h.effect.moved: h for h in world.happenings}) and len(paths[body.name]) > 1:
                place = document.need("happenings").need(moved[body.name].name).place
            for name, depth_m, way in overlaps(world, body):
                walks = "" if way[0] == way[1] else f" on its way from {_text(way[0])} to {_text(way[1])}"
                sentence = f"body {body.name!r}{walks} reaches {depth_m:.2f} m into {name!r}"
                self.findings.note(place, sentence, "move one of them, or its path", situation=scenario.key)
            for name, depth_m in crossed_ways(world, body):
                sentence = (
                    f"the ways of bodies {body.name!r} and {name!r} overlap by {depth_m:.2f} m: they may meet there"
                )
                self.findings.note(
                    place, sentence, "move one of the paths, or let one start later", situation=scenario.key
                )

    def _look(
        self, scenario: Scenario, way: list[Point], hull_m: Point, item: Item, what: str, *, ground: bool = True
    ) -> None:
        """Refuse a place where the hull touches something in every heading; note one where it does in some."""
        if not self._is_new(scenario.world, way):
            return
        self.looked_at += 1
        inner_m, outer_m = 0.5 * min(hull_m[:2]), 0.5 * math.hypot(*hull_m[:2])
        for name, gap_m in gaps(scenario.world, way, 0.5 * hull_m[2], outer_m):
            if name == GROUND and not ground:
                continue
            size = f"the hull of {hull_m[0]:g} x {hull_m[1]:g} m"
            if gap_m < inner_m - SLACK_M:
                sentence = f"at {what} {size} touches {name!r}, which is {gap_m:.2f} m from its centre"
                self.findings.wrong(item.place, sentence, f"keep {outer_m:.2f} m from it", situation=scenario.key)
            elif gap_m < outer_m - SLACK_M:
                sentence = f"at {what} {size} touches {name!r} in some headings, {gap_m:.2f} m from its centre"
                self.findings.note(item.place, sentence, f"keep {outer_m:.2f} m from it", situation=scenario.key)

    def _leg(self, scenario: Scenario, ends: list[Point], hull_m: Point, document: Item, what: str) -> None:
        """Note a leg on which the hull touches rock; bodies beside a leg are there to be met."""
        if not self._is_new(scenario.world, ends):
            return
        self.looked_at += 1
        inner_m = 0.5 * min(hull_m[:2])
        place = document.need("mission").need("route").place
        for name, gap_m in gaps(scenario.world, ends, 0.5 * hull_m[2], inner_m):
            if gap_m < inner_m - SLACK_M and name in (WALL, GROUND):
                sentence = f"on {what} the hull touches {name!r}, {gap_m:.2f} m from the leg"
                remedy = "add a waypoint: the time limit of a flight follows from straight legs"
                self.findings.note(place, sentence, remedy, situation=scenario.key)

    def _is_new(self, world: World, way: Sequence[object]) -> bool:
        bodies = tuple((body.name, body.mesh.vertices.tobytes()) for body in world.present)
        key = (id(world.mine), tuple(way), bodies)
        if key in self._seen:
            return False
        self._seen.add(key)
        return True


def gaps(world: World, way: list[Point], half_height_m: float, within_m: float) -> Iterator[tuple[str, float]]:
    """The level distance of a way from everything that comes nearer than `within_m` [m], by name.

    Args:
        world: the world.
        way: one point, or two ends of a straight line (3,) [m, world].
        half_height_m: only what is at most this much higher or lower than the way counts [m].
        within_m: greatest distance [m].
    """
    start, end = np.array(way[0]), np.array(way[-1])
    climb_m = abs(float(end[2] - start[2]))
    upright = math.dist(start[:2], end[:2]) == 0.0
    pieces = 1 if upright else min(MOST_PIECES, 1 + math.ceil(climb_m / (2.0 * half_height_m)))
    knots = start + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (end - start)
    parts = {WALL: world.mine.wall, GROUND: world.mine.ground} | {body.name: body.mesh for body in world.present}
    for name, mesh in parts.items():
        gap_m = min(_gap(mesh.triangles, one, other, half_height_m, within_m) for one, other in pairwise(knots))
        if gap_m < within_m:
            yield name, gap_m


def _gap(triangles: Array, start: Array, end: Array, half_height_m: float, within_m: float) -> float:
    """The level distance of a segment from the triangles beside it; infinite where none is within `within_m` [m]."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    reach = np.array([within_m, within_m, half_height_m])
    near = ((triangles.min(axis=1) <= high + reach) & (triangles.max(axis=1) >= low - reach)).all(axis=1)
    floor_m, roof_m = float(low[2]) - half_height_m, float(high[2]) + half_height_m
    a, b, least = complex(*start[:2]), complex(*end[:2]), math.inf
    for triangle in triangles[near].tolist():
        corners = [complex(x, y) for x, y, _ in _cut(_cut(triangle, floor_m, 1.0), -roof_m, -1.0)]
        sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
        if sides and (all(_side(p, q, a) > 0.0 for p, q in sides) or all(_side(p, q, a) < 0.0 for p, q in sides)):
            return 0.0  # the outline is convex, and has the point inside
        least = min([least, *(_apart(a, b, p, q) for p, q in sides)])
    return least


def overlaps(world: World, body: Body) -> Iterator[tuple[str, float, tuple[Corner, Corner]]]:
    """What a body reaches into by more than `SLACK_M` where it stands and on its way: name, depth [m], leg of its way.

    Seen from above, what the body sweeps is the hull of its outlines at both ends of a leg.  A body that another one
    carries, or that stands on the floor, reaches into nothing: what lies above or below does not count.
    """
    low, high = _heights(body)
    parts = {WALL: world.mine.wall, GROUND: world.mine.ground}
    parts |= {other.name: other.mesh for other in world.present if other is not body}
    start, *stops = world.path_of(body) or (body.centre[:2],)
    legs = list(pairwise([start, start, *stops]))
    for name, part in parts.items():
        if not stops and name in world.bodies and (name > body.name or len(world.path_of(world.bodies[name])) > 1):
            continue  # the other one tells of both
        triangles = part.triangles
        for one, other in legs:
            swept = _swept(body, start, one, other)
            floor, roof = np.append(swept.min(axis=0), low), np.append(swept.max(axis=0), high)
            near = triangles[((triangles.min(axis=1) <= roof) & (triangles.max(axis=1) >= floor)).all(axis=1)]
            corners = _outline(swept)
            cuts = (_cut(_cut(triangle, low, 1.0), -high, -1.0) for triangle in near.tolist())
            depth_m = max((depth(corners, np.array(cut)[:, :2]) for cut in cuts if len(cut) > 1), default=0.0)
            if depth_m > SLACK_M:
                yield name, depth_m, (one, other)
                break


def crossed_ways(world: World, body: Body) -> Iterator[tuple[str, float]]:
    """Each other body that moves and whose way crosses that of `body` at a height of both: name, and by how far [m].

    When they are there does not count: a drone that holds one of them up changes that.
    """
    low, high = _heights(body)
    legs = list(pairwise(world.path_of(body)))
    for other in world.present if legs else ():
        (floor, roof), others = _heights(other), list(pairwise(world.path_of(other)))
        if not others or other.name <= body.name or floor >= high or roof <= low:
            continue
        mine = [_outline(_swept(body, legs[0][0], *leg)) for leg in legs]
        theirs = [_outline(_swept(other, others[0][0], *leg)) for leg in others]
        depth_m = max(depth(one, two) for one in mine for two in theirs)
        if depth_m > SLACK_M:
            yield other.name, depth_m


def _heights(body: Body) -> tuple[float, float]:
    """Foot and top of a body, without a little of each [m]."""
    heights_m = body.mesh.vertices[:, 2]
    less_m = min(SLACK_M, 0.25 * float(np.ptp(heights_m)))
    return float(heights_m.min()) + less_m, float(heights_m.max()) - less_m


def _swept(body: Body, start: Corner, one: Corner, other: Corner) -> Array:
    """Corners (N, 2) of a body at both ends of a leg of its way, which begins at `start` [m]."""
    return np.concatenate([body.mesh.vertices[:, :2] + np.subtract(end, start) for end in (one, other)])


def _outline(points: Array) -> Array:
    return np.array(hull(list(map(tuple, points.tolist()))))


def depth(one: Array, other: Array) -> float:
    """How far two convex outlines (N, 2) overlap [m]: the least shift that parts them; at most 0 where none is needed.

    Only directions across a side of either count (separating axes, Gottschalk et al. 1996).
    """
    sides = np.concatenate([np.roll(one, -1, axis=0) - one, np.roll(other, -1, axis=0) - other])
    lengths = np.hypot(*sides.T)
    across = np.stack([-sides[:, 1], sides[:, 0]])[:, lengths > 0.0] / lengths[lengths > 0.0]
    first, second = one @ across, other @ across
    shifts = np.minimum(first.max(axis=0) - second.min(axis=0), second.max(axis=0) - first.min(axis=0))
    return float(shifts.min())


def _text(place: Corner) -> str:
    return f"({place[0]:g}, {place[1]:g})"


def _cut(outline: list[list[float]], least: float, sign: float) -> list[list[float]]:
    """The part of a polygon whose height times `sign` is at least `least` (Sutherland and Hodgman 1974)."""
    kept: list[list[float]] = []
    for p, q in zip(outline, outline[1:] + outline[:1], strict=True):
        above_p, above_q = sign * p[2] - least, sign * q[2] - least
        if above_p >= 0.0:
            kept.append(p)
        if (above_p > 0.0 > above_q) or (above_p < 0.0 < above_q):
            share = above_p / (above_p - above_q)
            kept.append([x + share * (y - x) for x, y in zip(p, q, strict=True)])
    return kept


def _apart(a: complex, b: complex, c: complex, d: complex) -> float:
    """Distance of the segments a-b and c-d in the plane, whose points are x + iy."""
    if _side(a, b, c) * _side(a, b, d) < 0.0 and _side(c, d, a) * _side(c, d, b) < 0.0:
        return 0.0
    return min(_from(a, c, d), _from(b, c, d), _from(c, a, b), _from(d, a, b))


def _from(point: complex, a: complex, b: complex) -> float:
    """Distance of a point from the segment a-b."""
    way, out = b - a, point - a
    share = (out * way.conjugate()).real / abs(way) ** 2 if way else 0.0
    return abs(out - min(max(share, 0.0), 1.0) * way)


def _side(a: complex, b: complex, c: complex) -> float:
    """Above 0 where c is left of the way from a to b, below 0 where it is right of it."""
    return ((b - a).conjugate() * (c - a)).imag


@dataclass(frozen=True)
class KnownSignals:
    """The signals of a study.

    Attributes:
        ranges: what each can read, by name.
        caps: the cap of each belief and optional signal that has one; None = not even the simulator's signals have any.
    """

    ranges: bounds.Ranges
    caps: Mapping[str, float] | None = field(default_factory=dict)

    @property
    def check(self) -> bounds.Check:
        """The check of a formula: thresholds within caps, and the grammar."""
        return Formula.parse if self.caps is None else bounds.within_caps(Formula.parse, self.caps)


def kinds_in(path: Path) -> Mapping[str, str]:
    """The kind of each requirement by name, as it stands in the file; empty for a file that cannot be read so far."""
    try:
        entries = load(path).need("requirements").mapping()
        return {name: str(kind.value) if (kind := item.get("kind")) else "" for name, item in entries.items()}
    except InputError:
        return {}


def check_requirements(path: Path, known: KnownSignals, findings: Findings) -> int:
    """Read every definition and requirement; returns how many requirements there are.

    Args:
        path: `sim/requirements.yaml`.
        known: the signals.
        findings: takes the findings.
    """
    made: list[bounds.Requirement] = []
    entries: Mapping[str, Item] = {}
    with findings.collecting():
        document = load(path)
        definitions = document.get("definitions")
        ranges, texts = dict(known.ranges), dict[str, str]()
        for name, item in (definitions.mapping(most=bounds.MOST) if definitions else {}).items():
            with findings.collecting():
                texts[name] = bounds.read_definition(name, item, set(ranges), known.check)
                formula = Formula.parse(texts[name], set(ranges))
                _tell_constants(formula, ranges, item.place, f"definition {name!r}", findings)
                ranges[name] = bounds.bounds_of(formula, ranges)
            ranges.setdefault(name, bounds.ANY)  # its name is known, whatever it says
        entries = document.need("requirements").mapping(most=bounds.MOST)
        for item in entries.values():
            with findings.collecting():
                made.append(bounds.read_requirement(item, texts, set(ranges), known.check))
                _check_bounds(made[-1], item, ranges, findings)
        read(bounds.RequirementsModel, document)
        if len(made) == len(entries) and not any(one.kind is bounds.Kind.SAFETY for one in made):
            what = "no requirement is of kind safety, so no mutant can be detected"
            findings.wrong(document.need("requirements").place, what, "give one of them `kind: safety`")
    return len(entries)


def _check_bounds(
    requirement: bounds.Requirement, item: Item, ranges: Mapping[str, bounds.Spans], findings: Findings
) -> None:
    known = dict(ranges)
    trigger = item.get("trigger")
    if trigger is not None:
        formula = Formula.parse(requirement.trigger, set(known))
        known[bounds.TRIGGER] = bounds.bounds_of(formula, known)
        always = bounds.verdict(known[bounds.TRIGGER])
        if always is False:
            what = f"the trigger of {requirement.name} comes true in no flight, so the requirement is vacuous in all"
            findings.wrong(trigger.place, what, _reads(formula, known))
            return
        if always:
            what = f"the trigger of {requirement.name} is true at every sample of every flight"
            findings.note(trigger.place, what, "leave it out, or mend it")
        else:
            _tell_constants(formula, known, trigger.place, f"trigger of {requirement.name}", findings)
    body = inside_always(requirement.text)
    assert body is not None
    formula = Formula.parse(body, set(known))
    always, place = bounds.verdict(bounds.bounds_of(formula, known)), item.need("formula").place
    if always is not None:
        what = f"{requirement.name} is {'held' if always else 'violated'} by every flight, whatever the drone does"
        findings.wrong(place, what, _reads(formula, known))
    else:
        _tell_constants(formula, known, place, f"formula of {requirement.name}", findings)


def check_predicate(
    text: str, place: str, name: str, known: KnownSignals, passing: Collection[str], findings: Findings
) -> None:
    """Check the formula `realised` of a value.

    Args:
        text: the formula.
        place: where it stands.
        name: name of the value.
        known: the signals that every flight records.
        passing: names of the signals that only some flights record.
        findings: takes the findings.

    Raises:
        FormulaError: it is no formula over the signals, or compares one beyond its cap.
    """
    ranges = {**dict.fromkeys(passing, bounds.ANY), **known.ranges}
    formula = known.check(text, set(ranges))
    always = bounds.verdict(bounds.bounds_of(formula, ranges))
    if always is not None:
        what = f"realised of {name} comes true in {'every' if always else 'no'} flight: {text}"
        findings.wrong(place, what, _reads(formula, ranges))
    else:
        _tell_constants(formula, ranges, place, f"realised of {name}", findings)


def _tell_constants(formula: Formula, ranges: bounds.Ranges, place: str, about: str, findings: Findings) -> None:
    for comparison, true in bounds.constants(formula, ranges):
        what = f"'{comparison}' in the {about} is {str(true).lower()} at every sample of every flight"
        findings.note(place, what, _reads(formula, ranges, tokenize(comparison)))


def _reads(formula: Formula, ranges: Mapping[str, bounds.Spans], words: Collection[str] = ()) -> str:
    """What the signals of a formula can read, as advice."""
    names = [name for name in formula.names if not words or name in " ".join(words)]
    spans = [f"{name} {' or '.join(_span(*span) for span in ranges[name])}" for name in names if name in ranges]
    return f"compare with what can be measured: {', '.join(spans)}"


def _span(low: float, high: float) -> str:
    return f"is {low:g}" if low == high else f"is {low:g} to {high:g}".replace("-inf to inf", "any number")


NAMED = 5
"""Seams or cells that a note names."""


@dataclass(frozen=True)
class MatrixCheck:
    """What was read of the matrix.

    Attributes:
        cells: the cells that can be read.
        mutants: number of mutants that the matrix derives; None where it cannot.
        matrix: the whole matrix; None where a part of it cannot be read.
    """

    cells: tuple[matrices.Cell, ...] = ()
    mutants: int | None = None
    matrix: matrices.Matrix | None = None


def check_matrix(study: Study, stack: Declaration | None, kinds: Mapping[str, str], findings: Findings) -> MatrixCheck:
    """Read the matrix, and hold it against stack and requirements.

    Args:
        study: the study.
        stack: declaration of its stack; None where it cannot be read, which leaves seams and operators unchecked.
        kinds: kind of each requirement by name; empty where they cannot be read.
        findings: takes the findings.
    """
    before, hazop = findings.errors, study.folder / "hazop"
    words: tuple[matrices.Guideword, ...] = ()
    parameters: tuple[matrices.Parameter, ...] = ()
    places: dict[str, str] = {}
    with findings.collecting():
        path = hazop / "guidewords.yaml"
        words = tuple(matrices.Guideword(name, name, "") for name in load(path).mapping())  # where one of them is wrong
        words = load_guidewords(path)
    with findings.collecting():
        path = hazop / "parameters.yaml"
        places = {name: item.place for name, item in load(path).mapping().items()}
        parameters = tuple(matrices.Parameter(name, name, "", "", "") for name in places)
        parameters, places = load_parameters(path)
    classes: tuple[matrices.SeverityClass, ...] = ()
    with findings.collecting():
        path = hazop / matrices.SEVERITIES
        names = load(path).mapping() if is_there(path) else {}
        classes = tuple(matrices.SeverityClass(rank, name, name, "") for rank, name in enumerate(names))
        classes = matrices.load_severities(path)
    if not words or not parameters:
        return MatrixCheck()
    findings.all_of(misnamed_sheets(hazop / SHEETS, places))
    read = [pair for one in parameters for pair in _cells(study, one, words, stack, classes, findings)]
    cells = [cell for cell, _ in read]
    for cell in cells:
        _check_requirements(cell, kinds, findings)
        _check_ladders(cell, findings)
        if stack is not None:
            _check_faults(cell, words, parameters, findings)
    whole = findings.errors == before
    if whole or len(cells) == len(words) * len(parameters):
        _check_controls(study, cells, stack, findings)
        _check_seams(study, cells, stack, findings)
        _check_severities(study, classes, read, findings)
    if not whole or stack is None:
        return MatrixCheck(tuple(cells))
    matrix: matrices.Matrix | None = None
    mutants: int | None = None
    with findings.collecting():
        matrix = study.matrix
        mutants = len(derive(matrix))
        _ = study.catalogue  # reading it compares it with the matrix
    with findings.collecting():
        _ = study.alpha
    return MatrixCheck(tuple(cells), mutants, matrix)


def _cells(
    study: Study,
    parameter: matrices.Parameter,
    words: Iterable[matrices.Guideword],
    stack: Declaration | None,
    classes: tuple[matrices.SeverityClass, ...],
    findings: Findings,
) -> Iterator[tuple[matrices.Cell, matrices.SeverityClass | None]]:
    path, ids = study.folder / "hazop" / SHEETS / f"{parameter.id}.yaml", [word.id for word in words]
    if not is_there(path):
        return
    with findings.collecting():
        sheet, seams = load(path), stack.by_name if stack else None
        if not findings.all_of(misnamed_cells(sheet, ids)):
            ids = [word for word in ids if word in sheet.mapping()]  # a blank cell may be the one that is misnamed
        yield from findings.each(lambda word: read_cell(sheet, word, parameter.id, seams, classes), ids)


def _check_requirements(cell: matrices.Cell, kinds: Mapping[str, str], findings: Findings) -> None:
    for name in cell.requirements if kinds else ():
        if name not in kinds:
            hint = did_you_mean(name, kinds).removeprefix("; ")
            findings.wrong(cell.requirements_place, f"{name!r} of {cell.name} is no requirement", hint)
    deciding = [name for name in cell.requirements if kinds.get(name, "safety") != "reported"]
    if cell.status is matrices.CellStatus.CONTROL and not deciding:
        findings.wrong(
            cell.requirements_place,
            f"the control {cell.name} names no requirement of kind safety or operability, so it can never show itself",
            "name the requirement that its fault must violate",
        )


def _check_ladders(cell: matrices.Cell, findings: Findings) -> None:
    for magnitude in (fault.magnitude for fault in cell.faults):
        if magnitude is not None and matrices.falls_unsaid(magnitude):
            what = f"the ladder of {cell.name} falls, so a smaller {magnitude.argument} counts as the stronger fault"
            findings.note(magnitude.place, what, "say `worse: smaller` if it is so, else turn the ladder round")


def _check_faults(
    cell: matrices.Cell,
    words: Iterable[matrices.Guideword],
    parameters: Iterable[matrices.Parameter],
    findings: Findings,
) -> None:
    """Derive the mutants of each fault alone: operator, seam, arguments and every magnitude must fit."""
    word = next(one for one in words if one.id == cell.guideword)
    parameter = next(one for one in parameters if one.id == cell.parameter)
    for fault in cell.faults:
        alone = {(cell.guideword, cell.parameter): replace(cell, faults=(fault,))}
        if error := refused(derive, matrices.Matrix((word,), (parameter,), alone)):
            found = finding_of(str(error))
            takes = f"`scaloft-fi operators {fault.operator}` shows what it takes"
            findings.add(replace(found, remedy=found.remedy or takes))


def _check_controls(
    study: Study, cells: Sequence[matrices.Cell], stack: Declaration | None, findings: Findings
) -> None:
    controls = [cell for cell in cells if cell.status is matrices.CellStatus.CONTROL]
    place = str(study.folder / "hazop" / SHEETS)
    if to_do := [cell.name for cell in cells if cell.status is matrices.CellStatus.TO_DO]:
        what = f"cells to do, without a mutant: {_some(to_do)}"
        remedy = "give each faults and requirements with status credible, or a reason with status not_meaningful"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy=remedy))
    if not controls:
        what = "no cell is a control, so no flight proves that faults reach the drone"
        remedy = "give a cell `status: control` whose fault no drone survives, such as velocity commands turned round"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy=remedy))
    elif stack and stack.canaries and not any(cell.faults[0].seam in stack.canaries for cell in controls):
        names = ", ".join(stack.canaries)
        what = f"no control strikes a seam that carries samples in every situation ({names})"
        remedy = "make a cell with a fault there a control, because `run --mutant` flies one control in one situation"
        findings.add(Finding(Severity.NOTE, place, None, what, remedy=remedy))


def _check_seams(study: Study, cells: Iterable[matrices.Cell], stack: Declaration | None, findings: Findings) -> None:
    used = {fault.seam for cell in cells for fault in cell.faults}
    seams = list(stack.by_name) if stack else []
    idle = [name for name in seams if name not in used]
    if idle:
        what = f"no cell of the matrix has a fault at {len(idle)} of the stack's {len(seams)} seams: {_some(idle)}"
        remedy = "ask the guidewords of what they carry, or leave them out on purpose; `scaloft-fi seams` counts cells"
        findings.add(Finding(Severity.NOTE, str(study.folder / "hazop" / SHEETS), None, what, remedy=remedy))


def _check_severities(
    study: Study,
    classes: Iterable[matrices.SeverityClass],
    read: Iterable[tuple[matrices.Cell, matrices.SeverityClass | None]],
    findings: Findings,
) -> None:
    """Name the credible cells without a class, where the study has classes."""
    lacking = [cell.name for cell, severity in read if cell.status is matrices.CellStatus.CREDIBLE and severity is None]
    names = [one.id for one in classes]
    if names and lacking:
        what = f"severity is missing in {len(lacking)} credible cells: {_some(lacking)}"
        remedy = (
            f"give each a class, `severity: {names[0]}` or another of {matrices.SEVERITIES}; without one it stands last"
        )
        findings.add(
            Finding(Severity.NOTE, str(study.folder / "hazop" / matrices.SEVERITIES), None, what, remedy=remedy)
        )


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
