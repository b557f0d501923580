/* The sheet of one flight: verdict, map, signals over time beside the unmutated drone's, robustness, the command that flies it. */
async function flightSheet(mutant, situation, seed) {
  const flights = await flightsIn(situation);
  const clean = flights?.find((one) => one.mutant === "baseline" && one.seed === seed) ?? null;
  const flight = flights?.find((one) => one.mutant === mutant && one.seed === seed) ?? null;
  const title = mutant === "baseline" ? "the unmutated drone" : mutant;
  const body = [];
  if (!flight) body.push(h("p", { class: "notice" }, DATA.listed < DATA.flights ? `The page lists ${DATA.listed.toLocaleString("en")} of ${DATA.flights.toLocaleString("en")} flights one by one, those of the lowest seeds; ${mutant}/${situation}/${seed} is not among them.  Its figures count all.` : `The campaign holds no flight ${mutant}/${situation}/${seed}.`));
  body.push(chooseFlight(flights, mutant, situation, seed));
  if (flight) body.push(...verdict(flight, situation));
  if (flight && !OF_TESTS) body.push(...pictures(situation, flight, clean), readings(flight, mutant === "baseline" ? null : clean));
  if (!OF_TESTS) body.push(command(mutant, situation, seed));
  const at = DATA.situations[PLACES.get(situation)];
  return { title: `${title} \u00b7 ${wordsOf(situation)}`, lead: `situation ${at ? codeOf(at) : situation}, seed ${seed}`, body };
}

function chooseFlight(flights, mutant, situation, seed) {
  const seeds = flights?.filter((one) => one.mutant === mutant).map((one) => [one.seed, one.status]) ?? [];
  const at = PLACES.get(situation);
  const beside = [-1, 1].map((step) => DATA.situations[at + step]?.key);
  const link = (key, text, label) => h("button", { type: "button", disabled: !key, onclick: () => go(flightHash(mutant, key, seed), true), "aria-label": label, title: key ? wordsOf(key) : null }, text);
  return h("div", { class: "row", role: "group", "aria-label": "Other flights" },
    h("span", { class: "name" }, "seed"),
    seeds.map(([one, status]) => h("button", { type: "button", "aria-pressed": String(one === seed), "data-seed": one, onclick: () => go(flightHash(mutant, situation, one), true) }, `${one} `, h("span", { class: "faint" }, spaced(status)))),
    h("span", { class: "name" }, "situation"), link(beside[0], "\u2039", "previous situation"), link(beside[1], "\u203a", "next situation"),
    at !== undefined && h("a", { href: situationHash(situation) }, "this situation"),
    MUTANTS.has(mutant) && h("a", { href: mutantHash(mutant) }, "all situations of this mutant"),
    CELLS.has(MUTANTS.get(mutant)?.cell) && h("a", { href: cellHash(MUTANTS.get(mutant).cell) }, "its cell of the HAZOP matrix"),
    mutant !== "baseline" && h("a", { href: flightHash("baseline", situation, seed) }, "the unmutated flight"));
}

/** What happened, in sentences. */
function verdict(flight, situation) {
  const mutant = MUTANTS.get(flight.mutant);
  const told = flight.revealed ?? [];
  const safely = told.filter((name) => SAFETY.includes(name));
  const heads = { held: "Holds every safety requirement", violated: "Violates a safety requirement without any fault" };
  const parts = [h("b", {}, heads[flight.status] ?? capital(spaced(flight.status))), safely.length > 0 && !OF_TESTS && ` by ${listed(safely)}`, ". "];
  if (flight.mutant !== "baseline") {
    parts.push(STATUSES[flight.status] ?? "", " ");
    if (OF_TESTS) parts.push(`The fault changed ${flight.altered} of ${flight.carried} samples. `);
    else parts.push(flight.infected_at_s === null ? `The fault changed none of ${flight.carried} samples. ` : `The fault changed ${flight.altered} of ${flight.carried} samples, the first at ${seconds(flight.infected_at_s)}. `);
  }
  for (const [name, t, x, y, z, struck] of flight.violations) {
    if (OF_TESTS || requirementOf(name)?.kind === "reported") continue;
    const too = flight.mutant !== "baseline" && !told.includes(name) ? ", as by the unmutated drone" : "";
    parts.push(`${name} is violated at ${seconds(t)}, at (${signed(x, 2)}, ${signed(y, 2)}, ${signed(z, 2)}) m${struck ? `, striking ${struck}` : ""}${too}. `);
  }
  if (flight.invalid) parts.push(`The test bench failed: ${flight.invalid}. `);
  else if (!OF_TESTS) parts.push(`After ${seconds(flight.duration_s)} it ${DATA.endings[flight.ending] ?? flight.ending}.`);
  if (flight.stack_error) parts.push(` The stack raised: ${flight.stack_error}`);
  const result = mutant?.results[PLACES.get(situation)];
  return [h("p", { class: "verdict" }, parts.filter(Boolean)),
    result && h("p", { class: "small faint" }, `One flight decides nothing.  All flights of the fault here: ${shown(result, situation).said.replaceAll("\n", "; ")}.  Over all situations: ${mutant.control ? showsText(mutant) : `${verdictText(mutant)}; ${killsText(mutant)}`}.`)];
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function pictures(situation, flight, clean) {
  if (!flight.rows && !clean?.rows) return [h("p", { class: "note" }, "The page holds no track of this flight.  ", withCode(DATA.detail))];
  const shownClean = flight.mutant === "baseline" ? null : clean;
  const { map, plots } = drawn(situation, flight, shownClean);
  const end = Math.max(...[flight, shownClean].filter((one) => one?.rows?.length).map((one) => one.rows.at(-1)[0]));
  const happened = marks(flight);
  const start = happened.find((mark) => mark.kind === "violation")?.t ?? 0;
  const time = player(end, happened, start, (moment) => [map, ...plots].forEach((picture) => picture?.move(moment)));
  plots.forEach((picture) => picture.root.addEventListener("pointermove", (event) => time.go(Math.max(0, Math.min(end, picture.timeAt(event))))));
  return [time.node, h("div", { class: "flight" },
    h("figure", {}, map?.root, key(flight, shownClean)),
    h("div", {}, plots.map((picture) => h("figure", {}, h("figcaption", {}, picture.caption), picture.root)),
      !flight.rows && h("p", { class: "note" }, "This flight's own track is not in the page.  ", withCode(DATA.detail))))];
}

/** The map of a flight beside the unmutated drone's, and a chart for each signal of the tracks. */
function drawn(situation, flight, clean) {
  return {
    map: mapOf(DATA.scenes.situations[situation], flight, clean),
    plots: DATA.columns.slice(4).map((column, number) => timeChart(column.name, number + 4, flight, clean)).filter(Boolean),
  };
}

const lineOf = (kind) => s("svg", { width: 30, height: 12, "aria-hidden": "true" }, s("path", { class: kind, d: "M3,6H27" }));

const signOf = (kind) => s("svg", { width: 18, height: 18, "aria-hidden": "true" }, sign({ kind, text: "", t: 0 }, 9, 9));

function key(flight, clean) {
  const kinds = new Set(marks(flight).map((mark) => mark.kind));
  return h("ul", { class: "keys" },
    h("li", {}, lineOf("flown"), flight.mutant === "baseline" ? "the unmutated drone" : flight.mutant),
    clean && h("li", {}, lineOf("clean"), "the unmutated drone, same seed"),
    [["infection", "first changed sample"], ["violation", "violation"], ["end", "end"]].filter(([kind]) => kinds.has(kind)).map(([kind, text]) => h("li", {}, signOf(kind), text)));
}

/** One signal over time: the unmutated drone's as a broad band, the mutant's as a line, the limits that requirements set to it. */
function timeChart(name, column, flight, clean) {
  const series = [clean, flight].filter((one) => one?.rows?.length);
  const values = series.flatMap((one) => one.rows.map((row) => row[column])).filter((value) => value !== null);
  if (!values.length) return null;
  const drawn = DATA.limits.filter((limit) => limit.signal === name);
  const most = Math.max(...values, ...drawn.map((limit) => limit.bound)) * 1.08 || 1;
  const least = Math.min(0, ...values, ...drawn.map((limit) => limit.bound));
  const end = Math.max(...series.map((one) => one.rows.at(-1)[0]));
  const caption = `${quantity(name)} [${unitOf(name)}]`;
  const frame = plot({ height: 150, x: [0, end], y: [least, most], top: 10, bottom: 22, right: 96, label: `${caption} over time`, xText: (value) => `${value} s` });
  const { root, sx, sy } = frame;
  const drawnOf = (one) => pathOf(one.rows.map((row) => (row[column] === null ? null : [sx(row[0]), sy(row[column])])));
  for (const limit of drawn) {
    const when = limit.role === "when" || idle(limit, flight, clean);
    root.append(s("line", { class: when ? "limit when" : "limit", x1: frame.left, x2: WIDE - frame.right, y1: sy(limit.bound), y2: sy(limit.bound) }));
  }
  if (clean?.rows) root.append(s("path", { class: "clean", d: drawnOf(clean) }));
  if (flight.rows) root.append(s("path", { class: "flown", d: drawnOf(flight) }));
  for (const mark of marks(flight)) if (mark.kind !== "end") root.append(s("line", { class: mark.kind, x1: sx(mark.t), x2: sx(mark.t), y1: frame.top, y2: 150 - frame.bottom }), sign(mark, sx(mark.t), frame.top));
  limitNames(drawn, sy, (limit) => idle(limit, flight, clean)).forEach(({ y, when, text }) => root.append(s("text", { class: when ? "limit-name when" : "limit-name", x: WIDE - frame.right + 5, y }, text)));
  const cursor = s("line", { class: "cursor", x1: 0, x2: 0, y1: frame.top, y2: 150 - frame.bottom, visibility: "hidden" });
  const read = s("text", { class: "strong", y: frame.top + 8, visibility: "hidden" });
  root.append(cursor, read);
  root.classList.add("chart");
  return {
    root, caption,
    timeAt: (event) => {
      const bounds = root.getBoundingClientRect();
      return ((((event.clientX - bounds.left) / bounds.width) * WIDE - frame.left) / (WIDE - frame.left - frame.right)) * end;
    },
    move: (time) => {
      const row = rowAt((flight.rows ? flight : clean).rows, time);
      [cursor, read].forEach((node) => node.setAttribute("visibility", row ? "visible" : "hidden"));
      if (!row) return;
      ["x1", "x2"].forEach((end_) => cursor.setAttribute(end_, sx(time)));
      read.textContent = row[column] === null ? "" : trimmed(row[column]);
      read.setAttribute("x", sx(time) + 5);
    },
  };
}

/** Whether the condition of a limit's requirement came true in neither flight. */
function idle(limit, flight, clean) {
  const number = DATA.requirements.findIndex((one) => one.name === limit.requirement);
  return [flight, clean].every((one) => !one || one.readings[number]?.[3] === 0);
}

/** Names of limits at the right edge: those at one height joined, then pushed apart. */
function limitNames(drawn, sy, isIdle) {
  const byHeight = new Map();
  for (const limit of drawn) {
    const when = limit.role === "when" || isIdle(limit);
    const sense = { "<=": "\u2264", ">=": "\u2265" }[limit.sense] ?? limit.sense;
    const entry = byHeight.get(`${limit.bound}${when}`) ?? { y: sy(limit.bound) + 4, when, names: [], text: `${sense} ${trimmed(limit.bound)}` };
    const role = limit.role === "when" ? `${limit.requirement} counts` : isIdle(limit) ? `${limit.requirement}, idle` : limit.requirement;
    entry.names.push(role);
    byHeight.set(`${limit.bound}${when}`, entry);
  }
  const entries = [...byHeight.values()].sort((a, b) => a.y - b.y);
  entries.forEach((entry, number) => { if (number) entry.y = Math.max(entry.y, entries[number - 1].y + 13 + 11 * entries[number - 1].names.length); });
  return entries.flatMap(({ y, when, text, names }) => [{ y, when, text }, ...names.map((name, line) => ({ y: y + 11 * (line + 1), when, text: name }))]);
}

/** What each requirement says of the flight beside the unmutated one. */
function readings(flight, clean) {
  const side = (one, number) => (one?.readings[number] ? [one.readings[number][2], signed(one.readings[number][0])] : ["–", "–"]);
  const rows = DATA.requirements.map((requirement, number) => {
    const own = flight.readings[number];
    return [h("span", { title: requirement.title }, requirement.name, h("span", { class: "faint small" }, ` ${requirement.kind}`)),
      ...(clean ? side(clean, number) : []), ...side(flight, number), own ? seconds(own[1]) : "–", h("span", { class: "faint small unit" }, requirement.unit)];
  });
  const headers = ["requirement", ...(clean ? ["unmutated drone", { text: "robustness", number: true }] : []), "flight", { text: "robustness", number: true }, { text: "violated at", number: true }, "unit"];
  return h("div", {}, h("h3", { class: "sub" }, "Robustness: below 0 a requirement is violated; \u2013 where it was not put to the test"), table(headers, rows, { stack: false }));
}

function command(mutant, situation, seed) {
  return commandBox("Fly it again, bit for bit", `scaloft-fi replay${inCampaign()} ${literal(`${mutant}/${situation}/${seed}`)}`);
}

function commandBox(title, words) {
  const button = h("button", { type: "button", onclick: () => copied(words, button) }, "Copy");
  return h("div", {}, h("h3", { class: "sub" }, title), h("div", { class: "command" }, h("code", {}, words), button));
}

async function copied(words, button) {
  try {
    await navigator.clipboard.writeText(words);
    button.textContent = "Copied";
  } catch {
    getSelection().selectAllChildren(button.previousSibling);
    button.textContent = "Selected";
  }
}
