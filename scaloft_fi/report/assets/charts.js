/* Axes, whiskers and lines, as SVG. */
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

/** A share with its interval on a rail from 0 to 100 %. */
function whisker(ratio, name) {
  const x = scale(0, 1, 4, 140);
  const value = share(ratio);
  return s("svg", { class: "whisker", viewBox: "0 0 144 18", role: "img", "aria-label": `${name}: ${ratioText(ratio)} ${intervalText(ratio)}` },
    s("line", { class: "rail", x1: x(0), x2: x(1), y1: 9, y2: 9 }),
    [0, 0.5, 1].map((at) => s("line", { class: "rail", x1: x(at), x2: x(at), y1: 6, y2: 12 })),
    ratio.interval && s("line", { class: "span", x1: x(ratio.interval[0]), x2: x(ratio.interval[1]), y1: 9, y2: 9 }),
    value !== null && s("circle", { class: "dot", cx: x(value), cy: 9, r: 4 }));
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
