// Accuracy against computing time, measured by the service; each family of methods is one line.

import * as api from "../answers/api.js";
import { byId, make, makeSvg } from "../dom.js";
import { duration, figure, raised } from "../numbers.js";
import { table } from "./plan.js";

const ABSENT = [404, 405, 501];
const SIZE = { width: 640, height: 380, left: 84, right: 30, top: 14, bottom: 50 };
const MIN_DRAWN_ERROR = 1e-17; // rad; smaller errors, also zero, are drawn here
const MARKS = ["circle", "square", "up", "diamond", "down", "plus", "cross"];
const COLOURS = 8; // colours in the style sheet

export function offerCost(documentText) {
  byId("measure").addEventListener("click", () => measure(documentText()));
}

export function forgetCost() {
  byId("cost").replaceChildren();
  setStatus("");
}

function setStatus(text, kind = "") {
  byId("cost-status").textContent = text;
  byId("cost-status").className = kind;
}

async function measure(text) {
  const button = byId("measure");
  button.disabled = true;
  const budget = byId("budget").value;
  setStatus(`Measuring, for about ${budget} s`);
  try {
    const report = await api.post(`v1/cost?budget=${encodeURIComponent(budget)}`, text);
    setStatus("");
    show(byId("cost"), report);
  } catch (error) {
    setStatus(ABSENT.includes(error.status) ? `This service does not measure cost: ${error.message}` : error.message, "bad");
  } finally {
    button.disabled = false;
  }
}

function show(element, report) {
  const horizon = bestHorizon(report);
  const cells = report.cells.filter((cell) => cell.horizon === horizon);
  const families = [...new Set(report.cells.map((cell) => cell.family))];
  const measured = cells.filter((cell) => cell.status === "measured");
  const missing = cells.filter((cell) => cell.status !== "measured");
  const title = `${report.samples.toLocaleString("en")} samples over ${figure(horizon)} × ${report.unit.name} (${duration(horizon * report.unit.s)})`;
  const lines = families.map((family, number) => ({
    family,
    number,
    points: measured.filter((cell) => cell.family === family).map((cell) => [cell.ns_per_sample, Math.max(cell.attitude_error_rad, MIN_DRAWN_ERROR)]),
  }));
  const drawn = lines.filter(({ points }) => points.length);
  element.replaceChildren(
    ...(drawn.length ? [picture(drawn, title), legend(drawn)] : [make("p", {}, "Nothing was measured.")]),
    make("p", { class: "hint" }, conditions(report, title)),
    table(["Method", "Attitude error, rad", "Energy", "Momentum", "ns a sample", "Set-up, s"], measured.map(row)),
    missing.length ? unmeasured(missing) : "",
  );
}

/** The horizon with the most measured cells (under torques: families); the longest of equals. */
function bestHorizon(report) {
  const count = (horizon) => {
    const cells = report.cells.filter((cell) => cell.horizon === horizon && cell.status === "measured");
    return report.effects ? new Set(cells.map((cell) => cell.family)).size : cells.length;
  };
  const horizons = [...new Set(report.cells.map((cell) => cell.horizon))].sort((a, b) => b - a);
  return horizons.reduce((best, each) => (count(each) > count(best) ? each : best));
}

const methodOf = (cell) => (cell.setting ? `${cell.family}, ${cell.setting}` : cell.family);

function unmeasured(cells) {
  const rows = cells.map((cell) => [methodOf(cell), reason(cell)]);
  return make("details", {}, make("summary", {}, `Not measured: ${cells.length}`), table(["Method", "Why"], rows));
}

function row(cell) {
  return [
    methodOf(cell),
    figure(cell.attitude_error_rad, 2),
    figure(cell.energy_error, 2),
    figure(cell.momentum_error, 2),
    figure(cell.ns_per_sample, 3),
    figure(cell.setup_s, 2),
  ];
}

function reason(cell) {
  if (cell.predicted_s !== null) return `${cell.status}: would take ${duration(cell.predicted_s, 2)}`;
  return cell.detail ? `${cell.status}: ${cell.detail}` : cell.status;
}

function conditions(report, title) {
  const { processor, cores } = report.machine;
  const truth = [...new Set(report.truth.map((each) => each.route))].join(" and ");
  return `${title}; against a truth by the ${truth} route; ${processor}, ${cores} cores; budget ${figure(report.budget_s)} s.`;
}

// -- the picture ----------------------------------------------------------------------------------

function picture(lines, title) {
  const x = scale(lines.flatMap(({ points }) => points.map((point) => point[0])), SIZE.left, SIZE.width - SIZE.right);
  const y = scale(lines.flatMap(({ points }) => points.map((point) => point[1])), SIZE.height - SIZE.bottom, SIZE.top);
  const names = lines.map(({ family }) => family).join(", ");
  return makeSvg(
    "svg",
    { viewBox: `0 0 ${SIZE.width} ${SIZE.height}`, class: "chart", role: "img", "aria-label": `Attitude error against time a sample, ${title}: ${names}; the figures are in the table` },
    ...ticks(x).map((power) => verticalGridline(power, x.of(10 ** power))),
    ...ticks(y).map((power) => horizontalGridline(power, y.of(10 ** power))),
    label("time, ns a sample", (SIZE.left + SIZE.width - SIZE.right) / 2, SIZE.height - 6),
    label("attitude error, rad", 13, (SIZE.top + SIZE.height - SIZE.bottom) / 2, true),
    ...lines.map((line) => drawnLine(line, x, y)),
  );
}

/** A logarithmic scale between powers of ten, with room for marks. */
function scale(values, from, to) {
  const low = Math.floor(Math.log10(Math.min(...values)) - 0.15);
  const high = Math.max(low + 1, Math.ceil(Math.log10(Math.max(...values)) + 0.15));
  return { low, high, of: (value) => from + ((Math.log10(value) - low) / (high - low)) * (to - from) };
}

function ticks({ low, high }) {
  const step = Math.max(1, Math.ceil((high - low) / 9));
  return Array.from({ length: Math.floor((high - low) / step) + 1 }, (_, k) => low + k * step);
}

const powerOfTen = (power) => `10${raised(power)}`;

function verticalGridline(power, x) {
  const bottom = SIZE.height - SIZE.bottom;
  return makeSvg("g", {}, makeSvg("line", { x1: x, x2: x, y1: SIZE.top, y2: bottom, class: "grid" }), label(powerOfTen(power), x, bottom + 20));
}

function horizontalGridline(power, y) {
  const text = makeSvg("text", { x: SIZE.left - 8, y: y + 4, "text-anchor": "end" }, powerOfTen(power));
  return makeSvg("g", {}, makeSvg("line", { x1: SIZE.left, x2: SIZE.width - SIZE.right, y1: y, y2: y, class: "grid" }), text);
}

function label(text, x, y, upright = false) {
  const transform = upright ? `rotate(-90 ${x} ${y})` : undefined;
  return makeSvg("text", { x, y, "text-anchor": "middle", transform }, text);
}

const styleOf = (number) => `kind-${number % COLOURS}${number === 0 ? " ours" : ""}`;

function drawnLine({ family, number, points }, x, y) {
  const places = points.map(([cost, error]) => [x.of(cost), y.of(error)]);
  const marks = places.map(([px, py], i) => {
    const text = `${family}: ${figure(points[i][0], 3)} ns, ${figure(points[i][1], 2)} rad`;
    return makeSvg("path", { d: mark(number, px, py, number === 0 ? 6 : 4.5) }, makeSvg("title", {}, text));
  });
  const path = makeSvg("polyline", { points: places.map((place) => place.join(",")).join(" ") });
  return makeSvg("g", { class: styleOf(number) }, path, ...marks);
}

function mark(number, x, y, r) {
  const shapes = {
    circle: `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`,
    square: `M${x - r} ${y - r}h${2 * r}v${2 * r}h${-2 * r}z`,
    up: `M${x} ${y - r}l${r} ${1.8 * r}h${-2 * r}z`,
    diamond: `M${x} ${y - 1.2 * r}l${r} ${1.2 * r}l${-r} ${1.2 * r}l${-r} ${-1.2 * r}z`,
    down: `M${x} ${y + r}l${r} ${-1.8 * r}h${-2 * r}z`,
    plus: `M${x - r} ${y - 1}h${r - 1}v${1 - r}h2v${r - 1}h${r - 1}v2h${1 - r}v${r - 1}h-2v${1 - r}h${1 - r}z`,
    cross: `M${x - r} ${y - r}l${2 * r} ${2 * r}M${x + r} ${y - r}l${-2 * r} ${2 * r}`,
  };
  return shapes[MARKS[number % MARKS.length]];
}

function legend(lines) {
  const items = lines.map(({ family, number }) => {
    const swatch = makeSvg("svg", { viewBox: "0 0 16 16", width: 16, height: 16, "aria-hidden": "true" }, makeSvg("g", { class: styleOf(number) }, makeSvg("path", { d: mark(number, 8, 8, 4.5) })));
    return make("li", {}, swatch, family);
  });
  return make("ul", { class: "chart-key" }, ...items);
}
