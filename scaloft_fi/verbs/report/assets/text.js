/* Numbers and names as people read them. */
/** A cell of the kill matrix: a name and what it says. */
const SIGNS = {
  kill: ["kill", "most flights of a detected fault violate a safety requirement that the unmutated drone holds in nine of ten flights"],
  seen: ["seen, no kill", "a violation of a requirement that tests the fault, but not in most flights, or no more often than chance explains"],
  tested: ["tested, nothing seen", "the unmutated drone holds a safety requirement in nine of ten flights, and so does the fault's every flight"],
  no_test: ["no test", "no safety requirement is steady, so nothing that happens here counts for or against the fault"],
  masked: ["masked", "samples differed, the flight is the unmutated drone's to the bit"],
  not_infected: ["not infected", "every mutated sample equalled the original"],
  not_reached: ["not reached", "the place of the fault carried no sample"],
  not_flown: ["not flown", "no flight that counts"],
  not_meaningful: ["not meaningful", "the study says why the pair of words has no meaning"],
};
/** The verdict on a mutant: a mark, which terminal and pictures have too, and what it says. */
const VERDICTS = {
  detected: ["\u25cf", "It violates requirements more often than chance explains: the tests would have shown it."],
  undecided: ["?", "Violations were seen, or so few flights were flown that none of their results could decide."],
  not_detected: ["\u2013", "It was put to the test, and nothing was seen."],
  not_tested: ["\u00b7", "It changes no sample where the unmutated drone holds a safety requirement steadily."],
};
/** What remains of a detection when one seed is left out. */
const FIRMNESS = { firm: "firm", firm_by_pool: "firm by the pool alone", hangs_on_a_seed: "hangs on a seed", too_few_seeds: "too few seeds to say" };
const isFirm = ({ firm }) => firm === "firm" || firm === "firm_by_pool";
/** A pair of situation and requirement, by what the unmutated drone does: a letter, and what it says. */
const STATES = {
  steady: ["", "the unmutated drone holds it in nine of ten flights: it tests faults"],
  red: ["r", "most flights of the unmutated drone violate it"],
  unsteady: ["u", "the unmutated drone holds it or not by chance"],
  open: ["o", "more than a tenth of its flights are cut short before it is judged"],
  vacuous: ["v", "it is not triggered in half of its flights, so nothing is tested"],
  unknown: ["?", "fewer than ten flights of the unmutated drone"],
};
/** One flight beside that of the unmutated drone with the same seed: an observation, never a verdict. */
const STATUSES = {
  revealed: "A safety requirement is violated that the unmutated drone, same seed, held up to that moment.",
  survived: "The flight went another way, and no safety requirement showed it.",
  baseline_red: "It violates only what the unmutated drone, same seed, violates too.",
  masked: "Samples differed, the flight is the unmutated drone's to the bit.",
  not_infected: "Every mutated sample equalled the original.",
  not_reached: "The place of the fault carried no sample.",
  invalid: "The test bench failed.",
};

const spaced = (name) => name.replaceAll("_", " ");
const percent = (share) => `${Math.round(100 * share)} %`;
const share = ({ part, whole }) => (whole ? part / whole : null);
const ratioText = (ratio) => `${ratio.part}/${ratio.whole} = ${ratio.whole ? percent(share(ratio)) : "n/a"}`;
const shortText = ({ part, whole }) => `${part}/${whole}`;
const pText = (p) => (p < 1e-3 ? p.toExponential(1).replace("-", "\u2212") : trimmed(p, 3));
const seconds = (value) => (value === null || value === undefined ? "–" : `${value.toFixed(2)} s`);
const plural = (count, noun, many = `${noun}s`) => `${count} ${count === 1 ? noun : many}`;
const listed = (words) => (words.length ? words.join(", ") : "–");
const signed = (value, digits = 3) =>
  value === null || value === undefined ? "–" : value.toFixed(digits).replace("-", "\u2212");
const trimmed = (value, digits = 2) => String(Number(value.toFixed(digits))).replace("-", "\u2212");

/** A quantity's name and unit from the name of its column. */
const QUANTITIES = {
  speed_mps: "speed",
  clearance_m: "clearance of the hull",
  clearance_person_m: "clearance to the person",
  person_sight_m: "distance to the person in sight",
  person_m: "distance to the person",
  person_range_m: "distance to the person",
  elapsed_s: "time of flight",
};
const UNITS = { mps: "m/s", m: "m", s: "s", deg: "°", rad: "rad" };
const unitOf = (column) => UNITS[column.split("_").at(-1)] ?? "";
const quantity = (column) => QUANTITIES[column] ?? column.split("_").slice(0, unitOf(column) ? -1 : undefined).join(" ");

/** What stands between backticks is set as code, whose lines break between its words only. */
const withCode = (text) => text.split("`").map((piece, number) => (number % 2 ? inCode(piece) : piece));
const inCode = (text) => h("code", {}, text.split(" ").map((word, number) => [number ? " " : "", h("span", { class: "word" }, word)]));
const bounds = (text) => text.replaceAll("<=", "\u2264").replaceAll(">=", "\u2265").replaceAll(/ mps2\b/g, " m/s\u00b2").replaceAll(/ mps\b/g, " m/s").replaceAll(/ radps\b/g, " rad/s");

const flightHash = (mutant, situation, seed) =>
  `#flight=${[mutant, situation, seed].map(encodeURIComponent).join("/")}`;
const mutantHash = (id) => `#mutant=${encodeURIComponent(id)}`;
const cellHash = (name) => `#cell=${encodeURIComponent(name)}`;
/** The options that name the study and the campaign of the page, with a space before each. */
const inCampaign = () => DATA.where;
const literal = (argument) => (/^[\w@%+=:,./#-]+$/.test(argument) && !argument.startsWith("#") ? argument : `'${argument.replaceAll("'", "'\\''")}'`);
