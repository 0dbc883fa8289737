// Two pinned runs side by side: how much they differ, and where.

import { at } from "./course.js";
import { el, table } from "./dom.js";
import { JOULE_PER_KWH, clock, delayText, energyScale, fixed, significant, signedText } from "./units.js";

const PLACES = 400;

/** Time (s) and energy (J) of pin B less those of pin A over distance; no energy where they count different ones. */
export function differences({ course: a, counts }, { course: b, counts: other }) {
  const [first, last] = [a.x[0], a.x[a.x.length - 1]];
  const x = Array.from({ length: PLACES + 1 }, (_, i) => first + ((last - first) * i) / PLACES);
  const apart = (column) => { const own = at(a, column, x); return at(b, column, x).map((value, i) => value - own[i]); };
  return { x, time_s: apart("t"), energy_j: counts === other ? apart("E") : null };
}

/** The shortest stretch on which half of a difference arises: [from, to] by index; null where there is none. */
export function halfOf(values) {
  const whole = values[values.length - 1];
  if (!whole) return null;
  let best = null;
  let to = 0;
  for (let from = 0; from < values.length; from += 1) {
    while (to < values.length && (values[to] - values[from]) / whole < 0.5) to += 1;
    if (to === values.length) break;
    if (!best || to - from < best[1] - best[0]) best = [from, to];
  }
  return best;
}

/** A card with what two runs differ in. */
export function compareCard(pins, compared, distance) {
  const [a, b] = [pins.a, pins.b];
  const energy = energyScale(Math.max(Math.abs(a.energy_kwh), Math.abs(b.energy_kwh)) * JOULE_PER_KWH);
  const shown = (kwh) => kwh * JOULE_PER_KWH * energy.factor;
  const text = (kwh) => `${significant(shown(kwh))} ${energy.unit}`;
  const row = (name, of, comparable = true) => [name, text(of(a)), text(of(b)), comparable ? signedText(shown(of(b) - of(a)), 3, energy.unit) : "–"];
  const alike = a.counts === b.counts;
  const rows = [
    ["Running time", clock(a.time_s), clock(b.time_s), delayText(b.time_s - a.time_s)],
    row("Energy", (pin) => pin.energy_kwh, alike),
    ...(a.pantograph_kwh === null || b.pantograph_kwh === null ? [] : [row("At the pantograph", (pin) => pin.pantograph_kwh)]),
  ];
  const where = (values, what) => {
    const half = halfOf(values);
    if (!half) return null;
    const [from, to] = half.map((i) => fixed(compared.x[i] * distance.factor, 1));
    return el("p", {}, `Half of the difference in ${what} arises between ${from} and ${to} ${distance.unit}.`);
  };
  return el("section", { class: "card compare", id: "compare" },
    el("h2", {}, "A against B"),
    table("Run A, run B, and B less A", ["", `A: ${a.name}`, `B: ${b.name}`, "B − A"], rows),
    alike ? null : el("p", {}, `Their energies do not compare: A counts ${a.counts}, B ${b.counts}.`),
    compared ? [where(compared.time_s, "time"), compared.energy_j ? where(compared.energy_j, "energy") : null] : el("p", {}, "These runs are on different lines: where they differ cannot be said."));
}
