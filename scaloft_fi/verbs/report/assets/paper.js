/* What the screen has behind a click, laid out for paper: every detected mutant, its kills, and the flight that shows it. */
function onPaper() {
  const shown = shownOnPaper();
  if (!shown.length) return null;
  const section = part("details", "Every detected mutant", "What shows each fault: where it is killed, and one flight that has the violation beside that of the unmutated drone with the same seed.",
    h("p", { class: "small faint" }, TESTED));
  section.classList.add("paper");
  return section;
}

function shownOnPaper() {
  const detected = DATA.mutants.filter((mutant) => mutant.verdict === "detected" && !mutant.control);
  const counted = detected.filter((mutant) => mutant.counts);
  return counted.length ? counted : detected;
}

/** Fill that section when the page is printed.  Nothing can be unpacked then, so its flights are unpacked before, while nothing else is to do. */
async function drawOnPaper() {
  const section = document.getElementById("details");
  if (!section) return;
  const flights = new Map();
  addEventListener("beforeprint", () => section.append(...shownOnPaper().map((mutant) => detailOnPaper(mutant, flights.get(mutant.first?.situation)))), { once: true });
  for (const { first } of shownOnPaper()) {
    if (!first || flights.has(first.situation)) continue;
    await new Promise((resolve) => { (globalThis.requestIdleCallback ?? setTimeout)(resolve); });
    flights.set(first.situation, await flightsIn(first.situation));
  }
  section.dataset.ready = "yes";
}

function detailOnPaper(mutant, flights) {
  const cell = CELLS.get(mutant.cell);
  return h("article", { class: "detail" },
    h("h3", { class: "sub" }, h("span", { class: "id" }, mutant.id)),
    cell && h("p", { class: "small" }, [cell.deviation, cell.effect].filter(Boolean).join("  ")),
    h("div", { class: "facts-on-paper" }, mutantFacts(mutant)),
    h("div", { class: "drawn" }, flightOnPaper(mutant, flights)));
}

function flightOnPaper({ id, first }, flights) {
  const [flight, clean] = [id, "baseline"].map((name) => flights?.find((one) => one.mutant === name && one.seed === first.seed) ?? null);
  if (!flight?.rows) return [];
  const { map, plots } = drawn(first.situation, flight, clean);
  return [h("p", { class: "small" }, `The flight ${id}/${first.situation}/${first.seed}: ${wordsOf(first.situation)}.`),
    h("div", { class: "flight" }, h("figure", {}, map?.root, key(flight, clean)), h("div", {}, plots.map((picture) => h("figure", {}, h("figcaption", {}, picture.caption), picture.root))))];
}
