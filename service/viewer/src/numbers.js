// Numbers and durations as text.

const UNITS = [
  [86400, "d"],
  [3600, "h"],
  [60, "min"],
  [1, "s"],
  [1e-3, "ms"],
  [1e-6, "µs"],
];

/** A number with so many significant digits, a minus sign U+2212, and powers of ten where needed. */
export function figure(value, digits = 4) {
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return minus(String(Number(value.toPrecision(digits))));
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  return minus(`${Number(mantissa)} × 10${raised(Number(exponent))}`);
}

const minus = (text) => text.replace("-", "−");

/** The exponent of a power of ten. */
export function raised(exponent) {
  return [...String(exponent)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
}

/** The greatest unit of time that fits a span at least twice. */
export function unitFor(span) {
  const [seconds, name] = UNITS.find(([size]) => span >= 2 * size) ?? (span > 0 ? UNITS[5] : UNITS[3]);
  return { seconds, name };
}

export function duration(seconds, digits = 4) {
  const unit = unitFor(Math.abs(seconds));
  return `${figure(seconds / unit.seconds, digits)} ${unit.name}`;
}

/** The number of decimals that resolve a thousandth of a span. */
export function decimals(span, unit) {
  return Math.min(9, Math.max(0, 3 - Math.floor(Math.log10(Math.max(span / unit.seconds, 1e-6)))));
}

export const degrees = (radians, digits = 4) => `${figure((radians * 180) / Math.PI, digits)}°`;
export const words = (name) => name.replaceAll("_", " ");
