// The curves of a scene: attitude, rate, conserved quantities, and chosen columns. A curve is
// {title, series: [{name, data, paint, sigma}], minRange}; sigma is the half width of the 1 sigma band,
// `minRange` the least range of the vertical axis.

import { norm } from "../answers/rotation.js";

const COLOURS = ["--x", "--y", "--z", "--ink", "--rate"];
const DEGREES = 180 / Math.PI;
const ROUNDING = 1e-13; // relative changes below it are rounding of doubles

/** `chosen` are {column, title, sigma} of the quantities section. */
export function curvesOf({ ephemeris, columns }, chosen) {
  const [q, omega] = ephemeris.sigmas ?? [[], []];
  const [w, ...xyz] = ephemeris.q;
  const motion = [
    { title: "Quaternion, body to inertial", series: [{ name: "w", data: w, paint: "--ink", sigma: q[0] }, ...vector(["x", "y", "z"], xyz, q.slice(1))] },
    { title: "Body rate, rad/s", series: vector(["ωx", "ωy", "ωz"], ephemeris.omega, omega) },
  ];
  return [...motion, ...(ephemeris.bodyKnown ? conserved(ephemeris) : []), ...chosen.map((each) => chosenCurve(each, columns))];
}

const vector = (names, data, sigmas) => names.map((name, i) => ({ name, data: data[i], paint: COLOURS[i], sigma: sigmas[i] }));

function conserved(ephemeris) {
  const [energy, momentum] = [energyChange(ephemeris), momentumChange(ephemeris)];
  return [
    { ...energy, series: [{ name: "", data: energy.data, paint: "--rate" }] },
    { ...momentum, series: [{ name: "", data: momentum.data, paint: "--momentum" }] },
  ];
}

/** Relative to the start, unless the body is at rest then. */
function energyChange(ephemeris) {
  const first = ephemeris.energy[0];
  return first > 0
    ? { title: "Energy, change relative to the start", minRange: ROUNDING, data: ephemeris.energy.map((energy) => energy / first - 1) }
    : { title: "Energy, J", data: ephemeris.energy };
}

function momentumChange(ephemeris) {
  const first = ephemeris.momentumAt(0);
  const size = norm(first) || 1;
  const title = norm(first) ? "Momentum, |L − L₀| / |L₀|, inertial" : "Momentum, |L|, N m s";
  const change = (_, i) => norm(ephemeris.momentumAt(i).map((x, k) => x - first[k])) / size;
  return { title, minRange: norm(first) ? ROUNDING : 0, data: ephemeris.t.map(change) };
}

function chosenCurve({ column, title, sigmaColumn }, columns) {
  const values = columns[column];
  if (!values || values.refused) return { column, title, refused: values?.refused ?? "A file has no such columns.", series: [] };
  const sigma = sigmaColumn && columns[sigmaColumn]?.data?.[0];
  // sigma is in degrees; in radians it bounds that of the components of a unit vector
  const scaled = sigma && (values.labels[0].endsWith("deg") ? sigma : sigma.map((x) => x / DEGREES));
  const series = values.data.map((data, i) => ({ name: values.labels[i], data, paint: COLOURS[i % COLOURS.length], sigma: scaled }));
  return { column, title, series };
}
