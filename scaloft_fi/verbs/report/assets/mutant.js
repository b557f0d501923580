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
        ["margin", DATA.margins[mutant.cell] && [marginText(mutant.cell), limitLines(againstOf(mutant.cell))]],
      ].filter(([, told]) => told && told.length).map(([what, told]) => [h("dt", {}, term(what)), h("dd", {}, told)])),
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

const TESTED = "Kills: of the situations where the requirement tests the fault.  Flights: those there that violate it, of the mutant and of the unmutated drone.  p, over all situations that can be judged: the chance of so many violations or more if the fault did nothing, adjusted for the number of requirements.";

function mutantFacts(mutant) {
  const { first, decided_at: decided } = mutant;
  const word = mutant.control ? showsText(mutant) : verdictText(mutant);
  const sure = mutant.certainty > 0 && `, ${sureText(mutant)}`;
  return [
    h("p", {}, h("b", {}, capital(word)), sure, `.  ${mutant.control ? "" : VERDICTS[mutant.verdict][1]}  `, findOf(mutant) ?? needed(mutant, decided)),
    first && h("p", {}, h("a", { class: "go", href: flightHash(mutant.id, first.situation, first.seed) }, `See the flight: ${first.requirement} violated at ${seconds(first.t_s)}`), " ", h("span", { class: "faint small" }, `${wordsOf(first.situation)}, seed ${first.seed}`)),
    mutant.condition && h("p", { class: "small" }, `${mutant.kill_rate.part ? "Killed" : "Violations seen, no kill,"} where: ${mutant.condition}.`),
    killTable(mutant),
    mutant.tests.length > 0 && table(["tested by", { text: "p", number: true }, { text: "kills", number: true }, { text: "flights", number: true }, { text: "unmutated drone", number: true }],
      mutant.tests.map(({ requirement, p, kills, flights, baseline }) => [requirement, pText(p), ...[kills, flights, baseline].map(shortText)]), { stack: false }),
    mutant.tests.length > 0 && h("p", { class: "small faint" }, h("span", { class: "once" }, `${TESTED}  `), `Detected where p is at most ${trimmed(decided.alpha, 4)}, at ${plural(decided.seeds, "seed")}.`),
    acceptance(mutant.id),
  ];
}

/** A requirement that kills; the score counts those of safety alone. */
const byText = (requirement) => (SAFETY.includes(requirement) ? requirement : `${requirement} (${requirementOf(requirement)?.kind})`);

/** Its kills by name: the situation, the requirement, and the flight that has the violation. */
function killTable(mutant) {
  if (!mutant.kills.length) return null;
  return table(["situation", "killed by", { text: "violated", number: true }, { text: "unmutated drone", number: true }, { text: "violated at", number: true }, "strikes", "flight"],
    mutant.kills.map(({ situation, requirement, flights, baseline, seed, t_s: time, struck }) => [
      h("a", { href: situationHash(situation) }, named(situation)), byText(requirement), shortText(flights), shortText(baseline), seconds(time), struck || "\u2013",
      h("a", { href: flightHash(mutant.id, situation, seed), "aria-label": `flight with seed ${seed}, ${wordsOf(situation)}, ${requirement}` }, `\u25b6\u00a0seed\u00a0${seed}`)]));
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

/** Its result in each situation flown by the name of the situation, each a link to a flight that has it. */
function flownList(mutant) {
  return h("details", { class: "fold" }, h("summary", {}, `Its result in each situation (${mutant.kill_rate_flown.whole})`),
    h("ul", { class: "flown-list", "aria-label": `situations of ${mutant.id}` }, mutant.results.map((result, column) => {
      const situation = DATA.situations[column];
      const { state, glyph, said, seed } = shown(result, situation.key);
      if (state === "not_flown") return null;
      return h("li", {}, h("a", { href: flightHash(mutant.id, situation.key, seed), title: `${situation.words.join(", ")} (${codeOf(situation)}): ${said}` },
        swatch(state, glyph), h("span", {}, situation.name, " ", h("span", { class: "faint" }, codeOf(situation))), h("span", { class: "visually-hidden" }, `: ${SIGNS[state][0]}`)));
    })));
}
