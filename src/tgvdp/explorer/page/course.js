// A profile as curves: rows cut where the speed changes much, since v² is linear in position between rows.

const FINENESS = 0.02;

/**
 * Columns over position, all of the same length: x, v, t, E (SI); effort F, power P and the regime from each point on,
 * and the power just before the next one, as an effort ends where its row does.
 */
export function courseOf(profile) {
  const { position_m: s, speed_mps: v, time_s: t, energy_j: E, force_n: F, regime } = profile;
  const top = v.reduce((most, speed) => Math.max(most, speed), Number.MIN_VALUE);
  const course = { x: [], v: [], t: [], E: [], F: [], P: [], beforeNext: [], regime: [] };
  const add = (x, speed, time, energy, row) => {
    course.x.push(x); course.v.push(speed); course.t.push(time); course.E.push(energy);
    course.F.push(F[row]); course.P.push(F[row] * speed); course.regime.push(regime[row]);
  };
  for (let i = 0; i < s.length - 1; i += 1) {
    const pieces = Math.min(50, Math.max(1, Math.ceil(Math.abs(v[i + 1] - v[i]) / (FINENESS * top))));
    const [w, step, ds] = [v[i] ** 2, v[i + 1] ** 2 - v[i] ** 2, s[i + 1] - s[i]];
    for (let k = 0; k < pieces; k += 1) {
      const part = k / pieces;
      const speed = Math.sqrt(w + part * step);
      // Constant acceleration: the time of a part is its length over its mean speed.
      add(s[i] + part * ds, speed, k ? t[i] + (2 * part * ds) / (v[i] + speed) : t[i], E[i] + part * (E[i + 1] - E[i]), i);
    }
  }
  const last = s.length - 1;
  add(s[last], v[last], t[last], E[last], Math.max(0, last - 1));
  course.beforeNext = course.F.map((force, i) => force * (course.v[i + 1] ?? course.v[i]));
  return course;
}

/** Values of a column at positions, linear between its points. */
export function at(course, column, positions) {
  const { x } = course;
  const y = course[column];
  let i = 0;
  return positions.map((position) => {
    while (i < x.length - 2 && x[i + 1] < position) i += 1;
    const width = x[i + 1] - x[i];
    const part = width > 0 ? Math.min(1, Math.max(0, (position - x[i]) / width)) : 1;
    return y[i] + part * (y[i + 1] - y[i]);
  });
}

/** Index of the value that is nearest. */
export function nearest(values, wanted) {
  let best = 0;
  values.forEach((value, i) => { if (Math.abs(value - wanted) < Math.abs(values[best] - wanted)) best = i; });
  return best;
}
