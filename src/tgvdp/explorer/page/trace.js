// The best-first search as it grew: labels over distance and speed, step by step, with the queue beside them.

import { Chart } from "./chart.js";
import { el, table } from "./dom.js";
import { clock, distanceScale, energyScale, fixed, significant, speedScale } from "./units.js";

const STEPS_PER_S = 4;
/** Looks of what is pruned, by reason. */
const PRUNED = { delay: ["neutral", "star"], bound: ["cruising", "square"], dominance: ["curves", "diamond"] };
const BECAME = {
  expanded: "is expanded", path: "has reached the end: a path", "near copy": "has reached the end, too close to a path found", "no better": "is no better than a path found: dropped", displaced: "was displaced by a better label before: dropped",
};

export class Trace {
  constructor(trace) {
    this.trace = trace;
    this.at = 0;
    const { position_m, speed_mps } = trace.nodes;
    this.distance = distanceScale(Math.max(...position_m));
    this.speed = speedScale(Math.max(...speed_mps));
    this.x = position_m.map((value) => value * this.distance.factor);
    this.y = speed_mps.map((value) => value * this.speed.factor);
    this.energy = energyScale(Math.max(...trace.labels.energy_j.map(Math.abs)));
    this.chart = new Chart({ label: "The tree of the search over distance and speed", xLabel: `Distance (${this.distance.unit})`, yLabel: `Speed (${this.speed.unit})`, height: 320 });
    this.slider = el("input", { type: "range", id: "step", min: 0, max: trace.steps.length, step: 1, "aria-label": "Step of the search", onInput: () => this.go(Number(this.slider.value)) });
    this.play = el("button", { type: "button", class: "primary", onClick: () => this.turn() }, "Play");
    this.told = el("p", { id: "step-told", role: "status" });
    this.queue = el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Queue" });
    const key = (role, text) => el("span", { class: "key" }, el("i", { class: "swatch", "data-role": role }), text);
    this.element = el("section", { class: "card trace", id: "trace" },
      el("h2", {}, "See the search"),
      el("p", { class: "help" }, `A queue of partial paths: the best one is taken, its children are made. Effective branching factor ${fixed(trace.effective_branching_factor, 2)} at depth ${trace.depth}, ${trace.counters.generated} children generated in ${trace.steps.length} steps.`),
      el("p", { class: "legend" }, key("line", "label in the queue"), key("muted", "expanded"), key("fastest", "taken now"), key("front", "path found"), Object.entries(PRUNED).map(([reason, [role]]) => key(role, `pruned by ${reason}`))),
      this.chart.element, el("div", { class: "slider steps" }, this.play, this.slider), this.told, this.queue);
    this.go(0);
  }

  /** Show the search after so many steps. */
  go(at) {
    const { trace } = this;
    this.at = Math.min(trace.steps.length, Math.max(0, at));
    this.slider.value = this.at;
    const steps = trace.steps.slice(0, this.at);
    const step = steps.at(-1);
    const made = [0, ...steps.flatMap((one) => one.children)];
    const gone = new Set(steps.flatMap((one) => one.displaced));
    const expanded = steps.filter((one) => one.became === "expanded").map((one) => one.label);
    const paths = steps.filter((one) => one.became === "path").map((one) => one.label);
    const layers = [{ kind: "points", x: this.x, y: this.y, color: "grid", size: 2 }];
    for (const label of made) if (!gone.has(label)) layers.push(this.arc(label, "line", 1.2));
    for (const label of expanded) layers.push(this.arc(label, "muted", 1.4));
    for (const path of paths) for (const label of this.way(path)) layers.push(this.arc(label, "front", 3));
    if (step) for (const label of this.way(step.label)) layers.push(this.arc(label, "fastest", 2.5));
    for (const [reason, [color, shape]] of Object.entries(PRUNED)) {
      const nodes = (step?.pruned ?? []).filter(([, why]) => why === reason).map(([node]) => node);
      layers.push({ kind: "points", x: nodes.map((node) => this.x[node]), y: nodes.map((node) => this.y[node]), color, shape, size: 5 });
    }
    if (step) layers.push({ kind: "points", x: [this.x[this.node(step.label)]], y: [this.y[this.node(step.label)]], color: "fastest", size: 6 });
    const [right, top] = [Math.max(...this.x), Math.max(...this.y)];
    this.chart.show({ layers: layers.filter((layer) => layer.x.length), x: [0, right], xRange: [-0.02 * right, 1.02 * right], yRange: [-0.03 * top, 1.06 * top] });
    this.tell(step);
  }

  node(label) { return this.trace.labels.node[label]; }

  /** Labels from one back to the root. */
  way(label) {
    const way = [];
    for (let at = label; at >= 0; at = this.trace.labels.parent[at]) way.push(at);
    return way;
  }

  arc(label, color, width) {
    const parent = this.trace.labels.parent[label];
    const ends = parent < 0 ? [label, label] : [parent, label];
    return { kind: "line", x: ends.map((one) => this.x[this.node(one)]), y: ends.map((one) => this.y[this.node(one)]), color, width };
  }

  tell(step) {
    const why = step ? Object.keys(PRUNED).map((reason) => [reason, step.pruned.filter(([, one]) => one === reason).length]).filter(([, count]) => count).map(([reason, count]) => `${count} pruned by ${reason}`) : [];
    const parts = step ? [`Step ${this.at}: label ${step.label} ${BECAME[step.became]}`, ...(step.became === "expanded" ? [`${step.children.length} children`, ...why, ...(step.blocked ? [`${step.blocked} arcs break a constraint`] : []), ...(step.displaced.length ? [`${step.displaced.length} worse labels displaced`] : [])] : []), `${step.queued} wait`] : ["Before the first step: the root waits"];
    this.told.textContent = `${parts.join(", ")}.`;
    const rows = (step?.head ?? [0]).map((label) => {
      const { duration_s, energy_j, priority } = this.trace.labels;
      return [String(label), significant(priority[label], 4), `${fixed(this.x[this.node(label)], 2)} ${this.distance.unit}`, `${fixed(this.y[this.node(label)], 0)} ${this.speed.unit}`, clock(duration_s[label]), `${significant(energy_j[label] * this.energy.factor, 4)} ${this.energy.unit}`];
    });
    this.queue.replaceChildren(table("Head of the queue, the next one first", ["Label", "Priority", "Distance", "Speed", "Time", "Energy"], rows));
  }

  turn() {
    if (this.timer) return this.stop();
    if (this.at === this.trace.steps.length) this.go(0);
    this.play.textContent = "Pause";
    this.timer = setInterval(() => { if (this.at >= this.trace.steps.length) this.stop(); else this.go(this.at + 1); }, 1000 / STEPS_PER_S);
  }

  stop() {
    clearInterval(this.timer);
    this.timer = null;
    this.play.textContent = "Play";
  }

  remove() {
    this.stop();
    this.chart.remove();
  }
}
