/* Elements without markup: whatever the study says becomes a text node or an attribute, never HTML. */
const SVG = "http://www.w3.org/2000/svg";
/** The attributes that people read. */
const TEXTS = ["title", "aria-label", "data-head"];

function furnished(node, attributes, children) {
  const own = node.localName === "code" || ["word", "id"].includes(attributes.class);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name.startsWith("--")) node.style.setProperty(name, value);
    else node.setAttribute(name, value === true ? "" : TEXTS.includes(name) ? spoken(value) : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false).map((child) => (own ? child : spoken(child))));
  return node;
}

const h = (tag, attributes = {}, ...children) => furnished(document.createElement(tag), attributes, children);
const s = (tag, attributes = {}, ...children) => furnished(document.createElementNS(SVG, tag), attributes, children);

/** A table: headers are texts, each a term, or {text, number: true, after: what follows it}; a cell is a text or a node; the first column names its row. */
function table(headers, rows, { caption = null, stack = true } = {}) {
  const heads = headers.map((head) => (typeof head === "string" ? { text: head } : head));
  const cell = (value, column) => {
    const attributes = { class: heads[column].number && "number", "data-head": column && heads[column].text };
    return column === 0 ? h("th", { scope: "row", ...attributes }, value) : h("td", attributes, value);
  };
  return h("div", { class: "scroll" },
    h("table", { class: stack ? "plain stack" : "plain" },
      caption && h("caption", {}, caption),
      h("thead", {}, h("tr", {}, heads.map((head) => h("th", { scope: "col", class: head.number && "number" }, term(head.text), head.after)))),
      h("tbody", {}, rows.map((row) => h("tr", {}, row.map(cell))))));
}

/** A section of the page with a heading that the bar at the top links to. */
function part(id, title, lead, ...children) {
  return h("section", { class: "part", id, "aria-labelledby": `${id}-title`, tabindex: "-1" },
    h("header", {}, h("h2", { id: `${id}-title` }, title), lead && h("p", {}, lead)),
    children);
}

/** What is behind a click, made when it is first opened: in the page it would cost each look at anything else. */
const UNMADE = new Map();
function fold(attributes, says, make) {
  const details = h("details", attributes, h("summary", {}, says));
  UNMADE.set(details, make);
  details.addEventListener("toggle", () => { made(details); reachable(details); });
  if (attributes.open) made(details);
  return details;
}

function made(details) {
  if (!UNMADE.has(details)) return;
  furnished(details, {}, [UNMADE.get(details)()]);
  UNMADE.delete(details);
}

/** What a section has behind a click; a link to the section opens it. */
const folded = (says, make) => fold({ class: "fold whole" }, says, make);

/** One tab stop for a grid of cells; arrows, Home and End move in it, Enter and Space open. */
function roving(grid, selector, rowsOf, open) {
  const cells = () => rowsOf().map((row) => [...row.querySelectorAll(selector)]);
  const settle = (cell) => {
    grid.querySelector(`${selector}[tabindex="0"]`)?.setAttribute("tabindex", "-1");
    cell.setAttribute("tabindex", "0");
  };
  grid.addEventListener("focusin", (event) => {
    const cell = event.target.closest(selector);
    if (cell) settle(cell);
  });
  grid.addEventListener("click", (event) => {
    const cell = event.target.closest(selector);
    if (!cell) return;
    cell.focus({ preventScroll: true });
    open(cell);
  });
  grid.addEventListener("keydown", (event) => {
    const cell = event.target.closest(selector);
    if (!cell || event.altKey || event.metaKey) return;
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      open(cell);
      return;
    }
    const rows = cells();
    const y = rows.findIndex((row) => row.includes(cell));
    const x = rows[y].indexOf(cell);
    const last = rows.length - 1;
    const steps = {
      ArrowRight: [y, x + 1], ArrowLeft: [y, x - 1], ArrowDown: [y + 1, x], ArrowUp: [y - 1, x],
      Home: [event.ctrlKey ? 0 : y, 0], End: [event.ctrlKey ? last : y, Infinity],
      PageDown: [y + 10, x], PageUp: [y - 10, x],
    };
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    const row = rows[Math.max(0, Math.min(last, step[0]))];
    const next = row[Math.max(0, Math.min(row.length - 1, step[1]))];
    settle(next);
    next.focus();
    next.scrollIntoView({ block: "nearest", inline: "nearest" });
  });
  return { reset: () => { const first = cells().flat()[0]; if (first) settle(first); } };
}

/** A box beside what is pointed at or focused, saying what it is. */
const tip = {
  box: () => document.getElementById("tip"),
  show(anchor, text) {
    const box = this.box();
    box.textContent = text;
    box.hidden = false;
    const at = anchor.getBoundingClientRect();
    const own = box.getBoundingClientRect();
    const below = at.bottom + 8 + own.height < innerHeight;
    box.style.left = `${Math.max(8, Math.min(innerWidth - own.width - 8, at.left))}px`;
    box.style.top = `${below ? at.bottom + 8 : Math.max(8, at.top - own.height - 8)}px`;
  },
  hide() { this.box().hidden = true; },
  on(root, selector, say) {
    const shown = (event) => {
      const anchor = event.target.closest(selector);
      if (anchor) this.show(anchor, say(anchor));
      else this.hide();
    };
    root.addEventListener("mouseover", shown);
    root.addEventListener("focusin", shown);
    root.addEventListener("mouseleave", () => this.hide());
    root.addEventListener("focusout", () => this.hide());
  },
};
