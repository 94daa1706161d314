// Rows of numbers over time, of the last minute.

export class History {
  private rows: { time: number; values: readonly number[] }[] = [];

  /** Keeps the newest `capacity` rows. */
  constructor(
    private readonly columns: number,
    private readonly capacity: number,
  ) {}

  /** `time` in s, above the last one's; other rows are left out. A value that is missing or no
   * number is none. */
  push(time: number, values: readonly number[]): void {
    const newest = this.rows.at(-1);
    if (newest && !(time > newest.time)) return;
    this.rows.push({ time, values });
    if (this.rows.length > this.capacity) this.rows.shift();
  }

  /** Values that come later are not joined to these by a line. */
  cut(): void {
    const newest = this.rows.at(-1);
    if (newest) this.push(newest.time + 1e-6, []);
  }

  clear(): void {
    this.rows = [];
  }

  /** Times relative to `now`, then each column, of the rows of the last `seconds` before it, and of
   * one more, from where the line enters. */
  window(now: number, seconds: number): (number | null)[][] {
    const seen = this.rows.filter(({ time }) => time <= now);
    const older = seen.filter(({ time }) => time < now - seconds).length;
    const rows = seen.slice(Math.max(older - 1, 0));
    const column = (i: number) => rows.map(({ values }) => {
      const value = values[i] ?? NaN;
      return Number.isFinite(value) ? value : null;
    });
    return [rows.map(({ time }) => time - now),
            ...Array.from({ length: this.columns }, (_, i) => column(i))];
  }
}
