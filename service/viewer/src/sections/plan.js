// The plan as text and tables: which effects are simulated, which are not, and why.

import { make } from "../dom.js";
import { duration, figure } from "../numbers.js";

export function showPlan(element, plan) {
  const parts = [make("p", { class: "lead" }, lead(plan)), facts(plan)];
  if (plan.effects.length) parts.push(effects(plan.effects));
  else parts.push(make("p", {}, "The document lists no effects: the free motion is computed."));
  if (plan.considered.length) parts.push(considered(plan));
  element.replaceChildren(...parts);
}

function lead(plan) {
  const simulated = plan.effects.filter((effect) => effect.simulated).length;
  const left = plan.effects.length - simulated;
  const count = plan.effects.length ? ` ${simulated} of ${plan.effects.length} effects simulated${left ? `, ${left} left out` : ""}.` : "";
  return `${capital(plan.simulates)} by ${plan.solver}.${count}`;
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function facts(plan) {
  const rows = [
    ["Samples", plan.samples.toLocaleString("en")],
    ["Tolerance", `${figure(plan.tolerance_rad, 2)} rad`],
    ["Predicted error", `${figure(plan.predicted_error_rad, 2)} rad`],
    ["Predicted time", duration(plan.predicted_s, 2)],
  ];
  if (plan.step_s !== null) rows.push(["Step", duration(plan.step_s, 3)]);
  if (plan.order !== null) rows.push(["Order", String(plan.order)]);
  return make("dl", { class: "readouts" }, ...rows.map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, value))));
}

function effects(list) {
  const rows = list.map((effect) => [
    make("code", {}, effect.type),
    make("span", { class: effect.simulated ? "yes" : "no" }, effect.simulated ? "simulated" : "left out"),
    effect.acts_on,
    effect.reason,
    effect.torque_N_m === null ? "–" : figure(effect.torque_N_m, 3),
    effect.influence_rad === null ? "–" : figure(effect.influence_rad, 3),
  ]);
  return table(["Effect", "Simulated", "Acts on", "Why", "Torque, N m", "Matters by, rad"], rows);
}

function considered(plan) {
  const rows = plan.considered.map((each) => [
    each.solver,
    figure(each.setting, 3),
    figure(each.predicted_error_rad, 2),
    duration(each.predicted_s, 2),
  ]);
  const heads = ["Solver", "Step or tolerance", "Predicted error, rad", "Predicted time"];
  return make("details", {}, make("summary", {}, "Solvers considered"), table(heads, rows));
}

/** A table; the last cell of a short row spans the remaining columns. */
export function table(heads, rows) {
  const head = (content) => make("th", { scope: "col" }, content);
  const cell = (content, i, row) => {
    const rest = i === row.length - 1 && row.length < heads.length ? heads.length - i : null;
    return make("td", { colspan: rest }, content);
  };
  return make(
    "div",
    { class: "table", tabindex: 0, role: "region", "aria-label": heads.filter(Boolean).join(", ") },
    make(
      "table",
      {},
      make("thead", {}, make("tr", {}, ...heads.map(head))),
      make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map(cell)))),
    ),
  );
}
