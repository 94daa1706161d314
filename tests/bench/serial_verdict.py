"""Judges a run over a serial link: rate, age of samples, and what became of every frame
(hw/README.md#the-board-protocol).

Frames are counted at both ends. Up, the board numbers what it makes: the numbers that the host
missed are `lost`, and each must stand in a counter as well, damaged on the way or never sent for
want of room. Down, what the host sent must be what the board counted, taken or refused.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from verdict import Verdict, quantile

RATE_HZ, RATE_WITHIN = 1010.0, 0.01  # 1000 samples and 10 times its counters
IN_FLIGHT = 3  # frames that the port may still hold when the last one closes it


@dataclasses.dataclass(frozen=True)
class Run:
    seconds: float  # between the first reading and the last
    frames: int  # from the board in that time
    ages: Sequence[tuple[float, int]]  # of samples in that time: (upper bound in s, ticks in all up
    # to it), +inf last
    host: Mapping[str, int]  # of the whole run, as the host's last word
    board: Mapping[str, int]  # the same of the board
    faults: Mapping[str, int]  # times each fault latched


def verdicts(run: Run, target_ms: float) -> list[Verdict]:
    return [rate(run), age(run, target_ms), up(run), down(run), undisturbed(run)]


def rate(run: Run) -> Verdict:
    hz = run.frames / run.seconds
    return Verdict(
        "rate",
        abs(hz / RATE_HZ - 1) <= RATE_WITHIN,
        f"{hz:.1f} frames/s from the board, {RATE_HZ:.0f} within {RATE_WITHIN:.0%} wanted",
    )


def age(run: Run, target_ms: float) -> Verdict:
    p50, p99 = (1e3 * quantile(run.ages, share) for share in (0.5, 0.99))
    return Verdict(
        "sample age",
        p99 <= target_ms,
        f"p50 {p50:.2f} ms, p99 {p99:.2f} ms of {run.ages[-1][1]} ticks; "
        f"target p99 <= {target_ms:g} ms",
    )


def up(run: Run) -> Verdict:
    """Noise between two frames counts as damage without a loss, so `counted` may be larger."""
    counted = (
        run.board["without_room"]
        + run.host["bad_crc"]
        + run.host["malformed"]
        + run.host["not_newer"]
    )
    return Verdict(
        "frames up",
        run.host["lost"] <= counted,
        f"{run.host['received']} received, {run.host['lost']} lost; "
        f"{run.board['without_room']} had no room, "
        f"{run.host['bad_crc']} bad CRC, {run.host['malformed']} malformed, "
        f"{run.host['not_newer']} not newer",
    )


def down(run: Run) -> Verdict:
    reasons = ("bad_crc", "malformed", "not_newer", "wrong_nonce")
    missing = run.host["sent"] - run.board["accepted"] - sum(run.board[r] for r in reasons)
    return Verdict(
        "frames down",
        0 <= missing <= IN_FLIGHT,
        f"{run.host['sent']} sent, {run.board['accepted']} accepted, "
        + ", ".join(f"{run.board[r]} {r}" for r in reasons)
        + f"; without a reason: {missing} (in flight at the end: at most {IN_FLIGHT}); "
        f"held back by a busy port: {run.host['held_back']}",
    )


def undisturbed(run: Run) -> Verdict:
    stops = run.board["watchdog_stops"]
    faults = {name: n for name, n in run.faults.items() if n}
    return Verdict(
        "undisturbed",
        stops == 0 and not faults,
        f"{stops} stops by the board's watchdog, faults {faults}",
    )
