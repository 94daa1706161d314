/** How long it takes from publish() to the arrival of the first state that used the sample. */
export class RoundTrip {
  /** ms; 0: not known yet. Rises at once and falls slowly: a horizon that is too near loses the
   * onset of a contact. */
  value = 0;
  #sent = new Map<bigint, number>();

  published(seq: bigint, nowMs: number): void {
    this.#sent.set(seq, nowMs);
    this.#sent.delete(seq - 1024n);
  }

  /** A state that came at `nowMs` uses sample `seq`; 0: none. */
  used(seq: bigint, nowMs: number): void {
    const at = this.#sent.get(seq);
    if (at === undefined) return;
    for (const known of this.#sent.keys()) {
      if (known > seq) break;
      this.#sent.delete(known);
    }
    const took = nowMs - at;
    this.value = Math.max(took, this.value + (took - this.value) / 16);
  }
}
