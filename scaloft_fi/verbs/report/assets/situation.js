/* A situation: its name in words, what stands there, what its pairs test, and the mutants that are killed there. */
const situationHash = (key) => `#situation=${encodeURIComponent(key)}`;
const codeOf = ({ key, aliases }) => OF_TESTS ? "" : [key, ...aliases.map((alias) => `alias ${alias}`)].join(", ");

/** A situation as tables show it: values in words, key and aliases behind. */
function named(key) {
  const situation = DATA.situations[PLACES.get(key)];
  return situation ? [situation.words.join(", "), " ", h("span", { class: "faint small" }, codeOf(situation))] : key;
}

function situationSheet(key) {
  const situation = DATA.situations[PLACES.get(key)];
  if (!situation) return { title: key, lead: "", body: [h("p", { class: "notice" }, `The campaign has no situation ${key}.`)] };
  const killed = DATA.mutants.flatMap((mutant) => mutant.kills.filter((kill) => kill.situation === key).map((kill) => [mutant, kill]));
  const pairs = DATA.pairs.filter((pair) => pair.situation === key);
  return {
    title: OF_TESTS ? key : capital(situation.words.join(", ")), lead: `situation ${codeOf(situation)}`,
    body: [
      h("div", { class: "flight" },
        !OF_TESTS && h("figure", {}, mapOf(DATA.scenes.situations[key], null, null)?.root, h("ul", { class: "keys" }, h("li", {}, lineOf("route"), "route of the mission"))),
        h("div", {},
          h("dl", { class: "pairs" }, DATA.axes.map((axis, number) => [h("dt", {}, axis.title), h("dd", {}, situation.words[number])])),
          pairs.length > 0 && table(["requirement", "state", { text: "the unmutated drone violates", number: true }], pairs.map((pair) => [pair.requirement, stateWord(pair.called), shortText({ part: pair.violated, whole: pair.flights - pair.open })]), { stack: false }),
          DATA.seeds.length > 0 && h("p", {}, h("a", { href: flightHash("baseline", key, DATA.seeds[0]) }, `The flight of the unmutated drone, seed ${DATA.seeds[0]}`)))),
      h("h3", { class: "sub" }, `Killed here: ${plural(new Set(killed.map(([mutant]) => mutant.id)).size, "mutant")}`),
      killed.length > 0 && table(["mutant", "killed by", { text: "violated", number: true }, { text: "violated at", number: true }, "flight"], killed.map(([mutant, kill]) => [
        h("a", { class: "id", href: mutantHash(mutant.id) }, mutant.id), byText(kill.requirement), shortText(kill.flights), seconds(kill.t_s), h("a", { href: flightHash(mutant.id, key, kill.seed) }, `seed ${kill.seed}`)]), { stack: false }),
    ],
  };
}

/** Every situation of the kill matrix by its name. */
function situationList() {
  if (OF_TESTS) return null;
  return h("details", { class: "fold" }, h("summary", {}, "The situations by name"),
    table(["situation", "key", "alias", ...SAFETY, { text: "killed there", number: true }], DATA.situations.map((situation, place) => [
      h("a", { href: situationHash(situation.key) }, situation.words.join(", ")), h("span", { class: "id" }, situation.key), situation.aliases.join(", "),
      ...SAFETY.map((name) => stateWord(calledOf(situation.key, name))), String(DATA.by_situation[place].killed)])));
}
