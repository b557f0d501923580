/* What kills what: interaction orders, the smallest suite, the subsumption graph. */
function whatKillsWhat() {
  return part("what", "What kills what", "Of the default mutants that have a kill: how many axes must be right, which situations are enough, which mutants say the same.",
    unkilled(),
    folded("Show how many axes, which situations, which mutants", () => [
      h("div", { class: "columns" },
        !OF_TESTS && h("div", {}, h("h3", {}, "How many axes a kill depends on"), orderChart(), orderNote()),
        h("div", {}, h("h3", {}, "The fewest situations that keep every kill"), suite())),
      h("h3", { class: "sub" }, "Which mutants say the same"), subsumption()]));
}

/** Detected mutants that no situation kills are in none of these analyses. */
function unkilled() {
  const found = DATA.mutants.filter((mutant) => mutant.counts && mutant.verdict === "detected" && !mutant.kill_rate.part);
  return found.length > 0 && h("p", { class: "note" }, `${plural(found.length, "mutant")} ${found.length === 1 ? "is" : "are"} detected by violations here and there, without a situation in which most flights violate: `, found.map(({ id }, number) => [number ? ", " : "", h("a", { class: "id", href: mutantHash(id) }, id)]), ".  What follows leaves them out.");
}

/** Mutants by the number of axes that have to be right, as bars; beside them the share so far, ours and NIST's. */
function orderChart() {
  const counts = DATA.orders.map(({ mutants }) => mutants), ours = DATA.orders.map((order) => order.cumulative_percent);
  const total = counts.reduce((sum, count) => sum + count, 0);
  if (!total) return h("p", { class: "note" }, "No default mutant has a kill.");
  const frame = plot({ width: Math.min(WIDE, 460), height: 190, x: [-0.5, counts.length - 0.5], y: [0, Math.max(...counts)], left: 34, bottom: 36, xTicks: counts.map((_, order) => order), xTitle: "axes that have to be right", yTitle: "mutants", top: 34, label: `Mutants by interaction order: ${counts.join(", ")} for 0 to ${counts.length - 1} axes` });
  const { root, sx, sy } = frame;
  const width = (sx(1) - sx(0)) * 0.62;
  counts.forEach((count, order) => root.append(
    s("rect", { class: "bar", x: sx(order) - width / 2, y: sy(count), width, height: sy(0) - sy(count) }),
    s("text", { class: "strong", x: sx(order), y: sy(count) - 5, "text-anchor": "middle" }, count || "")));
  const upTo = counts.slice(1).map((_, place) => place + 1);
  const cell = (value) => (value === null || value === undefined ? "–" : `${Math.round(value)} %`);
  return h("div", {}, root,
    h("details", {}, h("summary", {}, "Beside the published figures for software failures"),
      table(["at most %", ...upTo.map((t) => ({ text: String(t), number: true }))],
        [["this campaign", ...upTo.map((t) => cell(ours[t]))], ...Object.entries(DATA.nist.shares).map(([name, shares]) => [name, ...upTo.map((t) => cell(shares[t - 1]))])], { stack: false }),
      h("p", { class: "small faint" }, DATA.nist.source)));
}

const orderNote = () => h("p", { class: "small faint" }, "An order of 1 means that the mutant is killed wherever one axis has a certain value, whatever the others are; 0 that it is wherever it was tested.  Situations that are no test may fall on either side.");

function suite() {
  const { situations, exact, alternatives, needed } = DATA.suite;
  if (!situations.length) return h("p", { class: "note" }, "No default mutant has a kill.");
  const flown = DATA.coverage.situations.part;
  return h("div", {},
    h("p", {}, `${exact ? "" : "At most "}${situations.length} of ${flown} situations keep a kill of every default mutant that has one${alternatives > 1 ? `; ${alternatives} sets of that size do` : ""}:`),
    h("ul", { class: "bare" }, situations.map((key) => h("li", {}, withKey(key), needed.includes(key) && h("span", { class: "faint small" }, " \u2013 in every such set")))),
    h("p", { class: "small faint" }, `A suite cut down to these would show these faults and may miss others: the mutants were chosen, each situation flown with up to ${plural(DATA.seeds.length, "seed")}.`));
}

/** Layers from minimal mutants down to those that follow from them; a node is a set of mutants that the same situations kill. */
function subsumption() {
  const { nodes, killed, distinct, minimal } = DATA.subsumption;
  const edges = DATA.subsumption.edges.map(({ subsuming, subsumed }) => [subsuming, subsumed]);
  if (!nodes.length) return h("p", { class: "note" }, "No default mutant has a kill.");
  const below = (place) => {
    const seen = new Set();
    const walk = (from) => edges.forEach(([above, under]) => { if (above === from && !seen.has(under)) { seen.add(under); walk(under); } });
    walk(place);
    return [...seen].reduce((sum, under) => sum + nodes[under].mutants.length, 0);
  };
  const rows = nodes.map((node, place) => [node, place]).filter(([node]) => node.minimal).map(([node, place]) => [
    node.mutants.map((id, number) => [number ? ", " : "", h("a", { class: "id", href: mutantHash(id) }, id)]),
    String(node.kills.length), String(below(place))]);
  return h("div", {},
    h("p", {}, `${killed} killed mutants make ${distinct} different sets of situations with a kill; ${minimal} of them are minimal: where a minimal mutant is killed, those below it are, too.`),
    h("div", { class: "columns" },
      table(["minimal mutants", { text: "situations with a kill", number: true }, { text: "subsumes", number: true }], rows, { stack: false }),
      edges.length > 0 && graph(nodes, edges)));
}

function graph(nodes, edges) {
  const layers = [];
  nodes.forEach((node, place) => (layers[node.layer] ??= []).push(place));
  const x = new Map();
  const width = Math.min(WIDE, 520);
  const spread = (layer) => layer.forEach((place, number) => x.set(place, ((number + 0.5) / layer.length) * width));
  layers.forEach(spread);
  // a node stands below the middle of what subsumes it; a few rounds settle
  for (let round = 0; round < 4; round += 1) {
    for (const layer of layers) {
      const wish = (place) => {
        const above = edges.filter(([, under]) => under === place).map(([over]) => x.get(over));
        return above.length ? above.reduce((sum, value) => sum + value, 0) / above.length : x.get(place);
      };
      layer.sort((a, b) => wish(a) - wish(b));
      spread(layer);
    }
  }
  const y = (place) => 26 + nodes[place].layer * 48;
  const height = 26 + (layers.length - 1) * 48 + 26;
  const radius = (node) => 5 + 2.2 * Math.sqrt(node.mutants.length);
  const said = (node) => `${node.mutants.join(", ")}\n${plural(node.kills.length, "situation")}`;
  const root = s("svg", { viewBox: `0 0 ${width} ${height}`, class: "graph", role: "img", "aria-label": "Subsumption graph: minimal mutants at the top, mutants that follow from them below" },
    edges.map(([above, under]) => s("path", { class: "edge", d: `M${x.get(above)},${y(above)}C${x.get(above)},${y(above) + 24} ${x.get(under)},${y(under) - 24} ${x.get(under)},${y(under)}` })),
    nodes.map((node, place) => s("a", { href: mutantHash(node.mutants[0]), "aria-label": said(node), class: "node" },
      s("title", {}, said(node)),
      s("circle", { class: node.minimal ? "minimal" : "", cx: x.get(place), cy: y(place), r: radius(node) }),
      s("text", { x: x.get(place), y: y(place) + 4, "text-anchor": "middle" }, node.mutants.length > 1 ? node.mutants.length : ""))));
  return h("figure", {}, root, h("figcaption", {}, "A disc is a set of mutants killed by the same situations, the number how many they are; filled discs are minimal."));
}
