/* The HAZOP matrix: guidewords across, parameters down; shaded by how sure a detection is, hatched where nothing is decided. */
function cellState(cell) {
  if (cell.status === "not_meaningful") return { state: "not_meaningful", text: "", said: `not meaningful: ${cell.reason}` };
  if (cell.status === "to_do") return { state: "not_flown", text: "to do", said: `to do: ${cell.deviation}` };
  const mutant = MUTANTS.get(cell.default) ?? MUTANTS.get(cell.mutants[0]);
  if (!mutant) return { state: "not_flown", text: "not flown", said: `not flown: ${cell.deviation}` };
  if (mutant.control) return { state: mutant.shows.length ? "shows" : "silent", text: mutant.shows.join(" ") || "silent", said: `${mutant.id}: ${showsText(mutant)}` };
  const told = { sure: mutant.certainty, operable: mutant.by.some((name) => !SAFETY.includes(name)), said: `${mutant.id}: ${verdictText(mutant)}; ${killsText(mutant)}` };
  if (mutant.verdict === "not_tested") return { ...told, state: "not_tested", text: SIGNS[stopped(mutant)][0] };
  return { ...told, state: mutant.verdict, text: `${markOf(mutant)}\u00a0${rateText(mutant)}` };
}

/** The mark of a verdict; of a detection one for each step of certainty, and a tilde where it is not firm. */
const markOf = (mutant) => VERDICTS[mutant.verdict][0].repeat(Math.max(1, mutant.certainty)) + (mutant.firm && !isFirm(mutant) ? "~" : "");
/** Where a mutant that is never put to the test stopped: a sign of the kill matrix. */
const stopped = ({ status }) => (Object.hasOwn(SIGNS, status) ? status : status === "invalid" ? "not_flown" : "no_test");
/** In how many of the situations that test it a mutant is killed; in words where it is detected without a kill. */
const rateText = ({ verdict, kill_rate: rate }) => (verdict === "detected" && !rate.part ? "no\u00a0kill" : rate.whole ? shortText(rate) : "");
const killsText = ({ kill_rate: rate, kill_rate_flown: flown }) => `killed in ${rate.part} of ${plural(rate.whole, "situation")} that put it to the test, of ${flown.whole} flown`;
const showsText = ({ shows }) => (shows.length ? `shows itself by ${shows.join(" and ")}` : "does not show itself");
const verdictText = (mutant) => {
  const [safety, others] = [true, false].map((wanted) => mutant.by.filter((name) => SAFETY.includes(name) === wanted));
  const why = safety.length ? ` by ${listed(safety)}` : mutant.verdict === "not_tested" && stopped(mutant) !== "no_test" ? `, ${SIGNS[stopped(mutant)][0]}` : "";
  return `${spaced(mutant.verdict)}${why}${mutant.firm ? `, ${FIRMNESS[mutant.firm]}` : ""}${others.length ? `; operability shows it, by ${listed(others)}` : ""}`;
};
/** How sure a detection is, in words. */
const sureText = ({ certainty }) => (certainty ? `p at most ${DATA.certainty[certainty - 1].toLocaleString("en", { maximumFractionDigits: 12 })}` : "");

function hazop() {
  const board = h("table", { class: "hazop", role: "grid", "aria-label": "HAZOP matrix: parameters down, guidewords across" },
    h("thead", { role: "rowgroup" }, h("tr", { role: "row" }, h("th", { class: "corner", scope: "col", role: "columnheader" }, h("span", { class: "faint" }, "parameter")), DATA.guidewords.map((word) => h("th", { scope: "col", role: "columnheader", title: word.meaning }, wordOf(word))))),
    h("tbody", { role: "rowgroup" }, DATA.parameters.map((parameter) => h("tr", { role: "row" },
      h("th", { scope: "row", role: "rowheader", title: parameter.intent }, parameter.title),
      DATA.guidewords.map((word) => hazopCell(CELLS.get(`${word.id}-${parameter.id}`), word))))));
  roving(board, "td", () => [...board.tBodies[0].rows], (cell) => go(cellHash(cell.dataset.cell))).reset();
  tip.on(board, "td", (cell) => cell.getAttribute("aria-label"));
  const extensions = DATA.guidewords.filter((word) => word.extension);
  return part("hazop", "The HAZOP matrix", "Every guideword asked of every parameter.  A cell shows the verdict on its default mutant, and in how many of the situations that put the mutant to the test a requirement kills it.  A click opens the cell, with a flight that shows it.",
    h("ul", { class: "legend" },
      DATA.certainty.map((_, step) => h("li", {}, swatch("detected", VERDICTS.detected[0].repeat(step + 1), step + 1), step ? sureText({ certainty: step + 1 }) : [h("b", {}, term("detected")), sureText({ certainty: 1 }), ": the chance that a fault which does nothing looks so"])),
      h("li", {}, h("b", {}, `${VERDICTS.detected[0]}~`), "detected, not ", term("firm"), ": without some seed it is not, or too few seeds remain"),
      h("li", {}, swatch("not_detected", VERDICTS.not_detected[0]), h("b", {}, term("not detected")), "tested, nothing seen"),
      h("li", {}, swatch("undecided", VERDICTS.undecided[0]), h("b", {}, term("undecided")), "hatched: something seen, or too few flights"),
      h("li", {}, swatch("not_tested"), h("b", {}, term("not tested")), "hatched wide, with the reason in words"),
      h("li", {}, swatch("not_meaningful"), term("not meaningful")),
      h("li", {}, h("b", {}, "8/10"), "killed in 8 of 10 situations that put it to the test"),
      h("li", {}, h("b", {}, "no kill"), "detected by violations here and there; in no situation do most flights violate"),
      Object.keys(DATA.margins).length > 0 && h("li", {}, h("b", {}, term("margin")), "the least magnitude with a kill: 1-3 s between the two, \u2264 3 s nothing milder flown, > 3 s none flown has one"),
      h("li", {}, h("b", {}, "op"), h("span", {}, "not detected by safety; ", term("operability"), " shows it")),
      h("li", {}, h("b", {}, "C"), h("span", {}, "crude ", term("control"), ", in no ratio, with the requirements that show it"))),
    h("div", { class: "scroll" }, board),
    extensions.length > 0 && h("p", { class: "small faint" }, extensions.map((word) => `* ${word.title}: no guideword of IEC 61882.  ${word.reason}`).join("  ")));
}

const wordOf = (word) => word.title + (word.extension ? "*" : "");

function hazopCell(cell, word) {
  const { state, sure, operable, text, said } = cellState(cell);
  const control = cell.status === "control";
  const margin = sure === undefined ? "" : marginText(cell.name);
  const says = `${cell.guideword} ${cell.parameter}. ${cell.deviation || ""}\n${said}${sure ? `\n${sureText({ certainty: sure })}` : ""}${margin ? `\nmargin ${margin}` : ""}${control ? "\ncrude control, in no ratio" : ""}`;
  return h("td", { class: "state", role: "gridcell", tabindex: "-1", "data-cell": cell.name, "data-word": wordOf(word), "data-state": state, "data-sure": sure || null, "data-tag": control ? "C" : null, "aria-label": says },
    h("span", { class: "plate" }, text, operable && state !== "detected" && h("span", { class: "op" }, " op")), margin && h("span", { class: "margin" }, h("span", { class: "plate" }, margin)));
}
