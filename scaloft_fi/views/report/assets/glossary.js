/* The glossary at the end of the page, and the links to it: a head or a legend that is a term leads to its meaning. */
const FORMS = new Map(DATA.glossary.flatMap((entry, number) => [entry.name, ...entry.also].map((form) => [form.toLowerCase(), number])));
/** The terms that the page links to so far, by number; those that only sheets have are told here. */
const LINKED = new Set(["accepted", "causes", "deviation", "effect", "fault", "guideword", "parameter", "predicted", "p", "robustness", "seed", "violated", "seen", "tests", "unit", "state", "node", "margin", "strikes", "killed by", "flight"].map((name) => FORMS.get(name)));

/** A word as a link to its meaning: a requirement's name to the requirement, a term to the glossary; any other stays a text. */
function term(text) {
  const requirement = DATA.requirements.findIndex((one) => one.name === text);
  if (requirement >= 0) return h("a", { class: "term", href: `#requirement-${requirement}`, title: DATA.requirements[requirement].title }, text);
  const number = FORMS.get(text.toLowerCase());
  if (number === undefined) return text;
  LINKED.add(number);
  return h("a", { class: "term", href: `#term-${number}`, title: DATA.glossary[number].meaning }, text);
}

/** To be made last: it has the terms that are linked. */
function glossary() {
  const entries = [...LINKED].filter((number) => number !== undefined).sort((a, b) => a - b);
  return part("glossary", "Glossary", "The terms of this page.  A term in a head or a legend leads here.",
    h("dl", { class: "glossary" }, entries.map((number) => {
      const { name, meaning } = DATA.glossary[number];
      return h("div", { id: `term-${number}`, tabindex: "-1" }, h("dt", {}, name), h("dd", {}, withCode(meaning)));
    })));
}
