// The page: which exhibit is shown, and what changes it.

import { redrawAll } from "./chart.js";
import { byId, el } from "./dom.js";
import { Search } from "./search.js";
import { source } from "./source.js";
import * as state from "./state.js";

const KINDS = { search: Search };
const POLL_MS = 200;
let shown = null;

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

/** Show the run that the state names, else the first one. */
async function showRun() {
  const runs = await source.runs();
  const wanted = state.get("run");
  const run = runs.find((one) => one.id === wanted) ?? runs[0];
  if (!run) return say("No run yet.");
  if (wanted && run.id !== wanted) state.set({ run: run.id, point: null, a: null, b: null });
  if (run.state === "failed") return say(run.error.message, true);
  if (run.state !== "done") {
    say(`${run.name}: ${run.progress.stage ?? run.state} …`);
    return setTimeout(() => showRun().catch(fail), POLL_MS);
  }
  if (shown?.id === run.id) return;
  const view = await source.view(run.id);
  shown?.remove();
  shown = new KINDS[view.kind](run.id, view);
  byId("title").textContent = view.name;
  byId("exhibit").replaceChildren(shown.element);
  say("");
  await shown.show();
}

const fail = (error) => say(error.message, true);

state.hear((names) => {
  if (names.has("theme")) applyTheme();
  if (names.has("run")) showRun().catch(fail);
  else if (shown) shown.show().catch(fail);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
byId("theme").addEventListener("click", turnTheme);
applyTheme();
showRun().catch(fail);
