// One chart: uPlot has axes, scales and the cursor; layers are drawn here, in colours of the theme.
/* global uPlot */

import { color, el } from "./dom.js";

const FONT = "12px system-ui, sans-serif";
/** A chart of less height, px, has the marks of its axis nearer to each other, for there to be two. */
const LOW = 150;
/** Steps of an axis that counts. */
const WHOLE = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const drawn = new Set();

/** Draw all charts anew, in another theme. */
export function redrawAll() {
  for (const chart of drawn) chart.plot.redraw(false, true);
}

export class Chart {
  /**
   * @param {object} look label (for those who cannot see it), xLabel, yLabel, height (px), and where wanted:
   *   sync (charts of one name share the cursor), right ({ label, toShown, fromShown } of a second axis),
   *   onCursor(index or null), onZoom(min, max), hidesX (the axis of x is that of a chart below),
   *   yText(value) and ySplits(low, high) for the axis of y, wholeX (only whole numbers on the axis of x)
   */
  constructor(look) {
    this.look = look;
    this.layers = [];
    this.range = { x: [0, 1], y: [0, 1] };
    this.element = el("div", { class: "chart", role: "img", "aria-label": look.label });
    this.plot = new uPlot(this.options(), [[0], [0]], this.element);
    drawn.add(this);
    this.watcher = new ResizeObserver(() => this.fit());
    this.watcher.observe(this.element);
  }

  options() {
    const { look } = this;
    const axis = (label, more) => ({
      stroke: () => color("muted"), font: FONT, labelFont: FONT, labelSize: 18, label,
      grid: { stroke: () => color("grid"), width: 1 }, ticks: { show: false }, ...more,
    });
    const axes = [
      axis(look.hidesX ? "" : look.xLabel, look.hidesX ? { size: 4, values: () => [], labelSize: 0 } : { size: 28, ...(look.wholeX ? { incrs: WHOLE } : {}) }),
      axis(look.yLabel, { size: 44, space: look.height < LOW ? 18 : 30, ...(look.ySplits ? { splits: (plot, axis, low, high) => look.ySplits(low, high) } : {}), values: (plot, splits) => splits.map(look.yText ?? plain) }),
    ];
    if (look.right) axes.push(axis(look.right.label, { side: 1, size: 46, scale: "y", grid: { show: false }, splits: () => this.rightSplits().map(look.right.fromShown), values: (plot, splits) => splits.map((split) => plain(look.right.toShown(split))) }));
    return {
      width: 300, height: look.height, legend: { show: false }, padding: [8, look.right ? 0 : 12, 0, 0],
      scales: { x: { time: false, range: () => this.range.x }, y: { range: () => this.range.y } },
      series: [{}, { paths: () => null, points: { show: false } }],
      axes,
      cursor: {
        points: { show: false }, drag: { x: Boolean(look.onZoom), y: false, setScale: false, dist: 8 },
        sync: look.sync ? { key: look.sync, setSeries: false, scales: ["x", null] } : undefined,
      },
      hooks: {
        draw: [(plot) => this.paint(plot)],
        setCursor: [(plot) => look.onCursor?.(plot.cursor.left >= 0 ? plot.cursor.idx : null)],
        setSelect: [(plot) => this.zoomed(plot)],
      },
    };
  }

  /** Round values of the second axis. */
  rightSplits() {
    const [low, high] = this.range.y.map(this.look.right.toShown).sort((a, b) => a - b);
    const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 2.5, 5, 10].find((factor) => factor * power >= rough) * power;
    const splits = [];
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) splits.push(value);
    return splits.reverse();
  }

  zoomed(plot) {
    const { left, width } = plot.select;
    if (width > 8) this.look.onZoom?.(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  fit() {
    const width = Math.floor(this.element.clientWidth);
    if (width > 0 && width !== this.plot.width) this.plot.setSize({ width, height: this.look.height });
  }

  /** Show layers over ranges; the cursor stops at the points of x. */
  show({ layers, x, xRange, yRange }) {
    this.layers = layers;
    this.range = { x: xRange, y: yRange };
    this.plot.setData([x, new Array(x.length).fill(null)]);
    this.fit();
  }

  paint(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const at = { x: (value) => plot.valToPos(value, "x", true), y: (value) => plot.valToPos(value, "y", true), bbox };
    for (const layer of this.layers) {
      ctx.save();
      PAINTERS[layer.kind](ctx, layer, at, devicePixelRatio);
      ctx.restore();
    }
    ctx.restore();
  }

  remove() {
    drawn.delete(this);
    this.watcher.disconnect();
    this.plot.destroy();
  }
}

const plain = (value) => (value === null ? "" : String(Number(value.toPrecision(9))).replace("-", "−"));

/** The smallest range that holds values, with room around them. */
export function around(values, room = 0.05) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return [0, 1];
  const pad = room * (high - low) || 1;
  return [low - pad, high + pad];
}

function trace(ctx, layer, at, from, to) {
  const { x, y, ends } = layer;
  ctx.moveTo(at.x(x[from]), at.y(y[from]));
  for (let i = from + 1; i <= to; i += 1) {
    if (ends) ctx.lineTo(at.x(x[i]), at.y(ends[i - 1]));
    ctx.lineTo(at.x(x[i]), at.y(y[i]));
  }
}

// A layer: { kind, … } in the values of the axes; colours are roles of the palette.
const PAINTERS = {
  /** x, y, color or colors (a role for each stretch from a point to the next), width, dash, ends (a value just before the next point). */
  line(ctx, layer, at, ratio) {
    const last = layer.x.length - 1;
    ctx.lineWidth = (layer.width ?? 2) * ratio;
    ctx.lineJoin = "round";
    ctx.setLineDash((layer.dash ?? []).map((length) => length * ratio));
    let from = 0;
    while (from < last) {
      let to = from + 1;
      if (layer.colors) while (to < last && layer.colors[to] === layer.colors[from]) to += 1;
      else to = last;
      ctx.beginPath();
      ctx.strokeStyle = color(layer.colors ? layer.colors[from] : layer.color);
      trace(ctx, layer, at, from, to);
      ctx.stroke();
      from = to;
    }
  },

  /** x, low, high, color, alpha. */
  area(ctx, layer, at) {
    ctx.globalAlpha = layer.alpha ?? 1;
    ctx.fillStyle = color(layer.color);
    ctx.beginPath();
    layer.x.forEach((value, i) => ctx[i ? "lineTo" : "moveTo"](at.x(value), at.y(layer.high[i])));
    for (let i = layer.x.length - 1; i >= 0; i -= 1) ctx.lineTo(at.x(layer.x[i]), at.y(layer.low[i]));
    ctx.fill();
  },

  /** Stretches of x over the whole height: spans [[from, to], …], color, alpha. */
  spans(ctx, layer, at) {
    ctx.globalAlpha = layer.alpha ?? 0.2;
    ctx.fillStyle = color(layer.color);
    for (const [from, to] of layer.spans) {
      const left = at.x(from);
      ctx.fillRect(left, at.bbox.top, Math.max(at.x(to) - left, 2), at.bbox.height);
    }
  },

  /** x, y, color, size, shape (circle, ring, star, square, diamond), text beside each. */
  points(ctx, layer, at, ratio) {
    const size = (layer.size ?? 4) * ratio;
    ctx.fillStyle = ctx.strokeStyle = color(layer.color);
    ctx.lineWidth = 2 * ratio;
    layer.x.forEach((value, i) => {
      ctx.beginPath();
      SHAPES[layer.shape ?? "circle"](ctx, at.x(value), at.y(layer.y[i]), size);
      if (layer.shape === "ring") ctx.stroke();
      else ctx.fill();
      if (layer.text) {
        ctx.font = `bold ${12 * ratio}px system-ui, sans-serif`;
        ctx.fillText(layer.text[i], at.x(value) + 1.4 * size, at.y(layer.y[i]) - size);
      }
    });
  },
};

const polygon = (ctx, corners) => corners.forEach(([x, y], i) => ctx[i ? "lineTo" : "moveTo"](x, y));
const SHAPES = {
  circle: (ctx, x, y, size) => ctx.arc(x, y, size, 0, 2 * Math.PI),
  ring: (ctx, x, y, size) => ctx.arc(x, y, size, 0, 2 * Math.PI),
  square: (ctx, x, y, size) => ctx.rect(x - size, y - size, 2 * size, 2 * size),
  diamond: (ctx, x, y, size) => polygon(ctx, [[x, y - 1.3 * size], [x + 1.3 * size, y], [x, y + 1.3 * size], [x - 1.3 * size, y]]),
  star: (ctx, x, y, size) => polygon(ctx, Array.from({ length: 10 }, (_, i) => {
    const [angle, radius] = [(Math.PI * (i - 2.5)) / 5, i % 2 ? 0.65 * size : 1.6 * size];
    return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
  })),
};
