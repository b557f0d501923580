/* The top of the page: the answer, how sure it is, what the unmutated drone fails, what is not claimed; then the ratios. */
function masthead() {
  const cells = DATA.ratios.find((entry) => entry.name === "exercised");
  const [answer, ...others] = DATA.answers;
  const [notShown, sure, next] = others.map(({ name, text }) => line(name, withCode(sentence(text))));
  return h("header", { class: "masthead" },
    h("p", { class: "kicker" }, "Fault-injection mutation testing of an autonomous drone: if one of these faults were in it, would the tests have shown it?"),
    h("h1", {}, `${DATA.study}: campaign ${DATA.campaign}`),
    DATA.gates.failed && h("p", { class: "notice", role: "alert" }, h("b", {}, "These figures may not be believed. "), DATA.gates.failed),
    DATA.owed > 0 && h("p", { class: "notice" }, `${plural(DATA.owed, "planned flight")} of this campaign ${DATA.owed === 1 ? "is" : "are"} missing: the run was not finished.`),
    DATA.stale.map((text) => h("p", { class: "notice" }, withCode(`${text}.`))),
    h("p", { class: "answer" }, withCode(sentence(answer.text))),
    DATA.pooled && fateBar(),
    h("dl", { class: "answers" },
      sure,
      line("unmutated drone", [DATA.head.fails.map((text) => h("p", {}, text)), h("p", { class: "small" }, h("a", { href: "#baseline" }, "Which situations"), DATA.breaks.length > 0 && [" \u00b7 ", h("a", { href: "#breaks" }, "What breaks it")])]),
      line("not claimed", [h("ul", {}, DATA.head.claims.map((text) => h("li", {}, text))), h("p", { class: "small" }, h("a", { href: "#claims" }, "All that is not claimed"))]),
      notShown, next, DATA.besides.map(({ name, text }) => line(name, sentence(text)))),
    h("ul", { class: "facts" },
      [[cells.part, `of ${cells.whole} credible cells flown`], [DATA.seeds.length, `${DATA.seeds.length === 1 ? "seed" : "seeds"} of mutants (${seedText()})`],
        [DATA.flights, "flights"], ["scaloft-fi", DATA.version]].map(([figure, what]) => h("li", {}, h("b", {}, String(figure)), ` ${what}`))));
}

const line = (name, told) => [h("dt", {}, term(capital(name))), h("dd", {}, told)];

/** The mutants that the answer counts by verdict, as one bar in the looks of the matrix. */
function fateBar() {
  const faults = DATA.mutants.filter((mutant) => !mutant.control);
  const counted = faults.some((mutant) => mutant.counts) ? faults.filter((mutant) => mutant.counts) : faults;
  const fates = DATA.verdicts.map((verdict) => [verdict, counted.filter((mutant) => mutant.verdict === verdict).length]).filter(([, count]) => count);
  if (!fates.length) return null;
  return h("div", { class: "fates" },
    h("div", { class: "fate-bar", role: "img", "aria-label": `Mutants by verdict: ${fates.map(([verdict, count]) => `${count} ${spaced(verdict)}`).join(", ")}` },
      fates.map(([verdict, count]) => h("span", { class: "state", "data-state": verdict, "data-sure": verdict === "detected" ? 3 : null, "--count": count }))),
    h("ul", { class: "legend" }, fates.map(([verdict, count]) => h("li", {}, swatch(verdict, VERDICTS[verdict][0], verdict === "detected" && 3), h("b", {}, String(count)), term(spaced(verdict)), verdict === "detected" && [", ", h("b", {}, String(counted.filter(isFirm).length)), " ", term("firm")]))));
}

const sentence = (text) => (text.startsWith("`") ? text : capital(text));

function seedText() {
  const seeds = DATA.seeds;
  const even = seeds.length > 2 && seeds.at(-1) - seeds[0] === seeds.length - 1;
  return even ? `${seeds[0]}\u2013${seeds.at(-1)}` : seeds.join(", ");
}

function summary() {
  return part("summary", "The figures", "Part of whole.  Every whole is a closed list, of cells or of mutants, and no sample of anything: so there is no interval.  0/0 is n/a.",
    table(["ratio", { text: "part/whole", number: true }, { text: "share", number: true }, "population"],
      DATA.ratios.filter(({ name }) => DATA.pooled || ["exercised", "infected"].includes(name)).map((ratio) => [ratio.title, shortText(ratio), h("span", { class: "measured" }, meter(ratio, ratio.title), ratio.whole ? percent(share(ratio)) : "n/a"), h("span", { class: "faint" }, ratio.population)])),
    !DATA.pooled && h("p", { class: "note" }, "Without a baseline pool there is no verdict, and so no score."),
    h("div", { class: "columns" },
      h("div", {}, h("h3", { class: "sub" }, "The verdicts on the faults"), fates()),
      h("div", {}, h("h3", { class: "sub" }, "May the figures be believed?"), gates(),
        h("h3", { class: "sub" }, "Situation coverage"), coverageTable())));
}

/** Mutants by verdict, those that the ratios count, and all. */
function fates() {
  const every = DATA.mutants.filter((mutant) => !mutant.control);
  const counted = every.filter((mutant) => mutant.counts);
  const of = (members, verdict) => String(members.filter((mutant) => mutant.verdict === verdict).length);
  const more = every.length > counted.length;
  return table(["verdict", { text: "default mutants", number: true }, ...(more ? [{ text: "magnitudes", number: true }] : [])],
    DATA.verdicts.map((verdict) => [[h("b", {}, `${VERDICTS[verdict][0]}\u00a0`, term(spaced(verdict))), h("span", { class: "faint small" }, ` \u2013 ${VERDICTS[verdict][1]}`)],
      of(counted, verdict), ...(more ? [of(every, verdict)] : [])]), { stack: false });
}

const swatch = (state, text = "", sure = null) => h("span", { class: "swatch state", "data-state": state, "data-sure": sure, "aria-hidden": "true" }, text);

function gates() {
  const { placebo_flights: placebo, invalid_flights: invalid, controls, steady_situations: steady, failed } = DATA.gates;
  const showing = DATA.mutants.filter((mutant) => mutant.shows.length);
  const safely = showing.filter((mutant) => mutant.shows.some((name) => SAFETY.includes(name))).length;
  const lines = [
    [!failed, failed || "Every gate of the campaign holds."],
    [placebo > 0 && !failed.includes("PLACEBO"), placebo ? `PLACEBO, the patch that changes nothing, was flown ${plural(placebo, "time")} and equals the unmutated drone bit for bit.` : "PLACEBO was not flown."],
    [controls.part === controls.whole, `${controls.part} of ${plural(controls.whole, "crude control")} show themselves, ${safely} by a safety requirement, ${showing.length - safely} by operability alone.`],
    [true, `${invalid} of ${plural(DATA.flights, "flight")} failed on the test bench.`],
    [steady.part > 0, steady.whole ? `In ${steady.part} of ${plural(steady.whole, "situation")} with a baseline pool a safety requirement is steady, so that a fault can show.` : "There is no baseline pool: no situation has ten flights of the unmutated drone."],
  ];
  return lines.map(([held, says]) => h("div", { class: "gate", "data-held": held ? "yes" : "no" }, h("span", { role: "img", "aria-label": held ? "holds:" : "fails:" }, held ? "\u2713" : "\u2717"), h("span", {}, says)));
}

function coverageTable() {
  const covered = DATA.coverage;
  const plain = (ratio) => [shortText(ratio), ratio.whole ? percent(share(ratio)) : "n/a"];
  const rows = [
    ["situations of the grid", ...plain(covered.situations)],
    ...Object.entries(covered.t_way).map(([t, ratio]) => [`value combinations of ${plural(Number(t), "axis", "axes")} (${t}-way)`, ...plain(ratio)]),
    ["realised: every value came true in a flight of the unmutated drone", ...plain(covered.realised)],
    ["safety pairs that are steady, of those with a pool", ...plain(covered.steady)],
    ...Object.entries(covered.requirements).map(([name, ratio]) => [`${name} triggered in a flight of the unmutated drone`, ...plain(ratio)]),
    ["draws: a situation with a seed", String(covered.draws), ""],
    ["of these the unmutated drone's alone", String(covered.pool), ""],
  ];
  return table(["coverage", { text: "part/whole", number: true }, { text: "share", number: true }], rows, { stack: false });
}
