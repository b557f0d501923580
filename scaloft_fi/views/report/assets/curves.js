/* Coverage against kills: what k situations cover and kill, by each way of choosing them. */
const HUES = 8;
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "1 4", "12 4", "4 2", "6 2 1 2"];

function coverageAgainstKills() {
  const found = DATA.curves;
  const lead = "Does covering more of the situation space show more faults?  Every way of choosing situations is compared with random ones at equal number.";
  if (!found) return part("curves", "Coverage against kills", lead, h("p", { class: "note" }, "No mutants were flown in the same situations."));
  const followed = found.strategies.map((strategy, number) => ({ ...strategy, number }));
  return part("curves", "Coverage against kills", lead,
    h("p", { class: "verdict" }, found.answer.at(-1)),
    h("div", { class: "columns" },
      h("figure", {}, h("figcaption", {}, `Default mutants killed by k situations, of ${found.mutants}`), curveChart(followed, (strategy) => strategy.kills.mean, [0, Math.max(1, found.killed)], trimmed, found.spread)),
      h("figure", {}, h("figcaption", {}, "Share of the 2-way combinations covered by k situations"), curveChart(followed, (strategy) => strategy.t_way["2"] ?? [], [0, 1], percent, null))),
    h("ul", { class: "legend" }, followed.map((strategy) => h("li", {}, lineSample(strategy.number), h("b", {}, strategy.name), h("span", {}, strategy.about)))),
    h("h3", { class: "sub" }, "What the answer rests on"),
    h("ul", { class: "wide" }, found.answer.slice(0, -1).map((sentence) => h("li", {}, sentence))),
    h("details", {}, h("summary", {}, "The figures"), curveTable(followed, found)),
    h("p", { class: "small faint" }, "Grey band: 5 to 95 % of random orders.  An order that knows the kills beforehand is the upper bound, not a way of choosing.",
      found.left_out.length ? `  Left out, because not flown in all of these situations: ${found.left_out.join(", ")}.` : "",
      found.missing.map((entry) => `  ${entry.name}: ${entry.reason}.`)));
}

const strokeOf = (number) => ({ "data-series": number % HUES, "stroke-dasharray": DASHES[number % DASHES.length] });
const lineSample = (number) => s("svg", { width: 34, height: 10, "aria-hidden": "true" }, s("path", { class: "series", d: "M1,5H33", ...strokeOf(number) }));

function curveChart(followed, valuesOf, range, text, spread) {
  const size = Math.max(...followed.map((strategy) => valuesOf(strategy).length), 1);
  const frame = plot({ height: 300, x: [0, size], y: range, top: 12, bottom: 38, left: 44, yText: text, xTitle: "situations flown", label: "A line for each way of choosing situations" });
  const { root, sx, sy } = frame;
  if (spread) root.append(s("path", { class: "spread", d: `${pathOf(spread.high.map((value, place) => [sx(place + 1), sy(value)]))}${pathOf(spread.low.map((value, place) => [sx(place + 1), sy(value)]).reverse()).replace("M", "L")}Z` }));
  for (const strategy of followed) {
    const points = valuesOf(strategy).map((value, place) => [sx(place + 1), sy(value)]);
    root.append(s("path", { class: "series", d: pathOf(points), ...strokeOf(strategy.number) }, s("title", {}, strategy.name)));
    // a suite that is not an order of all situations ends where it is complete
    if (points.length && points.length < size) root.append(s("circle", { class: "series-end", cx: points.at(-1)[0], cy: points.at(-1)[1], r: 4, "data-series": strategy.number % HUES }, s("title", {}, strategy.name)));
  }
  return root;
}

function curveTable(followed, found) {
  const sizes = [1, 2, 4, 6, 8, 10, 16, 24, found.situations].filter((k, place, all) => k <= found.situations && all.indexOf(k) === place);
  const at = (values, k) => (k <= values.length ? values[k - 1].toFixed(1) : "");
  const between = (band, k) => (band && k <= band.mean.length ? `${signedPlus(band.mean[k - 1])} [${signedPlus(band.low[k - 1])}, ${signedPlus(band.high[k - 1])}]` : "");
  const heads = sizes.map((k) => ({ text: `k = ${k}`, number: true }));
  return h("div", {},
    table(["mutants killed", ...heads], followed.map((strategy) => [strategy.name, ...sizes.map((k) => at(strategy.kills.mean, k))]), { stack: false }),
    table(["kill sets met", ...heads], followed.map((strategy) => [strategy.name, ...sizes.map((k) => at(strategy.kill_sets.mean, k))]), { stack: false, caption: "Mutants that are killed in the same situations count once." }),
    table(["more kill sets than random", ...heads], followed.filter((strategy) => strategy.distinct).map((strategy) => [strategy.name, ...sizes.map((k) => between(strategy.distinct, k))]), { stack: false, caption: `In brackets the 95 % interval over redrawn campaigns: ${found.seeds_resampled ? "seeds and kill sets" : "kill sets"} are resampled, at equal k, paired.` }));
}

/** With its sign; what rounds to nothing has none. */
const signedPlus = (value) => {
  const size = Math.abs(value).toFixed(1);
  return Number(size) ? (value < 0 ? "\u2212" : "+") + size : size;
};
