// The runs that there are: which one is shown, which lie over it, how far those are that go on.

import { el } from "./dom.js";
import { source } from "./source.js";
import * as state from "./state.js";
import { fixed } from "./units.js";

/** What a run that goes on says of itself: its stage, a share where it is known, and the engine's counters. */
export function progressOf(run) {
  const { stage, done, total, counters = {} } = run.progress;
  const counted = Object.entries(counters).filter(([, count]) => count > 0).map(([name, count]) => `${name.replaceAll("_", " ")} ${fixed(count, 0)}`);
  return [
    el("progress", { "aria-label": `Progress of ${run.name}`, ...(total ? { value: done ?? 0, max: total } : {}) }),
    el("span", { class: "counters" }, [run.state === "queued" ? "waiting" : stage ?? "starting", ...counted].join("  ·  ")),
  ];
}

/** Draw the list into its card. */
export function drawRuns(card, runs, shownId, onDrop) {
  card.hidden = !source.canRun && runs.length < 2;
  const over = new Set(state.list("over"));
  const turn = (id, on) => state.set({ over: [...(on ? [...over, id] : [...over].filter((one) => one !== id))].join(",") });
  const takesOverlays = runs.some((run) => run.id === shownId && run.kind === "search");
  card.replaceChildren(el("ul", { class: "runs" }, runs.map((run) => {
    const isDone = run.state === "done";
    const overlay = el("input", { type: "checkbox", disabled: !isDone || run.id === shownId, onChange: (event) => turn(run.id, event.target.checked) });
    overlay.checked = over.has(run.id) && run.id !== shownId;
    return el("li", { "data-run": run.id, "data-state": run.state },
      el("button", { type: "button", class: "name", disabled: !isDone, "aria-pressed": String(run.id === shownId), onClick: () => state.set({ run: run.id, point: null }) }, run.name),
      isDone && takesOverlays && run.kind === "search" ? el("label", { class: "over" }, overlay, "overlay") : null,
      run.state === "failed" ? el("span", { class: "error" }, run.error.message) : null,
      run.state === "queued" || run.state === "running" ? progressOf(run) : null,
      source.canRun ? el("button", { type: "button", class: "quiet", "aria-label": `${isDone || run.error ? "Forget" : "Cancel"} ${run.name}`, onClick: () => onDrop(run.id) }, isDone || run.error ? "Forget" : "Cancel") : null);
  })));
}
