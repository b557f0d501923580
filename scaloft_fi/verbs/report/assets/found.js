/* The situations that a search found: what each shows and on what evidence, the map, the command that flies it. */
const findHash = (name) => `#find-${DATA.found.finds.findIndex((find) => find.name === name)}`;

/** Of more finds than these each is folded. */
const MANY_FINDS = 8;

/** Null for a study without finds. */
function foundSituations() {
  const { finds, misfits, grid } = DATA.found;
  if (!finds.length && !misfits.length) return null;
  return part("found", "Found situations", "A search flew situations around the grid for faults that were not shown, and confirmed these on seeds that it never flew.  They were chosen because of verdicts: a score that uses them is selected.",
    finds.length > 0 && h("p", {}, `${plural(finds.length, "situation")} of `, h("code", {}, "sim/found.yaml"), `; this campaign flew ${finds.filter((find) => find.flights).length}.  The figures are those of the search: where the study has changed since, flights over the grid `, h("code", {}, grid), " say what holds."),
    misfits.length > 0 && h("p", { class: "notice" }, `Left out, because ${misfits.length === 1 ? "it does" : "they do"} not fit the study any more: ${listed(misfits)}.  `, h("code", {}, "scaloft-fi seek ID"), " seeks anew."),
    finds.map((find, place) => foundOne(find, place, finds.length <= MANY_FINDS)));
}

function foundOne(find, place, open) {
  const own = find.shows.find((one) => one.mutant === find.mutant);
  const others = find.shows.length - 1;
  const [flight, clean] = find.flights ?? [];
  const facts = [["name", h("span", { class: "id" }, find.name)], ["situation", h("span", { class: "id" }, find.situation)],
    flight && ["on the map", h("a", { href: flightHash(flight.mutant, find.situation, flight.seed) }, `the flight of ${flight.mutant} with seed ${flight.seed}`)]];
  return h("details", { open, class: "fold", id: `find-${place}` },
    h("summary", {}, h("h3", { class: "inline" }, capital(find.words)), h("span", {}, ` shows ${find.mutant}${others ? ` and ${plural(others, "other")}` : ""}: ${effectOf(own)}`)),
    h("div", { class: "flight" },
      h("figure", {}, mapOf(find.scene, flight, clean)?.root, foundKey(find, flight, clean)),
      h("div", {},
        h("dl", { class: "pairs" }, facts.filter(Boolean).map(([what, told]) => [h("dt", {}, what), h("dd", {}, told)])),
        table(["shows", "violates", { text: "flights", number: true }, { text: "p", number: true }, { text: "alpha", number: true }, "in this campaign"], find.shows.map((one) => showsRow(find, one)), { stack: false }),
        table(["unmutated drone", { text: "held", number: true }, { text: "margin", number: true }, { text: "spread", number: true }, "unit"], baselineRows(find), { stack: false }),
        h("p", { class: "small faint" }, "Alpha: what p was compared with, the share of the candidate that the situation was.  Held: flights of the unmutated drone whose robustness is above its spread; margin: what nine in ten of them reach; spread: their standard deviation."),
        commandBox("Fly it", find.command))));
}

function foundKey(find, flight, clean) {
  const walked = find.scene.bodies.some(([, , path]) => path.length);
  return [
    flight ? key(flight, clean) : h("ul", { class: "keys" }, h("li", {}, lineOf("route"), "route of the mission; this campaign has no flight here")),
    walked && h("ul", { class: "keys" }, h("li", {}, lineOf("walked"), "path of a body that moves"))];
}

const effectOf = ({ requirement, struck }) => `${requirement}${struck ? `, strikes ${struck}` : ""}`;

/** The evidence for one mutant, and what the campaign of the page says of it there. */
function showsRow(find, one) {
  const mutant = find.flights && MUTANTS.get(one.mutant);
  const result = mutant?.results[PLACES.get(find.situation)];
  return [mutant ? h("a", { class: "id", href: mutantHash(one.mutant) }, one.mutant) : h("span", { class: "id" }, one.mutant),
    effectOf(one), shortText({ part: one.violated, whole: one.flights }), pText(one.p), pText(one.alpha),
    result ? shown(result, find.situation).said.replaceAll("\n", "; ") : "\u2013"];
}

/** What the unmutated drone does there, each requirement and number of seeds once. */
function baselineRows(find) {
  const rows = new Map(find.shows.map((one) => [`${one.requirement} ${one.baselines}`, one]));
  return [...rows.values()].map((one) => [one.requirement, shortText({ part: one.held, whole: one.baselines }), trimmed(one.margin, 3), trimmed(one.spread, 3), h("span", { class: "faint small unit" }, requirementOf(one.requirement)?.unit ?? "")]);
}
