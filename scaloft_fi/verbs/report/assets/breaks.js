/* The situations that break the unmutated drone: what it violates, where, after which wrong belief. */

/** Null for a study without breaks. */
function breakingSituations() {
  const breaks = DATA.breaks;
  if (!breaks.length) return null;
  return part("breaks", "What breaks the unmutated drone", "A search flew the unmutated drone in situations around the grid, and confirmed these on seeds that it never flew.  They are findings about the drone; no fault is put to the test here.",
    table(["the unmutated drone", { text: "in flights", number: true }, "where", "wrong belief"], breaks.map((one, place) => [
      h("a", { href: `#break-${place}` }, `violates ${effectOf(one)}`), shortText({ part: one.violated, whole: one.flights }), one.where, one.belief]), { stack: false }),
    h("p", { class: "small faint" }, "Wrong belief: the stage that was the farthest from the truth in the second before, and by how much.  It tells where to look; it is no proof of a cause."),
    h("div", { class: "cards" }, breaks.map(breakOne)),
    h("ul", { class: "keys" }, h("li", {}, lineOf("route"), "route of the mission"), h("li", {}, signOf("violation"), "where the requirement is violated")));
}

function breakOne(one, place) {
  const facts = [["name", h("span", { class: "id" }, one.name)], ["situation", h("span", { class: "id" }, one.situation)],
    ["where", one.where], ["wrong belief", one.belief], ["in the flight told", seconds(one.t_s)]];
  const mark = { kind: "violation", t: one.t_s, at: one.place, text: `${one.requirement} violated${one.struck ? `, strikes ${one.struck}` : ""}`, brief: `${one.requirement}, ${seconds(one.t_s)}` };
  return card(`break-${place}`, one.words, `${effectOf(one)} in ${shortText({ part: one.violated, whole: one.flights })} flights, ${one.alike} of them in this way.`,
    mapOf(one.scene, null, null, [mark])?.root,
    [h("dl", { class: "pairs" }, facts.map(([what, told]) => [h("dt", {}, what), h("dd", {}, told)])), commandBox("Fly it", one.command)]);
}
