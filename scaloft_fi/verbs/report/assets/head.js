/* The first screen: the answer in a sentence, the bar, the worst that is missed, the matrix; how sure, behind a click. */
function masthead() {
  const [, notShown, sure, next] = DATA.answers;
  return h("header", { class: "masthead" },
    h("div", { class: "first" },
      h("div", {},
        h("h1", {}, `${DATA.study}: campaign ${DATA.campaign}`),
        DATA.gates.failed && h("p", { class: "notice", role: "alert" }, h("b", {}, "These figures may not be believed. "), DATA.gates.failed),
        DATA.owed > 0 && h("p", { class: "notice" }, `${plural(DATA.owed, "planned flight")} of this campaign ${DATA.owed === 1 ? "is" : "are"} missing: the run was not finished.`),
        DATA.stale.map((text) => h("p", { class: "notice" }, withCode(`${text}.`))),
        h("p", { class: "answer" }, withCode(DATA.head.answer)),
        DATA.pooled && fateBar(),
        worst(),
        h("p", {}, h("b", {}, "How sure: "), DATA.head.sure),
        h("p", {}, h("b", {}, "Not claimed: "), DATA.head.claim),
        h("p", { class: "small" }, h("b", {}, "What next: "), withCode(sentence(next.text))),
        h("p", { class: "buttons" }, [["#survivors", "What is missing"], ["#sure", "How sure"], ["#next", "What next"]].map(([to, says]) => h("a", { class: "button", href: to }, says)))),
      hazop()),
    h("details", { class: "fold", id: "sure" }, h("summary", {}, "How sure, and what is not claimed"),
      h("dl", { class: "answers" },
        line(sure.name, withCode(sentence(sure.text))),
        line("unmutated drone", [DATA.head.fails.map((text) => h("p", {}, text)), h("p", { class: "small" }, h("a", { href: "#baseline" }, "Which situations"), DATA.breaks.length > 0 && [" \u00b7 ", h("a", { href: "#breaks" }, "What breaks it")])]),
        line("not claimed", [h("ul", {}, DATA.head.claims.map((text) => h("li", {}, text))), h("p", { class: "small" }, h("a", { href: "#claims" }, "All that is not claimed"))]),
        DATA.besides.map(({ name, text }) => line(name, sentence(text))))),
    h("details", { class: "fold", id: "next" }, h("summary", {}, "What next"),
      h("dl", { class: "answers" }, line(notShown.name, withCode(sentence(notShown.text))), line(next.name, h("ul", {}, [["#survivors", "each fault that is not shown: where it stopped, and what to change"], DATA.found.finds.length > 0 && ["#found", "situations that would have shown some"], ["#hazop", "the matrix: a cell opens with its flight"]].filter(Boolean).map(([to, says]) => h("li", {}, h("a", { href: to }, says))))))));
}

/** The faults that are missed of the worst class among them, the first few by name. */
function worst() {
  const missed = countedFaults().filter((mutant) => fateOf(mutant) === "not_detected" && rankOf(mutant));
  if (!missed.length) return null;
  const rank = Math.min(...missed.map(rankOf));
  const found = missed.filter((mutant) => rankOf(mutant) === rank);
  const [first, rest] = [found.slice(0, FEW), found.length - FEW];
  return h("div", {}, h("p", {}, h("b", {}, "Worst missed"), `, ${found[0].severity}: ${titleOf("severities", found[0].severity)}`),
    h("ul", { class: "worst" }, first.map((mutant) => h("li", {}, h("a", { class: "id", href: mutantHash(mutant.id) }, mutant.id), ` ${CELLS.get(mutant.cell)?.deviation ?? ""}`)),
      rest > 0 && h("li", {}, h("a", { href: "#survivors" }, `and ${plural(rest, "other")}`))));
}

const FEW = 6;
const line = (name, told) => [h("dt", {}, term(capital(name))), h("dd", {}, told)];

/** The faults that the answer counts. */
function countedFaults() {
  const faults = DATA.mutants.filter((mutant) => !mutant.control);
  return faults.some((mutant) => mutant.counts) ? faults.filter((mutant) => mutant.counts) : faults;
}

/** What became of the faults that count: the fates that some have, each with its faults, the worst first. */
function fatesOf() {
  const counted = countedFaults().sort((a, b) => grade(a) - grade(b));
  const fate = (state, says, mark, sure, members) => ({ state, says, mark, sure, members, count: members.length });
  const of = (state) => counted.filter((mutant) => fateOf(mutant) === state);
  return [
    fate("detected", "firm", VERDICTS.detected[0], 3, of("detected").filter(isFirm)),
    fate("detected", "shown, not firm", "\u25cb", 1, of("detected").filter((mutant) => !isFirm(mutant))),
    fate("undecided", "undecided", VERDICTS.undecided[0], null, of("undecided")),
    fate("not_detected", "missed", VERDICTS.not_detected[0], null, of("not_detected")),
    fate("same", "no effect", "=", null, of("same")),
    fate("not_tested", "not tested", VERDICTS.not_tested[0], null, of("not_tested")),
  ].filter(({ count }) => count);
}

/** The fates as one bar in the looks of the matrix; a count picks out its faults there. */
function fateBar() {
  const fates = fatesOf();
  if (!fates.length) return null;
  return h("div", { class: "fates" },
    h("div", { class: "fate-bar", role: "img", "aria-label": `Faults: ${fates.map(({ count, says }) => `${count} ${says}`).join(", ")}` },
      fates.flatMap(byRank).map(({ state, sure, rank, count }) => h("span", { class: "state", "data-state": state, "data-sure": sure, "data-rank": rank, "--count": count }))),
    h("ul", { class: "legend" }, fates.map(({ state, says, mark, sure, count, members }) => h("li", {}, h("button", { type: "button", class: "pick", "aria-pressed": "false", "aria-label": `Pick out: ${count} ${says}`, onclick: pick }, swatch(state, mark, sure, byRank({ state, members })[0].rank), h("b", {}, String(count))), term(says)))));

  function pick() {
    const buttons = [...this.closest("ul").querySelectorAll("button")];
    const picked = this.ariaPressed === "true" ? null : new Set(fates[buttons.indexOf(this)].members.map(({ cell }) => cell));
    buttons.forEach((button) => { button.ariaPressed = String(picked !== null && button === this); });
    document.querySelectorAll("#hazop td").forEach((cell) => cell.classList.toggle("aside", picked !== null && !picked.has(cell.dataset.cell)));
  }
}

/** The way to the faults before and after one among those of its fate, round and round; none for what does not count. */
function walk(mutant, to) {
  const { says, members, count } = fatesOf().find((fate) => fate.members.includes(mutant)) ?? { count: 0 };
  if (count < 2) return null;
  const place = members.indexOf(mutant);
  const step = (by, sign, name) => h("a", { class: "button", "data-step": name, "aria-label": `${name} fault, ${says}`, href: to(members[(place + by + count) % count]) }, sign);
  return h("nav", { class: "walk", "aria-label": "Faults of the same fate" }, step(-1, "\u2190", "previous"), h("span", {}, `${place + 1} of ${count} ${says}`), step(1, "\u2192", "next"));
}

/** The missed faults by class of severity, the worst first; any other fate as it is. */
function byRank(fate) {
  if (fate.state !== "not_detected") return [fate];
  const ranks = [...new Set(fate.members.map(shownRank))].sort((one, other) => one - other);
  return ranks.map((rank) => ({ ...fate, rank, count: fate.members.filter((mutant) => shownRank(mutant) === rank).length }));
}

const sentence = (text) => (text.startsWith("`") ? text : capital(text));

function summary() {
  return part("summary", "The figures", "Part of whole.  Every whole is a closed list, of cells or of mutants, and no sample of anything: so there is no interval.  0/0 is n/a.",
    table(["ratio", { text: "part/whole", number: true }, { text: "share", number: true }, "population"],
      DATA.ratios.filter(({ name }) => DATA.pooled || ["exercised", "infected"].includes(name)).map((ratio) => [ratio.title, shortText(ratio), h("span", { class: "measured" }, meter(ratio, ratio.title), ratio.whole ? percent(share(ratio)) : "n/a"), h("span", { class: "faint" }, ratio.population)])),
    !DATA.pooled && h("p", { class: "note" }, "Without a baseline pool there is no verdict, and so no score."),
    h("div", { class: "columns" },
      h("div", {}, h("h3", { class: "sub" }, "The verdicts on the faults"), fates()),
      h("div", {}, h("h3", { class: "sub" }, "May the figures be believed?"), gates(),
        !OF_TESTS && [h("h3", { class: "sub" }, "Situation coverage"), coverageTable()])));
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

const swatch = (state, text = "", sure = null, rank = null) => h("span", { class: "swatch state", "data-state": state, "data-sure": sure, "data-rank": rank, "aria-hidden": "true" }, text);

function gates() {
  const { placebo_flights: placebo, deterministic, invalid_flights: invalid, controls, steady_situations: steady, failed } = DATA.gates;
  const showing = DATA.mutants.filter((mutant) => mutant.shows.length);
  const differs = failed.includes("PLACEBO");
  const told = deterministic ? `${differs ? "does not equal" : "equals"} the unmutated drone bit for bit` : `is ${differs ? "" : "not "}told from the unmutated drone by the score's test`;
  const safely = showing.filter((mutant) => mutant.shows.some((name) => SAFETY.includes(name))).length;
  const lines = [
    [!failed, failed || "Every gate of the campaign holds."],
    [placebo > 0 && !differs, placebo ? `PLACEBO, the patch that changes nothing, was flown ${plural(placebo, "time")} and ${told}.` : "PLACEBO was not flown."],
    [controls.part === controls.whole, `${controls.part} of ${plural(controls.whole, "crude control")} show themselves, ${safely} by a safety requirement, ${showing.length - safely} by operability alone.`],
    [!failed.includes("invalid"), `${invalid} of ${plural(DATA.flights, "flight")} failed on the test bench.`],
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
