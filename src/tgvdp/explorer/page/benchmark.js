// A benchmark of formulations: how often solvers succeed, and how large the problems are, against the size N.

import { Chart, around } from "./chart.js";
import { el, table } from "./dom.js";
import * as state from "./state.js";
import { counted } from "./units.js";

const LOOKS = [["front", []], ["traction", [7, 3]], ["coasting", [2, 3]], ["neutral", [9, 3, 2, 3]], ["cruising", [4, 2]], ["curves", [1, 2]], ["ink", [12, 4]]];
const SHAPES = ["circle", "square", "diamond", "star"];

export class Benchmark {
  constructor(id, view) {
    this.id = id;
    this.tables = view.tables;
    const families = byRows(this.tables["ensembles.csv"].map((row) => row.family));
    this.family = el("select", { id: "family", onChange: () => state.set({ family: this.family.value }) }, families.map((name) => el("option", { value: name }, name)));
    this.success = new Chart({ label: "Success of an attempt against the size N, by solver", xLabel: "Size N", yLabel: "Success (median)", height: 320, wholeX: true });
    this.size = new Chart({ label: "Variables and qubits against the size N, by encoding", xLabel: "Size N", yLabel: "Variables, qubits", height: 320, wholeX: true, ySplits: decades, yText: (value) => String(Math.round(10 ** value)) });
    this.successKey = el("p", { class: "legend" });
    this.sizeKey = el("p", { class: "legend" });
    this.rows = el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Medians" });
    this.element = el("div", { class: "search benchmark" },
      el("div", { class: "column" }, el("section", { class: "card" }, el("h2", {}, "How often does an attempt succeed?"), el("label", { class: "row" }, "Family", this.family), this.success.element, this.successKey)),
      el("div", { class: "column" }, el("section", { class: "card" }, el("h2", {}, "How large are the problems?"), this.size.element, this.sizeKey), el("section", { class: "card" }, el("h2", {}, "Medians"), this.rows)));
    this.families = families;
  }

  async show() {
    const family = this.families.includes(state.get("family")) ? state.get("family") : this.families[0];
    if (family) this.family.value = family;
    const own = this.tables["ensembles.csv"].filter((row) => row.family === family && row["p median"] !== null);
    draw(this.success, this.successKey, grouped(own, (row) => row.solver, (row) => row["p median"]), [-0.03, 1.05]);
    const sized = this.tables["benchmark.csv"].filter((row) => row.encoding && row["# Decision Variables"]);
    const laid = this.tables["embeddings.csv"].filter((row) => row.qubits);
    const groups = { ...grouped(sized, (row) => `variables, ${row.encoding}`, (row) => Math.log10(row["# Decision Variables"])), ...grouped(laid, (row) => `qubits on ${row.topology}, ${row.encoding}`, (row) => Math.log10(row.qubits)) };
    this.size.element.parentElement.hidden = !Object.keys(groups).length;
    draw(this.size, this.sizeKey, groups);
    const heads = ["Solver", "N", "Instances", "Solved", "Success", "Time to 99 % (s)"];
    this.rows.replaceChildren(table(`Medians over the instances of ${family ?? "no family"}`, heads, own.map((row) => [row.solver, ...["N", "instances", "solved", "p median", "TTS99 s"].map((name) => counted(row[name], 3))])));
  }

  remove() {
    this.success.remove();
    this.size.remove();
  }
}

/** Names, the one of most rows first. */
function byRows(names) {
  const rows = (name) => names.filter((other) => other === name).length;
  return [...new Set(names)].sort((a, b) => rows(b) - rows(a));
}

/** Logarithms of 1, 2, 5, 10, … in a range of them; over many decades those of powers of ten alone. */
export function decades(low, high) {
  const factors = high - low > 3 ? [1] : [1, 2, 5], found = [];
  for (let power = Math.floor(low); power <= high; power += 1) found.push(...factors.map((factor) => power + Math.log10(factor)));
  return found.filter((value) => value >= low && value <= high);
}

/** Medians of a value at each N, by group: { name: { x, y } }. */
export function grouped(rows, nameOf, valueOf) {
  const found = {};
  for (const row of rows) ((found[nameOf(row)] ??= {})[row.N] ??= []).push(valueOf(row));
  return Object.fromEntries(Object.entries(found).map(([name, byN]) => {
    const x = Object.keys(byN).map(Number).sort((a, b) => a - b);
    return [name, { x, y: x.map((n) => median(byN[n])) }];
  }));
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

function draw(chart, key, groups, yRange) {
  const names = Object.keys(groups);
  const layers = names.flatMap((name, i) => {
    const [color, dash] = LOOKS[i % LOOKS.length];
    return [{ kind: "line", ...groups[name], color, dash }, { kind: "points", ...groups[name], color, shape: SHAPES[i % SHAPES.length] }];
  });
  const x = names.flatMap((name) => groups[name].x), y = names.flatMap((name) => groups[name].y);
  chart.show({ layers, x: [...new Set(x)].sort((a, b) => a - b), xRange: around(x, 0.06), yRange: yRange ?? around(y, 0.08) });
  key.replaceChildren(...names.map((name, i) => el("span", { class: "key" }, el("i", { class: "swatch", "data-role": LOOKS[i % LOOKS.length][0] }), name)));
}
