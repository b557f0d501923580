/* The HAZOP matrix as a heat map: guidewords across, parameters down. */
function cellState(cell) {
  if (cell.status === "not_meaningful") return { state: "not_meaningful", text: "", said: `not meaningful: ${cell.reason}` };
  const mutant = MUTANTS.get(cell.default) ?? MUTANTS.get(cell.mutants[0]);
  if (!mutant) return { state: "not_flown", text: "", said: `not flown: ${cell.deviation}` };
  if (mutant.control) return { state: mutant.shows.length ? "shows" : "silent", text: mutant.shows.join(" "), said: `${mutant.id}: ${showsText(mutant)}` };
  const said = `${mutant.id}: ${verdictText(mutant)}; ${killsText(mutant)}`;
  if (mutant.verdict === "not_tested") return { state: stopped(mutant), text: stopped(mutant) === "no_test" ? "no test" : "", said };
  return { state: mutant.verdict, share: share(mutant.kill_rate) ?? 0, text: `${VERDICTS[mutant.verdict][0]}\u00a0${mutant.kill_rate.whole ? shortText(mutant.kill_rate) : ""}`, said };
}

/** Where a mutant that is never put to the test stopped: a sign of the kill matrix. */
const stopped = ({ status }) => (Object.hasOwn(SIGNS, status) ? status : status === "invalid" ? "not_flown" : "no_test");
const killsText = ({ kill_rate: rate, kill_rate_flown: flown }) => `kills in ${rate.part} of ${plural(rate.whole, "situation")} that put it to the test, of ${flown.whole} flown`;
const showsText = ({ shows }) => (shows.length ? `shows itself by ${shows.join(" and ")}` : "does not show itself");
const verdictText = (mutant) => {
  const [safety, others] = [true, false].map((wanted) => mutant.by.filter((name) => SAFETY.includes(name) === wanted));
  const why = safety.length ? ` by ${listed(safety)}` : mutant.verdict === "not_tested" && stopped(mutant) !== "no_test" ? `, ${SIGNS[stopped(mutant)][0]}` : "";
  return `${spaced(mutant.verdict)}${why}${others.length ? `; operability shows it, by ${listed(others)}` : ""}`;
};

function hazop() {
  const board = h("table", { class: "hazop", role: "grid", "aria-label": "HAZOP matrix: parameters down, guidewords across" },
    h("thead", {}, h("tr", {}, h("th", { class: "corner" }, h("span", { class: "faint" }, "parameter")), DATA.guidewords.map((word) => h("th", { scope: "col", title: word.meaning }, word.title + (word.extension ? "*" : ""))))),
    h("tbody", {}, DATA.parameters.map((parameter) => h("tr", {},
      h("th", { scope: "row", title: parameter.intent }, parameter.title),
      DATA.guidewords.map((word) => hazopCell(CELLS.get(`${word.id}-${parameter.id}`)))))));
  roving(board, "td", () => [...board.tBodies[0].rows], (cell) => go(cellHash(cell.dataset.cell))).reset();
  tip.on(board, "td", (cell) => cell.getAttribute("aria-label"));
  const extensions = DATA.guidewords.filter((word) => word.extension);
  return part("hazop", "The HAZOP matrix", "Every guideword asked of every parameter.  A cell shows the verdict on its default mutant, and in how many of the situations that put it to the test a requirement kills it; it opens the cell's mutants.",
    h("ul", { class: "legend" },
      h("li", {}, swatch("detected", VERDICTS.detected[0]), h("b", {}, "detected"), "killed in few", h("span", { class: "ramp" }), "all situations"),
      h("li", {}, swatch("undecided", VERDICTS.undecided[0]), h("b", {}, "undecided"), "too few flights to tell"),
      h("li", {}, swatch("not_detected", VERDICTS.not_detected[0]), h("b", {}, "not detected"), "tested, nothing seen"),
      h("li", {}, h("b", {}, "not tested"), "because"),
      ["no_test", "masked", "not_infected", "not_reached"].map((state) => h("li", {}, swatch(state), state === "no_test" ? "it acts only where no pair is steady" : SIGNS[state][0])),
      h("li", {}, swatch("not_meaningful"), "not meaningful"),
      h("li", {}, swatch("not_flown"), "not flown"),
      Object.keys(DATA.margins).length > 0 && h("li", {}, h("b", {}, "margin"), "the least magnitude with a kill: 1-3 s between the two, \u2264 3 s nothing milder flown, > 3 s none flown has one"),
      h("li", {}, h("b", {}, "C"), "crude control, in no ratio, with the requirements that show it")),
    h("div", { class: "scroll" }, board),
    extensions.length > 0 && h("p", { class: "small faint" }, extensions.map((word) => `* ${word.title}: no guideword of IEC 61882.  ${word.reason}`).join("  ")));
}

function hazopCell(cell) {
  const { state, share: killed, text, said } = cellState(cell);
  const control = cell.status === "control";
  const margin = killed !== undefined ? marginText(cell.name) : "";
  const says = `${cell.guideword} ${cell.parameter}. ${cell.deviation || ""}\n${said}${margin ? `\nmargin ${margin}` : ""}${control ? "\ncrude control, in no ratio" : ""}`;
  const classes = ["state", killed > 0.5 && "deep", control && "control"].filter(Boolean);
  return h("td", { class: classes.join(" "), role: "gridcell", tabindex: "-1", "data-cell": cell.name, "data-state": state, "--share": killed > 0.5 ? 0.4 + 0.6 * killed : 0.5 * (killed ?? 0), "aria-label": says },
    text, margin && h("span", { class: "margin" }, margin));
}
