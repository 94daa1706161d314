#!/usr/bin/env python3
"""Judges what an observer saw by the contract of proto/README.md#staleness-and-gain.

    contract.py COMMAND FILE [ARGUMENT]

FILE holds lines of `hapticctl watch --json`, from shortly before the trouble. Commands:

    pressing    the last line shows force, engaged
    silence     samples stopped under force: the elastic force is zero within 200 ms of the last,
                and stays there until force is asked for again
    ramp        after the silence force came back by a ramp of the gain: no more than 1 per 200 ms
    closing     force was fading out, or gone, in the last state
    transport NAME    samples came by NAME and force was on meanwhile
    only NAME   all force came by NAME, for at least two seconds
    safe        no elastic force from LOST on, and the gain never rises faster than 1 per 200 ms
    quiet SECONDS     the proxy was lost that long ago: `silence` has what it needs
    spans SECONDS     the records are that long

Times are by the server's clock, which is part of every state. Ends with 0: as promised; 1: not; 3:
the records cannot tell, because this machine was too busy.
"""

import json
import sys

LIMIT_S = 0.200
RAMP_PER_S = 1 / 0.200
FELT_N = 0.5


def force(state: dict) -> float:
    return max(map(abs, state["tau_elastic"]), default=0.0)


def seconds(state: dict) -> float:
    return state["server_time_ns"] * 1e-9


def fail(message: str) -> None:
    sys.exit(f"contract.py: {message}")


def cannot_tell(message: str) -> None:
    print(f"contract.py: not resolvable: {message}", file=sys.stderr)
    sys.exit(3)


def last_loss(states: list[dict]) -> int | None:
    """Index of the last loss of the proxy. A busy machine may have lost it before the trouble
    began, too."""
    lost = [s["staleness"] == "LOST" for s in states]
    return next((i for i in reversed(range(len(states))) if lost[i] and not (i and lost[i - 1])),
                None)


def silence(states: list[dict]) -> None:
    # The last sample before a silence of more than fade_end (180 ms): its time is the state's minus
    # its age.
    lost = last_loss(states)
    if lost is None:
        fail("the proxy was never lost")
    fresh = [i for i, s in enumerate(states[:lost]) if s["staleness"] == "FRESH"]
    if not fresh:
        cannot_tell("no fresh sample before the silence")
    last = fresh[-1]
    if max(force(states[i]) for i in fresh[-25:]) < FELT_N:
        cannot_tell("there was no force to lose")
    last_sample = seconds(states[last]) - states[last]["proxy_age_us"] * 1e-6
    zero = next((i for i in range(last + 1, len(states)) if force(states[i]) == 0), None)
    if zero is None or seconds(states[zero - 1]) - last_sample > LIMIT_S:
        fail(f"there was force more than {LIMIT_S * 1e3:.0f} ms after the last sample")
    # The first state without force bounds the time from above; states come every 4 ms.
    took = seconds(states[zero]) - last_sample
    if took > LIMIT_S:
        blind = seconds(states[zero]) - seconds(states[zero - 1])
        cannot_tell(f"the observer saw nothing for {blind * 1e3:.0f} ms")
    disengaged = False
    for state in states[zero:]:
        engaged = state["state"] in ("ENGAGING", "ENGAGED")
        if engaged and disengaged:
            break  # force was asked for again
        disengaged = disengaged or not engaged
        if force(state) > 0:
            fail(f"force came back in {state['state']}")
    print(f"force was zero {took * 1e3:.0f} ms after the last sample")


def no_jump(states: list[dict]) -> None:
    for a, b in zip(states, states[1:]):
        allowed = (seconds(b) - seconds(a)) * RAMP_PER_S + 1e-6
        if b["gain"] - a["gain"] > allowed:
            fail(f"the gain rose by {b['gain'] - a['gain']:.3f}, {allowed:.3f} is allowed")


def safe(states: list[dict]) -> None:
    no_jump(states)
    for state in states:
        if state["staleness"] == "LOST" and force(state) > 0:
            fail(f"{force(state):.2f} N although the proxy was lost")
        if state["faults"]:
            fail(f"fault {state['faults']}")
    lost = [s["staleness"] == "LOST" for s in states]
    losses = sum(b and not a for a, b in zip(lost, lost[1:]))
    print(f"{seconds(states[-1]) - seconds(states[0]):.1f} s, force lost {losses} times")


def ramp(states: list[dict]) -> None:
    lost = next((i for i, s in enumerate(states) if s["staleness"] == "LOST"), None)
    if lost is None:
        fail("there was no silence")
    back = next((i for i, s in enumerate(states[lost:], lost) if s["state"] == "ENGAGED"), None)
    if back is None:
        fail("force did not come back")
    no_jump(states[lost : back + 1])
    took = seconds(states[back]) - seconds(states[lost])
    print(f"force came back over {took:.2f} s after its loss")


def closing(states: list[dict]) -> None:
    last = states[-1]
    if max(map(force, states)) < FELT_N:
        cannot_tell("there was no force to take back")
    # The stream ends with the server: its last state may be a few milliseconds before g = 0 (80 ms
    # from 1).
    if last["state"] not in ("RELEASING", "CLOSING") or last["gain"] > 0.15:
        cannot_tell(f"the last state that came is {last['state']}, its gain {last['gain']:.3f}")
    print(f"force faded out; {force(last):.2f} N in the last state that was sent")


def only(states: list[dict], carrier: str) -> None:
    felt = [s for s in states if force(s) > FELT_N]
    others = sorted({s["transport"] for s in felt} - {carrier})
    if others:
        fail(f"force by {', '.join(others)}, not by {carrier} alone")
    if not felt or seconds(felt[-1]) - seconds(felt[0]) < 2:
        fail("not yet two seconds of force")
    print(f"force up to {max(map(force, felt)):.1f} N, all by {carrier}")


def quiet(states: list[dict], least_s: str) -> None:
    lost = last_loss(states)
    if lost is None or seconds(states[-1]) - seconds(states[lost]) < float(least_s):
        fail("not yet")


def spans(states: list[dict], least_s: str) -> None:
    if seconds(states[-1]) - seconds(states[0]) < float(least_s):
        fail("not yet")


def pressing(states: list[dict]) -> None:
    last = states[-1]
    if last["state"] != "ENGAGED" or force(last) <= FELT_N:
        fail(f"{last['state']}, {force(last):.2f} N")


def transport(states: list[dict], carrier: str) -> None:
    if not any(s["transport"] == carrier and force(s) > FELT_N for s in states):
        fail(f"no force by {carrier}; seen: {sorted({s['transport'] for s in states})}")
    print(f"force by {carrier}")


COMMANDS = {judge.__name__: judge for judge in (
    pressing, silence, ramp, closing, transport, only, safe, quiet, spans)}


def main() -> None:
    command, file, *arguments = sys.argv[1:]
    with open(file, encoding="utf-8") as lines:
        texts = [line for line in lines if line.startswith("{") and line.endswith("}\n")]
    if not texts:
        fail("no states to judge")
    COMMANDS[command]([json.loads(line) for line in texts], *arguments)


if __name__ == "__main__":
    main()
