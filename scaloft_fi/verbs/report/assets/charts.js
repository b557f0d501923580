/* Axes, bars and lines, as SVG. */
const scale = (from, to, start, end) => (value) => start + ((value - from) / (to - from || 1)) * (end - start);

/** Round numbers that divide a range into about so many steps. */
function ticks(from, to, about = 5) {
  const raw = (to - from || 1) / about;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw * 0.999);
  const found = [];
  for (let value = Math.ceil(from / step - 1e-9) * step; value <= to + step * 1e-9; value += step) found.push(Number(value.toFixed(9)));
  return found;
}

const pathOf = (points) => {
  let text = "";
  let pen = false;
  for (const point of points) {
    if (!point) { pen = false; continue; }
    text += `${pen ? "L" : "M"}${point[0].toFixed(1)},${point[1].toFixed(1)}`;
    pen = true;
  }
  return text;
};

/** A share as a bar on a rail from 0 to 100 %. */
function meter(ratio, name) {
  return s("svg", { class: "meter", viewBox: "0 0 144 12", role: "img", "aria-label": `${name}: ${ratioText(ratio)}` },
    s("rect", { class: "rail", x: 0.5, y: 1.5, width: 143, height: 9 }),
    share(ratio) !== null && s("rect", { class: "filled", x: 0.5, y: 1.5, width: 143 * share(ratio), height: 9 }));
}

/** Pictures are drawn for the width of the screen, so that their letters stay readable. */
const WIDE = innerWidth < 640 ? 370 : 560;

/** A frame with axes; gives the scales and the node to draw in. */
function plot({ width = WIDE, height = 220, x, y, left = 46, right = 12, top = 12, bottom = 34, label, xTicks = null, yTicks = null, xText = trimmed, yText = trimmed, xTitle = "", yTitle = "" }) {
  const sx = scale(x[0], x[1], left, width - right);
  const sy = scale(y[0], y[1], height - bottom, top);
  const root = s("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label, class: "plot" });
  root.append(
    s("g", { class: "axis" },
      (yTicks ?? ticks(y[0], y[1], 4)).map((value) => [
        s("line", { class: "grid-line", x1: left, x2: width - right, y1: sy(value), y2: sy(value) }),
        s("text", { x: left - 6, y: sy(value) + 4, "text-anchor": "end" }, yText(value)),
      ]),
      (xTicks ?? ticks(x[0], x[1], 7)).map((value) => [
        s("line", { x1: sx(value), x2: sx(value), y1: height - bottom, y2: height - bottom + 4 }),
        s("text", { x: sx(value), y: height - bottom + 16, "text-anchor": "middle" }, xText(value)),
      ]),
      s("line", { x1: left, x2: width - right, y1: height - bottom, y2: height - bottom }),
      xTitle && s("text", { x: (left + width - right) / 2, y: height - 3, "text-anchor": "middle" }, xTitle),
      yTitle && s("text", { x: 2, y: top - 20 }, yTitle)));
  return { root, sx, sy, width, height, left, right, top, bottom };
}
