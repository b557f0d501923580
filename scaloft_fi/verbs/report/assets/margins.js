/* How much fault it takes: ladders of magnitudes, margins by situation, each beside the limit that it is measured against. */
const BOUNDS = new Map(DATA.bounds.map((entry) => [entry.name, entry]));
const SENSES = { "<=": "\u2264", ">=": "\u2265" };
const requirementOf = (name) => DATA.requirements.find((one) => one.name === name);

/** What a requirement demands, in the units of its signals; a formula that is more than bounds stands as it is. */
function limitText(name) {
  const { demands, when } = BOUNDS.get(name) ?? { demands: [], when: [] };
  if (!demands.length) return [h("b", {}, name), ": ", h("code", {}, requirementOf(name)?.text ?? "")];
  const said = (bounds) => bounds.map(({ signal, sense, bound, for_s: lasting }) => `${quantity(signal)} ${SENSES[sense] ?? sense} ${trimmed(bound, 3)} ${unitOf(signal)}`.trim() + (lasting ? ` for ${trimmed(lasting)} s` : "")).join(" and ");
  const [spoken, always] = [demands.filter((bound) => bound.triggered), demands.filter((bound) => !bound.triggered)];
  const parts = [spoken.length > 0 && `${said(spoken)} where ${said(when)}`, always.length > 0 && said(always) + (spoken.length ? " always" : "")];
  return [h("b", {}, name), `: ${parts.filter(Boolean).join("; ")}`];
}

/** The requirements that a cell's faults are measured against: those that kill them, else those that it puts at risk. */
function againstOf(name) {
  const found = DATA.thresholds.filter((entry) => entry.cell === name).flatMap((entry) => entry.against);
  const names = found.length ? found : CELLS.get(name).requirements.filter((one) => requirementOf(one)?.kind === "safety");
  return [...new Set(names)];
}

const marginText = (name) => bounds(DATA.margins[name] ?? "");

const limitLines = (names) => names.map((name) => h("span", { class: "line faint small" }, "limit of ", limitText(name)));

function ladders() {
  const found = DATA.ladders;
  const laddered = DATA.cells.find((cell) => cell.default.includes("@"))?.name ?? "CELL";
  return part("ladders", "How much fault does it take", "Share of the situations that put the fault to the test with a kill, against its magnitude, filled where it is detected; then the margin, the least magnitude with a kill, situation by situation.  A magnitude has the unit of the fault, a limit that of its requirement: no number of one is a number of the other, so the robustness of the requirement is shown at both ends of a margin.",
    found.length ? h("div", { class: "multiples" }, found.map(ladder)) : h("p", { class: "note" }, "No cell was flown with more than one magnitude.  ", h("code", {}, `scaloft-fi run${inCampaign()} --mutant ${literal(`${laddered}*`)}`), " flies a ladder, ", h("code", {}, `scaloft-fi margin${inCampaign()} ${literal(laddered)}`), " searches between its rungs."),
    DATA.thresholds.length > 0 && [h("h3", { class: "sub" }, "Margins by situation"), DATA.thresholds.some((entry) => entry.least.endsWith("!")) && h("p", { class: "small faint" }, "!: the response is not monotone; a stronger magnitude survives where a milder one is killed or seen."), DATA.thresholds.map((entry) => margins(entry, DATA.thresholds.length === 1))],
    DATA.whens.length > 0 && [h("h3", { class: "sub" }, "When it strikes"), h("p", { class: "small faint" }, "Each phase of a fault where it first changes a sample, the median of its flights, on a rail as long as the baseline's flight: times on one rail, each event of the flight on its own, which is bare where the fault never acts.  Filled: a situation with a kill; open: put to the test and none; a tick: not put to the test."), h("div", { class: "multiples" }, DATA.whens.map(phases))]);
}

/** The phases of a fault on rails of a flight: one for all times, one for each event. */
function phases(entry) {
  const [times, events] = [false, true].map((at) => entry.strikes.filter((strike) => strike.at_event === at));
  const rows = [["times", times], ...events.map((strike) => [strike.phase, [strike]])].filter(([, strikes]) => strikes.length);
  const frame = plot({ width: 300, height: 48 + 20 * rows.length, x: [0, entry.lasts_s], y: [rows.length - 0.5, -0.5], left: 70, top: 6, yTicks: rows.map((_, number) => number), yText: (number) => rows[number][0], xTitle: "time of flight [s]", label: `${entry.fault}: when it strikes` });
  const { root, sx, sy } = frame;
  rows.forEach(([, strikes], number) => strikes.filter((strike) => strike.acts_s).forEach((strike) => {
    const [x, y] = [sx(Math.min(strike.acts_s[1], entry.lasts_s)), sy(number)];
    const told = s("title", {}, `${strike.id}: acts at ${trimmed(strike.acts_s[1], 1)} s, ${spaced(strike.verdict)}, kills in ${ratioText(strike.kills)}`);
    root.append(strike.kills.whole ? s("circle", { class: strike.kills.part ? "dot" : "open", cx: x, cy: y, r: 4 }, told) : s("line", { class: "tick", x1: x, x2: x, y1: y - 4, y2: y + 4 }, told));
  }));
  const detected = (strikes, kind) => strikes.length > 0 && `detected at ${strikes.filter((strike) => strike.verdict === "detected").length} of ${strikes.length} ${kind}`;
  return h("figure", { class: "small-multiple" },
    h("figcaption", {}, entry.fault, h("span", { class: "line faint small" }, [detected(times, "times"), detected(events, "events")].filter(Boolean).join(", "))),
    root);
}

/** Kill share against magnitude, from mild to strong. */
function ladder(entry) {
  const rungs = entry.rungs;
  const frame = plot({ width: 300, height: 170, x: [-0.5, rungs.length - 0.5], y: [0, 1], left: 46, top: 14, bottom: 30, xTicks: rungs.map((_, number) => number), xText: (number) => rungs[number].magnitude, yTicks: [0, 0.5, 1], yText: percent, label: `${entry.cell}: kill share against magnitude` });
  const { root, sx, sy } = frame;
  rungs.forEach((rung, number) => {
    const value = share(rung.kill_rate);
    if (value !== null) root.append(s("circle", { class: rung.verdict === "detected" ? "dot" : "open", cx: sx(number), cy: sy(value), r: rung.default ? 5 : 4 }, s("title", {}, `${rung.id}: ${spaced(rung.verdict)}, ${ratioText(rung.kill_rate)}`)));
    else root.append(s("text", { x: sx(number), y: sy(0.5), "text-anchor": "middle" }, "n/a"));
  });
  return h("figure", { class: "small-multiple" },
    h("figcaption", {}, h("a", { href: cellHash(entry.cell) }, entry.cell), DATA.margins[entry.cell] && ` margin ${marginText(entry.cell)}`, limitLines(againstOf(entry.cell))),
    root);
}

/** One fault: its margin, the limit, a line a situation. */
function margins(entry, open) {
  const says = [h("h3", { class: "inline" }, entry.fault), h("span", {}, ` margin ${entry.least ? bounds(entry.least) : "not known"}, against ${listed(entry.against)}`)];
  return fold({ class: "fold", open }, says, () => thresholdsOf(entry));
}

function thresholdsOf(entry) {
  const range = magnitudes(entry);
  const rows = entry.situations.map((found) => [
    withKey(found.key),
    span(found, range, entry), ...[found.survives, found.seen, found.kills].map((value) => ended(value, entry.unit)), listed(found.by),
    entry.against.map((name) => h("span", { class: "line" }, entry.against.length > 1 ? `${name} ` : "", found.rho[name].map((value) => (twoDigits(value))).join(" / "))),
    found.again.length > 0 && `survives again at ${found.again.map((value) => ended(value, entry.unit)).join(", ")}`,
  ]);
  const untold = entry.situations_flown - entry.situations.length;
  return [h("p", { class: "small" }, limitLines(entry.against)),
    table(["situation", { text: "magnitude", after: `${entry.unit ? ` [${UNITS[entry.unit] ?? entry.unit}]` : ""}, ${trimmed(range[0], 3)} to ${trimmed(range[1], 3)}` }, { text: "survives", number: true }, { text: "seen", number: true }, { text: "killed", number: true }, "by", { text: "robustness", after: ": survives / violates" }, "again"], rows, { stack: false }),
    h("p", { class: "small faint" }, `Open disc: the strongest magnitude that survives; filled: the mildest that is killed; grey: the mildest of which most flights violate, too few for a verdict; the threshold lies between.  ${entry.worse > 0 ? "Larger" : "Smaller"} is worse.  Robustness below 0 is a violation; its unit: ${entry.against.map((name) => `${name} ${requirementOf(name)?.unit ?? ""}`).join("; ")}.`,
      untold > 0 && `  ${plural(untold, "further situation")} flown ${untold === 1 ? "tells" : "tell"} nothing of it: the fault changes nothing there, or no requirement that it puts at risk is steady.`)];
}

/** A robustness as `margin` prints it: near a threshold it is small, and its sign is what counts. */
const twoDigits = (value) => (typeof value === "number" ? String(Number(value.toPrecision(2))).replace("-", "\u2212") : value ?? "\u2013");
const ended = (value, unit) => (value === null ? "\u2013" : `${typeof value === "number" ? trimmed(value, 3) : value} ${UNITS[unit] ?? unit}`.trim());

function magnitudes(entry) {
  const all = entry.situations.flatMap((found) => found.flown).filter((value) => typeof value === "number");
  return [Math.min(0, ...all), Math.max(...all)];
}

/** What is known of a threshold, on a rail of magnitudes; an end that is not known runs to the end of the rail. */
function span(found, [from, to], { unit, worse }) {
  const x = scale(from, to, 6, 194);
  const at = (value, otherwise) => (typeof value === "number" ? x(value) : otherwise);
  const mildest = worse > 0 ? 6 : 194;
  const strong = found.seen ?? found.kills;
  const [start, stop] = [at(found.survives, mildest), at(strong, 200 - mildest)];
  return s("svg", { class: "threshold", width: 200, height: 18, viewBox: "0 0 200 18", role: "img", "aria-label": `margin ${bounds(found.margin)}` },
    s("line", { class: "rail", x1: 6, x2: 194, y1: 9, y2: 9 }),
    s("line", { class: "span", x1: start, x2: stop, y1: 9, y2: 9 }),
    found.flown.filter((value) => typeof value === "number").map((value) => s("line", { class: "tick", x1: x(value), x2: x(value), y1: 5, y2: 13 }, s("title", {}, `flown at ${ended(value, unit)}`))),
    typeof found.survives === "number" && s("circle", { class: "open", cx: start, cy: 9, r: 4 }),
    typeof strong === "number" && s("circle", { class: found.seen === null ? "dot" : "doubt", cx: stop, cy: 9, r: 4 }));
}
