/* The HAZOP matrix as a heat map: guidewords across, parameters down. */
function cellState(cell) {
  if (cell.status === "not_meaningful") return { state: "not_meaningful", text: "", said: `not meaningful: ${cell.reason}` };
  const mutant = MUTANTS.get(cell.default) ?? MUTANTS.get(cell.mutants[0]);
  if (!mutant) return { state: "not_flown", text: "", said: `not flown: ${cell.deviation}` };
  const rate = mutant.kill_rate;
  const said = `${mutant.id}: ${STATES[mutant.status][0]}, kills ${ratioText(rate)} ${intervalText(rate)} of the eligible situations`;
  if (rate.whole) return { state: rate.part ? "killed" : "survived", share: share(rate), text: `${rate.part}/${rate.whole}`, survivor: !rate.part && !mutant.control, said };
  return { state: mutant.status, text: "", said };
}

function hazop() {
  const board = h("table", { class: "hazop", role: "grid", "aria-label": "HAZOP matrix: parameters down, guidewords across" },
    h("thead", {}, h("tr", {}, h("th", { class: "corner" }, h("span", { class: "faint" }, "parameter")), DATA.guidewords.map((word) => h("th", { scope: "col", title: word.meaning }, word.title + (word.extension ? "*" : ""))))),
    h("tbody", {}, DATA.parameters.map((parameter) => h("tr", {},
      h("th", { scope: "row", title: parameter.intent }, parameter.title),
      DATA.guidewords.map((word) => hazopCell(CELLS.get(`${word.id}-${parameter.id}`)))))));
  roving(board, "td", () => [...board.tBodies[0].rows], (cell) => go(cellHash(cell.dataset.cell))).reset();
  tip.on(board, "td", (cell) => cell.getAttribute("aria-label"));
  const extensions = DATA.guidewords.filter((word) => word.extension);
  return part("hazop", "The HAZOP matrix", "Every guideword asked of every parameter.  A cell shows in how many of its eligible situations its default mutant is killed; it opens its mutants.",
    h("ul", { class: "legend" },
      h("li", {}, "none killed", h("span", { class: "ramp" }), "all killed"),
      h("li", {}, h("span", { class: "swatch framed", "aria-hidden": "true" }), "bold frame: survives everywhere"),
      ["baseline_red", "masked", "not_infected", "not_reached"].map((state) => h("li", {}, swatch(state), STATES[state][0])),
      h("li", {}, swatch("not_meaningful"), "not meaningful"),
      h("li", {}, swatch("not_flown"), "not flown"),
      Object.keys(DATA.margins).length > 0 && h("li", {}, h("b", {}, "margin"), "the least magnitude that kills: 1-3 s between the two, \u2264 3 s nothing milder flown, > 3 s none flown kills"),
      h("li", {}, h("b", {}, "C"), "crude control, in no ratio")),
    h("div", { class: "scroll" }, board),
    extensions.length > 0 && h("p", { class: "small faint" }, extensions.map((word) => `* ${word.title}: no guideword of IEC 61882.  ${word.reason}`).join("  ")));
}

function hazopCell(cell) {
  const { state, share: killed, text, survivor, said } = cellState(cell);
  const margin = text ? marginText(cell.name) : "";
  const says = `${cell.guideword} ${cell.parameter}. ${cell.deviation || ""}\n${said}${margin ? `\nmargin ${margin}` : ""}${cell.status === "control" ? "\ncrude control, in no ratio" : ""}`;
  const classes = ["state", survivor && "survivor", killed > 0.5 && "deep", cell.status === "control" && "control"].filter(Boolean);
  return h("td", { class: classes.join(" "), role: "gridcell", tabindex: "-1", "data-cell": cell.name, "data-state": state === "survived" && text ? "survived-rate" : state, "--share": killed ?? 0, "aria-label": says },
    text, margin && h("span", { class: "margin" }, margin));
}
