/* The top of the page: what was asked, the answer, its ratios, whether it may be believed. */
function masthead() {
  const ratio = DATA.ratios.find((entry) => entry.name === "mutation_score");
  const decided = DATA.ratios.find((entry) => entry.name === "decided_score");
  const cells = DATA.ratios.find((entry) => entry.name === "exercised");
  const flown = DATA.coverage.situations;
  const range = ratio.interval ? `, 95 % interval ${Math.round(100 * ratio.interval[0])} to ${Math.round(100 * ratio.interval[1])} %` : "";
  const answer = ratio.whole
    ? [`If one of these faults were in the drone, would the tests have shown it?  Of ${plural(ratio.whole, "fault")} that could have been shown, the tests show `,
      h("b", {}, `${ratio.part} (${percent(share(ratio))}${range})`),
      decided.whole ? `; repeated flights decide of ${decided.part} that more than chance kills them.` : "."]
    : "No fault of this campaign reached a situation where it could have been shown: there is no score.";
  return h("header", { class: "masthead" },
    h("p", { class: "kicker" }, "Fault-injection mutation testing of an autonomous drone"),
    h("h1", {}, `${DATA.study}: campaign ${DATA.campaign}`),
    h("p", { class: "lead" }, answer),
    h("ul", { class: "facts" },
      [[cells.part, `of ${cells.whole} credible cells flown`], [`${flown.part} of ${flown.whole}`, "situations"], [DATA.seeds.length, `${DATA.seeds.length === 1 ? "seed" : "seeds"} (${seedText()})`],
        [DATA.flights, "flights"], ["scaloft-fi", DATA.version]].map(([figure, what]) => h("li", {}, h("b", {}, String(figure)), ` ${what}`))),
    DATA.gates.failed && h("p", { class: "notice", role: "alert" }, h("b", {}, "These figures may not be believed. "), DATA.gates.failed),
    DATA.owed > 0 && h("p", { class: "notice" }, `${plural(DATA.owed, "planned flight")} of this campaign ${DATA.owed === 1 ? "is" : "are"} missing: the run was not finished.`));
}

function seedText() {
  const seeds = DATA.seeds;
  const even = seeds.length > 2 && seeds.at(-1) - seeds[0] === seeds.length - 1;
  return even ? `${seeds[0]}\u2013${seeds.at(-1)}` : seeds.join(", ");
}

function summary() {
  return part("summary", "The figures", "Part of whole, with Wilson's 95 % interval over the population that the line names; 0/0 is n/a.",
    table(["ratio", { text: "part/whole", number: true }, { text: "share", number: true }, "0 to 100 %", "population"],
      DATA.ratios.map((ratio) => [ratio.title, `${ratio.part}/${ratio.whole}`, ratio.whole ? percent(share(ratio)) : "n/a", whisker(ratio, ratio.title),
        h("span", { class: "faint" }, ratio.population)])),
    !SEVERAL && h("p", { class: "note" }, "One seed: one flight per mutant and situation decides nothing statistically; ", h("code", {}, "scaloft-fi run --seeds 3"), " flies more."),
    falseKills(),
    h("div", { class: "columns" },
      h("div", {}, h("h3", { class: "sub" }, "Where the faults stopped"), fates()),
      h("div", {}, h("h3", { class: "sub" }, "May the figures be believed?"), gates(),
        h("h3", { class: "sub" }, "Situation coverage"), coverageTable())));
}

/** Mutants by the rung they reached; it is the key to the signs of the matrices, too. */
function fates() {
  const order = ["killed", "survived", "baseline_red", "masked", "not_infected", "not_reached", "invalid"];
  const total = DATA.mutants.filter((mutant) => !mutant.control).length;
  return table(["sign", "status", { text: "mutants", number: true }],
    order.filter((state) => DATA.fates[state] || state !== "invalid").map((state) => [swatch(state),
      [h("b", {}, STATES[state][0]), h("span", { class: "faint small" }, ` \u2013 ${STATES[state][1]}`)],
      `${DATA.fates[state] ?? 0} of ${total}`]), { stack: false, caption: "Every mutant flown, other magnitudes than the default too; the ratios above count one mutant a cell." });
}

const swatch = (state, extra = {}) => h("span", { class: `swatch state${state === "killed" ? " deep" : ""}`, "data-state": state, "aria-hidden": "true", ...extra });

function gates() {
  const { placebo_flights: placebo, invalid_flights: invalid, controls, green_situations: green, failed } = DATA.gates;
  const lines = [
    [!failed, failed || "Every gate of the campaign holds."],
    [placebo > 0 && !failed.includes("PLACEBO"), placebo ? `PLACEBO, the patch that changes nothing, was flown ${plural(placebo, "time")} and equals the clean drone bit for bit.` : "PLACEBO was not flown."],
    [controls.part === controls.whole, `${controls.part} of ${plural(controls.whole, "crude control")} show themselves.`],
    [true, `${invalid} of ${plural(DATA.flights, "flight")} failed on the test bench.`],
    [green.part > 0, `In ${green.part} of ${plural(green.whole, "situation")} the clean drone holds every safety requirement.`],
  ];
  return lines.map(([held, says]) => h("div", { class: "gate", "data-held": held ? "yes" : "no" }, h("span", { role: "img", "aria-label": held ? "holds:" : "fails:" }, held ? "\u2713" : "\u2717"), h("span", {}, says)));
}

/** How often the kill rule kills what does nothing: baseline seeds judged by one another. */
function falseKills() {
  const { rate, population, expected_false_kills: expected, eligible_flights: flights, decided, reason } = DATA.redraw;
  if (reason) return h("p", { class: "note" }, h("b", {}, "False kills by chance: "), `not measured, because ${reason}.`);
  const sentences = [`${ratioText(rate)} of the ${population} are killed by nothing but another noise.`];
  if (expected !== null) sentences.push(`That makes ${expected.toFixed(1)} false kills expected among ${plural(flights, "eligible flight")}.`);
  if (decided.whole) sentences.push(`As a decision over ${plural(decided.seeds, "left-out seed")}: ${ratioText(decided)}.`);
  return h("p", { class: "note" }, h("b", {}, "False kills by chance (REDRAW): "), sentences.join("  "));
}

function coverageTable() {
  const covered = DATA.coverage;
  const plain = (ratio) => [`${ratio.part}/${ratio.whole}`, ratio.whole ? percent(share(ratio)) : "n/a"];
  const rows = [
    ["situations of the grid", ...plain(covered.situations)],
    ...Object.entries(covered.t_way).map(([t, ratio]) => [`value combinations of ${plural(Number(t), "axis", "axes")} (${t}-way)`, ...plain(ratio)]),
    ["realised: every value came true in a clean flight", ...plain(covered.realised)],
    ["eligible: some fault infects beside a clean drone that holds", ...plain(covered.eligible)],
    ...Object.entries(covered.requirements).map(([name, ratio]) => [`${name} triggered in a clean flight`, ...plain(ratio)]),
    ["draws: a situation with a seed", String(covered.draws), ""],
  ];
  return table(["coverage", { text: "part/whole", number: true }, { text: "share", number: true }], rows, { stack: false });
}
