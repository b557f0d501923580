/* The figures that the page carries, and its flights: one deflated pack a situation, opened when first asked for. */
const DATA = JSON.parse(document.getElementById("figures").textContent);
const PACKS = JSON.parse(document.getElementById("flights").textContent);

const MUTANTS = new Map(DATA.mutants.map((mutant) => [mutant.id, mutant]));
const CELLS = new Map(DATA.cells.map((cell) => [cell.name, cell]));
const PLACES = new Map(DATA.situations.map((situation, place) => [situation.key, place]));
const SEVERAL = DATA.seeds.length > 1;

const titleOf = (kind, id) => DATA[kind].find((entry) => entry.id === id)?.title ?? id;
const wordsOf = (key) => DATA.situations[PLACES.get(key)]?.words.join(", ") ?? key;

/** What the matrix shows of a result: its state, the killed share, and a number where the share is no whole one. */
function shown(result) {
  if (!result) return { state: "not_flown", share: 0, glyph: "", said: "not flown" };
  const [status, kills, eligible, flown, decision] = result;
  const state = DATA.statuses[status];
  const undecided = SEVERAL && DATA.decisions[decision] === "undecided";
  if (state === "killed" && !eligible) return { state, share: 0, glyph: "", uncounted: true, said: "killed, but not counted: the clean drone holds no safety requirement to the end here" };
  if (state === "killed") {
    const glyph = kills < eligible ? String(kills) : "";
    return { state, share: kills / eligible, glyph: undecided ? `${glyph}?` : glyph, said: `killed in ${kills} of ${plural(eligible, "eligible flight")}${undecided ? ", undecided" : ""}` };
  }
  return { state, share: 0, glyph: "", said: `${STATES[state][0]} (${plural(flown, "flight")}${state === "survived" && undecided ? ", too few to decide" : ""})` };
}

const CAN_INFLATE = typeof DecompressionStream === "function";
const opened = new Map();

/** The flights of a situation with their tracks; null when the page has none. */
function flightsIn(situation) {
  if (!(Object.hasOwn(PACKS, situation))) return Promise.resolve(null);
  if (!opened.has(situation)) opened.set(situation, inflated(PACKS[situation]).then(unpacked));
  return opened.get(situation);
}

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** A length, so many bytes of JSON, then the tracks one after the other. */
function unpacked(bytes) {
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const { flights, tracks } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const rows = [];
  let at = 4 + length;
  for (const [count, same, base] of tracks) {
    const own = count - same;
    rows.push(decoded(bytes, at, own, same ? rows[base].slice(0, same) : []));
    at += 2 * own * DATA.columns.length;
  }
  return flights.map((flight) => ({ ...flight, rows: flight.track === null ? null : rows[flight.track] }));
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
