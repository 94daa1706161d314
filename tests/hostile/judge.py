"""What a row says of the daemon: the recording of every tick, memory, stops, and the verdict."""

import csv
import dataclasses
import math
import random
import statistics

from daemon import FORCE, MB, SLEW, STOP

GROWTH_MB, SERVED_S, TERM_S, REGAINED_S = 1.0, 1.0, 5.0, 3.0
RAMP_S, HOLD_S, FADE_S, SILENT_S = 0.2, 0.1, 0.18, 0.2  # proto/README.md#staleness-and-gain
TINY, GAIN_STEP = 1e-9, 1e-4
DEADLINES = "deadlines skipped"
ARMED = ("ARMED", "ENGAGING", "ENGAGED", "RELEASING")


@dataclasses.dataclass
class Tick:
    at: int  # ns, CLOCK_MONOTONIC
    seq: int
    state: str
    mode: str
    faults: str
    age: float  # s
    gain: float
    elastic: float
    tau: float
    skipped: int


def number(cell):
    return float(cell) if cell else 0.0


def read_record(file):
    """The ticks of a recording of the finger; a last row that is cut off is left out."""
    ticks = []
    with open(file, newline="", encoding="utf-8", errors="replace") as stream:
        rows = csv.reader(stream)
        header = next(rows, [])
        column = {name: i for i, name in enumerate(header)}
        for row in rows:
            if len(row) != len(header):
                continue
            f = dict((name, row[i]) for name, i in column.items())
            ticks.append(Tick(
                int(f["server_time_ns"]), int(f["seq"]), f["state"], f["mode"], f["faults"],
                1e-6 * number(f["proxy_age_us"]), number(f["gain"]),
                number(f["tau_elastic_l_x_n"]), number(f["tau_a_l_x_n"]), int(f["skipped"] or 0)))
    return ticks


def only_taken(before, now):
    return abs(now) <= abs(before) + TINY and before * now >= -TINY


def ladder(age):
    return min(1.0, max(0.0, (FADE_S - age) / (FADE_S - HOLD_S)))


def wrong_force(before, now):
    """What no tick may do after the one before it; empty: nothing."""
    dt = 1e-9 * (now.at - before.at)
    values = (now.age, now.gain, now.elastic, now.tau)
    if dt <= 0.0 or now.seq <= before.seq or not all(map(math.isfinite, values)):
        return "a tick out of order, or not finite"
    fault = bool(now.faults) or now.state == "FAULT"
    if fault and before.faults and (now.tau or now.elastic):
        return f"{now.tau:g} N in a fault"
    step, most = now.tau - before.tau, SLEW * dt + TINY
    if abs(step) > most:
        damping = step - (now.elastic - before.elastic)
        envelope = (abs(now.elastic) >= now.gain * FORCE - TINY and
                    only_taken(before.elastic, now.elastic) and abs(damping) <= most)
        idle = now.state not in ARMED and abs(before.elastic) <= TINY
        if not envelope and not ((fault or idle) and only_taken(before.tau, now.tau)):
            return f"force changed by {step:.2f} N in {1e3 * dt:.1f} ms"
    if now.gain - before.gain > dt / RAMP_S + TINY:
        return f"gain rose from {before.gain:.3f} to {now.gain:.3f}"
    if abs(now.elastic) > now.gain * FORCE + TINY:
        return f"elastic force {now.elastic:.2f} N at gain {now.gain:.3f}"
    if now.mode not in ("", "NONE"):
        if now.gain > ladder(now.age) + GAIN_STEP:
            return f"gain {now.gain:.3f} at an age of {1e3 * now.age:.0f} ms"
        if now.age >= SILENT_S and now.elastic:
            return f"{now.elastic:.2f} N after {1e3 * now.age:.0f} ms of silence"
    elif now.elastic and not before.elastic:
        return "elastic force without a proxy"
    return ""


def judge_ticks(ticks, caused=()):
    """(what was wrong with force, faults that the row did not cause)."""
    force, faults = "", set()
    for before, now in zip(ticks, ticks[1:]):
        force = force or wrong_force(before, now)
        faults.update(f for f in now.faults.split("|") if f and f != "NONE" and f not in caused)
    return force, sorted(faults)


def skipped(ticks, begin, end):
    """Deadlines skipped between two times of the monotonic clock, s."""
    return sum(t.skipped for t in ticks if begin <= 1e-9 * t.at < end)


def losses(ticks, begin, end):
    """Times force was given up."""
    return sum(1 for a, b in zip(ticks, ticks[1:])
               if begin <= 1e-9 * b.at < end and a.state in ("ENGAGING", "ENGAGED") and
               b.state in ("ARMED", "IDLE", "RELEASING"))


@dataclasses.dataclass
class Measured:
    """Of one row. Times in s, memory in bytes."""
    wrong: list = dataclasses.field(default_factory=list)  # what the attack itself saw
    notes: list = dataclasses.field(default_factory=list)
    sent: int = 0
    seconds: float = 0.0
    before: int = 0
    owner: int = 0
    front: int = 0
    front_limit: int | None = None
    stops: list = dataclasses.field(default_factory=list)
    quiet_stops: list = dataclasses.field(default_factory=list)
    unanswered: list = dataclasses.field(default_factory=list)  # stops: why not
    punctual: bool = False
    served: float | None = 0.0
    regained: float | None = 0.0
    term: float = 0.0
    status: int = 0
    died: str = ""
    force: str = ""
    faults: list = dataclasses.field(default_factory=list)
    lost: int = 0
    false_alarm: bool = False  # a front that lived was taken for one that hangs
    quiet_skipped: int = 0
    skipped: int = 0
    realtime: bool = False
    alone: bool = False  # the row runs daemons of its own and judges them itself

    @property
    def growth_mb(self):
        return max(0.0, (self.owner - self.before) / MB)


def late_stop(stops):
    """The percentile of these that must keep the limit."""
    return sorted(stops)[min(len(stops) - 1, int(STOP.share * len(stops)))] if stops else 0.0


def median_interval(values, rounds=2_000, seed=1):
    """The median, and the 95 % interval of it by bootstrap."""
    chance = random.Random(seed)
    medians = sorted(statistics.median(chance.choices(values, k=len(values)))
                     for _ in range(rounds))
    return statistics.median(values), medians[rounds // 40], medians[-1 - rounds // 40]


def skips_allowed(quiet):
    """So many in the row's attack if `quiet` were skipped in as long a time without: four standard
    deviations of the difference of two Poisson counts, and one stall of a virtual machine."""
    return quiet + 4.0 * math.sqrt(2.0 * quiet + 1.0) + 10.0


def failures(m, grows=GROWTH_MB):
    """Everything that must not be, in words."""
    found = list(m.wrong)
    if m.alone:
        return found
    if m.died:
        found.append(m.died)
    if m.growth_mb > grows:
        found.append(f"owner grew by {m.growth_mb:.1f} MB")
    if m.front and m.front_limit and m.front > m.front_limit:
        found.append(f"front has {m.front / MB:.0f} MB, its limit is {m.front_limit / MB:.0f}")
    if m.front and not m.front_limit:
        found.append("front without RLIMIT_DATA")
    if m.served is None:
        found.append("not served again")
    elif m.served > SERVED_S:
        found.append(f"served again after {m.served:.1f} s")
    if m.unanswered:
        found.append(f"{len(m.unanswered)} local stops without answer ({m.unanswered[0][:80]})")
    late = late_stop(m.stops)
    if m.punctual and late > max(STOP.limit_s, 1.5 * late_stop(m.quiet_stops)):
        found.append(f"local stop took {1e3 * late:.0f} ms")
    if m.force:
        found.append(m.force)
    if m.faults:
        found.append("fault " + " ".join(m.faults))
    if m.regained is None:
        found.append("no force again")
    elif m.regained > REGAINED_S:
        found.append(f"force again after {m.regained:.1f} s")
    if m.realtime and m.skipped > skips_allowed(m.quiet_skipped):
        found.append(f"{m.skipped} {DEADLINES}, {m.quiet_skipped} without the attack")
    if m.false_alarm:
        found.append("a front that lived was taken for one that hangs")
    if m.term > TERM_S:
        found.append(f"SIGTERM took {m.term:.1f} s")
    if m.status not in (0, None) and not m.died:
        found.append(f"hapticd ended with {m.status}")
    return found
