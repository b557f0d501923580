/* The HAZOP matrix: guidewords across, parameters down; warm where a fault is missed, the worse the darker; shaded by how sure a detection is, hatched where nothing is decided. */
function cellState(cell) {
  if (cell.status === "not_meaningful") return { state: "not_meaningful", text: "", said: `not meaningful: ${cell.reason}` };
  if (cell.status === "to_do") return { state: "not_flown", text: "to do", said: `to do: ${cell.deviation}` };
  const mutant = MUTANTS.get(cell.default);
  if (!mutant) return { state: "not_flown", text: cell.mutants.length ? "not default" : "not flown", said: `${cell.mutants.length ? `only ${listed(cell.mutants)} flown` : "not flown"}: ${cell.deviation}` };
  if (mutant.control) return { state: mutant.shows.length ? "shows" : "silent", text: mutant.shows.join(" ") || "silent", said: `${mutant.id}: ${showsText(mutant)}` };
  const told = { sure: mutant.certainty, operable: mutant.by.some((name) => !SAFETY.includes(name)), said: `${mutant.id}: ${verdictText(mutant)}; ${killsText(mutant)}` };
  const idle = mutant.verdict === "not_tested" ? SIGNS[stopped(mutant)][0] : "same";
  if (mutant.same) return { ...told, state: "same", text: `= ${idle}` };
  if (mutant.verdict === "not_tested") return { ...told, state: "not_tested", text: `${VERDICTS.not_tested[0]} ${idle}` };
  const rate = mutant.verdict === "not_detected" ? "" : rateText(mutant);
  return { ...told, state: mutant.verdict, text: [markOf(mutant), rate].filter(Boolean).join(" ") };
}

/** The mark of a verdict; of a detection one for each step of certainty, hollow where it is not firm. */
const markOf = (mutant) => (mutant.firm && !isFirm(mutant) ? "\u25cb" : VERDICTS[mutant.verdict][0]).repeat(Math.max(1, mutant.certainty));
/** What became of a fault: its verdict, or that all its flights are the unmutated drone's to the bit. */
const fateOf = (mutant) => (mutant.same ? "same" : mutant.verdict);
/** The place of a class of severity, 1 for the worst; 0 without one. */
const rankOf = ({ severity }) => DATA.severities.findIndex(({ id }) => id === severity) + 1;
/** Where a mutant that is never put to the test stopped: a sign of the kill matrix. */
const stopped = ({ status }) => (Object.hasOwn(SIGNS, status) ? status : status === "invalid" ? "not_flown" : "no_test");
/** In how many of the situations that test it a mutant is killed; a word where it is detected without a kill. */
const rateText = ({ verdict, kill_rate: rate }) => (verdict === "detected" && !rate.part ? "rarely" : rate.whole ? shortText(rate) : "");
const killsText = ({ kill_rate: rate, kill_rate_flown: flown }) => `killed in ${rate.part} of ${plural(rate.whole, "situation")} that put it to the test, of ${flown.whole} flown`;
const showsText = ({ shows }) => (shows.length ? `shows itself by ${shows.join(" and ")}` : "does not show itself");
const verdictText = (mutant) => {
  const [safety, others] = [true, false].map((wanted) => mutant.by.filter((name) => SAFETY.includes(name) === wanted));
  const why = safety.length ? ` by ${listed(safety)}` : mutant.verdict === "not_tested" && stopped(mutant) !== "no_test" ? `, ${SIGNS[stopped(mutant)][0]}` : "";
  return `${spaced(mutant.verdict)}${why}${mutant.firm ? `, ${FIRMNESS[mutant.firm]}` : ""}${others.length ? `; operability shows it, by ${listed(others)}` : ""}`;
};
/** How sure a detection is, in words. */
const sureText = ({ certainty }) => (certainty ? `p at most ${DATA.certainty[certainty - 1].toLocaleString("en", { maximumFractionDigits: 12 })}` : "");

/** The matrix whole, with what its signs mean. */
function hazop() {
  const board = h("table", { class: "hazop", role: "grid", "aria-label": "HAZOP matrix: parameters down, guidewords across" },
    h("thead", { role: "rowgroup" }, h("tr", { role: "row" }, h("th", { class: "corner", scope: "col", role: "columnheader" }, h("span", { class: "faint" }, "parameter")), DATA.guidewords.map((word) => h("th", { scope: "col", role: "columnheader", title: word.meaning }, wordOf(word))))),
    h("tbody", { role: "rowgroup" }, DATA.parameters.map((parameter) => h("tr", { role: "row" },
      h("th", { scope: "row", role: "rowheader", title: parameter.intent }, parameter.title),
      DATA.guidewords.map((word) => hazopCell(CELLS.get(`${word.id}-${parameter.id}`), word))))));
  roving(board, "td", () => [...board.tBodies[0].rows], (cell) => go(cellHash(cell.dataset.cell))).reset();
  tip.on(board, "td", (cell) => cell.getAttribute("aria-label"));
  const extensions = DATA.guidewords.filter((word) => word.extension);
  const classes = DATA.severities.map(({ id, title }, place) => h("li", { title }, swatch("not_detected", String(place + 1), null, Math.min(place + 1, RANKS)), id));
  return h("section", { id: "hazop", "aria-label": "The HAZOP matrix", tabindex: "-1" },
    h("div", { class: "scroll" }, board),
    classes.length > 0 && h("ul", { class: "legend" }, h("li", {}, h("b", {}, "missed:"), "put to the test, nothing seen; by the class of the consequence"), classes),
    h("details", { class: "fold", open: ROOMY.matches }, h("summary", {}, "how to read the matrix"),
      h("ul", { class: "legend" },
        DATA.certainty.map((_, step) => h("li", {}, swatch("detected", VERDICTS.detected[0].repeat(step + 1), step + 1), step ? sureText({ certainty: step + 1 }) : [h("b", {}, term("detected")), sureText({ certainty: 1 }), ": the chance that a fault which does nothing looks so"])),
        h("li", {}, h("b", {}, "\u25cb"), "detected, not ", term("firm"), ": without some seed it is not, or too few seeds remain"),
        h("li", {}, swatch("undecided", VERDICTS.undecided[0]), h("b", {}, term("undecided")), "hatched: something seen, or too few flights"),
        h("li", {}, h("b", {}, "="), "no effect: every flight is the unmutated drone's to the bit"),
        h("li", {}, swatch("not_tested", VERDICTS.not_tested[0]), h("b", {}, term("not tested")), "with the reason in words"),
        h("li", {}, swatch("not_meaningful"), "no such fault: ", term("not meaningful")),
        h("li", {}, h("b", {}, "8/10"), "killed in 8 of 10 situations that put it to the test"),
        h("li", {}, h("b", {}, "rarely"), "detected by violations here and there, no kill: in no situation do most flights violate"),
        h("li", {}, h("b", {}, "op"), h("span", {}, "not detected by safety; ", term("operability"), " shows it")),
        h("li", {}, h("b", {}, "C"), h("span", {}, "crude ", term("control"), ", not among the faults, with the requirements that show it"))),
      extensions.length > 0 && h("p", { class: "small faint" }, extensions.map((word) => `* ${word.title}: no guideword of IEC 61882.  ${word.reason}`).join("  "))));
}

/** Classes of severity with a colour of their own; all milder ones have the last. */
const RANKS = 4;
/** The rank by whose colour a missed fault is shown; null without one. */
const shownRank = (mutant) => Math.min(rankOf(mutant), RANKS) || null;
/** Where what the signs mean has room beside the first screen. */
const ROOMY = matchMedia("(min-width: 80rem)");
const wordOf = (word) => word.title + (word.extension ? "*" : "");

function hazopCell(cell, word) {
  const { state, sure, operable, text, said } = cellState(cell);
  const control = cell.status === "control";
  const margin = sure === undefined ? "" : marginText(cell.name);
  const says = `${cell.guideword} ${cell.parameter}. ${cell.deviation || ""}\n${said}${sure ? `\n${sureText({ certainty: sure })}` : ""}${margin ? `\nmargin ${margin}` : ""}${control ? "\ncrude control, in no ratio" : ""}`;
  const rank = state === "not_detected" ? rankOf(cell) : 0;
  return h("td", { class: "state", role: "gridcell", tabindex: "-1", "data-cell": cell.name, "data-word": wordOf(word), "data-state": state, "data-sure": sure || null, "data-rank": rank ? shownRank(cell) : null, "data-tag": control ? "C" : rank || null, "aria-label": says },
    h("span", { class: "plate" }, text, operable && state !== "detected" && h("span", { class: "op" }, " op")));
}
