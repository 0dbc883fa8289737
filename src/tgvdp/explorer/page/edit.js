// Edits while one drags: a speed limit or the mass, with the front solved anew each time.

import { courseOf } from "./course.js";
import { el, perFrame } from "./dom.js";
import { source } from "./source.js";
import { KMH, counted, fixed, significant } from "./units.js";

/** How near to a limit the pointer must be to take it, px; limits go in whole steps, km/h. */
const GRIP_PX = 9;
const STEP_KMH = 5;
const ROUNDING_KMH = 1e-6;

const moreOrLess = (value, unit) => `${significant(Math.abs(value), 3)} ${unit} ${value < 0 ? "less" : "more"}`;

export class Edit {
  /** @param search the exhibit; onKept(run) */
  constructor(search, onKept) {
    Object.assign(this, { search, onKept, isBusy: false, next: null });
    const { editable, asked } = search.view;
    this.asked = asked;
    this.rows = editable.limits;
    this.top_kmh = editable.top_kmh;
    this.start = { mass_t: editable.mass_now_t, limits_kmh: this.rows.map((row) => row.now_kmh) };
    this.now = structuredClone(this.start);
    const { distance } = search.profile;
    const places = this.rows.map((row) => `from ${distance.unit} ${Number((row.from_m * distance.factor).toFixed(3))}`);
    this.status = el("p", { class: "readout", role: "status", id: "draft-status" });
    this.mass = el("input", { type: "range", id: "mass", min: 0.5 * editable.mass_t, max: 1.5 * editable.mass_t, step: editable.mass_t / 100, onInput: () => this.change({ mass_t: Number(this.mass.value) }) });
    this.mass.value = this.now.mass_t;
    this.massText = el("output", { for: "mass" });
    this.inputs = this.rows.map((row, i) => el("input", { type: "number", step: STEP_KMH, min: STEP_KMH, "aria-label": `Limit ${places[i]}, km/h`, onInput: (event) => this.setLimit(i, Number(event.target.value)) }));
    this.keep = el("button", { type: "button", class: "primary", onClick: () => this.keepIt() }, "Keep as a run");
    this.element = el("section", { class: "card edit", id: "edit" },
      el("h2", {}, "What if?"),
      el("p", { class: "help" }, "Drag a speed limit in the picture, or the mass here: the front is solved anew at once."),
      el("label", { class: "slider" }, el("span", {}, "Mass (t)"), this.mass, this.massText),
      el("details", {}, el("summary", {}, "Speed limits in km/h"), el("div", { class: "limits" }, places.map((place, i) => el("label", {}, place, this.inputs[i])))),
      el("div", { class: "row" }, this.keep, el("button", { type: "button", class: "quiet", onClick: () => this.reset() }, "As it was")), this.status);
    this.tell();
    this.listen();
  }

  listen() {
    const move = perFrame((event) => this.drag(event));
    this.search.profile.onSpeedPointer = {
      down: (event) => {
        this.held = this.limitAt(event);
        if (this.held === null) return false;
        event.target.setPointerCapture(event.pointerId);
        return true;
      },
      move: (event) => {
        if (this.held !== null && this.held !== undefined && event.buttons) { move(event); return true; }
        event.target.style.cursor = this.limitAt(event) === null ? "" : "ns-resize";
        return false;
      },
      up: () => { this.held = null; },
    };
  }

  /** Index of the limit under the pointer, or null: as it is drawn, and not where a speed restriction lies below it. */
  limitAt(event) {
    const { profile } = this.search, { plot } = profile.charts.speed, { distance, speed } = profile;
    const box = plot.over.getBoundingClientRect();
    const [left, top] = [event.clientX - box.left, event.clientY - box.top];
    const position = plot.posToVal(left, "x") / distance.factor;
    const i = this.rows.findIndex((row) => row.from_m <= position && position < row.to_m);
    if (i < 0) return null;
    const drawn_mps = profile.limits.findLast((row) => row.from_m <= position).speed_mps;
    if (drawn_mps * KMH < Math.min(this.now.limits_kmh[i], this.top_kmh) - ROUNDING_KMH) return null;
    return Math.abs(plot.valToPos(drawn_mps * speed.factor, "y") - top) <= GRIP_PX ? i : null;
  }

  drag(event) {
    const { plot } = this.search.profile.charts.speed, { speed } = this.search.profile;
    const top = event.clientY - plot.over.getBoundingClientRect().top;
    const kmh = (plot.posToVal(top, "y") / speed.factor) * KMH;
    this.setLimit(this.held, Math.max(STEP_KMH, Math.round(kmh / STEP_KMH) * STEP_KMH));
  }

  setLimit(i, kmh) {
    if (!(kmh > 0) || kmh === this.now.limits_kmh[i]) return;
    const limits_kmh = [...this.now.limits_kmh];
    limits_kmh[i] = kmh;
    this.change({ limits_kmh });
  }

  change(part) {
    Object.assign(this.now, part);
    this.tell();
    this.solve();
  }

  tell() {
    this.massText.textContent = counted(this.now.mass_t, 4);
    this.mass.setAttribute("aria-valuetext", `${counted(this.now.mass_t, 4)} t`);
    this.inputs.forEach((input, i) => { if (input !== document.activeElement) input.value = Math.round(10 * this.now.limits_kmh[i]) / 10; });
    this.keep.disabled = !this.isEdited;
  }

  get isEdited() { return JSON.stringify(this.now) !== JSON.stringify(this.start); }

  /** The question with the edits of the moment. */
  question() {
    const limits_kmh = { ...this.asked.limits_kmh };
    this.now.limits_kmh.forEach((kmh, i) => { if (kmh !== this.start.limits_kmh[i]) limits_kmh[this.rows[i].row] = kmh; });
    const mass = this.now.mass_t === this.start.mass_t ? this.asked.mass_t : this.now.mass_t;
    return { ...this.asked, limits_kmh, ...(mass ? { mass_t: mass } : {}) };
  }

  /** Solve what is wanted last; what is overtaken meanwhile is left out. */
  async solve() {
    if (this.isBusy) { this.next = true; return; }
    this.isBusy = true;
    try {
      do {
        this.next = null;
        await this.solveOnce();
      } while (this.next);
    } finally {
      this.isBusy = false;
    }
  }

  async solveOnce() {
    if (!this.isEdited) return this.show(null, "");
    const { content, chosen } = this.search;
    try {
      const { content: found, profile } = await source.draft(this.question(), content.front[chosen].delay_s);
      const points = found.time_s.map((time_s, i) => ({ delay_s: time_s - content.fastest.time_s, energy_kwh: found.energy_kwh[i] }));
      const apart = found.fastest.time_s - content.fastest.time_s;
      this.show({ points, point: chosen, course: courseOf(profile), limits: found.line.limits }, `Solved in ${fixed(1000 * found.elapsed_s, 0)} ms: the fastest run takes ${moreOrLess(apart, "s")} and ${moreOrLess(found.fastest.energy_kwh - content.fastest.energy_kwh, "kWh")}.`);
    } catch (error) {
      this.status.textContent = error.message;
      this.status.classList.add("error");
    }
  }

  show(draft, text) {
    this.search.draft = draft;
    this.status.classList.remove("error");
    this.status.textContent = text;
    return this.search.show();
  }

  async keepIt() {
    try {
      this.onKept(await source.start(this.question()));
    } catch (error) {
      this.status.textContent = error.message;
      this.status.classList.add("error");
    }
  }

  reset() {
    this.now = structuredClone(this.start);
    this.mass.value = this.now.mass_t;
    this.tell();
    this.solve();
  }
}
