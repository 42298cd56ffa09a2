// Numbers as text, by the rules of numbers.py: as many digits as the interval around a number supports.

const MISSING = "–";
const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
const timesTen = (power) => (power ? ` × 10${[...String(power)].map((digit) => RAISED[digit]).join("")}` : "");

function fixed(value, decimals, signed = false) {
  const text = Math.abs(value).toFixed(decimals);
  const zero = Number(text) === 0;
  const [whole, part] = text.split(".");
  const grouped = Math.abs(value) >= 1e4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") : whole;
  const sign = zero ? "" : value < 0 ? "−" : signed ? "+" : "";
  return sign + grouped + (part ? `.${part}` : "");
}

// A number to so many significant digits, without trailing zeros.
function significant(value, digits = 4) {
  if (!isNumber(value)) return MISSING;
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(value)));
  if (power < -4 || power >= 6) return significant(value / 10 ** power, digits) + timesTen(power);
  const text = fixed(value, Math.max(digits - 1 - power, 0));
  return text.includes(".") ? text.replace(/0+$/, "").replace(/\.$/, "") : text;
}

// Value and "[low, high]" as texts; two digits of the width of the interval are shown of all three.
function estimate(value, low, high, signed = false) {
  if (![value, low, high].every(isNumber)) return [significant(value), MISSING];
  const [decimals, power] = digitsOf(value, low, high);
  const shown = [value, low, high].map((number) => fixed(number / 10 ** power, decimals, signed));
  return [shown[0] + timesTen(power), `[${shown[1]}, ${shown[2]}]${timesTen(power)}`];
}

function digitsOf(value, low, high) {
  const largest = Math.max(Math.abs(value), Math.abs(low), Math.abs(high));
  if (largest === 0) return [0, 0];
  const top = Math.floor(Math.log10(largest));
  const finest = high > low ? Math.floor(Math.log10(high - low)) - 1 : top - 3;
  if (-finest > 5 || largest >= 1e6) return [Math.max(top - finest, 0), top];
  return [Math.max(-finest, 0), 0];
}

const perCent = (share) =>
  (isNumber(share) ? `${fixed(100 * share, Math.abs(share) > 0 && Math.abs(share) < 0.0995 ? 1 : 0)} %` : MISSING);
const withUnit = (text, unit) => (unit ? `${text} ${unit}` : text);
