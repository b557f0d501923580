/* Dispositions: survivors that somebody accepted, with owner, reason and last day, beside the survivor. */
const ACCEPTED = new Map(DATA.accepted.judged.map((entry) => [entry.mutant, entry]));

const STANDS = {
  accepted: "accepted",
  open: "not accepted",
  uncovered: "accepted elsewhere only",
  expired: "acceptance has expired",
  stale: "detected now: the disposition can go",
  untested: "accepted, not put to the test",
};

/** How a mutant stands; null where nobody asks whether it is accepted. */
function acceptance(id) {
  const entry = ACCEPTED.get(id);
  if (!entry) return null;
  const fails = DATA.accepted.judged.some((one) => one.until) && ["open", "uncovered", "expired"].includes(entry.state);
  const where = (keys) => keys.map((key, number) => [number ? "; " : "", h("span", { title: key }, wordsOf(key))]);
  return h("span", { class: "accepted", "data-state": entry.state },
    h("b", { class: fails && "fails" }, STANDS[entry.state]),
    entry.until && [entry.state === "expired" ? ", last day " : " until ", h("span", { class: "day" }, entry.until), ` by ${entry.owner}: `, h("q", {}, entry.reason)],
    entry.situations?.length > 0 && h("span", { class: "faint under" }, "Accepted in: ", where(entry.situations), "."),
    entry.unnamed?.length > 0 && h("span", { class: "under" }, "Survives in these too: ", where(entry.unnamed), "."));
}

/** How many survivors are accepted, by which day that was judged, and dispositions of what is no survivor. */
function acceptances() {
  const { today, judged } = DATA.accepted;
  if (!judged.length) return null;
  const listed_ = new Set(DATA.survivors.map((entry) => entry.mutant));
  const asked = judged.filter((entry) => entry.surviving.length > 0 && entry.state !== "stale");
  const held = asked.filter((entry) => entry.state === "accepted").length;
  const others = judged.filter((entry) => !listed_.has(entry.mutant));
  const day = today ? `Last days are judged as of ${today}.` : ["Without ", h("code", {}, "--today"), " the last day of each is shown, and none is called expired."];
  return h("div", {},
    h("p", {}, h("b", {}, `${held} of ${plural(asked.length, "survivor")}`), ` put to the test ${held === 1 ? "is" : "are"} accepted in `, h("code", {}, "hazop/dispositions.yaml"), judged.some((entry) => entry.until) ? [".  ", day] : ": the study accepts none so far."),
    others.length > 0 && h("ul", {}, others.map(({ mutant }) => h("li", {}, MUTANTS.has(mutant) ? h("a", { class: "id", href: mutantHash(mutant) }, mutant) : h("span", { class: "id" }, mutant), ": ", acceptance(mutant)))));
}
