// The page: which exhibit is shown, which runs there are, and what changes them.

import { Benchmark } from "./benchmark.js";
import { redrawAll } from "./chart.js";
import { byId } from "./dom.js";
import { Form } from "./form.js";
import { drawRuns } from "./runs.js";
import { Journey } from "./journey.js";
import { Search } from "./search.js";
import { source } from "./source.js";
import * as state from "./state.js";

const KINDS = { search: Search, journey: Journey, benchmark: Benchmark };
/** How often the page asks how far runs are that go on, ms. */
const POLL_MS = 150;
let shown = null;
let timer = null;
let wanted = 0;
const form = new Form(byId("form"), (run) => started(run));

function applyTheme() {
  const theme = state.get("theme");
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  redrawAll();
}

function turnTheme() {
  const isDark = (state.get("theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  state.set({ theme: isDark ? "light" : "dark" });
}

function say(text, isError = false) {
  const status = byId("status");
  status.textContent = text;
  status.classList.toggle("error", isError);
}

const fail = (error) => say(error.message, true);

/** A run that somebody asked for: it is shown when it is done. */
function started(run) {
  state.set({ awaits: run.id });
  refresh().catch(fail);
}

async function drop(id) {
  await source.drop(id);
  if (state.get("awaits") === id) state.set({ awaits: null });
  if (shown?.id === id) { shown.remove(); shown = null; byId("title").textContent = ""; byId("exhibit").replaceChildren(); state.set({ run: null, point: null }); }
  await refresh();
}

/** Bring the page to what the server has, and again while a run goes on. */
async function refresh() {
  clearTimeout(timer);
  const runs = await source.runs();
  const awaited = runs.find((run) => run.id === state.get("awaits"));
  if (awaited?.state === "done") state.set({ awaits: null, run: awaited.id, point: null });
  if (awaited?.state === "failed") { state.set({ awaits: null }); if (awaited.error.field) await form.showError(awaited.error); }
  const done = runs.filter((run) => run.state === "done");
  const run = done.find((one) => one.id === state.get("run")) ?? (shown ? null : done[0]);
  if (run && shown?.id !== run.id) await show(run);
  drawRuns(byId("runs"), runs, shown?.id, (id) => drop(id).catch(fail));
  if (!shown && !runs.length) say("No run yet: begin with New run.");
  if (runs.some((one) => one.state === "queued" || one.state === "running")) timer = setTimeout(() => refresh().catch(fail), POLL_MS);
}

/** Show a run; of several that are asked for meanwhile the last one wins. */
async function show(run) {
  wanted += 1;
  const turn = wanted;
  const view = await source.view(run.id);
  if (turn !== wanted) return;
  shown?.remove();
  shown = new KINDS[view.kind](run.id, view, started);
  byId("title").textContent = view.name;
  byId("exhibit").replaceChildren(shown.element);
  say("");
  if (state.get("run") !== run.id) state.set({ run: run.id });
  await shown.show();
}

state.hear((names) => {
  if (names.has("theme")) applyTheme();
  if (names.has("run") || names.has("over")) refresh().catch(fail);
  shown?.show().catch(fail);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
byId("theme").addEventListener("click", turnTheme);
byId("new-run").hidden = !source.canRun;
byId("new-run").addEventListener("click", () => form.open().catch(fail));
applyTheme();
refresh().catch(fail);
