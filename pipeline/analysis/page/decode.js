// Numbers of the page: base64 of little-endian arrays, and how they are written.
"use strict";

function bytes(text) {
  const raw = atob(text);
  const found = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
  return found.buffer;
}

const floats = (text) => new Float32Array(bytes(text));
const whole = (text) => new Uint16Array(bytes(text));

// A number with about four digits.
function shown(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e5 || size < 1e-3)) return Number(value.toPrecision(3)).toExponential().replace("e+", "e");
  return String(Number(value.toPrecision(4)));
}

// Round values in [low, high], about `count` of them.
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(count, 1);
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.999);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(Number((i * step).toPrecision(12)));
  return found;
}

// Where t falls in ascending times: the last index with times[i] <= t, at least 0.
function before(times, t) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}

const COLORS = ["#12608a", "#d1495b", "#2f8f6b", "#d98218", "#6a4c93", "#3fa7d6", "#8a5a3b", "#b0307f", "#5c6b1e", "#444"];
const FAINT = "#b5bcc4";
