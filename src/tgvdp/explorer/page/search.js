// A search: its front, the profile of the chosen point, pins, tables, and what can be edited.

import { compareCard, differences } from "./compare.js";
import { courseOf, nearest } from "./course.js";
import { el, table } from "./dom.js";
import { Edit } from "./edit.js";
import { Front, PINS } from "./front.js";
import { PANELS, Profile } from "./profile.js";
import { source } from "./source.js";
import * as state from "./state.js";
import { Trace } from "./trace.js";
import { JOULE_PER_KWH, clock, delayText, energyScale, fixed, powerScale, significant } from "./units.js";

const OVERLAY_DASH = [4, 3];
const OVERLAYS = ["curves", "neutral", "coasting", "cruising"];

export class Search {
  /** @param onKept hears of a run that an edit became */
  constructor(id, view, onKept) {
    Object.assign(this, { id, view, content: view.content, wanted: 0, draft: null, drawn: new Set(view.drawn) });
    this.front = new Front(this.content, (index) => state.set({ point: index }));
    this.profile = new Profile(this.content, view.regimes);
    this.practices = practicesOf(this.content);
    if (this.practices.length) this.front.element.append(el("p", { class: "legend" }, key("front", "least energy"), key("neutral", "today: all speeds scaled (linear margin)")));
    this.over = el("p", { class: "legend", id: "over" });
    this.front.element.append(this.over);
    this.unwritten = el("p", { class: "help", id: "unwritten", hidden: true }, "No profile of this point was written.");
    this.profile.stack.after(this.unwritten);
    this.figures = el("div", { class: "figures", id: "figures", "aria-live": "polite" });
    this.pinned = el("div", { class: "row" });
    this.compared = el("div", {});
    const panels = el("fieldset", { class: "row" }, el("legend", {}, "Over distance, too"), Object.entries(PANELS).map(([name, panel]) => this.toggle(name, panel.name)));
    this.profile.stack.before(panels);
    this.beside = el("div", { class: "column" });
    this.trace = view.trace ? new Trace(view.trace) : null;
    this.edit = view.editable && source.canRun ? new Edit(this, onKept) : null;
    if (this.edit) this.beside.append(this.edit.element);
    this.element = el("div", { class: "search" },
      el("div", { class: "column" }, this.front.element, el("section", { class: "card" }, el("h2", {}, "The chosen run"), this.figures, this.pinned), this.compared, this.beside),
      el("div", { class: "column" }, this.profile.element, this.trace?.element, this.tableOfPoints(), provenance(this.content)));
  }

  toggle(name, text) {
    const box = el("input", { type: "checkbox", onChange: () => {
      const shown = state.list("show").filter((one) => one !== name);
      state.set({ show: (box.checked ? [...shown, name] : shown).join(",") });
    } });
    box.checked = state.list("show").includes(name);
    return el("label", {}, box, text);
  }

  get chosen() {
    const last = this.content.front.length - 1;
    const asked = state.get("point");
    return asked === null ? this.middle(last) : Math.min(last, Math.max(0, Math.trunc(Number(asked)) || 0));
  }

  /** The point in the middle, of those with a profile. */
  middle(last) {
    const drawn = this.content.front.map((_, i) => i).filter((i) => this.hasProfile(i));
    return drawn[nearest(drawn, Math.round(last / 2))] ?? 0;
  }

  /** A search that had to end writes profiles of some points only. */
  hasProfile(point) { return this.drawn.has(String(point)); }

  async course(id, point) { return courseOf(await source.profile(id, point)); }

  /** Show what the state says; of several calls the last one wins, and until then the element says that it is busy. */
  async show() {
    this.wanted += 1;
    const turn = this.wanted;
    const { chosen } = this;
    this.element.setAttribute("aria-busy", "true");
    try {
      const found = await Promise.all([this.hasProfile(chosen) ? this.course(this.id, chosen) : null, this.pins(), this.overlays()]);
      if (turn === this.wanted) this.draw(chosen, ...found);
    } finally {
      if (turn === this.wanted) this.element.setAttribute("aria-busy", "false");
    }
  }

  draw(chosen, course, pins, { laid: overlays, others }) {
    const { draft } = this;
    if (draft && draft.point !== chosen) this.edit.solve();
    const shownPins = Object.fromEntries(Object.entries(pins).filter(([, pin]) => pin.counts === energyOf(this.content)));
    this.front.show(chosen, { pins: shownPins, overlays, practices: this.practices, draft: draft?.points ?? null });
    this.tellOverlays(overlays, others);
    this.tellFigures(this.content.front[chosen]);
    const own = draft ? [{ course: draft.course, name: "edited" }, { course, color: "muted", dash: [3, 3], name: "as it was" }] : [{ course, name: "chosen" }];
    const runs = own.filter((run) => run.course);
    for (const [pin, { course: own }] of Object.entries(pins)) runs.push({ course: own, color: `pin-${pin}`, dash: pin === "a" ? [7, 3] : [2, 3], name: pin.toUpperCase() });
    const both = pins.a && pins.b;
    const compared = both && pins.a.line === pins.b.line ? differences(pins.a, pins.b) : null;
    this.profile.show(runs, state.list("show"), compared, draft?.limits);
    this.compared.replaceChildren(...(both ? [compareCard(pins, compared, this.profile.distance)] : []));
    this.unwritten.hidden = Boolean(course);
    this.offerPins(pins);
    this.prefetch(chosen);
  }

  /** Neighbours of a point are fetched before somebody drags there. */
  prefetch(chosen) {
    for (const near of [chosen - 1, chosen + 1]) if (this.hasProfile(near)) source.profile(this.id, near).catch(() => {});
  }

  async pins() {
    const found = {};
    for (const pin of PINS) {
      const [id, point] = (state.get(pin) ?? "").split(":");
      if (!point) continue;
      try {
        const { content, name } = await source.view(id);
        const own = content.front[point];
        found[pin] = { id, point, course: await this.course(id, point), line: lineOf(content), counts: energyOf(content), time_s: own.time_s, energy_kwh: own.energy_kwh, pantograph_kwh: own.balance.pantograph_kwh, delay_s: own.time_s - this.content.fastest.time_s, name: id === this.id ? delayText(own.delay_s) : `${name}, ${delayText(own.delay_s)}` };
      } catch {
        state.set({ [pin]: null }); // its run is gone
      }
    }
    return found;
  }

  async overlays() {
    const laid = [], others = [];
    for (const id of state.list("over")) {
      if (id === this.id) continue;
      const view = await source.view(id).catch(() => null);
      if (view?.kind !== "search") continue;
      if (energyOf(view.content) !== energyOf(this.content)) { others.push(`${view.name} (${energyOf(view.content)})`); continue; }
      const points = view.content.front.map(({ time_s, energy_kwh }) => ({ delay_s: time_s - this.content.fastest.time_s, energy_kwh }));
      laid.push({ name: view.name, points, color: OVERLAYS[laid.length % OVERLAYS.length], dash: OVERLAY_DASH });
    }
    return { laid, others };
  }

  /** Name what lies over the front, and what cannot: kilowatt-hours of different places do not compare. */
  tellOverlays(laid, others) {
    const not = others.length ? `Not laid over, as their energy is not that of this run (${energyOf(this.content)}): ${others.join(", ")}.` : null;
    this.over.replaceChildren(...laid.map(({ name, color }) => key(color, name)), ...(not ? [not] : []));
  }

  tellFigures(point) {
    const { tariff } = this.content;
    const energy = energyScale(this.content.fastest.energy_kwh * JOULE_PER_KWH);
    const shown = (kwh) => (kwh === null ? null : `${significant(kwh * JOULE_PER_KWH * energy.factor, 4)} ${energy.unit}`);
    const balance = point.balance, peak_w = point.peak_power_kw === null ? null : 1000 * point.peak_power_kw;
    const power = powerScale(peak_w);
    const pairs = [
      ["Delay", `${delayText(point.delay_s)} (+${fixed(point.margin_pct, 1)} %)`],
      ["Running time", clock(point.time_s)],
      ["Energy", shown(point.energy_kwh)],
      ["Saved", `${fixed(point.saved_pct, 1)} %`],
      ["One more minute saves", shown(point.price_kwh_per_min)],
      ["Proven within", point.gap_pct === null ? null : `${significant(point.gap_pct, 2)} %`],
      ["Peak power", peak_w === null ? null : `${significant(peak_w * power.factor, 3)} ${power.unit}`],
      ["At the pantograph", shown(balance.pantograph_kwh)],
      ["Lost in brakes", shown(balance.braking_losses_kwh)],
      ["Costs", tariff.price_per_kwh === null ? null : `${fixed(point.cost_eur, 2)} €`],
      ["Replayed", point.replay.ok === null ? null : point.replay.ok ? "confirmed" : "NOT confirmed"],
    ].filter(([, text]) => text !== null);
    const advice = point.advice ? el("p", { class: "advice" }, el("strong", {}, "How to drive it: "), point.advice) : null;
    this.figures.replaceChildren(el("dl", {}, pairs.flatMap(([name, text]) => [el("dt", {}, name), el("dd", {}, text)])), ...(advice ? [advice] : []));
  }

  offerPins(pins) {
    this.pinned.hidden = !this.hasProfile(this.chosen);
    const buttons = PINS.flatMap((pin) => {
      const here = `${this.id}:${this.chosen}`;
      const set = el("button", { type: "button", class: `pin ${pin}`, onClick: () => state.set({ [pin]: here }) }, `Pin as ${pin.toUpperCase()}`);
      return pins[pin] ? [set, el("button", { type: "button", class: "quiet", onClick: () => state.set({ [pin]: null }) }, `Unpin ${pin.toUpperCase()}`)] : [set];
    });
    if (this.pinned.dataset.offered !== Object.keys(pins).join()) this.pinned.replaceChildren(...buttons);
    else [...this.pinned.querySelectorAll(".pin")].forEach((button, i) => button.replaceWith(buttons.filter((one) => one.classList.contains("pin"))[i]));
    this.pinned.dataset.offered = Object.keys(pins).join();
  }

  tableOfPoints() {
    const energy = energyScale(this.content.fastest.energy_kwh * JOULE_PER_KWH);
    const shown = (kwh) => (kwh === null ? "–" : significant(kwh * JOULE_PER_KWH * energy.factor, 4));
    const rows = this.content.front.map((point) => [
      el("button", { type: "button", class: "link", onClick: () => state.set({ point: point.id }) }, delayText(point.delay_s)),
      clock(point.time_s), shown(point.energy_kwh), fixed(point.saved_pct, 1), shown(point.price_kwh_per_min), point.gap_pct === null ? "–" : significant(point.gap_pct, 2),
    ]);
    const heads = ["Delay", "Running time", `Energy (${energy.unit})`, "Saved (%)", `A minute saves (${energy.unit})`, "Gap (%)"];
    return el("details", { class: "card" }, el("summary", {}, "All points as a table"), el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "All points" }, table("Points of the front", heads, rows)));
  }

  remove() {
    this.front.remove();
    this.profile.remove();
    this.trace?.remove();
  }
}

const key = (role, text) => el("span", { class: "key" }, el("i", { class: "swatch", "data-role": role }), text);

/** Which energy a run counts: at the wheel, at the pantograph, or that of a map. */
const energyOf = ({ energy }) => energy.map ?? energy.model;

/** Runs are on the same line where this is the same: its name, which tells the direction, the trip and the terrain. */
const lineOf = ({ trip, line }) => JSON.stringify([trip.track, trip.origin_m, trip.destination_m, line.altitude]);

/** What today's practices take, beside the front. */
function practicesOf({ practices, fastest }) {
  const rows = practices?.linear_margin ?? [];
  const points = rows.map(({ time_s, energy_kwh }) => ({ delay_s: time_s - fastest.time_s, energy_kwh }));
  return points.length ? [{ points, color: "neutral", dash: [6, 3] }] : [];
}

/** A value in a cell of a table: of what was read its name, the part of it, and the first digits of its fingerprint. */
function shown(value) {
  if (typeof value !== "object") return String(value);
  const name = value.file ?? value.name;
  if (!name) return JSON.stringify(value);
  return `${name}${value.part ? `#${value.part}` : ""}${value.sha256 ? `, sha256 ${value.sha256.slice(0, 12)}…` : ""}`;
}

/** Where a result comes from. */
export function provenance(content) {
  const { provenance: about = {}, counters = {}, warning } = content;
  const flat = (values) => Object.entries(values ?? {}).filter(([, value]) => value !== null && value !== "").map(([name, value]) => [name, shown(value)]);
  return el("details", { class: "card" }, el("summary", {}, "Where this comes from"),
    warning ? el("p", { class: "error" }, warning) : null,
    el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Provenance" },
      table("Made by", ["", ""], flat({ tgvdp: about.tgvdp, python: about.python, numpy: about.numpy, numba: about.numba, utc: about.utc, elapsed_s: about.elapsed_s, ...about.machine })),
      table("Inputs", ["", ""], flat(about.inputs)), Object.values(about.inputs ?? {}).flatMap(({ notes = [] }) => notes).map((note) => el("p", { class: "help" }, note)),
      table("Options", ["", ""], flat(about.options)), table("Work done", ["", ""], flat(counters))));
}
