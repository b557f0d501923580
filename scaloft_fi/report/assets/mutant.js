/* A mutant: its rates, where it is killed, its results; in the sheet of its cell, and with its Karnaugh map in a sheet of its own. */
function mutantSheet(id) {
  const mutant = MUTANTS.get(id);
  if (!mutant) return { title: id, lead: "", body: [h("p", { class: "notice" }, `The campaign holds no mutant ${id}.`)] };
  const cell = CELLS.get(mutant.cell);
  return {
    title: id, lead: cell?.deviation || "",
    body: [
      h("div", { class: "row" }, h("a", { href: cellHash(mutant.cell) }, "its cell of the HAZOP matrix"),
        siblings(mutant).map((other) => h("a", { class: "id", href: mutantHash(other.id) }, other.id))),
      mutantFacts(mutant),
      h("dl", { class: "pairs" }, [
        ["by requirement", Object.entries(mutant.requirements).map(([name, ratio]) => h("span", { class: "line" }, h("b", {}, name), ` in ${ratio.part} of ${plural(ratio.whole, "situation")} where the clean drone held it`))],
        ["margin of the cell", DATA.margins[mutant.cell] && [marginText(mutant.cell), limitLines(againstOf(mutant.cell))]],
      ].filter(([, told]) => told && told.length).map(([what, told]) => [h("dt", {}, what), h("dd", {}, told)])),
      h("h3", { class: "sub" }, "Where it is killed"), karnaughMap(mutant),
      DATA.karnaugh.reason && flownList(mutant),
    ],
  };
}

const siblings = (mutant) => DATA.mutants.filter((other) => other.cell === mutant.cell && other.id !== mutant.id);

/** In the sheet of its cell. */
function mutantBlock(mutant) {
  return h("div", { class: "mutant" },
    h("h3", { class: "sub" }, h("a", { class: "id", href: mutantHash(mutant.id), title: "Karnaugh map and more" }, mutant.id)),
    mutantFacts(mutant), flownList(mutant));
}

function mutantFacts(mutant) {
  const first = mutant.earliest;
  return [
    h("div", { class: "row" }, h("span", {}, `${capital(STATES[mutant.status][0])}: kills ${ratioText(mutant.kill_rate)} ${intervalText(mutant.kill_rate)} of the eligible situations, ${ratioText(mutant.kill_rate_flown)} of those flown${SEVERAL ? `; decided: ${mutant.decisions.killed} killed, ${mutant.decisions.survived} survived, ${mutant.decisions.undecided} undecided` : ""}`), whisker(mutant.kill_rate, mutant.id)),
    (mutant.condition || first) && h("p", { class: "small" }, mutant.condition && `${mutant.kill_rate.part ? "Killed where" : "Killed, but only where nothing counts"}: ${mutant.condition}.  `,
      first && ["Earliest: ", h("a", { href: flightHash(mutant.id, ...splitFlight(first.flight)) }, `${first.requirement} at ${seconds(first.t_s)} in ${first.flight}`), "."]),
    acceptance(mutant.id),
  ];
}

/** Its result in each situation flown, each a link to the flight. */
function flownList(mutant) {
  return h("ul", { class: "flown-list", "aria-label": `situations of ${mutant.id}` }, mutant.results.map((result, column) => {
    const { state, share: killed, glyph, uncounted, said } = shown(result);
    if (state === "not_flown") return null;
    const situation = DATA.situations[column];
    return h("li", {}, h("a", { class: `swatch state ${killed > 0.5 ? "deep" : ""} ${uncounted ? "uncounted" : ""}`, "data-state": state, "--share": killed, href: flightHash(mutant.id, situation.key, DATA.seeds[0] ?? 0),
      "aria-label": `${situation.words.join(", ")}: ${said}`, title: `${situation.words.join(", ")}: ${said}` }, glyph));
  }));
}

function splitFlight(text) {
  const slash = text.lastIndexOf("/");
  return [text.slice(0, slash), text.slice(slash + 1)];
}
