// What the page shows, held in the URL: a link, or a reload, shows the same.

const listeners = new Set();

const read = () => Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
let state = read();

export const get = (name) => state[name] ?? null;
export const list = (name) => (state[name] ? state[name].split(",") : []);

/** Change parts of the state (null removes) and tell who listens. */
export function set(changes) {
  const next = { ...state };
  for (const [name, value] of Object.entries(changes)) {
    if (value === null || value === "") delete next[name];
    else next[name] = String(value);
  }
  const names = Object.keys({ ...state, ...next }).filter((name) => state[name] !== next[name]);
  if (!names.length) return;
  state = next;
  const hash = new URLSearchParams(state).toString().replaceAll("%2C", ",").replaceAll("%3A", ":");
  history.replaceState(null, "", hash ? `#${hash}` : location.pathname);
  for (const listener of [...listeners]) listener(new Set(names));
}

/** Hear of changes: the listener gets the set of names that changed. Returns how to stop. */
export function hear(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

addEventListener("hashchange", () => {
  const before = state;
  state = read();
  const names = Object.keys({ ...before, ...state }).filter((name) => before[name] !== state[name]);
  if (names.length) for (const listener of [...listeners]) listener(new Set(names));
});
