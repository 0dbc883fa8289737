// A journey over several stops: its front beside today's practices, and how the supplement is split over the sections.

import { Chart, around } from "./chart.js";
import { el, table } from "./dom.js";
import { Front } from "./front.js";
import * as state from "./state.js";
import { clock, delayText, distanceScale, fixed, significant } from "./units.js";

// Waiting for windows is told from so many seconds on.
const WAITING_S = 0.5;
const PRACTICES = { proportional_to_time: ["supplement in proportion to time", "cruising", [6, 3]], proportional_to_distance: ["in proportion to distance", "neutral", [2, 3]], all_at_the_end: ["all before the last stop", "coasting", [8, 2, 2, 2]], linear_margin: ["all speeds scaled (linear margin)", "fastest", [4, 3]] };

export class Journey {
  constructor(id, view) {
    this.id = id;
    const { content } = view;
    this.sections = content.sections;
    this.points = content.front;
    const { fastest } = content;
    const relative = (one) => ({ ...one, delay_s: one.time_s - fastest.time_s });
    const front = this.points.map((point, index) => ({ ...relative(point), id: index, saved_pct: fastest.energy_kwh ? (100 * (fastest.energy_kwh - point.energy_kwh)) / Math.abs(fastest.energy_kwh) : 0, lower_bound_kwh: point.lower_bound_kwh ?? null }));
    this.front = new Front({ fastest, front }, (index) => state.set({ point: index }));
    this.practices = Object.entries(content.practices).map(([name, rows]) => {
      const [text, color, dash] = PRACTICES[name] ?? [name.replaceAll("_", " "), "muted", [3, 3]];
      return { rows, points: rows.filter((row) => row.energy_kwh !== null).map(relative), color, dash, text };
    });
    this.distance = distanceScale(this.sections.at(-1).to_m - this.sections[0].from_m);
    this.allocation = new Chart({ label: "Supplement of each section over its fastest time, in per cent", xLabel: `Position on the line (${this.distance.unit})`, yLabel: "Supplement (%)", height: 260 });
    this.tableHome = el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Sections" });
    this.figures = el("div", { class: "figures", id: "figures", "aria-live": "polite" });
    this.element = el("div", { class: "search journey" },
      el("div", { class: "column" }, content.warning ? el("p", { class: "error card" }, content.warning) : null, this.front.element, this.legend(), el("section", { class: "card" }, el("h2", {}, "The chosen journey"), this.figures)),
      el("div", { class: "column" }, el("section", { class: "card" }, el("h2", {}, "Which section gets how much?"), this.allocation.element), el("section", { class: "card" }, el("h2", {}, "Sections"), this.tableHome), this.advice(content)));
  }

  advice({ advice, front }) {
    if (!advice) return null;
    const named = ({ from, to }) => [from, to].filter(Boolean).join(" – ");
    const steps = advice.sections.map((own, i) => el("li", {}, named(this.sections[i]) ? el("strong", {}, `${named(this.sections[i])}: `) : null, own.advice));
    return el("section", { class: "card" }, el("h2", {}, `How to drive point ${advice.point} of ${front.length}`), el("ol", {}, steps));
  }

  legend() {
    const key = (role, text) => el("span", { class: "key" }, el("i", { class: "swatch", "data-role": role }), text);
    return el("p", { class: "legend card" }, key("front", "least energy"), this.practices.map(({ color, text }) => key(color, text)));
  }

  get chosen() {
    const asked = state.get("point");
    const last = this.points.length - 1;
    return asked === null ? Math.round(last / 2) : Math.min(last, Math.max(0, Math.trunc(Number(asked)) || 0));
  }

  async show() {
    const { chosen } = this;
    this.front.show(chosen, { practices: this.practices });
    const point = this.points[chosen];
    const supplements = this.sections.map((section, i) => 100 * (point.sections[i].time_s / section.fastest_time_s - 1));
    const x = [], y = [];
    this.sections.forEach((section, i) => { x.push(section.from_m * this.distance.factor, section.to_m * this.distance.factor); y.push(supplements[i], supplements[i]); });
    const [, high] = around([0, ...y], 0.12);
    this.allocation.show({ layers: [{ kind: "area", x, low: y.map(() => 0), high: y, color: "bound", alpha: 0.5 }, { kind: "line", x, y, color: "front", width: 2 }], x, xRange: [x[0], x.at(-1)], yRange: [Math.min(0, ...y), high] });
    const rows = this.sections.map((section, i) => {
      const own = point.sections[i];
      const end = (name, at_m) => `${name ? `${name}, ` : ""}${fixed(at_m * this.distance.factor, 1)}`;
      return [`${i + 1}`, `${end(section.from, section.from_m)} – ${end(section.to, section.to_m)}`, clock(own.time_s), delayText(own.time_s - section.fastest_time_s), fixed(supplements[i], 1), significant(own.energy_kwh, 4)];
    });
    this.tableHome.replaceChildren(table("Time and energy of each section at the chosen point", ["Section", `From – to (${this.distance.unit})`, "Time", "Supplement", "Supplement (%)", "Energy (kWh)"], rows));
    const pairs = [["Delay", delayText(this.front.delays[chosen])], ["Running time", clock(point.time_s)], ["Energy", `${significant(point.energy_kwh, 4)} kWh`],
      ...(point.waiting?.time_s > WAITING_S ? [["Waiting, in it", `${clock(point.waiting.time_s)}, ${significant(point.waiting.energy_kwh, 3)} kWh`]] : []), ["One more minute saves", `${significant(point.price_kwh_per_min, 3)} kWh`],
      ...(Number.isFinite(point.gap_pct) ? [["Proven within", `${significant(point.gap_pct, 2)} %`]] : []),
      ...this.practices.filter(({ rows }) => Number.isFinite(rows[chosen]?.energy_kwh)).map(({ text, rows }) => [text, `${significant(rows[chosen].energy_kwh, 4)} kWh`])];
    this.figures.replaceChildren(el("dl", {}, pairs.flatMap(([name, text]) => [el("dt", {}, name), el("dd", {}, text)])));
  }

  remove() {
    this.front.remove();
    this.allocation.remove();
  }
}
