/* The Karnaugh map of a mutant: the grid folded so that neighbours differ on one axis, each term of its condition outlined. */
const CELL_WIDTH = 76;
const CELL_HEIGHT = 46;
const INSETS = [3.5, 6.5, 9.5, 12.5, 15.5, 18.5];

function karnaughMap(mutant) {
  const fold = DATA.karnaugh;
  if (fold.reason) return h("p", { class: "note" }, h("b", {}, "No Karnaugh map. "), withCode(fold.reason));
  const rows = fold.rows.map((_, row) => h("div", { role: "row", class: "fold-row" }, fold.keys[row].map((key, column) => mapCell(mutant, key, row, column))));
  const grid = h("div", { class: "karnaugh", role: "grid", "aria-label": `Karnaugh map of ${mutant.id}: ${mutant.condition ? `killed where ${mutant.condition}` : "killed nowhere"}`,
    "--left": fold.down.length, "--rows": fold.rows.length, "--columns": fold.columns.length, "--above": fold.across.length },
    strips(fold.across, fold.columns, true), strips(fold.down, fold.rows, false), rows, outlines(mutant.terms));
  roving(grid, ".map-cell", () => rows, (cell) => { if (cell.dataset.key) go(flightHash(mutant.id, cell.dataset.key, Number(cell.dataset.seed))); }).reset();
  tip.on(grid, ".map-cell", (cell) => cell.getAttribute("aria-label"));
  return h("div", {},
    h("div", { class: "scroll" }, grid),
    mutant.terms.length > 0
      ? h("ul", { class: "keys" }, mutant.terms.map((term, number) => h("li", {}, s("svg", { width: 34, height: 10, "aria-hidden": "true" }, s("path", { class: "term", d: "M1,5H33", "data-term": number % INSETS.length })), h("b", {}, letterOf(number)), term.words)))
      : h("p", { class: "small" }, "Killed nowhere: no term to outline."),
    h("p", { class: "small faint" }, `Neighbouring cells differ on one axis${fold.cyclic.every(Boolean) ? "; opposite edges meet" : ""}.  An outline is a term of the condition that is true wherever there is a kill and nowhere that the fault was tested without one, or could change nothing.  What is no test, or was not flown, may lie on either side.  Arrow keys move, Enter opens a flight.`));
}

const letterOf = (number) => String.fromCharCode(65 + (number % 26)) + (number >= 26 ? Math.floor(number / 26) : "");

function mapCell(mutant, key, row, column) {
  const { state, said, seed, by, counts } = shown(mutant.results[PLACES.get(key)], key);
  const words = { kill: "kill", seen: "seen", tested: "nothing seen" }[state] ?? (state === "no_test" ? `no test: ${stateWord(untested(key))}` : SIGNS[state][0]);
  return h("div", { class: `map-cell state${key ? "" : " absent"}`, role: "gridcell", tabindex: "-1",
    "data-state": state, "data-key": key, "data-seed": seed, "--row": row, "--column": column,
    "aria-label": key ? `${wordsOf(key)} (${key})\n${said}` : "The grid has no such situation." }, h("span", { class: "plate" }, key ? [words, ...by, counts].join(" ").trim() : ""));
}

/** Per axis of a side its values, equal neighbours joined; what is not benign is shaded. */
function strips(axes, side, across) {
  return axes.map((axis, line) => {
    const found = [];
    side.forEach((levels, place) => {
      if (found.at(-1)?.level === levels[line]) found.at(-1).span += 1;
      else found.push({ level: levels[line], place, span: 1 });
    });
    return found.map(({ level, place, span }) => h("div", { class: `strip ${across ? "across" : "down"}${level ? " raised" : ""}`, "--line": line, "--place": place, "--span": span, title: DATA.axes[axis].title }, DATA.axes[axis].words[level]));
  });
}

/** Each term's cells, framed; a frame stays open where the term goes on at the opposite edge. */
function outlines(terms) {
  const { down, across, rows, columns, cyclic } = DATA.karnaugh;
  const kept = (side, axes, levels) => new Set(side.flatMap((place, number) => (axes.every((axis, line) => levels[axis].includes(place[line])) ? [number] : [])));
  const shut = (at, step, taken, size, meets) => {
    const beyond = at + step, outside = beyond < 0 || beyond >= size;
    return outside && (!meets || taken.size === size) ? true : !taken.has((beyond + size) % size);
  };
  const drawn = terms.map(({ levels }, number) => {
    const [down_, across_] = [kept(rows, down, levels), kept(columns, across, levels)];
    const inset = INSETS[number % INSETS.length];
    const lines = [];
    for (const row of down_) for (const column of across_) {
      const [north, south] = [-1, 1].map((step) => shut(row, step, down_, rows.length, cyclic[0]));
      const [west, east] = [-1, 1].map((step) => shut(column, step, across_, columns.length, cyclic[1]));
      const [x0, x1] = [column * CELL_WIDTH + inset * west, (column + 1) * CELL_WIDTH - inset * east];
      const [y0, y1] = [row * CELL_HEIGHT + inset * north, (row + 1) * CELL_HEIGHT - inset * south];
      if (north) lines.push(`M${x0},${y0}H${x1}`);
      if (south) lines.push(`M${x0},${y1}H${x1}`);
      if (west) lines.push(`M${x0},${y0}V${y1}`);
      if (east) lines.push(`M${x1},${y0}V${y1}`);
    }
    const d = lines.join("");
    const [row, column] = [Math.min(...down_), Math.min(...across_)];
    return [s("path", { class: "term halo", d }), s("path", { class: "term", d, "data-term": number % INSETS.length }),
      s("text", { class: "letter", x: column * CELL_WIDTH + 8 + 12 * (number % 5), y: row * CELL_HEIGHT + 12 }, letterOf(number))];
  });
  return s("svg", { class: "terms", width: columns.length * CELL_WIDTH, height: rows.length * CELL_HEIGHT, "aria-hidden": "true" }, drawn);
}
