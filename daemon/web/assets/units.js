// Numbers with their units.

const STEPS = [[1e9, "s"], [1e6, "ms"], [1e3, "µs"], [1, "ns"]];

/** A time in nanoseconds, as 1.25 ms. */
export function duration(ns) {
  if (ns === undefined || ns === null) return "–";
  const [unit, name] = STEPS.find(([unit]) => ns >= unit) ?? STEPS[3];
  return `${Number((ns / unit).toPrecision(3))} ${name}`;
}

/** Seconds since 1970 as 12:34:56.789 of the place of the browser. */
export function timeOfDay(seconds) {
  const date = new Date(seconds * 1000);
  const two = (number) => String(number).padStart(2, "0");
  const milliseconds = String(date.getMilliseconds()).padStart(3, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${milliseconds}`;
}

/** A number with few digits, as it is read at a glance. */
export function glance(number) {
  if (typeof number !== "number") return String(number);
  if (Number.isInteger(number) && Math.abs(number) < 1e9) return String(number);
  const size = Math.abs(number);
  return size !== 0 && (size < 1e-3 || size >= 1e7) ? number.toExponential(3) : number.toPrecision(5);
}

export const frequency = (hertz) => `${hertz >= 100 || hertz === 0 ? hertz.toFixed(0) : hertz.toPrecision(3)} Hz`;

/** A time in seconds, as 1.5 s or 2 min 3 s. */
export function seconds(time) {
  if (time < 60) return `${time.toFixed(1)} s`;
  const whole = Math.round(time);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return hours > 0 ? `${hours} h ${minutes} min` : `${minutes} min ${whole % 60} s`;
}

/** A size in bytes, as 4.2 MB. */
export function bytes(size) {
  const [unit, text] = [[1e9, "GB"], [1e6, "MB"], [1e3, "kB"]].find(([unit]) => size >= unit) ?? [1, "B"];
  return `${unit === 1 ? size : (size / unit).toFixed(1)} ${text}`;
}

export const count = (number) => number.toLocaleString("en");

/** `::demo::OUT_OF_RANGE` as `OUT_OF_RANGE` of demo; others whole. */
export function exception(name) {
  return String(name).replace(/^::/, "");
}

/** Names of middlewares: one, or several, as shm+zenoh. */
export const middlewares = (backend) => [backend ?? []].flat().flatMap((names) => names.split("+"));
