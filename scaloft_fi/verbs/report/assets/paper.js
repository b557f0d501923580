/* What the screen has behind a click, laid out for paper: every detected mutant, its kills, and the flight that shows it. */
function onPaper() {
  const detected = DATA.mutants.filter((mutant) => mutant.verdict === "detected" && !mutant.control);
  const counted = detected.filter((mutant) => mutant.counts);
  const shown = counted.length ? counted : detected;
  if (!shown.length) return null;
  const section = part("details", "Every detected mutant", "What shows each fault: where it is killed, and one flight that has the violation beside that of the unmutated drone with the same seed.",
    h("p", { class: "small faint" }, TESTED),
    shown.map((mutant) => h("article", { class: "detail" },
      h("h3", { class: "sub" }, h("span", { class: "id" }, mutant.id)),
      CELLS.has(mutant.cell) && h("p", { class: "small" }, [CELLS.get(mutant.cell).deviation, CELLS.get(mutant.cell).effect].filter(Boolean).join("  ")),
      h("div", { class: "facts-on-paper" }, mutantFacts(mutant)),
      h("div", { class: "drawn", "data-mutant": mutant.id }))));
  section.classList.add("paper");
  return section;
}

/** Draw the flights of that section, one at a time while nothing else is to do. */
async function drawOnPaper() {
  const section = document.getElementById("details");
  if (!section || !CAN_INFLATE) return;
  for (const place of section.querySelectorAll(".drawn")) {
    await new Promise((resolve) => { (globalThis.requestIdleCallback ?? setTimeout)(resolve); });
    const { id, first } = MUTANTS.get(place.dataset.mutant);
    if (!first) continue;
    const flights = await flightsIn(first.situation);
    const of = (name) => flights?.find((one) => one.mutant === name && one.seed === first.seed) ?? null;
    const flight = of(id);
    if (!flight?.rows) continue;
    const { map, plots } = drawn(first.situation, flight, of("baseline"));
    place.append(
      h("p", { class: "small" }, `The flight ${id}/${first.situation}/${first.seed}: ${wordsOf(first.situation)}.`),
      h("div", { class: "flight" }, h("figure", {}, map?.root, key(flight, of("baseline"))), h("div", {}, plots.map((picture) => h("figure", {}, h("figcaption", {}, picture.caption), picture.root)))));
  }
  section.dataset.drawn = "yes";
}
