/** Counts of the samples. */
import type { SampleAck } from "./gen/haptic/v1/session_pb.js";

/** Numbers of samples since the session was first opened. */
export interface PublishStatistics {
  /** Samples given to publish(); number of the newest. */
  published: number;
  /** Handed to the network. */
  sent: number;
  /** Replaced by a newer one before they could be sent. */
  conflated: number;
  /** Planes of a sample that were more than one can have. */
  planesLeftOut: number;
  // Counts of the server.
  accepted: number;
  rejectedOld: number;
  rejectedInvalid: number;
  /** Accepted, but too fast to count as fresh. */
  backlog: number;
  /** The newest reason of a rejection; empty: none. */
  lastRejection: string;
}

export class Statistics {
  readonly counts: PublishStatistics = {
    published: 0, sent: 0, conflated: 0, planesLeftOut: 0, accepted: 0, rejectedOld: 0,
    rejectedInvalid: 0, backlog: 0, lastRejection: "",
  };
  #earlier = { ...this.counts };

  /** A stream opened: its acknowledgements begin at 0. */
  opened(): void {
    this.#earlier = { ...this.counts };
  }

  sent(replaced: number): void {
    ++this.counts.sent;
    this.counts.conflated += replaced;
  }

  acknowledged(ack: SampleAck): void {
    const earlier = this.#earlier;
    Object.assign(this.counts, {
      accepted: earlier.accepted + Number(ack.accepted),
      rejectedOld: earlier.rejectedOld + Number(ack.rejectedOld),
      rejectedInvalid: earlier.rejectedInvalid + Number(ack.rejectedInvalid),
      backlog: earlier.backlog + Number(ack.conflatedBacklog),
      lastRejection: ack.lastRejection,
    });
  }
}
