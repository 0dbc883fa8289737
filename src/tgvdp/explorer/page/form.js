// The form of a run, made from the declaration of options: units and ranges are those of the command line.

import { el } from "./dom.js";
import { source } from "./source.js";

const ALWAYS_OPEN = "Search";

export class Form {
  /** @param dialog its element; onStarted(run) */
  constructor(dialog, onStarted) {
    Object.assign(this, { dialog, onStarted, fields: {}, reading: 0 });
  }

  async open() {
    if (!this.form) await this.make();
    this.dialog.showModal();
  }

  async make() {
    const declared = await source.form();
    this.declared = declared;
    const headings = [...new Set(declared.options.map((one) => one.heading))];
    this.submit = el("button", { class: "primary", type: "submit" }, "Run");
    this.form = el("form", { method: "dialog", novalidate: true, onSubmit: (event) => this.send(event) },
      el("h2", { id: "form-title" }, "New run"),
      this.dropZone(),
      el("div", { class: "fields" }, this.choice("train", "train", declared.trains, "tgv"), this.choice("track", "line", declared.tracks, "lgv-100km"),
        this.input({ name: "line_speed_kmh", label: "line speed", unit: "km/h", kind: "number", help: "Speed limit wherever the file of the line gives none; set it before the file is dropped." }),
        this.input({ name: "mass_t", label: "mass", unit: "t", kind: "number", help: "Another mass of the train." })),
      headings.map((heading) => el("details", { open: heading === ALWAYS_OPEN }, el("summary", {}, heading),
        el("div", { class: "fields" }, declared.options.filter((one) => one.heading === heading).map((one) => this.field(one))))),
      el("p", { class: "error", id: "error-", role: "alert" }),
      el("div", { class: "row end" }, el("button", { type: "button", class: "quiet", onClick: () => this.dialog.close() }, "Close"), this.submit));
    this.dialog.replaceChildren(this.form);
    this.fields.method.addEventListener("change", () => this.suit());
    this.suit();
  }

  dropZone() {
    const picker = el("input", { type: "file", id: "file", multiple: true, onChange: () => this.take(picker.files) });
    this.taken = el("ul", { class: "taken" });
    const zone = el("div", { class: "drop" }, el("label", { for: "file" }, "Drop files of trains and lines here, or choose them: TTOBench, railML, SFERA, OSRD, railtoolkit, tables, TOML"), picker, this.taken);
    for (const kind of ["dragover", "dragenter"]) zone.addEventListener(kind, (event) => { event.preventDefault(); zone.classList.add("over"); });
    zone.addEventListener("dragleave", () => zone.classList.remove("over"));
    zone.addEventListener("drop", (event) => { event.preventDefault(); zone.classList.remove("over"); this.take(event.dataTransfer.files); });
    return zone;
  }

  async take(files) {
    this.reading += files.length;
    this.submit.disabled = true; // until what is being read can be chosen
    for (const file of files) {
      const line = el("li", {}, `${file.name}: reading …`);
      this.taken.append(line);
      try {
        const { id, name, holds } = await source.upload(file, this.fields.line_speed_kmh.value);
        line.textContent = `${name}: ${holds.map((held) => `${held.kinds.join(" and ") || "options"} ${held.name} (${held.format})`).join(", ")}`;
        line.title = holds.map((held) => held.headline).join("\n");
        holds.forEach((held, item) => this.offer(`upload:${id}:${item}`, held, name));
      } catch (error) {
        line.textContent = error.message;
        line.className = "error";
      }
      this.reading -= 1;
      this.submit.disabled = this.reading > 0;
    }
  }

  /** Let what an uploaded file holds be chosen, and choose it; its options fill the form. */
  offer(value, held, file) {
    const places = { train: this.fields.train, track: this.fields.track, map: this.fields.energy };
    for (const kind of held.kinds.filter((one) => one in places)) {
      places[kind].append(el("option", { value }, `${held.name} (${file})`));
      places[kind].value = value;
    }
    for (const [name, given] of Object.entries(held.options)) {
      if (!(name === "energy" && given === "map" && held.kinds.includes("map"))) this.fill(name, given); // "map" is its own one
    }
    this.suit();
  }

  fill(name, value) {
    const field = this.fields[name];
    if (!field) return;
    field.value = typeof value === "boolean" ? String(value) : Array.isArray(value) ? value.join(", ") : value;
  }

  field(one) {
    if (one.kind === "choice") return this.choice(one.name, one.label, [...one.choices, ...(one.is_open ? this.declared.maps.filter((name) => !one.choices.includes(name)) : [])], one.default, one);
    if (one.kind === "switch") return this.choice(one.name, one.label, ["true", "false"], one.default === null ? null : String(one.default), one, { true: "yes", false: "no" });
    return this.input(one);
  }

  /** A field with its label, its unit, its help and room for its error. */
  wrap(name, label, unit, help, input, methods) {
    this.fields[name] = input;
    input.setAttribute("aria-describedby", `help-${name} error-${name}`);
    return el("div", { class: "field", "data-methods": methods?.join(" ") ?? null }, el("label", { for: `field-${name}` }, label, unit ? el("span", { class: "unit" }, ` in ${unit}`) : null), input,
      el("p", { class: "help", id: `help-${name}` }, help ?? ""), el("p", { class: "error", id: `error-${name}` }));
  }

  choice(name, label, choices, initial, one = {}, texts = {}) {
    const select = el("select", { id: `field-${name}` }, initial === null ? el("option", { value: "" }, one.placeholder || "as usual") : null, choices.map((choice) => el("option", { value: choice }, texts[choice] ?? choice)));
    select.value = initial ?? "";
    select.dataset.initial = initial ?? "";
    return this.wrap(name, label, "", one.help, select, one.methods);
  }

  input(one) {
    const isNumber = one.kind === "number" || one.kind === "whole";
    const input = el("input", { id: `field-${one.name}`, type: isNumber ? "number" : "text", step: one.kind === "whole" ? 1 : "any", placeholder: one.placeholder ?? "" });
    input.value = one.default ?? "";
    input.dataset.initial = one.default ?? "";
    input.dataset.kind = one.kind;
    return this.wrap(one.name, one.label, one.unit, one.help, input, one.methods);
  }

  /** Show the fields that the method has. */
  suit() {
    for (const field of this.form.querySelectorAll("[data-methods]")) field.hidden = !field.dataset.methods.split(" ").includes(this.fields.method.value);
    for (const group of this.form.querySelectorAll("details")) group.hidden = [...group.querySelectorAll(".field")].every((field) => field.hidden);
  }

  /** What is asked for: whatever is not as it was, nor empty, and belongs to the method. */
  asked() {
    const { train, track, line_speed_kmh, mass_t, ...others } = this.fields;
    const options = {};
    for (const [name, input] of Object.entries(others)) {
      if (input.value === "" || input.value === input.dataset.initial || input.closest(".field").hidden) continue;
      options[name] = valueOf(input);
    }
    return {
      train: train.value, track: track.value, options,
      ...(line_speed_kmh.value && track.value.startsWith("upload:") ? { line_speed_kmh: Number(line_speed_kmh.value) } : {}),
      ...(mass_t.value ? { mass_t: Number(mass_t.value) } : {}),
    };
  }

  async send(event) {
    event.preventDefault();
    this.clearErrors();
    const unread = Object.entries(this.fields).find(([, input]) => input.validity.badInput && !input.closest(".field").hidden);
    if (unread) return this.showError({ field: unread[0], message: "must be a number" });
    try {
      const run = await source.start(this.asked());
      this.dialog.close();
      this.onStarted(run);
    } catch (error) {
      this.showError(error);
    }
  }

  clearErrors() {
    for (const place of this.form.querySelectorAll("p.error")) place.textContent = "";
    for (const input of Object.values(this.fields)) input.removeAttribute("aria-invalid");
  }

  /** An error stands next to the field that it belongs to. */
  async showError({ field, message }) {
    if (!this.form) await this.make();
    if (!this.dialog.open) this.dialog.showModal();
    const input = this.fields[field];
    this.form.querySelector(`#error-${input ? field : ""}`).textContent = input ? message : `${field ? `${field}: ` : ""}${message}`;
    if (!input) return;
    input.setAttribute("aria-invalid", "true");
    const group = input.closest("details");
    if (group) group.open = true;
    input.focus();
  }
}

function valueOf(input) {
  if (input.dataset.kind === "number" || input.dataset.kind === "whole") return Number(input.value);
  if (input.dataset.kind === "list") return input.value.split(",").map((text) => text.trim());
  return { true: true, false: false }[input.value] ?? input.value;
}
