// Numbers that the reader sets, as text by the rules of numbers.py; those of the folder come as texts.

const MISSING = "–";
const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
const timesTen = (power) => (power ? ` × 10${[...String(power)].map((digit) => RAISED[digit]).join("")}` : "");

function fixed(value, decimals) {
  const text = Math.abs(value).toFixed(decimals);
  const [whole, part] = text.split(".");
  const grouped = Math.abs(value) >= 1e4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") : whole;
  return (Number(text) !== 0 && value < 0 ? "−" : "") + grouped + (part ? `.${part}` : "");
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

const withUnit = (text, unit) => (unit ? `${text} ${unit}` : text);
