/* A mutant: hazard, flight beside the unmutated drone's, why nothing saw it and what would have, worksheet row, results; a page with a link of its own. */
async function mutantSheet(id) {
  const mutant = MUTANTS.get(id);
  if (!mutant) return { title: id, lead: "", body: [h("p", { class: "notice" }, `The campaign holds no mutant ${id}.`)] };
  const cell = CELLS.get(mutant.cell);
  const told = DATA.survivors.find((one) => one.mutant === id);
  return {
    title: id, walk: walk(mutant, (one) => mutantHash(one.id)), lead: [cell?.deviation, cell?.effect].filter(Boolean).join(" "),
    body: [
      verdictLine(mutant, told ? "" : needed(mutant)),
      ...await tellingFlight(mutant, told),
      told && missed(told),
      cell && [h("h3", { class: "sub" }, "Its row of the worksheet"), cellFacts(cell)],
      h("h3", { class: "sub" }, "Its figures"), ...figuresOf(mutant),
      !OF_TESTS && [h("h3", { class: "sub" }, "Where a safety requirement kills it"), karnaughMap(mutant)],
      (OF_TESTS || DATA.karnaugh.reason) && flownList(mutant),
      h("div", { class: "row" }, h("a", { href: cellHash(mutant.cell) }, "its cell of the HAZOP matrix"), siblings(mutant).map((other) => h("a", { class: "id", href: mutantHash(other.id) }, other.id))),
    ],
  };
}

/** The flight that says most of a mutant, in motion beside the unmutated drone's: its first violation, else where a requirement lost the most. */
async function tellingFlight(mutant, told) {
  if (OF_TESTS) return [];
  const places = DATA.situations.map(({ key }, place) => ({ situation: key, ...shown(mutant.results[place], key) }));
  const { situation, seed } = mutant.first ?? told?.loss ?? places.find(({ state }) => ["seen", "tested", "masked", "no_test"].includes(state)) ?? {};
  const flights = situation ? await flightsIn(situation) : null;
  const [flight, clean] = [mutant.id, "baseline"].map((id) => flights?.find((one) => one.mutant === id && one.seed === seed));
  if (!flight) return [];
  const chosen = mutant.first ? "its earliest violation" : told?.loss?.share > 0 ? `of all its flights ${told.loss.requirement} lost the most of its margin here` : "one of its flights";
  return [h("h3", { class: "sub" }, `The flight: ${wordsOf(situation)}, seed ${seed}`), h("p", { class: "small faint" }, `${capital(chosen)}.  `, h("a", { href: flightHash(mutant.id, situation, seed) }, "More of this flight")),
    ...pictures(situation, flight, clean ?? null), command(mutant.id, situation, seed)];
}

/** Why no requirement saw a survivor, and the situation that would have, where a search found one. */
function missed({ mutant, why, next, find: name, stage }) {
  const find = DATA.found.finds.find((one) => one.name === name);
  const says = h("div", {}, h("p", {}, "It stopped at: ", h("b", {}, stage), ".  ", withCode(why)),
    find ? h("p", {}, h("a", { href: findHash(name) }, "The situation found")) : h("p", {}, "To change: ", h("b", {}, NEXT[next] ?? next), "."),
    next === "oracle" && commandBox("Look for a requirement that shows it", `scaloft-fi propose${inCampaign()} ${literal(mutant)}`));
  return [h("h3", { class: "sub" }, "Why no requirement saw it, and what would"), find ? h("div", { class: "flight missed" }, h("figure", {}, foundPicture(find)), says) : says];
}

const siblings = (mutant) => DATA.mutants.filter((other) => other.cell === mutant.cell && other.id !== mutant.id);

/** In the sheet of its cell. */
function mutantBlock(mutant) {
  return h("div", { class: "mutant" },
    h("h3", { class: "sub" }, h("a", { class: "id", href: mutantHash(mutant.id), title: "Karnaugh map and more" }, mutant.id)),
    mutantFacts(mutant), flownList(mutant));
}

const TESTED = "Kills: of the situations where the requirement tests the fault.  Flights: those there that violate it, of the mutant and of the unmutated drone.  p, over all situations in which the unmutated drone violates in at most a tenth of its flights: the chance of so many violations or more if the fault did nothing, adjusted for the number of requirements.";

const mutantFacts = (mutant) => [verdictLine(mutant, findOf(mutant) ?? needed(mutant)), ...figuresOf(mutant)];

function verdictLine(mutant, next) {
  const { first, control, severity } = mutant;
  const sure = mutant.certainty > 0 && `, ${sureText(mutant)}`;
  return [
    h("p", {}, h("b", {}, capital(control ? showsText(mutant) : verdictText(mutant))), sure, `.  ${control ? "" : VERDICTS[mutant.verdict][1]}  `, severity && !control && `Severity: ${severity}.  `, next),
    first && !OF_TESTS && h("p", {}, h("a", { class: "go", href: flightHash(mutant.id, first.situation, first.seed) }, `See the flight: ${first.requirement} violated at ${seconds(first.t_s)}`), " ", h("span", { class: "faint small" }, `${wordsOf(first.situation)}, seed ${first.seed}`))];
}

/** Where it is killed, and the test behind its verdict. */
function figuresOf(mutant) {
  const { decided_at: decided } = mutant;
  return [
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
  if (!mutant.kills.length || OF_TESTS) return null;
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
function needed(mutant) {
  const { needed: seeds, anew } = mutant.decided_at;
  if (mutant.verdict !== "undecided" || mutant.control || OF_TESTS) return "";
  if (!seeds) return mutant.tests.length ? "No more than 50 seeds would not decide." : "A baseline pool is missing where it infects; the same run flies it.";
  const where = anew ? `${DATA.anew}${DATA.grid ? ` --grid ${literal(DATA.grid)}` : ""}` : inCampaign();
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
