// What is selected: an interval for any of the dimensions, the same for every view. Pure functions.

// A margin that no crossing limits is infinite, and null in the data.
const valueOf = (row, i) => (row.values[i] === null ? Infinity : row.values[i]);
const passes = (row, ranges) =>
  Object.entries(ranges).every(([i, [low, high]]) => valueOf(row, i) >= low && valueOf(row, i) <= high);

function withRange(ranges, dimension, range) {
  const { [dimension]: _, ...others } = ranges;
  return Object.freeze(range ? { ...others, [dimension]: range } : others);
}

// One end alone, the lower (0) or the upper (1), as sliders set it; the other end of a brush stays.
function withLevel(ranges, dimension, end, level) {
  const range = [...(ranges[dimension] ?? [-Infinity, Infinity])];
  range[end] = level;
  return withRange(ranges, dimension, range.some(Number.isFinite) ? range : null);
}

// How far a row is from what is selected: the largest excess, in shares of the spans shown.
function distanceTo(row, ranges, spans) {
  const apart = Object.entries(ranges).map(([i, [low, high]]) => {
    const span = spans[i].high - spans[i].low || 1;
    return Math.max(low - valueOf(row, i), valueOf(row, i) - high, 0) / span;
  });
  return Math.max(0, ...apart);
}

const nearest = (rows, ranges, spans) =>
  rows.reduce((best, row) => (!best || distanceTo(row, ranges, spans) < distanceTo(best, ranges, spans) ? row : best), null);

function rangeText([low, high], { unit, name }) {
  const end = (value) => withUnit(significant(value, 3), unit);
  if (low === -Infinity) return `${name} max ${end(high)}`;
  if (high === Infinity) return `${name} min ${end(low)}`;
  return `${name} ${significant(low, 3)} to ${end(high)}`;
}

// Lines on a row: what it is and its objectives, with intervals where it was flown on held-out scenarios.
const summaryOf = ({ values, point }) => objectives.map((entry, i) =>
  withUnit(`${entry.label} ${(point ? point.texts.values[i] : [significant(values[i], 3)]).join(" ")}`, entry.unit));

function tellingOf(row) {
  const faults = row.point?.texts.faults;
  return [`${wordsOf(row.name)}: ${data.states[row.layer]}${faults ? ` (${faults})` : ""}`, ...summaryOf(row)];
}
