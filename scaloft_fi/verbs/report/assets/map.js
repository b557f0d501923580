/* A situation from above: what stands there, the unmutated drone's path and the mutant's, or the route where nothing is flown. */
const PIXELS_PER_METRE = 52;
const HULL_M = 0.235;
const X = () => DATA.columns.findIndex((column) => column.name === "x_m");
const Y = () => DATA.columns.findIndex((column) => column.name === "y_m");

function mapOf(scene, flight, clean, marked = flight ? marks(flight) : []) {
  if (!scene) return null;
  const mine = DATA.scenes.mines[scene.mine];
  const paths = [clean, flight].filter((one) => one?.rows).map((one) => one.rows.map((row) => [row[X()], row[Y()]]));
  const points = [...mine.floor.flat(), ...mine.walls.flat(), scene.home, ...scene.waypoints, ...scene.bodies.flatMap(([, outline, path]) => [...outline, ...path]), ...paths.flat()];
  const box = [0, 1].map((axis) => {
    const values = points.map((point) => point[axis]).filter(Number.isFinite);
    return [Math.floor(2 * Math.min(...values) - 0.4) / 2, Math.ceil(2 * Math.max(...values) + 0.4) / 2];
  });
  const [width, height] = box.map(([from, to]) => (to - from) * PIXELS_PER_METRE);
  const sx = scale(box[0][0], box[0][1], 0, width);
  const sy = scale(box[1][0], box[1][1], height, 0);
  const at = (point) => [sx(point[0]), sy(point[1])];
  const closed = (outline) => `${pathOf(outline.map(at))}Z`;
  const metres = (axis) => ticks(box[axis][0], box[axis][1], box[axis][1] - box[axis][0]).filter(Number.isInteger);
  const cursors = [clean, flight].filter((one) => one?.rows?.length).map((one) => ({ one, node: s("circle", { class: one === clean && flight !== clean ? "hull of-clean" : "hull", r: HULL_M * PIXELS_PER_METRE, visibility: "hidden" }) }));
  /** Beside points, of which the outermost is cleared. */
  const label = (points, text, kind = "", gap = 14) => {
    const [xs, ys] = [0, 1].map((axis) => points.map((point) => at(point)[axis]));
    const left = Math.max(...xs) > 0.7 * width;
    const y = (Math.min(...ys) + Math.max(...ys)) / 2 + 5;
    return s("text", { class: `label ${kind}`, x: left ? Math.min(...xs) - gap : Math.max(...xs) + gap, y, "text-anchor": left ? "end" : "start" }, text);
  };
  const names = scene.bodies.map(([, , , name]) => name);
  const root = s("svg", { class: "map", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `Map of the ${flight ? "flight" : "situation"} from above, one metre a square: home, ${plural(scene.waypoints.length, "waypoint")}${names.length ? `, ${names.join(", ")}` : ""}${marked.map((mark) => `; ${mark.text} at (${mark.at.map((value) => trimmed(value, 1)).join(", ")}) m`).join("")}` },
    mine.floor.length > 0 && s("path", { class: "floor", d: mine.floor.map(closed).join("") }),
    mine.walls.map((wall) => s("path", { class: "wall", d: pathOf(wall.map(at)) })),
    metres(0).map((value) => s("line", { class: "metre", x1: sx(value), x2: sx(value), y1: 0, y2: height })),
    metres(1).map((value) => s("line", { class: "metre", x1: 0, x2: width, y1: sy(value), y2: sy(value) })),
    scene.bodies.filter(([, , path]) => path.length).map(([, , path]) => s("path", { class: "walked", d: pathOf(path.map(at)) })),
    scene.bodies.map(([kind, outline, , name]) => s("path", { class: ["obstacle", "person", "structure"].includes(kind) ? kind : "obstacle", d: closed(outline) }, s("title", {}, name))),
    scene.waypoints.map((point) => s("circle", { class: "waypoint", cx: at(point)[0], cy: at(point)[1], r: 9 })),
    s("rect", { class: "waypoint", x: at(scene.home)[0] - 10, y: at(scene.home)[1] - 10, width: 20, height: 20, rx: 4 }),
    !flight && s("path", { class: "route", d: pathOf([scene.home, ...scene.waypoints].map(at)) }),
    clean?.rows && clean !== flight && s("path", { class: "clean", d: pathOf(clean.rows.map((row) => at([row[X()], row[Y()]]))) }),
    flight?.rows && s("path", { class: "flown", d: pathOf(flight.rows.map((row) => at([row[X()], row[Y()]]))) }),
    scene.bodies.map(([, outline, , name]) => label(outline, name, "", 6)),
    numbered(scene).map(([point, text]) => label([point], text)),
    marked.filter((mark) => mark.kind === "violation").map((mark) => label([mark.at], mark.brief, "violated")),
    scaleBar(height),
    cursors.map((cursor) => cursor.node),
    marked.map((mark) => sign(mark, ...at(mark.at))));
  const move = (time) => cursors.forEach(({ one, node }) => {
    const row = rowAt(one.rows, time);
    node.setAttribute("visibility", row ? "visible" : "hidden");
    if (row) [["cx", sx(row[X()])], ["cy", sy(row[Y()])]].forEach(([name, value]) => node.setAttribute(name, value));
  });
  return { root, move };
}

/** Home and the waypoints with their numbers; one that is passed again has all of them. */
function numbered({ home, waypoints }) {
  const found = new Map([[String(home), [home, ["home"]]]]);
  waypoints.forEach((point, number) => {
    const entry = found.get(String(point)) ?? [point, []];
    found.set(String(point), entry);
    entry[1].push(`${number + 1}`);
  });
  return [...found.values()].map(([point, words]) => [point, words.join(", ")]);
}

/** How long a metre is. */
function scaleBar(height) {
  const [x, y] = [14, height - 14];
  return s("g", { class: "scale" },
    s("path", { d: `M${x},${y - 6}V${y}H${x + PIXELS_PER_METRE}V${y - 6}` }),
    s("text", { class: "label", x: x + PIXELS_PER_METRE + 8, y }, "1 m"));
}

/** The last row not later than a time; none before the first or after the last. */
function rowAt(rows, time) {
  if (!rows?.length || time > rows.at(-1)[0] + 0.1) return null;
  let low = 0;
  let high = rows.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (rows[middle][0] <= time + 1e-6) low = middle;
    else high = middle - 1;
  }
  return rows[low];
}

/** What is marked on map and charts: when the fault first changed a sample, the violations, the end. */
function marks(flight) {
  const found = [];
  const where = (time) => { const row = rowAt(flight.rows, time); return row && [row[X()], row[Y()]]; };
  if (flight.infected_at_s !== null && where(flight.infected_at_s)) found.push({ kind: "infection", t: flight.infected_at_s, at: where(flight.infected_at_s), text: "first changed sample" });
  for (const [requirement, t, x, y, , struck] of flight.violations) {
    if (DATA.requirements.find((one) => one.name === requirement)?.kind === "reported") continue;
    found.push({ kind: "violation", t, at: [x, y], text: `${requirement} violated${struck ? `, strikes ${struck}` : ""}`, brief: `${requirement}, ${seconds(t)}` });
  }
  const last = flight.rows?.at(-1);
  if (last) found.push({ kind: "end", t: last[0], at: [last[X()], last[Y()]], text: DATA.endings[flight.ending] ?? flight.ending });
  return found;
}

function sign({ kind, text, t }, x, y) {
  const shapes = {
    infection: () => s("path", { class: "infection", d: `M${x},${y - 7}L${x + 7},${y}L${x},${y + 7}L${x - 7},${y}Z` }),
    violation: () => s("path", { class: "violation", d: `M${x - 7},${y - 7}L${x + 7},${y + 7}M${x + 7},${y - 7}L${x - 7},${y + 7}` }),
    end: () => s("rect", { class: "end", x: x - 4.5, y: y - 4.5, width: 9, height: 9 }),
  };
  return s("g", {}, s("title", {}, `${seconds(t)}: ${text}`), shapes[kind]());
}
