// Numbers as people read them, and round values on axes.

const MINUS = "\u2212";

// A number with so many digits that count: 3.664, 0.0123, 1.5e−7.
export function digits(value, count = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(count - 1) : Number(value.toPrecision(count)).toString();
  return text.replaceAll("-", MINUS);
}

// Round values within `low` to `high`, about `most` of them, steps of 1, 2 or 5, with how to write them.
export function ticks(low, high, most) {
  const raw = (high - low) / Math.max(1, most);
  if (!(raw > 0) || !Number.isFinite(raw)) return [];
  let power = Math.floor(Math.log10(raw));
  const mantissa = raw / 10 ** power;
  let round = [1, 2, 5].find((m) => mantissa <= m * (1 + 1e-9));
  if (!round) [round, power] = [1, power + 1];
  const step = round * 10 ** power;
  const places = Math.max(0, -power);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= Math.floor(high / step + 1e-9); k += 1) {
    const value = k * step;
    const text = places > 6 || Math.abs(value) >= 1e6 ? value.toExponential(1) : value.toFixed(places);
    found.push({ value, text: (Number(text) === 0 ? text.replace("-", "") : text).replaceAll("-", MINUS) });
  }
  return found;
}

// The least and the largest of `values`, opened by a share, and to a span of at least `least`; [0, 1] of nothing.
export function around(values, margin = 0.04, least = 0) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (!(low <= high)) return [0, 1];
  const room = Math.max(margin * (high - low), (least - (high - low)) / 2, high > low ? 0 : Math.abs(low) * 0.05 || 1);
  return [low - room, high + room];
}
