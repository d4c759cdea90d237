// The range of the legend. In: values. Out: a range of nice numbers that holds 2 to 98 % of them;
// of differences, 98 % on both sides of 0.

const MOST_SAMPLED = 20_000;

/** 1, 2, 2.5 or 5 times a power of ten: the least that is not below a length. */
export function niceStep(length: number): number {
  if (!(length > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(length));
  return power * ([1, 2, 2.5, 5].find((step) => step * power >= length * (1 - 1e-9)) ?? 10);
}

/** Returns a sample of the finite values, ascending. */
function sampled(columns: readonly Float32Array[]): number[] {
  const sample: number[] = [];
  for (const values of columns) {
    const every = Math.max(1, Math.floor(values.length / MOST_SAMPLED));
    for (let index = 0; index < values.length; index += every) if (Number.isFinite(values[index])) sample.push(values[index]!);
  }
  return sample.sort((a, b) => a - b);
}

/** Returns a range of differences with 0 in its middle, or null if there are no values. */
export function symmetricRange(values: Float32Array): [number, number] | null {
  const sample = sampled([values.map(Math.abs)]);
  if (sample.length === 0) return null;
  const most = sample[Math.round(0.98 * (sample.length - 1))]! || sample.at(-1)!;
  const step = niceStep(most / 5);
  const end = most > 0 ? Number((step * Math.ceil(most / step - 1e-6)).toPrecision(6)) : 1;
  return [-end, end];
}

/** Returns one range for all columns, or null if there are no values. */
export function autoRange(...columns: readonly Float32Array[]): [number, number] | null {
  const sample = sampled(columns);
  if (sample.length === 0) return null;
  const at = (share: number): number => sample[Math.round(share * (sample.length - 1))]!;
  let [low, high] = [at(0.02), at(0.98)];
  // Zero belongs to the range unless it would waste more than half of the range.
  if (low > 0 && low < 0.5 * high) low = 0;
  const step = niceStep((high - low) / 10);
  const [from, to] = [Math.floor(low / step + 1e-6) * step, Math.ceil(high / step - 1e-6) * step];
  const tidy = (value: number): number => Number(value.toPrecision(6));
  return to > from ? [tidy(from), tidy(to)] : [tidy(from), tidy(from + (Math.abs(from) > 0 ? step : 1))];
}

/**
 * Returns the labels below the legend's bar: its ends, and round values that keep clear of them.
 */
export function legendTicks(low: number, high: number): number[] {
  const clear = (high - low) / 5.5;
  return [low, ...ticks(low, high).filter((value) => value > low + clear && value < high - clear), high];
}

/** Returns four to six round values from low to high. */
export function ticks(low: number, high: number): number[] {
  const step = niceStep((high - low) / 5);
  const found: number[] = [];
  for (let value = Math.ceil(low / step - 1e-6) * step; value <= high + step * 1e-6; value += step) found.push(Number(value.toPrecision(6)));
  return found;
}
