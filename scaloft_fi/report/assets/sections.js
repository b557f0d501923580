/* The sections below the matrices. */
function baselineFindings() {
  const red = DATA.baseline.filter((finding) => finding.violated.length);
  const rows = red.map((finding) => [
    h("a", { href: flightHash("baseline", finding.situation, finding.first?.seed ?? DATA.seeds[0] ?? 0) }, wordsOf(finding.situation), " ", h("span", { class: "faint small" }, finding.situation)),
    `${finding.red}/${finding.flown}`, listed(finding.violated), listed(finding.open), listed(finding.vacuous), finding.first ? firstText(finding.first) : "–"]);
  const green = DATA.gates.green_situations;
  return part("baseline", "Findings about the drone itself", `Without any fault: ${green.part} of ${plural(green.whole, "situation")} hold every safety requirement in all flights.  The others are defects of the clean drone, or of what is asked of it, and no mutant can be shown there by the requirement that is red.`,
    rows.length ? table(["situation", { text: "red flights", number: true }, "violated", "left open", "never triggered", "first safety violation"], rows) : h("p", {}, "No clean flight violates a requirement."),
    h("h3", { class: "sub" }, "Requirements over the clean flights"),
    table(["requirement", "kind", ...verdicts().map((text) => ({ text, number: true })), { text: "triggered", number: true }, { text: "least robustness", number: true }, "its unit"],
      DATA.tallies.map((tally) => [tally.requirement, tally.kind, ...verdicts().map((verdict) => String(tally.verdicts[verdict] ?? 0)), String(tally.triggered), signed(tally.least_rho), h("span", { class: "faint small" }, requirementOf(tally.requirement)?.unit ?? "")]), { stack: false }),
    h("p", { class: "small faint" }, "Flights by verdict.  Open: the flight was cut short before the requirement could be held to the end.  Vacuous: never triggered in the flight, so not passed."));
}

const verdicts = () => Object.keys(DATA.tallies[0]?.verdicts ?? {});
const firstText = (first) => `${first.requirement} at ${seconds(first.t_s)}${first.struck ? `, strikes ${first.struck}` : ""}, seed\u00a0${first.seed}`;

function survivors() {
  const told = new Map(DATA.survivors.map((entry) => [entry.mutant, entry]));
  const found = DATA.mutants.filter((mutant) => told.has(mutant.id) && !mutant.searched);
  const left = DATA.survivors.length - found.length;
  const order = ["survived", "baseline_red", "masked", "not_infected", "not_reached", "invalid"];
  return part("survivors", "What was not shown, and what to do next", "Mutants that no eligible flight kills, by the rung where the fault stopped.",
    todo(DATA.survivors.filter(({ mutant }) => !MUTANTS.get(mutant).searched)), acceptances(),
    left > 0 && h("p", { class: "small faint" }, `${plural(left, "magnitude")} that a search for a margin flew in some situations only ${left === 1 ? "is" : "are"} not listed; they are in the margins above.`),
    order.map((state) => {
      const members = found.filter((mutant) => mutant.status === state);
      if (!members.length) return null;
      return h("details", { open: members.length <= 12, class: "fold" }, h("summary", {}, h("h3", { class: "inline" }, `${capital(STATES[state][0])} (${members.length})`), h("span", {}, ` ${STATES[state][1]}`)),
        table(["mutant", { text: "killed/eligible", number: true }, "change next", "why", "accepted"], members.map((mutant) => survivor(mutant, told.get(mutant.id)))));
    }),
    !found.length && h("p", {}, "Every mutant flown is killed somewhere."));
}

/** How many survivors ask for what. */
function todo(entries) {
  const counts = new Map();
  entries.forEach(({ next }) => counts.set(NEXT[next] ?? next, (counts.get(NEXT[next] ?? next) ?? 0) + 1));
  return entries.length > 0 && h("p", {}, "What to change next: ", [...counts].sort((a, b) => b[1] - a[1]).map(([what, count], place) => [place ? ", " : "", h("b", {}, String(count)), ` ${what}`]), ".");
}

/** A survivor's line: what it is, what to change, the facts that say so. */
function survivor(mutant, told) {
  return [h("span", {}, h("a", { class: "id", href: mutantHash(mutant.id) }, mutant.id), h("span", { class: "faint small under" }, CELLS.get(mutant.cell)?.deviation ?? "")),
    `${mutant.kill_rate.part}/${mutant.kill_rate.whole}`, h("b", {}, NEXT[told.next] ?? told.next), h("span", { class: "small" }, withCode(told.why)), acceptance(mutant.id) ?? h("span", { class: "faint", title: "The score does not count it against the tests." }, "\u2013")];
}

const NEXT = { repeat: "fly again", situation: "situation", magnitude: "magnitude", oracle: "requirement", operability: "nothing (operability shows it)", expected: "nothing (known beforehand)" };

function claims() {
  return part("claims", "What these figures do not claim", null,
    h("ol", { class: "claims" },
      h("li", {}, "That no other fault is in the drone: only the faults of this HAZOP matrix, at these magnitudes, were tried."),
      h("li", {}, "That the simulator is the mine: mine, vehicle, sensors and light are a model, and many of its numbers are assumptions; the study names the source of each."),
      h("li", {}, "That the HAZOP study is complete: a deviation that nobody thought of is in no cell.")),
    h("p", {}, "What they do claim: had one of the killed faults, of that magnitude or more where the ladder says so, been in the drone, flying these situations would have shown a violated requirement as often as the kill rate and its interval say."),
    h("h3", { class: "sub" }, "Limits of the simulation"),
    h("ul", {},
      ["The situations are static: nobody walks, the light does not change during a flight, missions are shorter than the battery lasts.",
        "The requirements judge ground truth of the simulation, not what the drone believed.",
        "Bits are promised on one platform only: the one named below."].map((text) => h("li", {}, text))));
}

function reading() {
  return part("reading", "How to read this", null,
    h("div", { class: "columns" },
      h("div", {}, h("h3", {}, "Requirements"), DATA.requirements.map((requirement) => h("details", {}, h("summary", {}, h("b", {}, requirement.name), ` (${requirement.kind}) ${requirement.title}`),
        h("dl", { class: "pairs" }, [["formula", h("code", {}, requirement.text)], requirement.trigger && ["counts when", h("code", {}, requirement.trigger)], ...requirement.definitions.map(([name, text]) => [name, h("code", {}, text)]), ["robustness in", requirement.unit], ["source", requirement.source]]
          .filter((pair) => pair && pair[1]).map(([what, text]) => [h("dt", {}, what), h("dd", {}, text)]))))),
      h("div", {}, h("h3", {}, "Words"),
        h("dl", { class: "pairs" }, [
          ["mutant", "a fault made from one cell of the HAZOP matrix, with a magnitude, patched into one place of the drone's software"],
          ["situation", "one combination of values of the axes; the grid is all of them"],
          ["eligible", "the fault changed a sample, and the clean drone, same situation and seed, held a safety requirement to its end"],
          ["default mutant", "of each cell the one magnitude that the ratios count; the others of its ladder are shown beside it"],
          ["infected", "the fault changed at least one sample that the software got"],
          ["killed", STATES.killed[1]], ["survivor", "a mutant that no eligible flight kills"], ["baseline red", STATES.baseline_red[1]],
          ["control", "a fault so crude that any test must show it; it checks the test bench, and is in no ratio"],
          ["PLACEBO", "a patch that changes nothing: its flights must equal the clean drone's to the bit"],
          ["margin", "the least magnitude that kills: between the severest that survives and the mildest that kills"],
          ["condition", "the shortest statement on the axes that is true wherever the mutant is killed and nowhere it survives"],
          ["t-way", "of all combinations of values of t axes, those that occur in a flight"], ["clean drone", "the drone without any fault: the baseline of the same situation and seed"],
          ["robustness", "how far a flight was from violating a requirement; below 0 it is violated"]].map(([what, text]) => [h("dt", {}, what), h("dd", {}, text)])))),
    h("details", {}, h("summary", {}, "Platform, and how this page was made"),
      h("dl", { class: "pairs" }, Object.entries(DATA.fingerprint).map(([what, text]) => [h("dt", {}, what), h("dd", {}, text)])),
      h("p", { class: "small faint" }, DATA.detail, "  Made by ", h("code", {}, `scaloft-fi report --campaign ${literal(DATA.campaign)}`), DATA.stale ? `; ${plural(DATA.stale, "flight")} flown with other data or code left out.` : ".")));
}
