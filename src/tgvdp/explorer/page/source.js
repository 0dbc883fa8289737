// Where exhibits come from: the server, or the file that holds the page.

/** What went wrong, and the field of a form that it is about. */
export class SourceError extends Error {
  constructor(message, field = "") {
    super(message);
    this.field = field;
  }
}

async function ask(path, options = {}) {
  let answer;
  try {
    answer = await fetch(path, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new SourceError("the server does not answer: has it ended?");
  }
  const content = answer.status === 204 ? null : await answer.json();
  if (!answer.ok) throw new SourceError(content.message, content.field);
  return content;
}

const post = (path, content, signal) => ask(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(content), signal });

class Server {
  constructor() {
    this.canRun = true;
    this.kept = new Map();
  }

  runs() { return ask("/api/runs"); }
  run(id) { return ask(`/api/runs/${id}`); }
  form() { return this.once("/api/form"); }
  start(asked) { return post("/api/runs", asked); }
  drop(id) { return ask(`/api/runs/${id}`, { method: "DELETE" }); }
  draft(asked, delay_s) { return post("/api/drafts", { asked, delay_s }); }
  view(id) { return this.once(`/api/runs/${id}/view`); }
  profile(id, point) { return this.once(`/api/runs/${id}/profiles/${point}`); }

  upload(file, lineSpeedKmh) {
    const query = new URLSearchParams({ name: file.name, line_speed_kmh: lineSpeedKmh });
    return ask(`/api/uploads?${query}`, { method: "POST", body: file });
  }

  /** What never changes is fetched once. */
  once(path) {
    if (!this.kept.has(path)) {
      this.kept.set(path, ask(path).catch((error) => { this.kept.delete(path); throw error; }));
    }
    return this.kept.get(path);
  }
}

class Embedded {
  constructor(held) {
    this.canRun = false;
    this.held = held;
  }

  async runs() { return this.held.map(({ id, view }) => ({ id, name: view.name, kind: view.kind, state: "done", progress: {}, error: null })); }
  async run(id) { return (await this.runs()).find((run) => run.id === id); }
  async view(id) { return this.find(id).view; }
  async profile(id, point) { return this.find(id).profiles[point]; }
  find(id) { return this.held.find((one) => one.id === id); }
}

const inside = document.getElementById("exhibits");
export const source = inside ? new Embedded(JSON.parse(inside.textContent)) : new Server();
