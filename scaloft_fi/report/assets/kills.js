/* The kill matrix: mutants down, situations across in Gray-code order, so that neighbours differ in one axis. */
const SORTS = {
  parameter: ["by parameter", null],
  rate: ["by kill rate", (a, b) => (share(b.kill_rate) ?? -1) - (share(a.kill_rate) ?? -1)],
  status: ["by status", (a, b) => DATA.statuses.indexOf(b.status) - DATA.statuses.indexOf(a.status)],
  guideword: ["by guideword", (a, b) => place("guidewords", a.guideword) - place("guidewords", b.guideword)],
};
const place = (kind, id) => DATA[kind].findIndex((entry) => entry.id === id);

function killMatrix() {
  const body = h("tbody");
  const board = h("table", { class: "kills", role: "grid", "aria-label": "Kill matrix: mutants down, situations across", "aria-rowcount": DATA.mutants.length }, strip(), body, tallies());
  const rows = new Map(DATA.mutants.map((mutant) => [mutant.id, mutantRow(mutant)]));
  const count = h("output", { "aria-live": "polite" });
  const controls = filters(() => arrange());
  const grid = roving(board, "td.state", () => [...body.rows].filter((row) => row.querySelector("td.state")), (cell) => openResult(cell));

  function arrange() {
    const { sort, keep } = controls.read();
    const kept = DATA.mutants.filter(keep);
    const order = SORTS[sort][1];
    const sorted = order ? [...kept].sort(order) : kept;
    const nodes = [];
    let group = null;
    for (const mutant of sorted) {
      if (!order && mutant.parameter !== group) {
        group = mutant.parameter;
        nodes.push(groupRow(group));
      }
      nodes.push(rows.get(mutant.id));
    }
    body.replaceChildren(...nodes);
    count.textContent = kept.length === DATA.mutants.length ? plural(kept.length, "mutant") : `${kept.length} of ${plural(DATA.mutants.length, "mutant")}`;
    grid.reset();
  }
  controls.node.append(count);
  arrange();
  tip.on(board, "td.state", (cell) => cell.getAttribute("aria-label"));
  light(board);
  return part("kills", "The kill matrix", "Each line is a fault, each column a situation; neighbouring columns differ in one axis.  A result opens its flight, a fault's name the map of where it is killed.",
    controls.node,
    h("ul", { class: "legend" },
      h("li", {}, "killed: few", h("span", { class: "ramp" }), "all eligible flights"),
      ["survived", "baseline_red", "masked", "not_infected", "not_reached"].map((state) => h("li", {}, swatch(state), STATES[state][0])),
      SEVERAL && h("li", {}, h("b", {}, "2?"), "how many flights are killed, where not all are; ? where they do not decide"),
      h("li", {}, h("span", { class: "swatch state uncounted", "data-state": "killed" }), "killed where nothing counts")),
    h("div", { class: "matrix-box", tabindex: "-1" }, board),
    h("p", { class: "small faint" }, "Right: situations killed of those eligible, with Wilson's 95 % interval.  Below: default mutants killed in each situation.  Arrow keys move, Enter opens."));
}

/** One line an axis: black where the value is not the benign one, grey between. */
function strip() {
  const rows = DATA.axes.map((axis, number) => h("tr", {},
    h("th", { class: "stub axis-name", scope: "row" }, `${axis.title}: ${axis.words.slice(1).join(", ")}`),
    DATA.situations.map((situation) => {
      const level = situation.levels[number];
      return h("td", { class: "mark", "--level": axis.words.length > 1 ? level / (axis.words.length - 1) : 0, title: situation.words[number] }, h("span", {}));
    })));
  rows.at(-1)?.append(h("th", { class: "side", scope: "col" }, "killed/eligible, 0 to 100 %"), h("th", { class: "side", scope: "col" }, "killed where"));
  return h("thead", {}, rows);
}

function tallies() {
  const most = Math.max(1, ...DATA.by_situation.map((counts) => counts.killed));
  return h("tfoot", {}, h("tr", {}, h("th", { class: "stub axis-name", scope: "row" }, "default mutants killed"),
    DATA.by_situation.map((counts, column) => h("td", { class: "tally", title: `${DATA.situations[column].key}: ${counts.killed} killed of ${counts.eligible} eligible` },
      counts.killed, h("span", { "--share": counts.killed / most }))),
    h("td", { class: "rate" }), h("td", { class: "said" })));
}

function groupRow(parameter) {
  const members = DATA.mutants.filter((mutant) => mutant.parameter === parameter && mutant.counts);
  const killed = members.filter((mutant) => mutant.kill_rate.part).length;
  const eligible = members.filter((mutant) => mutant.kill_rate.whole).length;
  return h("tr", { class: "group" }, h("th", { scope: "colgroup" }, titleOf("parameters", parameter)),
    h("td", { colspan: DATA.situations.length }), h("td", { class: "rate faint small", colspan: 2 }, `${killed} of ${eligible} shown`));
}

function mutantRow(mutant) {
  return h("tr", { "data-mutant": mutant.id },
    h("th", { scope: "row" }, h("a", { class: "quiet", href: mutantHash(mutant.id), title: `${mutant.id}: where it is killed, as a map` }, mutant.id), mutant.control && h("span", { class: "tag", title: "crude control, in no ratio" }, "C")),
    mutant.results.map((result, column) => {
      const { state, share: killed, glyph, uncounted, said } = shown(result);
      const situation = DATA.situations[column];
      const classes = ["state", killed > 0.5 && "deep", uncounted && "uncounted"].filter(Boolean).join(" ");
      return h("td", { class: classes, role: "gridcell", tabindex: "-1", "data-state": state, "data-column": column, "--share": killed,
        "aria-label": `${mutant.id}\n${situation.words.join(", ")} (${situation.key})\n${said}` }, glyph);
    }),
    h("td", { class: "rate" }, h("span", { class: "number" }, mutant.kill_rate.whole ? `${mutant.kill_rate.part}/${mutant.kill_rate.whole}` : "n/a"), " ", whisker(mutant.kill_rate, mutant.id)),
    h("td", { class: "said", title: killedWhere(mutant) }, killedWhere(mutant)));
}

/** The condition of its kills; where no score counts one, that is said first. */
const killedWhere = (mutant) => (mutant.condition ? `${mutant.kill_rate.part ? "" : "uncounted: "}${mutant.condition}` : STATES[mutant.status][0]);

function openResult(cell) {
  const mutant = cell.closest("tr").dataset.mutant;
  const situation = DATA.situations[Number(cell.dataset.column)].key;
  go(flightHash(mutant, situation, DATA.seeds[0] ?? 0));
}

/** Mark the line and the column of the cell that is pointed at. */
function light(board) {
  let lit = [];
  const mark = (event) => {
    lit.forEach((node) => node.classList.remove("lit"));
    const cell = event.target.closest("td.state");
    lit = cell ? [cell.parentElement, ...board.querySelectorAll(`thead td:nth-child(${Number(cell.dataset.column) + 2}), tfoot td:nth-child(${Number(cell.dataset.column) + 2})`)] : [];
    lit.forEach((node) => node.classList.add("lit"));
  };
  board.addEventListener("mouseover", mark);
  board.addEventListener("focusin", mark);
  board.addEventListener("mouseleave", mark);
}

function filters(changed) {
  const chooser = (label, options) => {
    const select = h("select", { onchange: changed }, options.map(([value, text]) => h("option", { value }, text)));
    return { node: h("label", {}, label, select), get value() { return select.value; } };
  };
  const sort = chooser("order", Object.entries(SORTS).map(([value, [text]]) => [value, text]));
  const guideword = chooser("guideword", [["", "all"], ...DATA.guidewords.map((word) => [word.id, word.title])]);
  const parameter = chooser("parameter", [["", "all"], ...DATA.parameters.map((entry) => [entry.id, entry.title])]);
  const status = chooser("status", [["", "all"], ...DATA.statuses.slice().reverse().map((id) => [id, STATES[id][0]])]);
  const magnitude = chooser("magnitudes", [["", "all"], ["counts", "default, one a cell"], ...(DATA.mutants.some((one) => one.searched) ? [["ladder", "without searched ones"]] : [])]);
  const text = h("input", { type: "search", placeholder: "id or condition", oninput: changed, "aria-label": "text in id or condition" });
  const node = h("div", { class: "controls", role: "group", "aria-label": "Order and filter of the kill matrix" },
    sort.node, guideword.node, parameter.node, status.node, magnitude.node, h("label", {}, "text", text));
  const read = () => {
    const wanted = text.value.trim().toLowerCase();
    return {
      sort: sort.value,
      keep: (mutant) => (!guideword.value || mutant.guideword === guideword.value) && (!parameter.value || mutant.parameter === parameter.value)
        && (!status.value || mutant.status === status.value)
        && (!magnitude.value || (magnitude.value === "counts" ? mutant.counts : !mutant.searched)) && (!wanted || `${mutant.id} ${mutant.condition}`.toLowerCase().includes(wanted)),
    };
  };
  return { node, read };
}
