/* Time in a flight: a slider, buttons that jump to what happened, and one that plays it. */
/** Seconds of flight in a second. */
const FASTER = 8;

/** `happened` are marks; `move(time)` shows a moment.  Who asks for less motion gets no play button. */
function player(end, happened, start, move) {
  const told = h("output", {});
  const slider = h("input", { type: "range", min: 0, max: end, step: 0.1, value: 0, "aria-label": "time in the flight" });
  const play = h("button", { type: "button", class: "play", onclick: () => (last === null ? begin() : stop()) });
  let now = 0;
  let last = null;
  let touched = false;
  function show(time) {
    now = Math.max(0, Math.min(end, time));
    slider.value = now;
    slider.setAttribute("aria-valuetext", seconds(now));
    told.textContent = seconds(now);
    move(now);
  }
  function stop() {
    last = null;
    play.replaceChildren(h("span", { "aria-hidden": "true" }, "\u25b6 "), "Play");
  }
  function begin() {
    if (!touched || now >= end) show(0);
    touched = true;
    last = performance.now();
    play.replaceChildren(h("span", { "aria-hidden": "true" }, "\u2016 "), "Pause");
    requestAnimationFrame(frame);
  }
  function frame(moment) {
    if (last === null) return;
    if (!play.isConnected || !play.closest("dialog[open]")) { stop(); return; }
    show(now + (FASTER * Math.max(0, moment - last)) / 1000);
    last = moment;
    if (now >= end) stop();
    else requestAnimationFrame(frame);
  }
  const go_ = (time) => { touched = true; stop(); show(time); };
  slider.addEventListener("input", () => go_(Number(slider.value)));
  stop();
  show(start);
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const jumps = happened.map(({ kind, t, text }) => h("button", { type: "button", onclick: () => go_(t) }, signOf(kind), `${text}, ${seconds(t)}`));
  const node = h("div", { class: "player" },
    h("div", { class: "time" }, !still && play, h("span", {}, "time"), slider, told),
    jumps.length > 0 && h("div", { class: "row jumps", role: "group", "aria-label": "Jump to what happened" }, h("span", { class: "name" }, "jump to"), jumps));
  return { node, go: go_ };
}
