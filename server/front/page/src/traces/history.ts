// Columns of numbers over time, of the last minute.

/** One column may have no value at a time: NaN. */
export class History {
  private times: Float64Array;
  private columns: Float64Array[];
  private begin = 0;
  private end = 0;

  /** Keeps `capacity` rows at least. */
  constructor(
    columns: number,
    private readonly capacity: number,
  ) {
    this.times = new Float64Array(2 * capacity);
    this.columns = Array.from({ length: columns }, () => new Float64Array(2 * capacity));
  }

  /** `time` in s, above the last one's; other rows are left out. */
  push(time: number, values: readonly number[]): void {
    if (this.end > this.begin && !(time > this.times[this.end - 1]!)) return;
    if (this.end === this.times.length) this.slide();
    this.times[this.end] = time;
    this.columns.forEach((column, i) => (column[this.end] = values[i] ?? NaN));
    this.end++;
    this.begin = Math.max(this.begin, this.end - this.capacity);
  }

  /** Values that come later are not joined to these by a line. */
  cut(): void {
    if (this.end > this.begin) this.push(this.newest() + 1e-6, []);
  }

  clear(): void {
    this.begin = this.end = 0;
  }

  /** Time of the newest row, s; 0: there is none. */
  newest(): number {
    return this.end > this.begin ? this.times[this.end - 1]! : 0;
  }

  /** Times relative to `now`, then each column, of the rows of the last `seconds` before it. */
  window(now: number, seconds: number): (number | null)[][] {
    let to = this.end;
    while (to > this.begin && this.times[to - 1]! > now) to--;
    let from = to;
    while (from > this.begin && this.times[from - 1]! >= now - seconds) from--;
    if (from > this.begin) from--; // the line enters from outside
    const times = Array.from(this.times.subarray(from, to), (time) => time - now);
    const columns = this.columns.map((column) =>
      Array.from(column.subarray(from, to), (value) =>
        Number.isFinite(value) ? value : null,
      ),
    );
    return [times, ...columns];
  }

  private slide(): void {
    for (const column of [this.times, ...this.columns]) column.copyWithin(0, this.begin, this.end);
    this.end -= this.begin;
    this.begin = 0;
  }
}
