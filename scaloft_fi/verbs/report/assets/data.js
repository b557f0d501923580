/* The figures that the page carries, deflated, and its flights: one deflated pack a situation, opened when first asked for. */
if (typeof DecompressionStream !== "function") {
  document.getElementById("main").textContent = "This browser cannot open the figures in this file: it has no DecompressionStream (Chrome 80, Firefox 113 and Safari 16.4 have it).  The command scaloft-fi score prints the tables.";
  return;
}
const DATA = JSON.parse(new TextDecoder().decode(await inflated(JSON.parse(document.getElementById("figures").textContent))));
const PACKS = JSON.parse(document.getElementById("flights").textContent);

const MUTANTS = new Map(DATA.mutants.map((mutant) => [mutant.id, mutant]));
const CELLS = new Map(DATA.cells.map((cell) => [cell.name, cell]));
const PLACES = new Map(DATA.situations.map((situation, place) => [situation.key, place]));
const SAFETY = DATA.requirements.filter((one) => one.kind === "safety").map((one) => one.name);
const PAIRS = new Map(DATA.pairs.map((pair) => [`${pair.situation} ${pair.requirement}`, pair]));

/** Whether one's own tests were run instead of flights; then texts of flights are said in the words of tests, but for those of the study. */
const OF_TESTS = DATA.words.length > 0;
const WORDS = new Map(DATA.words);
const OWN = new Set();
const keep = (value) => (typeof value === "string" ? OWN.add(value) : Object.values(value ?? {}).forEach(keep));
if (OF_TESTS) [DATA.cells, DATA.parameters, DATA.guidewords, DATA.severities, DATA.situations].forEach(keep);
const escaped = (text) => text.replaceAll(/[.*+?^${}()|[\]\\/]/g, "\\$&");
const WORD = new RegExp(`(?<![\\w:./@-])(?:${[...WORDS.keys()].sort((a, b) => b.length - a.length).map(escaped).join("|")})(?![\\w/@-]|[:.]\\S)`, "g");
const spoken = (text) => (OF_TESTS && typeof text === "string" && !OWN.has(text) ? text.replaceAll(WORD, (found) => WORDS.get(found)) : text);

const titleOf = (kind, id) => DATA[kind].find((entry) => entry.id === id)?.title ?? id;
const wordsOf = (key) => DATA.situations[PLACES.get(key)]?.words.join(", ") ?? key;
/** A situation in words, with its key; a test has but its name. */
const withKey = (key) => (OF_TESTS ? key : [wordsOf(key), " ", h("span", { class: "faint small" }, key)]);
const pairOf = (situation, requirement) => PAIRS.get(`${situation} ${requirement}`);
const stateOf = (situation, requirement) => pairOf(situation, requirement)?.state ?? "unknown";
/** The state as it is told: a test that is red now and then is called flaky, though it tests. */
const calledOf = (situation, requirement) => pairOf(situation, requirement)?.called ?? "unknown";
const besideText = (pair) => `unmutated drone ${pair.violated} of ${pair.flights - pair.open}`;
/** Of the requirements that are not steady, the state that says most. */
const untested = (situation) => ["red", "unsteady", "open", "unknown", "vacuous"].find((state) => SAFETY.some((name) => stateOf(situation, name) === state));

const stateWord = (state) => (state === "unknown" ? "no pool" : state);

/** What the kill matrix shows of a mutant in a situation: a sign, letters in it, what it says, the seed that a click opens. */
function shown(result, situation) {
  if (!result) return { state: "not_flown", glyph: "", said: SIGNS.not_flown[0], seed: DATA.seeds[0] ?? 0, by: [], counts: "" };
  const [sign, flown, seed, violated, by] = result;
  const state = DATA.signs[sign];
  const beside = (name) => `${name} violated in ${violated[name]} of ${plural(flown, "flight")} (${besideText(pairOf(situation, name))})`;
  const steady = SAFETY.filter((name) => stateOf(situation, name) === "steady");
  const what = {
    kill: () => `kill: ${by.map(beside).join("; ")}`,
    seen: () => `violation seen, no kill: ${by.map(beside).join("; ")}`,
    tested: () => `tested by ${listed(steady)}, nothing seen in ${plural(flown, "flight")}`,
    no_test: () => `no test: ${SAFETY.map((name) => `${name} ${stateWord(stateOf(situation, name))}`).join(", ")}`,
  }[state]?.() ?? SIGNS[state][0];
  const others = Object.keys(violated).filter((name) => !by.includes(name));
  const glyph = { kill: by.map((name) => SAFETY.indexOf(name) + 1).join(""), no_test: STATES[untested(situation)]?.[0] }[state] ?? "";
  return { state, glyph, seed, by, said: [what, ...others.map(beside)].join("\n"), counts: by.length ? `${violated[by[0]]}/${flown}` : "" };
}

const opened = new Map();

/** The flights of a situation with their tracks; null when the page has none. */
function flightsIn(situation) {
  if (!(Object.hasOwn(PACKS, situation))) return Promise.resolve(null);
  if (!opened.has(situation)) opened.set(situation, inflated(PACKS[situation]).then(unpacked));
  return opened.get(situation);
}

async function inflated(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let at = 0; at < raw.length; at += 1) bytes[at] = raw.charCodeAt(at);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** A length, so many bytes of JSON, then the tracks one after the other; a track is decoded when it is first asked for. */
function unpacked(bytes) {
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const { flights, tracks } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  let at = 4 + length;
  const starts = tracks.map(([count, same]) => {
    at += 2 * (count - same) * DATA.columns.length;
    return at - 2 * (count - same) * DATA.columns.length;
  });
  const rows = [];
  const track = (place) => {
    const [count, same, base] = tracks[place];
    return (rows[place] ??= decoded(bytes, starts[place], count - same, same ? track(base).slice(0, same) : []));
  };
  return flights.map((flight) => ({ ...flight, get rows() { return flight.track === null ? null : track(flight.track); } }));
}

/** Undo two planes of bytes, zigzag, differences column by column, and the quantum. */
function decoded(bytes, at, count, before) {
  const width = DATA.columns.length;
  const size = count * width;
  const out = Array.from({ length: count }, () => new Array(width));
  for (let column = 0; column < width; column += 1) {
    const { quantum } = DATA.columns[column];
    const first = before.length ? before.at(-1)[column] : 0;
    let value = first === null ? DATA.far : Math.round(first / quantum);
    for (let row = 0; row < count; row += 1) {
      const place = at + column * count + row;
      const word = bytes[place] | (bytes[place + size] << 8);
      value = (((value + ((word >>> 1) ^ -(word & 1))) << 16) >> 16);
      out[row][column] = Math.abs(value) === DATA.far ? null : value * quantum;
    }
  }
  return [...before, ...out];
}
