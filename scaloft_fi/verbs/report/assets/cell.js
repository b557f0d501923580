/* The sheet of one HAZOP cell: its default mutant with the flight that shows it, what the cell asks, its other mutants. */
function cellSheet(name) {
  const cell = CELLS.get(name);
  if (!cell) return { title: name, lead: "", body: [h("p", { class: "notice" }, `The study has no cell ${name}.`)] };
  const mutants = cell.mutants.map((id) => MUTANTS.get(id));
  const main = mutants.find((mutant) => mutant.id === cell.default);
  const others = mutants.filter((mutant) => mutant !== main);
  return {
    title: name, walk: main && walk(main, (one) => cellHash(one.cell)), lead: { credible: "A credible deviation.", control: "A crude control: it must show itself, and enters no ratio.", not_meaningful: "Not meaningful.", to_do: "A draft that nobody has finished: it has no mutant." }[cell.status],
    body: [
      main && mutantBlock(main),
      h("h3", { class: "sub" }, "What the cell asks"),
      cellFacts(cell),
      others.length > 0 && [h("h3", { class: "sub" }, "Other mutants of the cell"), others.map((mutant) => h("details", { class: "fold" },
        h("summary", {}, h("b", { class: "id" }, mutant.id), ` ${verdictText(mutant)}, ${killsText(mutant)}`), mutantBlock(mutant)))],
      !mutants.length && ["credible", "control"].includes(cell.status) && h("p", { class: "note" }, "No mutant of this cell was flown in this campaign: ", h("code", {}, `${DATA.again}${OF_TESTS ? "" : inCampaign()} --mutant ${literal(`${name}*`)}`)),
    ],
  };
}

/** Its row of the worksheet. */
function cellFacts(cell) {
  const word = DATA.guidewords.find((entry) => entry.id === cell.guideword);
  const parameter = DATA.parameters.find((entry) => entry.id === cell.parameter);
  const pairs = [
    ["guideword", `${word.title}: ${word.meaning}`],
    ["parameter", `${parameter.title}: ${parameter.intent}`],
    ["node", parameter.node],
    cell.deviation && ["deviation", cell.deviation],
    cell.causes.length && ["causes", cell.causes.map((cause) => h("span", { class: "line" }, cause))],
    cell.effect && ["effect", cell.effect],
    cell.severity && ["severity", `${cell.severity}: ${titleOf("severities", cell.severity)}`],
    cell.requirements.length && ["requirements", listed(cell.requirements)],
    cell.predicted && ["predicted", cell.predicted],
    cell.expected.length && ["known beforehand", cell.expected.join("; ")],
    cell.reason && ["why not meaningful", cell.reason],
    DATA.margins[cell.name] && ["margin", [marginText(cell.name), limitLines(againstOf(cell.name))]],
  ].filter(Boolean);
  return h("dl", { class: "pairs" }, pairs.map(([what, text]) => [h("dt", {}, term(what)), h("dd", {}, text)]));
}
