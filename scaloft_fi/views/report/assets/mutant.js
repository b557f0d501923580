/* A mutant: its verdict and what it rests on, where it is killed, its results; in the sheet of its cell, and with its Karnaugh map in a sheet of its own. */
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
        ["margin of the cell", DATA.margins[mutant.cell] && [marginText(mutant.cell), limitLines(againstOf(mutant.cell))]],
      ].filter(([, told]) => told && told.length).map(([what, told]) => [h("dt", {}, what), h("dd", {}, told)])),
      h("h3", { class: "sub" }, "Where a safety requirement kills it"), karnaughMap(mutant),
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
  const { first, decided_at: decided } = mutant;
  const word = mutant.control ? showsText(mutant) : verdictText(mutant);
  return [
    h("p", {}, h("b", {}, capital(word)), `.  ${mutant.control ? "" : VERDICTS[mutant.verdict][1]}  `, findOf(mutant) ?? needed(mutant, decided)),
    (mutant.condition || first) && h("p", { class: "small" }, mutant.condition && `${mutant.kill_rate.part ? "Killed" : "Violations seen, no kill,"} where: ${mutant.condition}.  `,
      first && ["Earliest: ", h("a", { href: flightHash(mutant.id, first.situation, first.seed) }, `${first.requirement} at ${seconds(first.t_s)} in ${first.situation}, seed ${first.seed}`), "."]),
    mutant.tests.length > 0 && table(["tested by", { text: "p", number: true }, { text: "kills", number: true }, { text: "flights", number: true }, { text: "unmutated", number: true }],
      mutant.tests.map(({ requirement, p, kills, flights, baseline }) => [requirement, pText(p), ...[kills, flights, baseline].map(shortText)]), { stack: false }),
    mutant.tests.length > 0 && h("p", { class: "small faint" }, `Kills: of the situations where the requirement tests it.  Flights: those there that violate it, of the mutant and of the unmutated drone.  p, over all situations that can be judged: the chance of so many violations or more if the fault did nothing, adjusted for the number of requirements; detected where at most ${trimmed(decided.alpha, 4)}, at ${plural(decided.seeds, "seed")}.`),
    acceptance(mutant.id),
  ];
}

/** The situation that a search found for a mutant, which is to be flown next; null without one. */
function findOf(mutant) {
  const told = DATA.survivors.find((one) => one.mutant === mutant.id);
  return told?.find ? [withCode(told.why), " ", h("a", { href: findHash(told.find) }, "The situation found")] : null;
}

/** The command whose flights would decide on an undecided mutant. */
function needed(mutant, { needed: seeds, anew }) {
  if (mutant.verdict !== "undecided" || mutant.control) return "";
  if (!seeds) return mutant.tests.length ? "No more than 50 seeds would not decide." : "A baseline pool is missing where it infects; the same run flies it.";
  const where = anew ? ` --campaign NEW${DATA.grid ? ` --grid ${literal(DATA.grid)}` : ""}` : inCampaign();
  return [`${seeds} seeds would decide if what was seen goes on: `, inCode(`scaloft-fi run${where} --mutant ${literal(mutant.id)} --seeds ${seeds}`)];
}

/** Its result in each situation flown, each a link to a flight that has it. */
function flownList(mutant) {
  return h("ul", { class: "flown-list", "aria-label": `situations of ${mutant.id}` }, mutant.results.map((result, column) => {
    const situation = DATA.situations[column];
    const { state, glyph, said, seed } = shown(result, situation.key);
    if (state === "not_flown") return null;
    return h("li", {}, h("a", { class: "swatch state", "data-state": state, href: flightHash(mutant.id, situation.key, seed),
      "aria-label": `${situation.words.join(", ")}: ${said}`, title: `${situation.words.join(", ")}: ${said}` }, glyph));
  }));
}
