/** A symmetric positive definite matrix whose rows begin at their first entry, and equations
 * with it. Cholesky's factor keeps that shape, so little is done where objects touch few others. */
export class Skyline {
  /** Row i holds the columns from first[i] to i. */
  private first = new Int32Array(0);
  private rows: Float64Array[] = [];

  /** n rows of one zero each. */
  begin(n: number): void {
    this.first = Int32Array.from({ length: n }, (_, i) => i);
    this.rows = [];
  }
  /** Row i has entries from column k on; before the first add(). */
  reach(i: number, k: number): void {
    if (k < this.first[i]!) this.first[i] = k;
  }
  /** Adds to entry i, k <= i, which was reached. */
  add(i: number, k: number, value: number): void {
    if (this.rows.length === 0) {
      this.rows = Array.from(this.first, (first, row) => new Float64Array(row - first + 1));
    }
    this.rows[i]![k - this.first[i]!]! += value;
  }
  /** From here on it is its own factor. False: a square on its diagonal is not above `share` times
   * the entry there, so it is not positive definite; `least` is in its place, then. */
  factor(least: number, share = 0): boolean {
    let definite = true;
    this.rows.forEach((row, i) => {
      const begin = this.first[i]!, limit = share * row[i - begin]!;
      for (let k = begin; k <= i; ++k) {
        const other = this.rows[k]!, shift = this.first[k]!;
        let left = row[k - begin]!;
        for (let j = Math.max(begin, shift); j < k; ++j) {
          left -= row[j - begin]! * other[j - shift]!;
        }
        if (k === i && !(left > limit)) definite = false;
        row[k - begin] = k < i ? left / other[k - shift]! : Math.sqrt(Math.max(left, least));
      }
    });
    return definite;
  }
  /** x = A^-1 x, after factor(). */
  solve(x: Float64Array): void {
    const n = this.rows.length;
    for (let i = 0; i < n; ++i) {
      const row = this.rows[i]!, begin = this.first[i]!;
      for (let k = begin; k < i; ++k) x[i]! -= row[k - begin]! * x[k]!;
      x[i]! /= row[i - begin]!;
    }
    for (let i = n - 1; i >= 0; --i) {
      const row = this.rows[i]!, begin = this.first[i]!;
      x[i]! /= row[i - begin]!;
      for (let k = begin; k < i; ++k) x[k]! -= row[k - begin]! * x[i]!;
    }
  }
}
