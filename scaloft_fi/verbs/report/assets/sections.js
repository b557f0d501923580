/* The sections below the matrices. */
function unmutated() {
  const names = [...SAFETY, ...DATA.requirements.filter((one) => one.kind === "operability").map((one) => one.name)];
  const pooled = DATA.situations.map(({ key }) => key).filter((key) => names.some((name) => stateOf(key, name) !== "unknown"));
  const lost = pooled.filter((key) => SAFETY.every((name) => stateOf(key, name) !== "steady"));
  const ill = DATA.situations.map(({ key }) => key).filter((key) => names.some((name) => ["red", "unsteady", "open"].includes(calledOf(key, name))));
  const firsts = new Map(DATA.firsts.map((first) => [first.situation, first]));
  return part("baseline", "What the unmutated drone does", `Without any fault: ${names.map((name) => `${name} is steady in ${pooled.filter((key) => calledOf(key, name) === "steady").length}`).join(", ")} of ${plural(pooled.length, "situation")} with ten flights or more.  Only a steady pair of situation and requirement puts a fault to the test; a red or unsteady one is a finding about the drone, or about what is asked of it.`,
    table(["pair", ...names.map((text) => ({ text, number: true }))],
      Object.entries(STATES).map(([state, [, says]]) => [[state, h("span", { class: "faint small" }, ` \u2013 ${says}`)], ...names.map((name) => String(DATA.pairs.filter((pair) => pair.requirement === name && pair.called === state).length))]), { stack: false }),
    h("p", { class: "note" }, lost.length ? [h("b", {}, `${plural(lost.length, "situation")} of ${pooled.length} put no fault to the safety test`), ", because no safety requirement is steady there: ", lost.map((key, number) => [number ? "; " : "", wordsOf(key)]), "."] : pooled.length ? "Every situation with a pool puts faults to the safety test." : "There is no pool: no situation has ten flights of the unmutated drone."),
    folded("Show each situation and requirement", () => [ill.length > 0 && table(["situation", ...names, "tests", "first"], ill.map((key) => pairRow(key, names, firsts.get(key))), { caption: "Situations with a red, unsteady or open pair: flights that violate, of those judged to their ends." }),
    !OF_TESTS && [h("h3", { class: "sub" }, "Requirements over the flights of the unmutated drone"),
    table(["requirement", "kind", ...compliances().map((text) => ({ text, number: true })), { text: "triggered", number: true }, { text: "least robustness", number: true }, "unit"],
      DATA.tallies.map((tally) => [tally.requirement, tally.kind, ...compliances().map((compliance) => String(tally.compliances[compliance] ?? 0)), String(tally.triggered), signed(tally.least_rho), h("span", { class: "faint small unit" }, requirementOf(tally.requirement)?.unit ?? "")]), { stack: false }),
    h("p", { class: "small faint" }, "Flights by verdict.  Open: the flight was cut short before the requirement could be held to the end.  Vacuous: never triggered in the flight, so not passed.")]]));
}

/** A situation where the unmutated drone leaves a pair that does not test: the pairs, what that takes, the first violation. */
function pairRow(key, names, first) {
  const steady = SAFETY.filter((name) => stateOf(key, name) === "steady");
  const pair = (name) => {
    const found = pairOf(key, name);
    const state = calledOf(key, name);
    const count = ["vacuous", "unknown"].includes(state) ? "" : state === "open" ? ` ${found.open}/${found.flights}` : ` ${found.violated}/${found.flights - found.open}`;
    return h("span", { class: "pair", "data-pair": state }, state, count);
  };
  return [withKey(key), ...names.map(pair), steady.length ? `${listed(steady)} still ${steady.length === 1 ? "tests" : "test"}` : h("b", {}, "nothing tests here"),
    first ? h("a", { href: flightHash("baseline", key, first.seed) }, firstText(first)) : "\u2013"];
}

const compliances = () => Object.keys(DATA.tallies[0]?.compliances ?? {});
const firstText = (first) => OF_TESTS ? `run ${first.seed}` : `${first.requirement} at ${seconds(first.t_s)}${first.struck ? `, strikes ${first.struck}` : ""}, seed\u00a0${first.seed}`;

function survivors() {
  const found = DATA.survivors.filter(({ mutant }) => !MUTANTS.get(mutant).searched);
  const left = DATA.survivors.length - found.length;
  return part("survivors", "What was not shown, and what to do next", "Mutants that no safety requirement detects, by verdict: where the fault stopped, and what would make it say something.",
    todo(found), acceptances(),
    left > 0 && h("p", { class: "small faint" }, `${plural(left, "magnitude")} that a search for a margin flew in some situations only ${left === 1 ? "is" : "are"} not listed; they are in the `, h("a", { href: "#ladders" }, "margins"), " below."),
    DATA.verdicts.map((verdict) => {
      const members = found.filter((entry) => entry.verdict === verdict);
      if (!members.length) return null;
      return h("details", { open: members.length <= 12, class: "fold" }, h("summary", {}, h("h3", { class: "inline" }, `${capital(spaced(verdict))} (${countText(members)})`), h("span", {}, ` ${VERDICTS[verdict][1]}`)),
        table(["mutant", ...(DATA.severities.length ? ["severity"] : []), "stopped at", "next", "why", "accepted"], members.map((entry) => survivor(MUTANTS.get(entry.mutant), entry))));
    }),
    !found.length && h("p", {}, DATA.mutants.some((mutant) => !mutant.control) ? "Every mutant flown is detected." : "No mutant was flown."));
}

/** How many mutants a list has, and how many of these the score counts. */
function countText(members) {
  const counted = members.filter(({ mutant }) => MUTANTS.get(mutant).counts).length;
  return counted === members.length ? String(counted) : `${members.length}, of which ${counted} count in the score`;
}

/** How many survivors ask for what. */
function todo(entries) {
  const counts = new Map();
  entries.forEach(({ next }) => counts.set(NEXT[next] ?? next, (counts.get(NEXT[next] ?? next) ?? 0) + 1));
  return entries.length > 0 && h("p", {}, "What to change next: ", [...counts].sort((a, b) => b[1] - a[1]).map(([what, count], place) => [place ? ", " : "", h("b", {}, String(count)), ` ${what}`]), ".");
}

/** The class of severity; its title where it is pointed at. */
const severityText = ({ severity }) => (severity ? h("span", { title: titleOf("severities", severity) }, severity) : "\u2013");

/** A survivor's line: what it is, what to change, the facts that say so. */
function survivor(mutant, told) {
  return [h("span", {}, h("a", { class: "id", href: mutantHash(mutant.id) }, mutant.id), h("span", { class: "faint small under" }, CELLS.get(mutant.cell)?.deviation ?? "")),
    ...(DATA.severities.length ? [severityText(mutant)] : []), told.stage, h("b", {}, told.find ? h("a", { href: findHash(told.find) }, NEXT.find) : NEXT[told.next] ?? told.next), h("span", { class: "small" }, withCode(told.why)), acceptance(mutant.id) ?? h("span", { class: "faint", title: "The score does not count it against the tests." }, "\u2013")];
}

const NEXT = { repeat: "fly again", find: "situation (found)", pool: "baseline pool", seeds: "seeds", situation: "situation", magnitude: "magnitude", oracle: "requirement", operability: "nothing (operability shows it)", test: "another test", expected: "nothing (known beforehand)" };

function claims() {
  return part("claims", "What these figures do not claim", null,
    h("ol", { class: "claims" },
      h("li", {}, "That no other fault is in the drone: only the faults of this HAZOP matrix, at these magnitudes, were tried."),
      !OF_TESTS && h("li", {}, "That the simulator is the mine: mine, vehicle, sensors and light are a model, and many of its numbers are assumptions; the study names the source of each."),
      h("li", {}, "That the HAZOP study is complete: a deviation that nobody thought of is in no cell.")),
    h("p", {}, "What they do claim: had one of the detected faults, of that magnitude, been in the drone, flying these situations with as many seeds would have shown violated requirements more often than the unmutated drone does; how many such verdicts chance explains stands at the top."),
    !OF_TESTS && [h("h3", { class: "sub" }, "Limits of the simulation"), h("ul", {},
      ["What no axis of the situations changes stays as it is: without such an axis nobody walks, the light does not change during a flight, missions are shorter than the battery lasts.",
        "The requirements judge ground truth of the simulation, not what the drone believed.",
        "Bits are promised on one platform only: the one named below."].map((text) => h("li", {}, text)))]);
}

function reading() {
  return part("reading", "How to read this", null,
    !OF_TESTS && [h("h3", {}, "Requirements"), DATA.requirements.map((requirement, number) => h("details", { id: `requirement-${number}` }, h("summary", {}, h("b", {}, requirement.name), ` (${requirement.kind}) ${requirement.title}`),
      h("dl", { class: "pairs" }, [["formula", h("code", {}, requirement.formula)], requirement.trigger && ["triggered", ["when ", h("code", {}, requirement.trigger)]], ...requirement.definitions.map(([name, text]) => [name, h("code", {}, text)]), ["unit", requirement.unit], ["source", requirement.source]]
        .filter((pair) => pair && pair[1]).map(([what, text]) => [h("dt", {}, what), h("dd", {}, text)]))))],
    h("details", {}, h("summary", {}, "Platform, and how this page was made"),
      h("dl", { class: "pairs" }, Object.entries(DATA.fingerprint).map(([what, text]) => [h("dt", {}, what), h("dd", {}, text)])),
      h("p", { class: "small faint" }, !OF_TESTS && withCode(`${DATA.detail}  `), "Made by ", h("code", {}, `scaloft-fi report${inCampaign()}`), ".")));
}
