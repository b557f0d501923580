/* Numbers and names as people read them. */
const STATES = {
  killed: ["killed", "A safety requirement is violated that the clean drone held up to that moment."],
  survived: ["survived", "The flight went another way, and no safety requirement showed it."],
  baseline_red: ["baseline red", "It violates only what the clean drone violates too: such a flight proves nothing."],
  masked: ["masked", "Samples differed, the flight is the clean drone's to the bit."],
  not_infected: ["not infected", "Every mutated sample equalled the original."],
  not_reached: ["not reached", "The place of the fault carried no sample."],
  invalid: ["invalid", "The test bench failed: never a kill, never a survivor."],
  not_meaningful: ["not meaningful", "The study says why the pair of words has no meaning."],
  not_flown: ["not flown", "No flight in this campaign."],
};

const percent = (share) => `${Math.round(100 * share)} %`;
const share = ({ part, whole }) => (whole ? part / whole : null);
const ratioText = (ratio) => `${ratio.part}/${ratio.whole} = ${ratio.whole ? percent(share(ratio)) : "n/a"}`;
const intervalText = (ratio) =>
  ratio.interval ? `[${Math.round(100 * ratio.interval[0])}, ${Math.round(100 * ratio.interval[1])}]` : "";
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
  told_range_m: "distance to the person as told",
};
const UNITS = { mps: "m/s", m: "m", s: "s", deg: "°", rad: "rad" };
const unitOf = (column) => UNITS[column.split("_").at(-1)] ?? "";
const quantity = (column) => QUANTITIES[column] ?? column.split("_").slice(0, unitOf(column) ? -1 : undefined).join(" ");

/** What stands between backticks is set as code. */
const withCode = (text) => text.split("`").map((piece, number) => (number % 2 ? h("code", {}, piece) : piece));
const bounds = (text) => text.replaceAll("<=", "\u2264").replaceAll(">=", "\u2265").replaceAll(/ mps\b/g, " m/s");

const flightHash = (mutant, situation, seed) =>
  `#flight=${[mutant, situation, seed].map(encodeURIComponent).join("/")}`;
const mutantHash = (id) => `#mutant=${encodeURIComponent(id)}`;
const cellHash = (name) => `#cell=${encodeURIComponent(name)}`;
const literal = (argument) => (/^[\w@%+=:,./#-]+$/.test(argument) && !argument.startsWith("#") ? argument : `'${argument.replaceAll("'", "'\\''")}'`);
