// The front: delay against energy saved; a point of it is chosen by click, drag or slider.

import { Chart, around } from "./chart.js";
import { el, perFrame } from "./dom.js";
import { JOULE_PER_KWH, clock, delayScale, delayText, energyScale, fixed, significant } from "./units.js";

export const PINS = ["a", "b"];

/** Where energy is counted, as far as the object says so: at the wheel, at the pantograph, or by a map. */
const counted = (energy) => {
  if (!energy?.model) return "";
  const { model, map } = energy;
  return map == null && ["wheel", "pantograph"].includes(model) ? ` at the ${model}` : ` by ${map ?? model}`;
};

export class Front {
  /** @param content result.json; onChoose(index) */
  constructor(content, onChoose) {
    this.content = content;
    this.onChoose = onChoose;
    const { fastest, front } = content;
    this.delays = front.map((point) => point.delay_s);
    this.delay = delayScale(Math.max(...this.delays, 0));
    this.whole = fastest.energy_kwh;
    this.energy = energyScale(this.whole * JOULE_PER_KWH);
    this.extra = { pins: {}, overlays: [], draft: null, practices: [] };
    const toShown = (saved) => (this.whole - (saved / 100) * Math.abs(this.whole)) * JOULE_PER_KWH * this.energy.factor;
    const toSaved = (shown) => this.saved(shown / (JOULE_PER_KWH * this.energy.factor));
    this.chart = new Chart({
      label: `Pareto front: energy saved over delay, ${front.length} points. The slider below chooses a point.`,
      xLabel: `Delay over the fastest run of ${clock(fastest.time_s)} (${this.delay.unit})`,
      yLabel: "Energy saved (%)",
      right: { label: `Energy${counted(content.energy)} (${this.energy.unit})`, toShown, fromShown: toSaved },
      height: 300,
    });
    this.slider = el("input", {
      type: "range", id: "delay", min: 0, max: this.shown(Math.max(...this.delays, 0)), step: "any",
      onInput: () => this.onChoose(this.nearest(Number(this.slider.value) / this.delay.factor)),
      onKeydown: (event) => this.step(event),
    });
    this.element = el("section", { class: "card front" },
      el("h2", {}, "How much does a later arrival save?"),
      this.chart.element,
      el("label", { class: "slider" }, el("span", {}, `Delay in ${this.delay.unit}`), this.slider),
    );
    this.listen();
  }

  shown(delay_s) { return delay_s * this.delay.factor; }

  saved(energy_kwh) { return this.whole ? (100 * (this.whole - energy_kwh)) / Math.abs(this.whole) : 0; }

  nearest(delay_s) {
    let best = 0;
    this.delays.forEach((delay, i) => { if (Math.abs(delay - delay_s) < Math.abs(this.delays[best] - delay_s)) best = i; });
    return best;
  }

  /** Arrows go from point to point. */
  step(event) {
    const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
    const last = this.delays.length - 1;
    const wanted = event.key === "Home" ? 0 : event.key === "End" ? last : event.key in steps ? this.chosen + steps[event.key] : null;
    if (wanted === null) return;
    event.preventDefault();
    this.onChoose(Math.min(last, Math.max(0, wanted)));
  }

  listen() {
    const over = this.chart.plot.over;
    const choose = perFrame((event) => {
      const { plot } = this.chart;
      const box = over.getBoundingClientRect();
      const [left, top] = [event.clientX - box.left, event.clientY - box.top];
      const distances = this.content.front.map((point) => Math.hypot(
        plot.valToPos(this.shown(point.delay_s), "x") - left,
        0.3 * (plot.valToPos(this.saved(point.energy_kwh), "y") - top),
      ));
      this.onChoose(distances.indexOf(Math.min(...distances)));
    });
    over.addEventListener("pointerdown", (event) => {
      over.setPointerCapture(event.pointerId);
      choose(event);
    });
    over.addEventListener("pointermove", (event) => { if (event.buttons) choose(event); });
  }

  /** Show a chosen point, and what stands beside the front: pins ({ a: { delay_s, energy_kwh } }), overlays, a draft. */
  show(chosen, extra = {}) {
    this.chosen = chosen;
    Object.assign(this.extra, extra);
    const point = this.content.front[chosen];
    this.slider.value = this.shown(point.delay_s);
    this.slider.setAttribute("aria-valuetext", `${delayText(point.delay_s)}, ${fixed(point.saved_pct, 1)} % of the energy saved`);
    const layers = this.layers(point);
    const drawnX = layers.flatMap((layer) => layer.x), drawnY = layers.flatMap((layer) => layer.y ?? [...layer.low, ...layer.high]);
    this.chart.show({ layers, x: this.delays.map((delay) => this.shown(delay)), xRange: around(drawnX, 0.04), yRange: around(drawnY, 0.07) });
  }

  layers(point) {
    const { content, extra } = this;
    const line = (points) => ({ x: points.map((one) => this.shown(one.delay_s)), y: points.map((one) => this.saved(one.energy_kwh)) });
    const layers = [];
    const bounded = content.front.filter((one) => one.lower_bound_kwh !== null);
    if (bounded.length) {
      const { x, y } = line(bounded);
      layers.push({ kind: "area", x, low: y, high: bounded.map((one) => this.saved(one.lower_bound_kwh)), color: "bound", alpha: 0.5 });
    }
    for (const { points, color, dash } of [...extra.overlays, ...extra.practices]) layers.push({ kind: "line", ...line(points), color, dash, width: 1.8 });
    layers.push({ kind: "line", ...line(content.front), color: "front", width: 2 });
    if (content.front.length <= 100) layers.push({ kind: "points", ...line(content.front), color: "front", size: 2.5 });
    if (extra.draft) layers.push({ kind: "line", ...line(extra.draft), color: "pin-a", width: 2.5, dash: [6, 3] });
    layers.push({ kind: "points", ...line([{ delay_s: 0, energy_kwh: this.whole }]), color: "fastest", size: 6, shape: "star" });
    for (const [pin, at] of Object.entries(extra.pins)) layers.push({ kind: "points", ...line([at]), color: `pin-${pin}`, size: 5, shape: "diamond", text: [pin.toUpperCase()] });
    layers.push({ kind: "points", ...line([point]), color: "ink", size: 8, shape: "ring" });
    return layers;
  }

  remove() { this.chart.remove(); }
}
