// Curves against time, with the current time as a line, shaded windows, 1 sigma bands, and the curves of a
// reference scene, dashed.

import uPlot from "uplot";
import { colour, make } from "../dom.js";
import { figure, unitFor } from "../numbers.js";
import { curvesOf } from "./curves.js";
import { fileName, linkTo } from "./saving.js";

const HEIGHT = 220;
const FONT = "11px system-ui, sans-serif";
const DASH = [5, 4];

export class Plots {
  /** `onPick` is called with a time, s; `onRemove` with the column of a removed panel. */
  constructor(element, onPick, onRemove) {
    Object.assign(this, { element, onPick, onRemove, panels: [], windows: [] });
    new ResizeObserver(() => this.#resize()).observe(element);
  }

  /** Shows a scene with the chosen quantities, and the reference scene or null. */
  show(shown, chosen, reference) {
    Object.assign(this, { ephemeris: shown.ephemeris, curves: curvesOf(shown, chosen) });
    this.reference = reference && { ephemeris: reference.ephemeris, curves: curvesOf(reference, chosen) };
    this.build();
  }

  /** Shades intervals [{start_s, stop_s}]. */
  shade(windows) {
    this.windows = windows;
    for (const { plot } of this.panels) plot.redraw(false, false);
  }

  build() {
    if (!this.ephemeris) return;
    for (const panel of this.panels) panel.plot.destroy();
    this.element.replaceChildren();
    this.unit = unitFor(this.ephemeris.span);
    this.panels = this.curves.map((curve) => this.#panel(curve)).filter(Boolean);
    if (this.time !== undefined) this.at(this.time);
  }

  at(time) {
    this.time = time;
    if (!this.ephemeris) return;
    const i = this.ephemeris.index(time);
    for (const panel of this.panels) {
      showValues(panel, i);
      this.#placePlayhead(panel);
    }
  }

  #panel(curve) {
    const bar = make("div", { class: "panel-bar" });
    if (curve.column) bar.append(quietButton("Remove", `Remove ${curve.title}`, () => this.onRemove(curve.column)));
    const values = curve.series.map(() => make("span", { class: "value" }));
    const title = make("figcaption", {}, make("span", {}, curve.title), make("span", { class: "keys" }, ...legend(curve, values)));
    if (curve.refused) {
      this.element.append(make("figure", { class: "panel" }, title, make("p", { class: "refused" }, curve.refused), bar));
      return null;
    }
    const holder = make("div", { class: "plot", role: "img", "aria-label": description(curve) });
    this.element.append(make("figure", { class: "panel" }, title, holder, bar));
    const panel = { holder, values, series: curve.series, playhead: make("div", { class: "playhead" }) };
    const other = this.reference?.curves.find(({ title }) => title === curve.title);
    panel.plot = new uPlot(this.#options(curve, other, holder.clientWidth, panel), this.#data(curve, other), holder);
    panel.plot.over.append(panel.playhead);
    holder.addEventListener("click", () => this.#pick(panel.plot));
    this.#offerFiles(curve, panel, bar);
    return panel;
  }

  #offerFiles(curve, panel, bar) {
    const status = make("span", { class: "hint", role: "status" });
    bar.prepend(
      quietButton("Picture", `Save a picture of ${curve.title}`, () => savePicture(panel.plot, curve.title, status)),
      quietButton("Data", `Save the data of ${curve.title}`, () => saveData(this.ephemeris, curve, status)),
      status,
    );
  }

  /** Columns of uPlot: time, each line, both edges of each band; the reference joined at its own times. */
  #data(curve, other) {
    const inUnit = (ephemeris) => Array.from(ephemeris.t, (t) => t / this.unit.seconds);
    const table = [inUnit(this.ephemeris), ...curve.series.map(({ data }) => data), ...seriesWithSigma(curve).flatMap(edges)];
    if (!other?.series.length) return table;
    return uPlot.join([table, [inUnit(this.reference.ephemeris), ...other.series.map(({ data }) => data)]]);
  }

  #options(curve, other, width, panel) {
    const [ink, hair] = [colour("--muted"), colour("--grid")];
    const axis = { stroke: ink, font: FONT, grid: { stroke: hair, width: 1 }, ticks: { stroke: hair, width: 1, size: 4 } };
    return {
      width,
      height: HEIGHT,
      padding: [10, 12, 0, 0],
      legend: { show: false },
      cursor: { sync: { key: "time" }, points: { size: 6 }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: (_, low, high) => paddedRange(low, high, curve.minRange) } },
      axes: [
        { ...axis, size: 24, gap: 4, label: `time, ${this.unit.name}`, labelFont: FONT, labelSize: 18, labelGap: 0 },
        { ...axis, size: 78, gap: 5, values: (_, ticks) => ticks.map((tick) => figure(tick, 6)) },
      ],
      series: this.#lines(curve, other),
      bands: bandsOf(curve),
      hooks: {
        drawClear: [(plot) => this.#shades(plot)],
        setScale: [() => panel.plot && this.#placePlayhead(panel)],
        // all plots show the values under the pointer, or those at the current time
        setCursor: [(plot) => showValues(panel, this.ephemeris.index(this.#pointed(plot) ?? this.time ?? this.ephemeris.start))],
      },
    };
  }

  #lines(curve, other) {
    const points = { show: this.ephemeris.length === 1 };
    const line = ({ name, paint }, more) => ({ label: name, stroke: colour(paint), width: 1.4, points, spanGaps: true, ...more });
    const edge = { width: 0, stroke: "transparent", points: { show: false }, spanGaps: true };
    return [
      {},
      ...curve.series.map((each) => line(each)),
      ...seriesWithSigma(curve).flatMap(() => [edge, edge]),
      ...(other?.series ?? []).map((each) => line(each, { width: 1, dash: DASH, alpha: 0.75 })),
    ];
  }

  #pointed(plot) {
    const { idx } = plot.cursor;
    return idx === null || idx === undefined ? null : plot.data[0][idx] * this.unit.seconds;
  }

  #placePlayhead({ plot, playhead }) {
    const x = plot.valToPos((this.time ?? this.ephemeris.start) / this.unit.seconds, "x");
    playhead.hidden = !(x >= 0 && x <= plot.over.clientWidth);
    playhead.style.transform = `translateX(${x.toFixed(1)}px)`;
  }

  /** Draws the windows behind the curves, and above the plot a bar for each, at least one pixel wide. */
  #shades(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.fillStyle = colour("--window");
    for (const { start_s: start, stop_s: stop } of this.windows) {
      const ends = [start, stop].map((t) => plot.valToPos(t / this.unit.seconds, "x", true));
      const [from, to] = ends.map((x) => Math.max(bbox.left, Math.min(bbox.left + bbox.width, x)));
      if (ends[1] < bbox.left || ends[0] > bbox.left + bbox.width) continue;
      ctx.globalAlpha = 0.3;
      ctx.fillRect(from, bbox.top, to - from, bbox.height);
      ctx.globalAlpha = 1;
      ctx.fillRect(from, bbox.top - 5 * window.devicePixelRatio, Math.max(window.devicePixelRatio, to - from), 4 * window.devicePixelRatio);
    }
    ctx.restore();
  }

  #pick(plot) {
    if (plot.cursor.left >= 0) this.onPick(plot.posToVal(plot.cursor.left, "x") * this.unit.seconds);
  }

  #resize() {
    for (const { plot, holder } of this.panels) {
      if (holder.clientWidth && holder.clientWidth !== plot.width) plot.setSize({ width: holder.clientWidth, height: HEIGHT });
    }
  }
}

const seriesWithSigma = (curve) => curve.series.filter(({ sigma }) => sigma);

function edges({ data, sigma }) {
  return [1, -1].map((sign) => Array.from(data, (value, i) => value + sign * sigma[i]));
}

/** The edges of the bands come after the lines, two for each. */
function bandsOf(curve) {
  const first = 1 + curve.series.length;
  return seriesWithSigma(curve).map(({ paint }, k) => ({
    series: [first + 2 * k, first + 2 * k + 1],
    fill: `color-mix(in srgb, ${colour(paint)} 20%, transparent)`,
  }));
}

function legend(curve, values) {
  return curve.series.map((each, k) => {
    const key = make("span", { class: "key" }, make("i"), each.name, " ", values[k]);
    key.firstChild.style.background = colour(each.paint);
    return key;
  });
}

/** Writes the values of one sample beside the names of a panel's lines. */
function showValues({ values, series }, i) {
  values.forEach((value, k) => {
    const { data, sigma } = series[k];
    value.textContent = figure(data[i], 5) + (sigma ? ` ± ${figure(sigma[i], 2)}` : "");
  });
}

function quietButton(text, label, act) {
  const button = make("button", { type: "button", class: "quiet", "aria-label": label }, text);
  button.addEventListener("click", act);
  return button;
}

function save(blob, name, status) {
  const link = linkTo(blob, name);
  status.replaceChildren(link);
  link.click();
}

/** Saves the plot with its title as PNG. */
function savePicture(plot, title, status) {
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
  picture.toBlob((blob) => save(blob, `${fileName(title)}.png`, status));
}

/** Saves the curve as CSV: seconds since the epoch, every line, and 1 sigma of lines that have one. */
function saveData(ephemeris, { title, series }, status) {
  const name = (each) => each.name.replaceAll(" ", "_") || "value";
  const withSigma = series.filter(({ sigma }) => sigma);
  const names = ["elapsed_s", ...series.map(name), ...withSigma.map((each) => `${name(each)}_sigma`)];
  const columns = [ephemeris.t, ...series.map(({ data }) => data), ...withSigma.map(({ sigma }) => sigma)];
  const rows = Array.from(ephemeris.t, (_, i) => columns.map((column) => column[i]).join(","));
  const text = [names.join(","), ...rows, ""].join("\n");
  save(new Blob([text], { type: "text/csv" }), `${fileName(title)}.csv`, status);
}

/** The range of an axis with a margin; of a constant, a range that is not empty. */
function paddedRange(low, high, minRange = 0) {
  if (Math.max(-low, high) < minRange) return [low < 0 ? -minRange : -0.1 * minRange, minRange];
  const room = 0.08 * (high - low) || Math.max(1e-16, Math.abs(high) * 0.1);
  return [low - room, high + room];
}

function description({ title, series }) {
  const ranges = series.map(({ name, data }) => {
    const [low, high] = data.reduce(([a, b], x) => [Math.min(a, x), Math.max(b, x)], [Infinity, -Infinity]);
    return `${name} from ${figure(low)} to ${figure(high)}`.trim();
  });
  return `${title}: ${ranges.join(", ")}`;
}
