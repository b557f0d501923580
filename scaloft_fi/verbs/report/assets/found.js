/* The situations that a search found, each a picture with its values and what it shows; evidence and command behind a click. */
const findHash = (name) => `#find-${DATA.found.finds.findIndex((find) => find.name === name)}`;

/** Null for a study without finds. */
function foundSituations() {
  const { finds, misfits, grid } = DATA.found;
  if (!finds.length && !misfits.length) return null;
  return part("found", "Found situations", "A search flew situations around the grid for the faults that it was given, and confirmed these on seeds that it never flew.  They were chosen because of verdicts: a score that uses them is selected.",
    finds.length > 0 && h("p", {}, `${plural(finds.length, "situation")} of `, h("code", {}, "sim/found.yaml"), `; this campaign flew ${finds.filter((find) => find.flights).length}.  The figures are those of the search: where the study has changed since, flights over the grid `, h("code", {}, grid), " say what holds."),
    misfits.length > 0 && h("p", { class: "notice" }, `Left out, because ${misfits.length === 1 ? "it does" : "they do"} not fit the study any more: ${listed(misfits)}.  `, h("code", {}, "scaloft-fi seek ID"), " seeks anew."),
    h("div", { class: "cards" }, finds.map(foundOne)),
    finds.length > 0 && [routeKey(), h("p", { class: "small faint" }, "Alpha: what p was compared with, the share of the candidate that the situation was.  Held: flights of the unmutated drone whose robustness is above its spread; margin: what nine in ten of them reach; spread: their standard deviation.")]);
}

/** A picture under its name, what it says, and the rest behind a click. */
function card(id, title, says, picture, rest) {
  return h("article", { class: "card", id, tabindex: "-1", "aria-labelledby": `${id}-title` },
    h("figure", {}, picture), h("h3", { id: `${id}-title` }, capital(title)), h("p", {}, says),
    h("details", { class: "fold" }, h("summary", {}, "Evidence and command"), rest));
}

function foundOne(find, place) {
  const own = find.shows.find((one) => one.mutant === find.mutant);
  const others = find.shows.length - 1;
  const flight = find.flights?.[0];
  const facts = [["name", h("span", { class: "id" }, find.name)], ["situation", h("span", { class: "id" }, find.situation)],
    flight && ["on the map", h("a", { href: flightHash(flight.mutant, find.situation, flight.seed) }, `the flight of ${flight.mutant} with seed ${flight.seed}`)]];
  return card(`find-${place}`, find.words,
    ["shows ", mutantName(own.mutant), `: ${effectOf(own)} in ${own.violated} of ${plural(own.flights, "flight")}; the unmutated drone holds it with a margin in ${own.held} of ${own.baselines}`, others > 0 && `.  It shows ${plural(others, "other fault")} too`, "."],
    foundPicture(find), [
      h("dl", { class: "pairs" }, facts.filter(Boolean).map(([what, told]) => [h("dt", {}, what), h("dd", {}, told)])),
      table(["shows", "violates", { text: "flights", number: true }, { text: "p", number: true }, { text: "alpha", number: true }, "in this campaign"], find.shows.map((one) => showsRow(find, one)), { stack: false }),
      table(["unmutated drone", { text: "held", number: true }, { text: "margin", number: true }, { text: "spread", number: true }, "unit"], baselineRows(find), { stack: false }),
      commandBox("Fly it", find.command)]);
}

/** The map of a find, with a pair of flights where the campaign has one. */
function foundPicture(find) {
  const [flight, clean] = find.flights ?? [];
  return [mapOf(find.scene, flight, clean)?.root, flight && key(flight, clean)];
}

const routeKey = () => h("ul", { class: "keys" }, h("li", {}, lineOf("route"), "route of the mission, where the campaign has no flight"), h("li", {}, lineOf("walked"), "path of a body that moves"));

/** A mutant by its id, which leads to its page where the campaign has it. */
const mutantName = (id) => (MUTANTS.has(id) ? h("a", { class: "id", href: mutantHash(id) }, id) : h("span", { class: "id" }, id));

const effectOf = ({ requirement, struck }) => `${requirement}${struck ? `, strikes ${struck}` : ""}`;

/** The evidence for one mutant, and what the campaign of the page says of it there. */
function showsRow(find, one) {
  const result = find.flights && MUTANTS.get(one.mutant)?.results[PLACES.get(find.situation)];
  return [mutantName(one.mutant),
    effectOf(one), shortText({ part: one.violated, whole: one.flights }), pText(one.p), pText(one.alpha),
    result ? shown(result, find.situation).said.replaceAll("\n", "; ") : "\u2013"];
}

/** What the unmutated drone does there, each requirement and number of seeds once. */
function baselineRows(find) {
  const rows = new Map(find.shows.map((one) => [`${one.requirement} ${one.baselines}`, one]));
  return [...rows.values()].map((one) => [one.requirement, shortText({ part: one.held, whole: one.baselines }), trimmed(one.margin, 3), trimmed(one.spread, 3), h("span", { class: "faint small unit" }, requirementOf(one.requirement)?.unit ?? "")]);
}
