/* Puts the page together, follows its fragment, switches its theme. */
const SHEETS = /^#(flight|cell|mutant|situation)=/;
const MAKERS = { situation: (names) => situationSheet(names[0]), cell: (names) => cellSheet(names[0]), mutant: (names) => mutantSheet(names[0]), flight: (names) => flightSheet(names[0], names[1] ?? "", Number(names[2] ?? 0)) };
let returned = null;
/* Whether the sheet closes because the fragment left it; its close event comes later, when the fragment may be back. */
let left = false;

function go(hash, inPlace = false) {
  if (inPlace) history.replaceState(null, "", hash);
  else location.hash = hash;
  if (inPlace) follow();
}

/** Open what the fragment names, or close what is open. */
async function follow() {
  const sheet = document.getElementById("sheet");
  const hash = location.hash;
  if (!SHEETS.test(hash)) {
    const named = document.getElementById(hash.slice(1));
    const whole = named?.tagName === "DETAILS" ? named : named?.querySelector("details.whole");
    if (whole) whole.open = true;
    if (sheet.open) {
      left = true;
      sheet.close();
    }
    return;
  }
  const value = hash.slice(hash.indexOf("=") + 1);
  let told;
  try {
    const names = value.split("/").map(decodeURIComponent);
    told = await MAKERS[SHEETS.exec(hash)[1]](names);
  } catch (error) {
    told = { title: "This cannot be shown", lead: value, body: [h("p", { class: "notice" }, String(error))] };
  }
  if (location.hash !== hash) return;
  const close = h("button", { type: "button", "aria-label": "Close", onclick: () => sheet.close() }, "Close");
  const stepped = sheet.open && document.activeElement?.dataset.step;
  sheet.replaceChildren(
    h("div", { class: "sheet-head" }, h("div", {}, h("h2", { id: "sheet-title" }, told.title), told.lead && h("p", {}, told.lead)), told.walk, close),
    h("div", { class: "sheet-body" }, told.body.filter(Boolean)));
  tip.hide();
  if (!sheet.open) {
    returned = document.activeElement;
    document.body.classList.add("sheet-open");
    // where a click left the caret nothing can be selected now, and a browser would search all that is behind for another place
    getSelection().removeAllRanges();
    sheet.showModal();
  }
  sheet.scrollTop = 0;
  reachable(sheet);
  (sheet.querySelector(`[data-step="${stepped}"]`) ?? close).focus({ preventScroll: true });
}

/** What scrolls sideways can be scrolled by keys, too. */
function reachable(root = document) {
  for (const box of root.querySelectorAll(".scroll")) {
    const wider = box.scrollWidth > box.clientWidth + 1;
    for (const [name, value] of [["tabindex", "0"], ["role", "group"], ["aria-label", "scrolls sideways"]]) {
      if (wider) box.setAttribute(name, value);
      else box.removeAttribute(name);
    }
  }
}

function closed() {
  const followed = left;
  left = false;
  if (document.getElementById("sheet").open) return;
  document.body.classList.remove("sheet-open");
  if (!followed && SHEETS.test(location.hash)) history.pushState(null, "", "#");
  const target = document.getElementById(location.hash.slice(1));
  if (target) target.focus();
  else if (returned?.isConnected) returned.focus({ preventScroll: true });
}

function bar(sections) {
  const links = sections.map((section) => h("li", {}, h("a", { href: `#${section.id}` }, section.dataset.short ?? section.querySelector("h2").textContent)));
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = null;
  const button = h("button", { type: "button", onclick: () => { chosen = dark() ? "light" : "dark"; paint(); } });
  const dark = () => (chosen ? chosen === "dark" : system.matches);
  function paint() {
    document.documentElement.dataset.theme = dark() ? "dark" : "light";
    button.textContent = dark() ? "Light" : "Dark";
    button.setAttribute("aria-label", dark() ? "Switch to light colours" : "Switch to dark colours");
  }
  system.addEventListener("change", paint);
  paint();
  return h("div", {}, h("nav", { "aria-label": "Sections" }, h("ul", {}, links)), button);
}

/** On paper nothing is folded away. */
function unfold() {
  const opened_ = [];
  for (let shut; (shut = [...document.querySelectorAll("main details:not([open])")]).length; opened_.push(...shut)) shut.forEach((one) => { made(one); one.open = true; });
  addEventListener("afterprint", () => opened_.forEach((one) => { one.open = false; }), { once: true });
}

/** Mark in the bar which section is being read. */
function watch(sections) {
  const links = new Map([...document.querySelectorAll("#bar a")].map((link) => [link.getAttribute("href").slice(1), link]));
  const observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      links.forEach((link) => link.removeAttribute("aria-current"));
      links.get(target.id)?.setAttribute("aria-current", "true");
    }
  }, { rootMargin: "-20% 0px -70% 0px" });
  sections.forEach((section) => observer.observe(section));
}

function start() {
  document.title = `${DATA.study} \u00b7 ${DATA.campaign} \u00b7 scaloft-fi report`;
  const makers = [[killMatrix, "Kill matrix"], [unmutated, "Unmutated drone"], [breakingSituations, "Breaks"], [survivors, "Survivors"], [foundSituations, "Found"], [summary, "Figures"], [whatKillsWhat, "What kills what"], ...(OF_TESTS ? [] : [[ladders, "Magnitudes"]]), [claims, "Not claimed"], [onPaper, ""], [reading, "How to read"], [glossary, "Glossary"]];
  const head = masthead();
  const sections = makers.map(([make, short]) => {
    const section = make();
    if (section) section.dataset.short = short;
    return section;
  }).filter(Boolean);
  document.getElementById("main").replaceChildren(head, ...sections);
  const named_ = sections.filter((section) => section.dataset.short);
  document.getElementById("bar").replaceChildren(bar(named_));
  watch(named_);
  reachable();
  addEventListener("resize", () => reachable());
  document.getElementById("sheet").addEventListener("close", closed);
  addEventListener("beforeprint", unfold);
  addEventListener("hashchange", follow);
  follow();
  drawOnPaper();
}

start();
