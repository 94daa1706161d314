#!/usr/bin/env python3
"""Writes contacts.json: contacts and proxies that the clients in every language must compute.

    python3 tests/client/make_contacts.py > tests/client/contacts.json

Needs python3-mpmath. Nothing of hapticd is used. With 50 digits a gap is a distance of points that
chains of rotations place; its derivatives are differences of it. A proxy is where the energy's
derivative is 0 with a set of touched contacts that holds, found by trying the sets.
"""

import itertools
import json

import mpmath as mp

mp.mp.dps = 50
STEP = mp.mpf(10) ** -14
RIGID = "rigid"


def turn(v: mp.matrix, axis: mp.matrix, angle: mp.mpf) -> mp.matrix:
    """v turned about an axis of length 1."""
    cross = mp.matrix([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return v + mp.sin(angle) * (cross * v) + (1 - mp.cos(angle)) * (cross * cross * v)


def position(tool: dict, x: list, x_told: list) -> mp.matrix:
    """Of the tool's point at x; a chain's axes are those at x_told."""
    first = tool["first"]
    if tool["kind"] == "itself":
        return mp.matrix(x[first:first + 3])
    if tool["kind"] == "finger":
        at, angle = mp.mpc(0), mp.mpf(0)
        for k in range(tool["phalanx"] + 1):
            angle += x[first + k]
            last = k == tool["phalanx"]
            bone = mp.mpc(tool["along"], -tool["palmar"]) if last else mp.mpc(tool["lengths"][k])
            at += bone * mp.expj(-angle)
        return mp.matrix([at.real, at.imag, 0])
    if tool["kind"] == "pose":
        half = mp.matrix(x[first + 3:first + 7])
        half /= mp.norm(half)
        sine = mp.norm(half[:3])
        axis = half[:3] / sine if sine else mp.matrix([1, 0, 0])
        return mp.matrix(x[first:first + 3]) + turn(mp.matrix(tool["offset"]), axis,
                                                    2 * mp.atan2(sine, half[3]))
    at = mp.matrix(tool["point"])
    for k in reversed(range(len(tool["joints"]))):  # from the tip: axes further in stand still
        joint, by = tool["joints"][k], x[first + k] - x_told[first + k]
        axis, origin = mp.matrix(joint["axis"]), mp.matrix(joint["origin"])
        at = at + by * axis if joint["prismatic"] else origin + turn(at - origin, axis, by)
    return at


def gap(contact: dict, x: list, x_told: list) -> mp.mpf:
    thing = contact["object"]
    away = position(contact["tool"], x, x_told) - mp.matrix(thing["centre"])
    axis = mp.matrix(thing["axis"])
    if thing["shape"] == "wall":
        return (axis.T * away)[0]
    if thing["shape"] == "rod":
        away = away - (axis.T * away)[0] * axis
    distance, radius = mp.norm(away), mp.mpf(thing["radius"])
    return distance - radius if radius > 0 else -radius - distance


def count(tool: dict) -> int:
    """Coordinates of the tool."""
    return {"itself": 3, "pose": 7, "finger": tool.get("phalanx", 0) + 1,
            "joints": len(tool.get("joints", []))}[tool["kind"]]


def moved(x: list, *by: tuple) -> list:
    x = list(x)
    for i, sign in by:
        x[i] += sign * STEP
    return x


def slopes(contact: dict, x: list, x_told: list) -> list:
    first = contact["tool"]["first"]
    return [(gap(contact, moved(x, (i, 1)), x_told) - gap(contact, moved(x, (i, -1)), x_told)) /
            (2 * STEP) if first <= i < first + count(contact["tool"]) else mp.mpf(0)
            for i in range(len(x))]


def told(contact: dict, told_x: list, coupling: float) -> dict:
    """The contact as the server takes it; one of an object whose direction is not said must be of a
    point whose coordinates are its own, so that the slope is the normal."""
    x, first, n = [mp.mpf(v) for v in told_x], contact["tool"]["first"], count(contact["tool"])
    here, slope = gap(contact, x, x), slopes(contact, x, x)
    bend = [sum(a * b * gap(contact, moved(x, (first + i, a), (first + j, b)), x)
                for a in (1, -1) for b in (1, -1)) / (4 * STEP * STEP)
            for i in range(n) for j in range(i + 1)]
    flat = max(map(abs, bend)) < mp.mpf(10) ** -18
    stiffness, c = contact["stiffness"], mp.mpf(coupling)
    return {
        "normal": [-v for v in slope], "offset": here - sum(s * v for s, v in zip(slope, x)),
        "compliance": 0.0 if stiffness == RIGID else c / stiffness,
        "velocity": contact["velocity"], "curvature": [] if flat else bend,
        "first_coordinate": first, "id": contact["id"],
        **{name: contact[name] / c for name in ("mass", "damping", "ground_stiffness", "load")},
        "uncertainty": contact["uncertainty"], "object": contact["on"],
        "object_direction": contact["direction"] or (slope if contact["on"] else []),
    }


def proxy(contacts: list, probe: list, start: list, weights: list, coupling: float) -> list:
    """Of all x at which the energy is stationary, the one that is nearest to the start."""
    n, c, found = len(probe), mp.mpf(coupling), []
    probe, start = [mp.mpf(v) for v in probe], [mp.mpf(v) for v in start]
    inside = [i for i, contact in enumerate(contacts) if gap(contact, start, start) < 0.001]
    sets = [s for k in range(len(contacts) + 1) for s in itertools.combinations(
        range(len(contacts)), k)] if len(contacts) < 6 else [tuple(inside)]
    for touched in sets:
        for _ in range(12):
            answer = stationary(contacts, touched, probe, start, weights, c)
            if answer is None:
                break
            x, forces = answer
            holds = tuple(i for i, contact in enumerate(contacts)
                          if (forces[i] > 0 if i in touched else gap(contact, x, x) < 0))
            if holds == touched:
                found.append(x)
            if holds == touched or len(contacts) < 6:
                break
            touched = holds
    assert found, "no set of contacts holds"
    return min(found, key=lambda x: sum((a - b) ** 2 for a, b in zip(x, start)))[:n]


def stationary(contacts: list, touched: tuple, probe: list, start: list, weights: list,
               c: mp.mpf) -> tuple | None:
    """x, and the force of each touched contact; the unknowns are both."""
    n = len(probe)

    def off(*z: mp.mpf) -> list:
        x, forces = list(z[:n]), dict(zip(touched, z[n:]))
        pull = [c * w * (a - p) for w, a, p in zip(weights, x, probe)]
        lacks = []
        for i, force in forces.items():
            pull = [f - force * s for f, s in zip(pull, slopes(contacts[i], x, x))]
            depth, stiffness = -gap(contacts[i], x, x), contacts[i]["stiffness"]
            lacks.append(depth if stiffness == RIGID else force / stiffness - depth)
        return pull + lacks

    try:
        z = mp.findroot(off, [*start, *(c * mp.mpf("0.01") for _ in touched)],
                        tol=mp.mpf(10) ** -40, maxsteps=60)
    except (ValueError, ZeroDivisionError):
        return None
    return list(z[:n]), dict(zip(touched, list(z)[n:]))


def ball(*centre: float, radius: float) -> dict:
    return {"shape": "ball", "centre": centre, "axis": (0.0, 0.0, 1.0), "radius": radius}


def rod(*centre: float, radius: float, axis: tuple = (0.0, 0.0, 1.0)) -> dict:
    return {"shape": "rod", "centre": centre, "axis": axis, "radius": radius}


def wall(*centre: float, axis: tuple) -> dict:
    return {"shape": "wall", "centre": centre, "axis": axis, "radius": 0.0}


def contact(tool: dict, thing: dict, stiffness: float | str = RIGID, **more: object) -> dict:
    return {"tool": {"first": 0, **tool}, "object": thing, "stiffness": stiffness, "velocity": 0.0,
            "id": 0, "mass": 0.0, "damping": 0.0, "ground_stiffness": 0.0, "load": 0.0,
            "uncertainty": None, "on": 0, "direction": [], **more}


SKEW = (0.36, 0.48, 0.8)
CHAIN = {"kind": "joints", "first": 1, "point": (0.13, 0.06, 0.08), "joints": [
    {"origin": (0.0, 0.0, 0.3), "axis": (0.0, 0.0, 1.0), "prismatic": False},
    {"origin": (0.0, 0.0, 0.0), "axis": (0.6, 0.8, 0.0), "prismatic": True},
    {"origin": (0.1, 0.04, 0.05), "axis": SKEW, "prismatic": False}]}
ITSELF = {"kind": "itself"}
PUSHED = {"id": 7, "velocity": -0.1, "mass": 0.75, "damping": 3.0, "ground_stiffness": 375.0,
          "load": -1.5}
POSE = [0.01, 0.02, 0.03, 0.1, -0.2, 0.3, 0.86 ** 0.5]


def finger(phalanx: int, along: float, palmar: float = 0.008, first: int = 0) -> dict:
    return {"kind": "finger", "lengths": (0.045, 0.03), "phalanx": phalanx, "along": along,
            "palmar": palmar, "first": first}


def planes() -> list:
    near, cases = ball(0.06, 0.01, 0.02, radius=0.02), []
    for x, tool in (([9.0, 0.4, 0.05, -0.7], CHAIN), ([9.0, 0.4, 0.8], finger(0, 0.015, first=1)),
                    ([0.4, 0.8, 0.3], finger(2, 0.015)), ([9.0, 0.01, 0.02, 0.03],
                                                         {**ITSELF, "first": 1}),
                    ([9.0, *POSE], {"kind": "pose", "offset": (0.03, -0.02, 0.05), "first": 1}),
                    ([1.25 * v for v in POSE], {"kind": "pose", "offset": (0.03, -0.02, 0.05)})):
        for thing in (near, rod(0.06, 0.01, 0.02, radius=0.02, axis=SKEW),
                      ball(0.06, 0.01, 0.02, radius=-0.5), wall(0.0, 0.0, -0.01, axis=SKEW)):
            cases.append((contact(tool, thing, 400.0, id=7, uncertainty=0.25), x, 0.02))
    here = [0.01, 0.02, 0.07]
    cases += [(contact(ITSELF, near, 400.0, **PUSHED), here, 1500.0), (contact(ITSELF, near), here,
                                                                       1500.0),
              (contact(ITSELF, wall(0.0, 0.0, 0.0, axis=SKEW), 1e4, **PUSHED, on=4,
                       direction=[0.0, 1.0]), here, 1500.0),
              (contact(ITSELF, near, 400.0, **PUSHED, on=4), here, 1500.0)]
    return [{"x": x, "coupling": c, "contact": a, "plane": told(a, x, c)} for a, x, c in cases]


def grasp() -> list:
    """A soft finger closes on a rod, a step after the other."""
    pads = [contact(finger(k, length * i / 6), rod(0.045, -0.052, 0.0, radius=0.025), 400.0,
                    id=6 * k + i) for k, length in enumerate((0.045, 0.04)) for i in range(1, 7)]
    steps, x = [], [0.5, 0.6]
    for i in range(6):
        probe = [0.55 + 0.05 * i, 0.65 + 0.06 * i]
        steps.append(("soft finger", pads, probe, x, [1.0, 1.0], 0.02))
        x = [float(v) for v in proxy(*steps[-1][1:])]
    return steps


def solved() -> list:
    tip = {"kind": "pose", "offset": (0.0, 0.0, -0.1)}
    corner = [contact(ITSELF, wall(0.0, 0.0, 0.0, axis=axis), stiffness) for axis, stiffness in (
        ((0.0, 0.0, 1.0), RIGID), ((0.8, 0.6, 0.0), RIGID), ((-0.6, 0.8, 0.0), 900.0))]
    floor, one = wall(0.0, 0.0, -0.05, axis=(0.0, 0.0, 1.0)), [1.0] * 3
    two = [contact(finger(1, 0.03), rod(0.05, -0.03, 0.0, radius=0.02), 800.0),
           contact(finger(1, 0.03, first=2), rod(0.05, -0.03, 0.0, radius=0.02))]
    upright = [0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 1.0]
    cases = [
        ("rigid ball", [contact(ITSELF, ball(0.0, 0.0, 0.0, radius=0.03))],
         [0.004, 0.002, -0.001], [0.0, 0.0, 0.035], one, 100.0),
        ("soft ball", [contact(ITSELF, ball(0.0, 0.0, 0.0, radius=0.03), 400.0)],
         [0.01, 0.02, 0.005], [0.02, 0.03, 0.0], one, 100.0),
        ("hollow ball", [contact(ITSELF, ball(0.0, 0.0, 0.0, radius=-0.03))],
         [0.03, 0.02, 0.01], [0.0, 0.0, 0.01], one, 100.0),
        ("corner", corner, [-0.02, -0.03, -0.01], [0.01, 0.03, 0.01], one, 300.0),
        ("corner in a metric", corner, [-0.02, -0.03, -0.01], [0.01, 0.03, 0.01],
         [1.0, 4.0, 0.25], 300.0),
        ("nothing touched", corner, [0.0, 0.03, 0.01], [0.01, 0.03, 0.01], one, 300.0),
        ("stylus", [contact(tip, floor, 2000.0)], [0.01, 0.0, 0.035, 0.1, 0.0, 0.0, 0.99 ** 0.5],
         upright, [1.0, 1.0, 1.0, 0.01, 0.01, 0.01, 0.01], 500.0),
        ("two fingers", two, [0.4, 0.35, 0.42, 0.3], [0.1] * 4, [1.0] * 4, 0.05),
        *grasp(),
    ]
    return [{"name": name, "contacts": contacts, "x_probe": probe, "start": start,
             "weights": weights, "coupling": c, "x": proxy(contacts, probe, start, weights, c)}
            for name, contacts, probe, start, weights, c in cases]


HORIZONS = [{"round_trip_s": a, "period_s": b, "v_max": v, "metres": m} for a, b, v, m in (
    (0.1, 0.02, 0.5, 0.06), (0.1, 0.02, 0.3, 0.036), (0.0, 0.0, 0.5, 0.1))]


def main() -> None:
    rows = []
    for name, cases in (("planes", planes()), ("solve", solved()), ("horizon", HORIZONS)):
        lines = ",\n".join(json.dumps(case, default=float) for case in cases)
        rows.append(f'"{name}": [\n{lines}\n]')
    print("{" + ",\n".join(rows) + "}")


main()
