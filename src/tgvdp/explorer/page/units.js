// From SI to what people read. The only place of the page where a unit changes.

export const KMH = 3.6;
export const JOULE_PER_KWH = 3.6e6;

const number = (value, digits) => value.toLocaleString("en", { maximumFractionDigits: digits, minimumFractionDigits: digits, useGrouping: false }).replace("-", "−");

/** A number with so many significant digits, none beyond what is sensible. */
export function significant(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  if (Math.abs(value) < 1e-4) return value.toExponential(digits - 1).replaceAll("-", "−");
  const size = Math.floor(Math.log10(Math.abs(value)));
  return number(value, Math.max(0, Math.min(6, digits - 1 - size)));
}

/** A whole number as it is, any other with so many significant digits. */
export const counted = (value, digits) => (Number.isInteger(value) ? fixed(value, 0) : significant(value, digits));

export const fixed = (value, digits) => (value === null || !Number.isFinite(value) ? "–" : number(value, digits));

/** A running time as people say it: 1:02:03 h, 4:05 min, 1.234 s for toys. */
export function clock(seconds) {
  if (Math.abs(seconds) < 60) return `${significant(seconds)} s`;
  const sign = seconds < 0 ? "−" : "";
  const whole = Math.round(Math.abs(seconds));
  const two = (value) => String(value).padStart(2, "0");
  const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return sign + (hours ? `${hours}:${two(minutes)}:${two(rest)} h` : `${minutes}:${two(rest)} min`);
}

const signed = (text, value) => (value > 0 ? `+${text}` : text);
export const delayText = (seconds) => signed(clock(seconds), seconds);
export const signedText = (value, digits, unit) => `${signed(significant(value, digits), value)} ${unit}`;

// Units of the axes: small ones for toys. Each is { unit, factor } with shown value = SI value · factor.
const pick = (...choices) => (largest) => choices.find(([least]) => Math.abs(largest) >= least).slice(1).reduce((unit, factor) => ({ unit, factor }));
export const distanceScale = pick([1e3, "km", 1e-3], [0, "m", 1]);
export const speedScale = pick([5, "km/h", KMH], [0, "m/s", 1]);
export const delayScale = pick([30, "min", 1 / 60], [0, "s", 1]);
export const energyScale = pick([0.01 * JOULE_PER_KWH, "kWh", 1 / JOULE_PER_KWH], [0, "J", 1]);
export const forceScale = pick([1e3, "kN", 1e-3], [0, "N", 1]);
export const powerScale = pick([1e6, "MW", 1e-6], [1e3, "kW", 1e-3], [0, "W", 1]);
