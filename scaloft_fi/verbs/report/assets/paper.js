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

/** The flights of that section, drawn when it is printed; nothing can be unpacked then, so they are unpacked before, while nothing else is to do. */
async function drawOnPaper() {
  const section = document.getElementById("details");
  if (!section || !CAN_INFLATE) return;
  const drawings = [];
  for (const place of section.querySelectorAll(".drawn")) {
    const { id, first } = MUTANTS.get(place.dataset.mutant);
    if (!first) continue;
    await new Promise((resolve) => { (globalThis.requestIdleCallback ?? setTimeout)(resolve); });
    const flights = await flightsIn(first.situation);
    const of = (name) => flights?.find((one) => one.mutant === name && one.seed === first.seed) ?? null;
    drawings.push(() => place.replaceChildren(...onPaperFlight(id, first, of(id), of("baseline"))));
  }
  addEventListener("beforeprint", () => drawings.splice(0).forEach((draw) => draw()));
  section.dataset.ready = "yes";
}

function onPaperFlight(id, { situation, seed }, flight, clean) {
  if (!flight?.rows) return [];
  const { map, plots } = drawn(situation, flight, clean);
  return [h("p", { class: "small" }, `The flight ${id}/${situation}/${seed}: ${wordsOf(situation)}.`),
    h("div", { class: "flight" }, h("figure", {}, map?.root, key(flight, clean)), h("div", {}, plots.map((picture) => h("figure", {}, h("figcaption", {}, picture.caption), picture.root))))];
}
