// The speed profile over distance, the line below it, and on demand effort, power, energy and time.

import { Chart, around } from "./chart.js";
import { at } from "./course.js";
import { el } from "./dom.js";
import { clock, delayScale, distanceScale, energyScale, fixed, forceScale, powerScale, significant, speedScale } from "./units.js";

const SYNC = "distance";
/** Panels on demand: the column of a course, the one it has before the next point where it goes in steps, its name, how its unit is found. */
export const PANELS = {
  force: { column: "F", ends: "F", name: "Effort", scale: forceScale },
  power: { column: "P", ends: "beforeNext", name: "Power", scale: powerScale },
  energy: { column: "E", name: "Energy used", scale: energyScale },
  time: { column: "t", name: "Time", scale: delayScale },
};
const FEATURES = { stops: "stops passed", neutral: "neutral section", lowered: "pantograph lowered", tunnels: "tunnel", curves: "curve" };
/** Limits above this multiple of the top speed are cut off. */
const LIMIT_SHOWN = 2;
const HEIGHTS = { speed: 300, panel: 130, line: 110 };

export class Profile {
  /** @param content result.json; regimes: their names; onZoom(min, max) in m, or null for all */
  constructor(content, regimes) {
    this.content = content;
    this.regimes = regimes;
    const { origin_m, destination_m } = content.trip;
    this.all = [origin_m, destination_m];
    this.zoom = this.all;
    this.distance = distanceScale(destination_m - origin_m);
    this.charts = {};
    this.readout = el("p", { class: "readout" });
    this.stack = el("div", { class: "stack" });
    this.element = el("section", { class: "card profile" },
      el("div", { class: "head" }, el("h2", {}, "How to drive?"), el("button", { type: "button", class: "quiet", onClick: () => this.zoomTo(this.all) }, "Whole line")),
      this.legend(), this.stack, this.readout);
    this.show([], []);
  }

  legend() {
    const key = (role, text, shape = "swatch") => el("span", { class: "key" }, el("i", { class: shape, "data-role": role }), text);
    const features = Object.keys(this.content.line.features).map((kind) => key(kind, FEATURES[kind]));
    return el("p", { class: "legend" }, this.regimes.map((name) => key(name, name)), key("limit", "speed limit", "swatch thin"), key("bound", "altitude", "swatch terrain"), features);
  }

  zoomTo(range) {
    this.zoom = [Math.max(this.all[0], range[0]), Math.min(this.all[1], range[1])];
    this.draw();
  }

  /**
   * Show runs: the first in colours of its regimes, the others in their own.
   * @param runs [{ course, color, dash, name }]; panels: names of `PANELS`; compared: the differences of two pins or null
   */
  show(runs, panels, compared = null, limits = null) {
    Object.assign(this, { runs, panels, compared, limits: limits ?? this.content.line.limits });
    this.stack.hidden = !runs.length;
    if (runs.length) this.draw();
    else this.tell(null);
  }

  draw() {
    const names = ["speed", ...Object.keys(PANELS).filter((name) => this.panels.includes(name)), ...(this.compared ? ["timeApart", ...(this.compared.energy_j ? ["energyApart"] : [])] : []), "line"];
    this.arrange(names);
    this.drawSpeed();
    for (const name of names) if (PANELS[name]) this.drawPanel(name);
    if (this.compared) this.drawCompared();
    this.drawLine();
  }

  yLabel(name) {
    if (name === "line") return "Altitude (m)";
    if (name === "speed") return `Speed (${this.speed.unit})`;
    if (name === "timeApart") return "B − A (s)";
    if (name === "energyApart") return `B − A (${energyScale(this.topEnergy()).unit})`;
    return `${PANELS[name].name} (${this.panelScale(name).unit})`;
  }

  /** Keep charts as long as they are the same, units included, in their order; the last one has the axis. */
  arrange(names) {
    const labels = names.map((name) => this.yLabel(name)), arranged = [...names, ...labels].join();
    if (arranged === this.arranged) return;
    this.arranged = arranged;
    for (const chart of Object.values(this.charts)) chart.remove();
    this.charts = {};
    this.stack.replaceChildren();
    for (const [i, name] of names.entries()) {
      const chart = new Chart({
        label: CHART_LABELS[name] ?? `${PANELS[name].name} over distance`, yLabel: labels[i], xLabel: `Position on the line (${this.distance.unit})`,
        height: name === "line" ? HEIGHTS.line : name === "speed" ? HEIGHTS.speed : HEIGHTS.panel,
        hidesX: name !== "line", sync: SYNC, onCursor: (index) => this.tell(index),
        onZoom: (from, to) => this.zoomTo([from / this.distance.factor, to / this.distance.factor]),
      });
      chart.plot.over.addEventListener("dblclick", () => this.zoomTo(this.all));
      if (name === "speed") this.hearPointer(chart.plot.over);
      this.charts[name] = chart;
      this.stack.append(chart.element);
    }
  }

  /** Whoever edits limits hears the pointer over the speeds first; what it takes is no zoom. */
  hearPointer(over) {
    for (const kind of ["down", "move", "up"]) {
      over.addEventListener(kind === "down" ? "mousedown" : `pointer${kind}`, (event) => {
        if (kind === "down") { if (this.isTaken) event.stopImmediatePropagation(); return; }
        this.onSpeedPointer?.[kind](event);
        if (kind === "up") this.isTaken = false;
      }, { capture: true });
    }
    over.addEventListener("pointerdown", (event) => { this.isTaken = this.onSpeedPointer?.down(event) ?? false; }, { capture: true });
  }

  /** Largest size of a column. */
  top(column) { return this.runs.reduce((most, { course }) => course[column].reduce((own, value) => Math.max(own, Math.abs(value)), most), 0); }

  topEnergy() { return this.top("E"); }

  get speed() { return speedScale(this.topSpeed()); }

  topSpeed() { return Math.max(1e-9, this.top("v")); }

  panelScale(name) {
    const { column, ends = column, scale } = PANELS[name];
    return scale(Math.max(this.top(column), this.top(ends)));
  }

  x(values) { return values.map((value) => value * this.distance.factor); }

  put(name, layers, yRange) {
    this.charts[name].show({ layers, x: this.x(this.runs[0].course.x), xRange: this.x(this.zoom), yRange });
  }

  /** Runs as lines of one column; the first one on top. */
  lines(column, factor, ends) {
    const shown = (values) => values?.map((value) => value * factor);
    return this.runs.map(({ course, color, dash }, i) => ({
      kind: "line", x: this.x(course.x), y: shown(course[column]), ends: shown(course[ends]), dash, width: i ? 1.8 : 2.6,
      ...(color ? { color } : { colors: course.regime.map((code) => this.regimes[code]) }),
    })).reverse();
  }

  drawSpeed() {
    const top = this.topSpeed(), { factor } = this.speed;
    const limits = this.limits.filter((row) => row.speed_mps !== null);
    const shown = limits.filter((row) => row.speed_mps <= LIMIT_SHOWN * top);
    const ceiling = Math.max(top, ...shown.map((row) => row.speed_mps));
    const speeds = limits.map((row) => row.speed_mps * factor);
    const layers = this.spans();
    if (shown.length) layers.push({ kind: "line", x: this.x(limits.map((row) => row.from_m)), y: speeds, ends: speeds, color: "limit", width: 1.5 });
    this.put("speed", [...layers, ...this.lines("v", factor)], [0, 1.06 * ceiling * factor]);
  }

  spans() {
    const { features } = this.content.line;
    return ["neutral", "lowered"].filter((kind) => features[kind]).map((kind) => ({ kind: "spans", color: "neutral", alpha: 0.28, spans: features[kind].map((one) => this.x([one.from_m, one.to_m])) }));
  }

  drawPanel(name) {
    const { column, ends } = PANELS[name];
    const { factor } = this.panelScale(name);
    const lines = this.lines(column, factor, ends);
    this.put(name, lines, around([0, ...lines.flatMap((line) => [...line.y, ...(line.ends ?? [])])], 0.08));
  }

  drawCompared() {
    const { x, time_s, energy_j } = this.compared;
    const energy = energyScale(this.topEnergy());
    for (const [name, y] of [["timeApart", time_s], ...(energy_j ? [["energyApart", energy_j.map((value) => value * energy.factor)]] : [])]) {
      const layers = [
        { kind: "line", x: this.x(this.all), y: [0, 0], color: "line", width: 1 },
        { kind: "line", x: this.x(x), y, color: name === "timeApart" ? "pin-a" : "pin-b", width: 2.2 },
      ];
      this.put(name, layers, around([0, ...y], 0.1));
    }
  }

  drawLine() {
    const { altitude, features } = this.content.line;
    const heights = altitude.map((row) => row.altitude_m);
    const [low, high] = around(heights, 0.15);
    const range = [low - 0.35 * (high - low), high];
    const x = this.x(altitude.map((row) => row.position_m));
    const layers = [{ kind: "area", x, low: heights.map(() => range[0]), high: heights, color: "terrain" }, { kind: "line", x, y: heights, color: "muted", width: 1.4 }];
    const step = (range[1] - range[0]) * 0.07;
    Object.entries(features).forEach(([kind, rows], i) => {
      const y = range[0] + (i + 1) * step;
      for (const row of rows) {
        if (row.to_m > row.from_m) layers.push({ kind: "line", x: this.x([row.from_m, row.to_m]), y: [y, y], color: kind, width: 5 });
        else layers.push({ kind: "points", x: this.x([row.from_m]), y: [y], color: kind, shape: "square", size: 3.5 });
      }
    });
    this.put("line", layers, range);
  }

  /** Say what is under the cursor. */
  tell(index) {
    if (index === null || !this.runs.length) { this.readout.textContent = ""; return; }
    const [{ course }] = this.runs;
    const { speed } = this, energy = energyScale(this.topEnergy());
    const x = course.x[index];
    this.readout.textContent = [
      `${fixed(x * this.distance.factor, 2)} ${this.distance.unit}`, `${fixed(course.v[index] * speed.factor, 1)} ${speed.unit}`,
      this.regimes[course.regime[index]], `${fixed(this.gradient(x), 1)} ‰`, clock(course.t[index]),
      `${significant(course.E[index] * energy.factor, 4)} ${energy.unit}`,
      ...this.runs.slice(1).map((run) => `${run.name}: ${fixed(at(run.course, "v", [x])[0] * speed.factor, 1)} ${speed.unit}`),
    ].join("  ·  ");
  }

  gradient(position_m) {
    const { altitude } = this.content.line;
    const next = altitude.findIndex((row) => row.position_m > position_m);
    const i = next < 0 ? altitude.length - 1 : Math.max(1, next);
    const [before, after] = [altitude[i - 1], altitude[i]];
    return (1000 * (after.altitude_m - before.altitude_m)) / (after.position_m - before.position_m);
  }

  remove() { for (const chart of Object.values(this.charts)) chart.remove(); }
}

const CHART_LABELS = {
  speed: "Speed over distance, with the speed limits; the driving regimes in colour", line: "Altitude of the line over distance, with its stops, neutral sections, tunnels and curves",
  timeApart: "How much later run B is than run A, in seconds over distance", energyApart: "How much more energy run B has used than run A, over distance",
};
