// Elements without markup in strings: no text is ever taken for HTML.

/** Make an element with attributes, listeners (onClick: …) and children. */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2).toLowerCase(), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

export const byId = (id) => document.getElementById(id);

/** A colour of the palette, as it is in the theme of the moment. */
export const color = (role) => getComputedStyle(document.documentElement).getPropertyValue(`--${role}`).trim();

/** A table of rows (arrays of texts) under heads; the first column names its row. */
export function table(caption, heads, rows) {
  return el("table", {},
    el("caption", {}, caption),
    el("thead", {}, el("tr", {}, heads.map((head) => el("th", { scope: "col" }, head)))),
    el("tbody", {}, rows.map(([name, ...cells]) => el("tr", {}, el("th", { scope: "row" }, name), cells.map((cell) => el("td", {}, cell))))));
}

/** Call a function at most once per frame, with the arguments of its last call. */
export function perFrame(action) {
  let waiting = null;
  return (...given) => {
    if (waiting === null) requestAnimationFrame(() => { const last = waiting; waiting = null; action(...last); });
    waiting = given;
  };
}
