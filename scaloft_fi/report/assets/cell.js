/* The sheet of one HAZOP cell: what it asks, and its mutants with their results. */
function cellSheet(name) {
  const cell = CELLS.get(name);
  if (!cell) return { title: name, lead: "", body: [h("p", { class: "notice" }, `The study has no cell ${name}.`)] };
  const word = DATA.guidewords.find((entry) => entry.id === cell.guideword);
  const parameter = DATA.parameters.find((entry) => entry.id === cell.parameter);
  const pairs = [
    ["guideword", `${word.title}: ${word.meaning}`],
    ["parameter", `${parameter.title}: ${parameter.intent}`],
    ["between", parameter.node],
    cell.deviation && ["deviation", cell.deviation],
    cell.causes.length && ["causes", cell.causes.map((cause) => h("span", { class: "line" }, cause))],
    cell.effect && ["effect", cell.effect],
    cell.requirements.length && ["requirements", listed(cell.requirements)],
    cell.predicted && ["predicted", cell.predicted],
    cell.expected.length && ["known beforehand", cell.expected.join("; ")],
    cell.reason && ["why not meaningful", cell.reason],
    DATA.margins[name] && ["margin", bounds(DATA.margins[name])],
  ].filter(Boolean);
  const mutants = cell.mutants.map((id) => MUTANTS.get(id));
  return {
    title: name, lead: { credible: "A credible deviation.", control: "A crude control: it must show itself, and enters no ratio.", not_meaningful: "Not meaningful." }[cell.status],
    body: [
      h("dl", { class: "pairs" }, pairs.map(([what, text]) => [h("dt", {}, what), h("dd", {}, text)])),
      mutants.length ? mutants.map(mutantBlock) : cell.status !== "not_meaningful" && h("p", { class: "note" }, "No mutant of this cell was flown in this campaign: ", h("code", {}, `scaloft-fi run --mutant ${literal(`${name}*`)}`)),
    ],
  };
}

function mutantBlock(mutant) {
  const first = mutant.earliest;
  return h("div", { class: "mutant" },
    h("h3", { class: "sub" }, h("span", { class: "id" }, mutant.id)),
    h("div", { class: "row" }, h("span", {}, STATES[mutant.status][0], `, kills ${ratioText(mutant.kill_rate)} ${intervalText(mutant.kill_rate)} of the eligible situations, ${ratioText(mutant.kill_rate_flown)} of those flown${SEVERAL ? `; decided: ${mutant.decisions.killed} killed, ${mutant.decisions.survived} survived, ${mutant.decisions.undecided} undecided` : ""}`), whisker(mutant.kill_rate, mutant.id)),
    (mutant.condition || first) && h("p", { class: "small" }, mutant.condition && `Killed where: ${mutant.condition}.  `,
      first && ["Earliest: ", h("a", { href: flightHash(mutant.id, ...splitFlight(first.flight)) }, `${first.requirement} at ${seconds(first.t_s)} in ${first.flight}`), "."]),
    h("ul", { class: "flown-list", "aria-label": `situations of ${mutant.id}` }, mutant.results.map((result, column) => {
      const { state, share: killed, glyph, uncounted, said } = shown(result);
      if (state === "not_flown") return null;
      const situation = DATA.situations[column];
      return h("li", {}, h("a", { class: `swatch state ${killed > 0.5 ? "deep" : ""} ${uncounted ? "uncounted" : ""}`, "data-state": state, "--share": killed, href: flightHash(mutant.id, situation.key, DATA.seeds[0] ?? 0),
        "aria-label": `${situation.words.join(", ")}: ${said}`, title: `${situation.words.join(", ")}: ${said}` }, glyph));
    })));
}

function splitFlight(text) {
  const slash = text.lastIndexOf("/");
  return [text.slice(0, slash), text.slice(slash + 1)];
}
