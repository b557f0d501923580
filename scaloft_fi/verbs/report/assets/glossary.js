/* The glossary at the end of the page, and the links to it: a head or a legend that is a term leads to its meaning. */
const FORMS = new Map(DATA.glossary.flatMap((entry, number) => [entry.name, ...entry.also].map((form) => [form.toLowerCase(), number])));
/** Terms that stand in sentences. */
const ALWAYS = ["fault", "mutant", "guideword", "parameter", "deviation", "seed", "robustness", "violated"];
/** By number the terms that the glossary has: those, and all that a link leads to. */
const LINKED = new Set(ALWAYS.map((name) => FORMS.get(name)));
const meanings = h("dl", { class: "glossary" });

/** A word as a link to its meaning: a requirement's name to the requirement, a term to the glossary; any other stays a text. */
function term(text) {
  const requirement = DATA.requirements.findIndex((one) => one.name === text);
  if (requirement >= 0) return h("a", { class: "term", href: `#requirement-${requirement}`, title: DATA.requirements[requirement].title }, text);
  const number = FORMS.get(text.toLowerCase());
  if (number === undefined) return text;
  if (!LINKED.has(number)) {
    LINKED.add(number);
    if (meanings.isConnected) explain();
  }
  return h("a", { class: "term", href: `#term-${number}`, title: DATA.glossary[number].meaning }, text);
}

/** Write the meanings of the terms that are linked. */
function explain() {
  meanings.replaceChildren(...[...LINKED].sort((a, b) => a - b).map((number) => {
    const { name, meaning } = DATA.glossary[number];
    return h("div", { id: `term-${number}`, tabindex: "-1" }, h("dt", {}, name), h("dd", {}, withCode(meaning)));
  }));
}

function glossary() {
  explain();
  return part("glossary", "Glossary", "The terms of this page.  A term in a head or a legend leads here.", meanings);
}
