// Attitude, rate, energy and momentum against time, with the time that is shown as a line.

import uPlot from "uplot";
import { colour, make } from "./dom.js";
import { figure, unitFor } from "./numbers.js";
import { norm } from "./rotation.js";
import { fileName, linkTo } from "./saving.js";

const HEIGHT = 220;
const FONT = "11px system-ui, sans-serif";

export class Plots {
  constructor(element, onPick) {
    this.element = element;
    this.onPick = onPick;
    this.panels = [];
    new ResizeObserver(() => this.#resize()).observe(element);
  }

  /** A course, and curves that were chosen besides. */
  show(course, chosen = []) {
    [this.course, this.chosen] = [course, chosen];
    this.build();
  }

  build() {
    if (!this.course) return;
    for (const panel of this.panels) panel.plot.destroy();
    this.element.replaceChildren();
    this.unit = unitFor(this.course.span);
    const x = this.course.t.map((t) => t / this.unit.seconds);
    this.panels = [...curves(this.course), ...this.chosen].map((curve) => this.#panel(curve, x)).filter(Boolean);
    if (this.time !== undefined) this.at(this.time);
  }

  at(time) {
    this.time = time;
    if (!this.course) return;
    const i = this.course.index(time);
    for (const panel of this.panels) {
      read(panel, i);
      panel.plot.redraw(false, false);
    }
  }

  #panel(curve, x) {
    const values = curve.series.map(() => make("span", { class: "value" }));
    const keys = curve.series.map((each, k) => {
      const key = make("span", { class: "key" }, make("i"), each.name, " ", values[k]);
      key.firstChild.style.background = colour(each.paint);
      return key;
    });
    const title = make("figcaption", {}, make("span", {}, curve.title), make("span", { class: "keys" }, ...keys));
    const bar = make("div", { class: "panel-bar" });
    if (curve.remove) bar.append(pressed("Remove", `Remove ${curve.title}`, curve.remove));
    if (curve.refused) {
      this.element.append(make("figure", { class: "panel" }, title, make("p", { class: "refused" }, curve.refused), bar));
      return null;
    }
    const holder = make("div", { class: "plot", role: "img", "aria-label": spoken(curve) });
    this.element.append(make("figure", { class: "panel" }, title, holder, bar));
    const panel = { holder, values, series: curve.series };
    const data = [x, ...curve.series.map((each) => each.data)];
    panel.plot = new uPlot(this.#options(curve, holder.clientWidth, panel), data, holder);
    holder.addEventListener("click", () => this.#pick(panel.plot));
    const said = make("span", { class: "hint", role: "status" });
    bar.prepend(
      pressed("Picture", `Save a picture of ${curve.title}`, () => savePicture(panel.plot, curve.title, said)),
      pressed("Data", `Save the data of ${curve.title}`, () => saveData(this.course, curve, said)),
      said,
    );
    return panel;
  }

  #options(curve, width, panel) {
    const [ink, hair] = [colour("--muted"), colour("--grid")];
    const axis = { stroke: ink, font: FONT, grid: { stroke: hair, width: 1 }, ticks: { stroke: hair, width: 1, size: 4 } };
    const dots = { show: this.course.length === 1 };
    return {
      width,
      height: HEIGHT,
      padding: [10, 12, 0, 0],
      legend: { show: false },
      cursor: { sync: { key: "time" }, points: { size: 6 }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: (_, low, high) => spread(low, high) } },
      axes: [
        { ...axis, size: 24, gap: 4, label: `time, ${this.unit.name}`, labelFont: FONT, labelSize: 18, labelGap: 0 },
        { ...axis, size: 78, gap: 5, values: (_, ticks) => ticks.map((tick) => figure(tick, 6)) },
      ],
      series: [{}, ...curve.series.map((each) => ({ label: each.name, stroke: colour(each.paint), width: 1.4, points: dots }))],
      hooks: {
        draw: [(plot) => this.#playhead(plot)],
        // the figures of every plot are those under the pointer, wherever it is; else those of the time shown
        setCursor: [({ cursor: { idx } }) => read(panel, idx ?? this.course.index(this.time ?? this.course.start))],
      },
    };
  }

  #playhead(plot) {
    if (this.time === undefined) return;
    const x = Math.round(plot.valToPos(this.time / this.unit.seconds, "x", true)) + 0.5;
    const { left, top, width, height } = plot.bbox;
    if (x < left - 1 || x > left + width + 1) return;
    const { ctx } = plot;
    ctx.save();
    ctx.strokeStyle = colour("--ink");
    ctx.lineWidth = window.devicePixelRatio;
    ctx.globalAlpha = 0.6;
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(x, top + height);
    ctx.stroke();
    ctx.restore();
  }

  #pick(plot) {
    if (plot.cursor.left >= 0) this.onPick(plot.posToVal(plot.cursor.left, "x") * this.unit.seconds);
  }

  #resize() {
    for (const { plot, holder } of this.panels) {
      if (holder.clientWidth !== plot.width) plot.setSize({ width: holder.clientWidth, height: HEIGHT });
    }
  }
}

const PAINTS = ["--x", "--y", "--z"];

function curves(course) {
  const vector = (names, columns) => names.map((name, i) => ({ name, data: columns[i], paint: PAINTS[i] }));
  const [w, ...xyz] = course.q;
  const motion = [
    { title: "Quaternion, body to inertial", series: [{ name: "w", data: w, paint: "--ink" }, ...vector(["x", "y", "z"], xyz)] },
    { title: "Body rate, rad/s", series: vector(["ωx", "ωy", "ωz"], course.omega) },
  ];
  if (!course.bodyKnown) return motion;
  const [energy, momentum] = [energyChange(course), momentumChange(course)];
  return [
    ...motion,
    { title: energy.title, series: [{ name: "", data: energy.data, paint: "--rate" }] },
    { title: momentum.title, series: [{ name: "", data: momentum.data, paint: "--momentum" }] },
  ];
}

/** Against the start; a body that starts at rest has nothing to be relative to. */
function energyChange(course) {
  const first = course.energy[0];
  return first > 0
    ? { title: "Energy, change relative to the start", data: course.energy.map((energy) => energy / first - 1) }
    : { title: "Energy, J", data: course.energy };
}

function momentumChange(course) {
  const first = course.momentumAt(0);
  const size = norm(first) || 1;
  const title = norm(first) ? "Momentum, |L − L₀| / |L₀|, inertial" : "Momentum, |L|, N m s";
  const change = (_, i) => norm(course.momentumAt(i).map((x, k) => x - first[k])) / size;
  return { title, data: course.t.map(change) };
}

/** The figures of one sample, beside the names of a panel's lines. */
function read({ values, series }, i) {
  values.forEach((value, k) => (value.textContent = figure(series[k].data[i], 5)));
}

function pressed(text, label, act) {
  const button = make("button", { type: "button", class: "quiet", "aria-label": label }, text);
  button.addEventListener("click", act);
  return button;
}

function save(blob, name, said) {
  const link = linkTo(blob, name);
  said.replaceChildren(link);
  link.click();
}

/** The plot on the page's ground, with its title. */
function savePicture(plot, title, said) {
  const { canvas } = plot.ctx;
  const scale = window.devicePixelRatio;
  const picture = make("canvas", { width: canvas.width, height: canvas.height + 24 * scale });
  const context = picture.getContext("2d");
  context.fillStyle = colour("--panel");
  context.fillRect(0, 0, picture.width, picture.height);
  context.fillStyle = colour("--ink");
  context.font = `${12 * scale}px system-ui, sans-serif`;
  context.fillText(title, 8 * scale, 16 * scale);
  context.drawImage(canvas, 0, 24 * scale);
  picture.toBlob((blob) => save(blob, `${fileName(title)}.png`, said));
}

/** What is drawn, as CSV: seconds since the epoch, and every line. */
function saveData(course, { title, series }, said) {
  const names = ["elapsed_s", ...series.map(({ name }) => name.replaceAll(" ", "_") || "value")];
  const rows = Array.from(course.t, (t, i) => [t, ...series.map(({ data }) => data[i])].join(","));
  const text = [names.join(","), ...rows, ""].join("\n");
  save(new Blob([text], { type: "text/csv" }), `${fileName(title)}.csv`, said);
}

/** A little room above and below; of what never changes, a width that can be drawn. */
function spread(low, high) {
  const room = 0.08 * (high - low) || Math.max(1e-16, Math.abs(high) * 0.1);
  return [low - room, high + room];
}

function spoken({ title, series }) {
  const ranges = series.map(({ name, data }) => {
    const [low, high] = data.reduce(([a, b], x) => [Math.min(a, x), Math.max(b, x)], [Infinity, -Infinity]);
    return `${name} from ${figure(low)} to ${figure(high)}`.trim();
  });
  return `${title}: ${ranges.join(", ")}`;
}
