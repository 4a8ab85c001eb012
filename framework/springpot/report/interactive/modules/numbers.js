// Numbers as the command line prints them: as many digits as are known, and no more.

export function number(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (!Number.isFinite(value)) return value > 0 ? "inf" : "-inf";
  if (value === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  if (exponent >= 6 || exponent < -3) return value.toExponential(digits - 1);
  return value.toFixed(Math.max(0, digits - 1 - exponent));
}

const RAISED = { ".": "·", "-": "⁻", alpha: "ᵅ", beta: "ᵝ" };
const raised = (_, power) => RAISED[power] || power.replace(/./g, (sign) => RAISED[sign] || "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign]);

// Units and names in words as they are printed: °C and s², where a file can only say degC and s^2.
export const pretty = (text) => String(text).replace(/\bdegC\b/g, "°C").replace(/\^(-?\d+(?:\.\d+)?|alpha|beta)(?!\w|\.\d)/g, raised)
  .replace(/\bomega\b/g, "ω").replace(/\bsigma\b/g, "σ").replace(/(\d) x(?![\w.])/g, "$1 ×")
  .replace(/\b\d(\.\d+)?e\+0[1-5]\b/g, (told) => String(Number(told)));

export const capital = (text) => `${text[0].toUpperCase()}${text.slice(1)}`;

export const percent = (fraction, digits = 3) =>
  fraction === null || fraction === undefined ? "-" : `${number(100 * fraction, digits)} %`;

export const times = (error, floor) => (floor > 0 ? `${number(error / floor, 2)} × floor` : "");

export function probability(value) {
  if (value > 0.999) return "> 0.999";
  if (value < 0.001) return "< 0.001";
  return value.toFixed(value < 0.1 ? 3 : 2);
}

const VAGUE = 1e6; // ratio of an interval's ends beyond which nothing is known of a value

// Two digits of the interval's width decide how many of the value are told.
export function withInterval(value, low, high) {
  const width = Math.abs(high - low) / 2;
  if (low === null || high === null || !Number.isFinite(width) || width === 0) return [number(value), ""];
  if (low > 0 && high / low > VAGUE) return [number(value, 2), "(these data do not tell it)"];
  const place = Math.floor(Math.log10(width)) - 1;
  const size = Math.floor(Math.log10(Math.abs(value) || width));
  const digits = Math.min(8, Math.max(2, size - place + 1));
  return [number(value, digits), `[${number(low, digits)}, ${number(high, digits)}]`];
}
