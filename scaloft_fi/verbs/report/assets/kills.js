/* The kill matrix: mutants down, situations across in Gray-code order, so that neighbours differ in one axis. */
const SORTS = {
  parameter: ["by parameter", null],
  rate: ["by situations with a kill", (a, b) => (share(b.kill_rate) ?? -1) - (share(a.kill_rate) ?? -1)],
  verdict: ["by verdict", (a, b) => DATA.verdicts.indexOf(a.verdict) - DATA.verdicts.indexOf(b.verdict)],
  ...(DATA.severities.length ? { severity: ["by severity", (a, b) => grade(a) - grade(b)] } : {}),
  guideword: ["by guideword", (a, b) => place("guidewords", a.guideword) - place("guidewords", b.guideword)],
};
const place = (kind, id) => DATA[kind].findIndex((entry) => entry.id === id);
/** The rank of its class, 0 the worst; what has no class stands last. */
const grade = ({ severity }) => (severity ? place("severities", severity) : DATA.severities.length);

function killMatrix() {
  const whole = DATA.coverage.situations.whole;
  const columns = DATA.situations.length < whole ? `a situation that was flown, of ${whole} in the grid` : "a situation; neighbouring columns differ in one axis";
  return part("kills", "The kill matrix", `Each line is a fault, each column ${columns}.  A result opens a flight that has what it says, a fault's name the map of where it is killed.`,
    folded(`Show ${plural(DATA.mutants.length, "fault")} x ${plural(DATA.situations.length, "situation")}`, killBoard));
}

function killBoard() {
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
  return [controls.node,
    h("ul", { class: "legend" },
      h("li", {}, swatch("kill", "1"), h("b", {}, term("kill")), `most flights of a detected fault violate ${SAFETY.map((name, number) => `${name} (${number + 1})`).join(" or ")}, which the unmutated drone holds in nine of ten`),
      ["seen", "tested", "masked", "not_infected", "not_reached", "not_flown"].map((state) => h("li", {}, swatch(state), legendOf(SIGNS[state][0]))),
      h("li", {}, swatch("no_test", "r"), h("b", {}, term("no test")), h("span", {}, "no safety requirement is steady: ", Object.entries(STATES).filter(([, [letter]]) => letter).map(([state, [letter]], number) => [number ? ", " : "", `${letter} `, term(stateWord(state))])))),
    h("div", { class: "matrix-box", tabindex: "-1" }, board),
    h("p", { class: "small faint" }, "At the top: the values of each situation that are not benign, its alias, the axes (black: not benign).  Below the axes: where the unmutated drone holds each safety requirement steadily (filled), else the letter of what it does.  Right: the verdict, and situations with a kill of those that put the fault to the test; of a control what shows it.  Below: default mutants with a kill in each situation.  Arrow keys move, Enter opens."),
    situationList()];
}

/** A sign in words, whose first is a term. */
function legendOf(words) {
  const [first, ...others] = words.split(",");
  return h("span", {}, term(first), others.map((text) => `,${text}`));
}

/** A name a situation, then one line an axis: black where the value is not the benign one, grey between; one a safety requirement: whether it tests. */
function strip() {
  const row = (title, cells, kind) => h("tr", { class: kind }, h("th", { class: "stub axis-name", scope: "row" }, title), cells);
  const rows = DATA.axes.map((axis, number) => row(`${axis.title}: ${axis.words.slice(1).join(", ")}`, DATA.situations.map((situation) => {
    const level = situation.levels[number];
    return h("td", { class: "mark", "--level": axis.words.length > 1 ? level / (axis.words.length - 1) : 0, title: situation.words[number] }, h("span", {}));
  }), "axis"));
  const tests = SAFETY.map((name) => row(`${name} tests`, DATA.situations.map(({ key }) => {
    const state = stateOf(key, name);
    const pair = pairOf(key, name);
    return h("td", { class: "mark test", "data-pair": state, title: `${name} ${calledOf(key, name)}${pair ? `: violated by the ${besideText(pair)}` : ""}` }, h("span", {}, pair && STATES[state][0]));
  })));
  tests[0]?.classList.add("tests");
  [...rows, ...tests].at(-1)?.append(h("th", { class: "side", scope: "col" }, term("verdict"), ", killed of tested"), h("th", { class: "side", scope: "col" }, "killed ", term("where")));
  return h("thead", { role: "rowgroup" }, names(), rows, tests);
}

/** The situations by name, upright; each opens the situation. */
function names() {
  return h("tr", { class: "names", role: "row" }, h("th", { class: "stub axis-name", scope: "row", role: "rowheader" }, term("situation"), ": values that are not benign"), DATA.situations.map((situation) =>
    h("th", { scope: "col", role: "columnheader", class: "upright" }, h("a", { class: "quiet", href: situationHash(situation.key), title: `${situation.words.join(", ")} (${codeOf(situation)})` }, h("span", {}, situation.name), situation.aliases.map((alias) => h("span", { class: "alias" }, alias))))));
}

function tallies() {
  const most = Math.max(1, ...DATA.by_situation.map((counts) => counts.killed));
  return h("tfoot", {}, h("tr", {}, h("th", { class: "stub axis-name", scope: "row" }, "default mutants killed"),
    DATA.by_situation.map((counts, column) => h("td", { class: "tally", title: `${DATA.situations[column].key}: ${counts.killed} killed of ${counts.tested} put to the test` },
      counts.killed, h("span", { "--share": counts.killed / most }))),
    h("td", { class: "rate" }), h("td", { class: "said" })));
}

function groupRow(parameter) {
  const members = DATA.mutants.filter((mutant) => mutant.parameter === parameter && mutant.counts);
  const found = members.filter((mutant) => mutant.verdict === "detected").length;
  return h("tr", { class: "group" }, h("th", { scope: "colgroup" }, titleOf("parameters", parameter)),
    h("td", { colspan: DATA.situations.length }), h("td", { class: "rate faint small", colspan: 2 }, DATA.pooled && members.length > 0 && `${found} of ${plural(members.length, "default mutant")} detected`));
}

function mutantRow(mutant) {
  return h("tr", { "data-mutant": mutant.id },
    h("th", { scope: "row" }, h("a", { class: "quiet", href: mutantHash(mutant.id), title: `${mutant.id}: where it is killed, as a map` }, mutant.id), mutant.control && h("span", { class: "tag", title: "crude control, in no ratio" }, "C")),
    mutant.results.map((result, column) => {
      const situation = DATA.situations[column];
      const { state, glyph, said, seed } = shown(result, situation.key);
      return h("td", { class: "state", role: "gridcell", tabindex: "-1", "data-state": state, "data-column": column, "data-seed": seed,
        "aria-label": `${mutant.id}\n${situation.words.join(", ")} (${codeOf(situation)})\n${said}` }, glyph);
    }),
    mutant.control ? h("td", { class: "rate" }, showsText(mutant))
      : h("td", { class: "rate" }, h("span", { class: "mark-of" }, markOf(mutant)), ` ${spaced(mutant.verdict)} `, h("span", { class: "number" }, rateText(mutant))),
    h("td", { class: "said", title: killedWhere(mutant) }, killedWhere(mutant)));
}

/** The condition of its kills; of a mutant without one where a violation was seen, else where it stopped. */
const killedWhere = (mutant) => {
  if (mutant.condition) return `${mutant.kill_rate.part ? "" : "seen: "}${mutant.condition}`;
  return mutant.verdict === "not_tested" ? SIGNS[stopped(mutant)][0] : "";
};

function openResult(cell) {
  go(flightHash(cell.closest("tr").dataset.mutant, DATA.situations[Number(cell.dataset.column)].key, Number(cell.dataset.seed)));
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
  const verdict = chooser("verdict", [["", "all"], ...DATA.verdicts.map((id) => [id, spaced(id)])]);
  const magnitude = chooser("magnitudes", [["", "all"], ["counts", "default, one a cell"], ...(DATA.mutants.some((one) => one.searched) ? [["ladder", "without searched ones"]] : [])]);
  const text = h("input", { type: "search", placeholder: "id or condition", oninput: changed, "aria-label": "text in id or condition" });
  const node = h("div", { class: "controls", role: "group", "aria-label": "Order and filter of the kill matrix" },
    sort.node, guideword.node, parameter.node, verdict.node, magnitude.node, h("label", {}, "text", text));
  const read = () => {
    const wanted = text.value.trim().toLowerCase();
    return {
      sort: sort.value,
      keep: (mutant) => (!guideword.value || mutant.guideword === guideword.value) && (!parameter.value || mutant.parameter === parameter.value)
        && (!verdict.value || mutant.verdict === verdict.value)
        && (!magnitude.value || (magnitude.value === "counts" ? mutant.counts : !mutant.searched)) && (!wanted || `${mutant.id} ${mutant.condition}`.toLowerCase().includes(wanted)),
    };
  };
  return { node, read };
}
