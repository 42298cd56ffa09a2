// Linear and logarithmic scales between data and pixels. Pure functions.

function makeScale({ low, high, log }, from, to) {
  const warp = log ? (value) => Math.log10(Math.max(value, 1e-300)) : (value) => value;
  const a = warp(low);
  const span = warp(high) - a || 1;
  return {
    to: (value) => from + ((warp(value) - a) / span) * (to - from),
    back: (pixel) => {
      const at = a + ((pixel - from) / (to - from)) * span;
      return log ? 10 ** at : at;
    },
    inside: (value) => value >= low && value <= high,
    ticks: (most) => (log ? decades(low, high, most) : rounds(low, high, most)),
  };
}

// Round numbers, at most so many, between two ends.
function rounds(low, high, most) {
  const rough = (high - low) / Math.max(most, 1);
  if (!(rough > 0)) return [low];
  const base = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * base).find((size) => size >= rough * (1 - 1e-9));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push(k * step);
  return found;
}

function decades(low, high, most) {
  const found = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += 1) {
    for (const factor of [1, 2, 5]) found.push(factor * 10 ** power);
  }
  const inside = found.filter((value) => value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9));
  if (inside.length <= most) return inside;
  const whole = inside.filter((value) => Math.abs(Math.log10(value) % 1) < 1e-9);
  return whole.length >= 2 && whole.length <= most ? whole : inside.filter((_, i) => i % Math.ceil(inside.length / most) === 0);
}

// Where a value lies in a range: 0 at its low end, 1 at its high end.
const placeIn = (span, value) => Math.min(Math.max(makeScale(span, 0, 1).to(value), 0), 1);
