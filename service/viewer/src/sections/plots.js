// Curves against time, with the time that is shown as a line, windows as shades, bands of 1 sigma, and the
// same curves of a reference, dashed.

import uPlot from "uplot";
import { colour, make } from "../dom.js";
import { figure, unitFor } from "../numbers.js";
import { curvesOf } from "./curves.js";
import { fileName, linkTo } from "./saving.js";

const HEIGHT = 220;
const FONT = "11px system-ui, sans-serif";
const DASH = [5, 4];

export class Plots {
  /** `onPick` is told a time, s; `onRemove` a column that is not wanted any more. */
  constructor(element, onPick, onRemove) {
    Object.assign(this, { element, onPick, onRemove, panels: [], windows: [] });
    new ResizeObserver(() => this.#resize()).observe(element);
  }

  /** A scene with the quantities chosen, and the scene that it is compared with, or null. */
  show(shown, chosen, reference) {
    Object.assign(this, { course: shown.course, curves: curvesOf(shown, chosen) });
    this.reference = reference && { course: reference.course, curves: curvesOf(reference, chosen) };
    this.build();
  }

  /** Intervals that are shaded: [{start_s, stop_s}]. */
  shade(windows) {
    this.windows = windows;
    for (const { plot } of this.panels) plot.redraw(false, false);
  }

  build() {
    if (!this.course) return;
    for (const panel of this.panels) panel.plot.destroy();
    this.element.replaceChildren();
    this.unit = unitFor(this.course.span);
    this.panels = this.curves.map((curve) => this.#panel(curve)).filter(Boolean);
    if (this.time !== undefined) this.at(this.time);
  }

  at(time) {
    this.time = time;
    if (!this.course) return;
    const i = this.course.index(time);
    for (const panel of this.panels) {
      read(panel, i);
      this.#placePlayhead(panel);
    }
  }

  #panel(curve) {
    const bar = make("div", { class: "panel-bar" });
    if (curve.column) bar.append(pressed("Remove", `Remove ${curve.title}`, () => this.onRemove(curve.column)));
    const values = curve.series.map(() => make("span", { class: "value" }));
    const title = make("figcaption", {}, make("span", {}, curve.title), make("span", { class: "keys" }, ...keys(curve, values)));
    if (curve.refused) {
      this.element.append(make("figure", { class: "panel" }, title, make("p", { class: "refused" }, curve.refused), bar));
      return null;
    }
    const holder = make("div", { class: "plot", role: "img", "aria-label": spoken(curve) });
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
    const said = make("span", { class: "hint", role: "status" });
    bar.prepend(
      pressed("Picture", `Save a picture of ${curve.title}`, () => savePicture(panel.plot, curve.title, said)),
      pressed("Data", `Save the data of ${curve.title}`, () => saveData(this.course, curve, said)),
      said,
    );
  }

  /** A column of times, of each line, of both edges of each band; those of the reference at its own times. */
  #data(curve, other) {
    const inUnit = (course) => Array.from(course.t, (t) => t / this.unit.seconds);
    const table = [inUnit(this.course), ...curve.series.map(({ data }) => data), ...banded(curve).flatMap(edges)];
    if (!other?.series.length) return table;
    return uPlot.join([table, [inUnit(this.reference.course), ...other.series.map(({ data }) => data)]]);
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
      scales: { x: { time: false }, y: { range: (_, low, high) => roomy(low, high, curve.least) } },
      axes: [
        { ...axis, size: 24, gap: 4, label: `time, ${this.unit.name}`, labelFont: FONT, labelSize: 18, labelGap: 0 },
        { ...axis, size: 78, gap: 5, values: (_, ticks) => ticks.map((tick) => figure(tick, 6)) },
      ],
      series: this.#lines(curve, other),
      bands: bandsOf(curve),
      hooks: {
        drawClear: [(plot) => this.#shades(plot)],
        setScale: [() => panel.plot && this.#placePlayhead(panel)],
        // the figures of every plot are those under the pointer, wherever it is; else those of the time shown
        setCursor: [(plot) => read(panel, this.course.index(this.#pointed(plot) ?? this.time ?? this.course.start))],
      },
    };
  }

  #lines(curve, other) {
    const points = { show: this.course.length === 1 };
    const line = ({ name, paint }, more) => ({ label: name, stroke: colour(paint), width: 1.4, points, spanGaps: true, ...more });
    const edge = { width: 0, stroke: "transparent", points: { show: false }, spanGaps: true };
    return [
      {},
      ...curve.series.map((each) => line(each)),
      ...banded(curve).flatMap(() => [edge, edge]),
      ...(other?.series ?? []).map((each) => line(each, { width: 1, dash: DASH, alpha: 0.75 })),
    ];
  }

  #pointed(plot) {
    const { idx } = plot.cursor;
    return idx === null || idx === undefined ? null : plot.data[0][idx] * this.unit.seconds;
  }

  #placePlayhead({ plot, playhead }) {
    const x = plot.valToPos((this.time ?? this.course.start) / this.unit.seconds, "x");
    playhead.hidden = !(x >= 0 && x <= plot.over.clientWidth);
    playhead.style.transform = `translateX(${x.toFixed(1)}px)`;
  }

  /** Behind the curves: the windows, as dark as the share of the time they hold; on top a bar of each, seen however narrow. */
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

const banded = (curve) => curve.series.filter(({ sigma }) => sigma);

function edges({ data, sigma }) {
  return [1, -1].map((sign) => Array.from(data, (value, i) => value + sign * sigma[i]));
}

/** The edges of the bands come after the lines, two for each. */
function bandsOf(curve) {
  const first = 1 + curve.series.length;
  return banded(curve).map(({ paint }, k) => ({
    series: [first + 2 * k, first + 2 * k + 1],
    fill: `color-mix(in srgb, ${colour(paint)} 20%, transparent)`,
  }));
}

function keys(curve, values) {
  return curve.series.map((each, k) => {
    const key = make("span", { class: "key" }, make("i"), each.name, " ", values[k]);
    key.firstChild.style.background = colour(each.paint);
    return key;
  });
}

/** The figures of one sample, beside the names of a panel's lines. */
function read({ values, series }, i) {
  values.forEach((value, k) => {
    const { data, sigma } = series[k];
    value.textContent = figure(data[i], 5) + (sigma ? ` ± ${figure(sigma[i], 2)}` : "");
  });
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

/** What is drawn, as CSV: seconds since the epoch, every line, and 1 sigma of those that have one. */
function saveData(course, { title, series }, said) {
  const name = (each) => each.name.replaceAll(" ", "_") || "value";
  const withSigma = series.filter(({ sigma }) => sigma);
  const names = ["elapsed_s", ...series.map(name), ...withSigma.map((each) => `${name(each)}_sigma`)];
  const columns = [course.t, ...series.map(({ data }) => data), ...withSigma.map(({ sigma }) => sigma)];
  const rows = Array.from(course.t, (_, i) => columns.map((column) => column[i]).join(","));
  const text = [names.join(","), ...rows, ""].join("\n");
  save(new Blob([text], { type: "text/csv" }), `${fileName(title)}.csv`, said);
}

/** A little room above and below; of what never changes, a width that can be drawn. */
function roomy(low, high, least = 0) {
  if (Math.max(-low, high) < least) return [low < 0 ? -least : -0.1 * least, least];
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
