"""The wires rig by SciPy's solve_ivp with terminal events.

Usage: scipy_peer.py CELLS.csv OUT EVERY   (every EVERY-th cell; writes OUT/scipy.csv, OUT/scipy.json)
"""

import csv
import json
import math
import sys
import time

import scipy
from scipy.integrate import solve_ivp

A0, L, G, M, KI, CI = 0.89e-3, 0.075, 9.81, 0.298, 5.5e6, 1.2e3
CYCLES, RECORDED = 300, 100
RTOL, ATOL = 1e-6, 1e-8
# Where a contact's force is looked at, over each piece.
LOOKS = 64


def simulate(gap, hz):
    omega, period = 2 * math.pi * hz, 1 / hz

    def force(y):
        return KI * (L * math.sin(y[0]) - gap) + CI * L * y[1] * math.cos(y[0])

    def flight(t, y):
        s, c = math.sin(y[0]), math.cos(y[0])
        return (y[1], (A0 * omega * omega * c * math.sin(omega * t) - G * s) / L)

    def contact(t, y):
        v, a = flight(t, y)
        return (v, a - force(y) / (M * L))

    def onset(_, y):
        return min(KI * (L * math.sin(y[0]) - gap), force(y))

    def release(_, y):
        return force(y)

    onset.terminal = release.terminal = True
    onset.direction, release.direction = 1, -1

    t, y, touching = 0.0, (0.0, 0.0), False
    strobes = []
    for cycle in range(1, CYCLES + 1):
        end, onsets, peak = cycle * period, 0, 0.0
        while t < end:
            # What begins on the far side of its switch has no crossing to find.
            if not touching and onset(t, y) > 1e-6:
                touching, onsets = True, onsets + 1
            piece = solve_ivp(
                contact if touching else flight,
                (t, end),
                y,
                method="DOP853",
                rtol=RTOL,
                atol=ATOL,
                max_step=period / 16,
                first_step=min(1e-5, end - t),
                events=release if touching else onset,
                dense_output=touching,
            )
            t1, y1 = piece.t[-1], piece.y[:, -1]
            if touching:
                for k in range(LOOKS + 1):
                    peak = max(peak, force(piece.sol(t + (t1 - t) * k / LOOKS)))
            if piece.status == 1:
                touching = not touching
                onsets += touching
            if t1 == t:
                t1 = t + 1e-12
            t, y = t1, tuple(y1)
        if cycle >= CYCLES - RECORDED:
            strobes.append((y[0], y[1], onsets, peak))
        t = end
    return strobes


def main():
    cells_file, out, every = sys.argv[1], sys.argv[2], int(sys.argv[3])
    with open(cells_file) as f:
        cells = [(float(r["gap_mm"]) * 1e-3, float(r["frequency_hz"])) for r in csv.DictReader(f)]
    chosen = range(0, len(cells), every)
    start = time.process_time()
    found = {i: simulate(*cells[i]) for i in chosen}
    cpu = time.process_time() - start
    with open(f"{out}/scipy.csv", "w") as f:
        f.write("cell,q,v,onsets,force_n\n")
        for i, strobes in found.items():
            for q, v, onsets, peak in strobes:
                f.write(f"{i},{float(q)!r},{float(v)!r},{onsets},{float(peak)!r}\n")
    with open(f"{out}/scipy.json", "w") as f:
        name = f"SciPy {scipy.__version__}, solve_ivp DOP853, events, 1e-6"
        json.dump({"name": name, "cycles": len(chosen) * CYCLES, "cpu_s": cpu}, f)


main()
