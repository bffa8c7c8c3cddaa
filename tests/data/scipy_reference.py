#!/usr/bin/env python3
"""Independent reference values for the vibro-impact model, computed with SciPy.

Run (about four minutes on two idle cores; writes scipy_reference.json beside this file):

    python3 -m venv /tmp/scipyref && /tmp/scipyref/bin/pip install numpy==2.4.6 scipy==1.17.1
    /tmp/scipyref/bin/python scipy_reference.py            # everything, two processes
    /tmp/scipyref/bin/python scipy_reference.py --check    # cross-checks only, writes nothing

Written with Python 3.11.7, numpy 2.4.6, scipy 1.17.1 (the versions used are stored in the JSON).

Method.  scipy.integrate.DOP853, rtol 1e-12, restarted at every contact onset, every release and every
drive period (time is the time since the last drive phase 0, so the phase never grows).  The solver is
stepped here rather than through solve_ivp, because solve_ivp tests an event at step ends only and so
cannot see two crossings inside one step; the steps and the dense output are SciPy's.  `--check` repeats
a case with solve_ivp and its own events, once with DOP853 and once with Radau.

Contact is indicator = min(ki*delta, F) > 0: touching and pushing.  Spring-dashpot contact ends when F falls
to 0 with delta still positive; the free motion that follows is left again when the indicator rises through
0, which is delta rising through 0, or F rising through 0 while delta is still positive (then the signed
speed at onset is negative: the mass is still moving out, and is pushed back before it is out).
Events are located by brentq on the dense output; a step inside which delta or F has an extremum is searched
for a double crossing; the first step after a release is a tenth of the predicted hop.
"""
import argparse
import json
import math
import os
import platform
import sys

for _v in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_v, "1")

import numpy as np
import scipy
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq, minimize_scalar

# ----------------------------------------------------------------------------------------------- parameters
M_HAMMER = 0.298       # kg
A0 = 0.89e-3           # m
WIRE_L = 0.075         # m
GRAV = 9.81            # m/s2
ZETA = 0.004
KI, CI = 5.5e6, 1.2e3  # N/m, N s/m  (spring-dashpot)
OMEGA_HZ = {"wires": 1.82, "beam-170": 4.50, "beam-150": 5.25, "beam-135": 6.50}

# Numerical settings: "tight" makes the values, "loose" is run as well to show how far they can be trusted.
SETTINGS = {
    "tight": dict(rtol=1e-12, flight_steps_per_period=200, contact_step_s=1e-5, late_step_s=5e-5),
    "loose": dict(rtol=1e-9, flight_steps_per_period=20, contact_step_s=1e-4, late_step_s=3e-4),
}
LATE_AFTER_S = 2e-3    # contact age after which the longer contact step is allowed
ATOL_PER_RTOL = {"wires": (1e-3, 1e-1), "beam": (1e-4, 1e-2)}   # atol = rtol * these (state 0, state 1)

TRANSIENT, WINDOW, NMAX, STICK_S = 300, 32, 16, 5e-3
SECTION_TOL = 1e-3


class Rig:
    """Free acceleration, contact kinematics and contact acceleration of one rig at one frequency and gap."""

    def __init__(self, name, gap_mm, ratio):
        self.name, self.gap_mm, self.ratio = name, gap_mm, ratio
        self.wires = name == "wires"
        self.gap = gap_mm * 1e-3
        self.f = ratio * OMEGA_HZ[name]
        self.w = 2.0 * math.pi * self.f
        self.T = 1.0 / self.f
        wn = 2.0 * math.pi * OMEGA_HZ[name]
        self.k = M_HAMMER * wn * wn
        self.c = 2.0 * ZETA * M_HAMMER * wn
        self.kappa = self.k
        sin, cos = math.sin, math.cos
        w, gap = self.w, self.gap
        if self.wires:
            L = WIRE_L
            drive, grav, push = A0 * w * w / L, GRAV / L, 1.0 / (M_HAMMER * L)

            def free(t, y):
                th, om = y[0], y[1]
                return [om, drive * cos(th) * sin(w * t) - grav * sin(th)]

            def contact(t, y):
                th, om = float(y[0]), float(y[1])
                s, co = sin(th), cos(th)
                F = KI * (L * s - gap) + CI * (L * om * co)
                return [om, drive * co * sin(w * t) - grav * s - push * F]

            def kin(y):
                th, om = float(y[0]), float(y[1])
                return L * sin(th) - gap, L * om * cos(th)

            def ddelta(y, acc):
                th, om = float(y[0]), float(y[1])
                return L * (float(acc) * cos(th) - om * om * sin(th))
        else:
            drive = A0 * w * w
            cm, km, kapm, im = self.c / M_HAMMER, self.k / M_HAMMER, self.kappa / M_HAMMER, 1.0 / M_HAMMER

            def free(t, y):
                x, v = float(y[0]), float(y[1])
                return [v, drive * sin(w * t) - cm * v - km * x - kapm * x * x * x]

            def contact(t, y):
                x, v = float(y[0]), float(y[1])
                F = KI * (x - gap) + CI * v
                return [v, drive * sin(w * t) - cm * v - km * x - kapm * x * x * x - im * F]

            def kin(y):
                return float(y[0]) - gap, float(y[1])

            def ddelta(y, acc):
                return float(acc)
        self.free, self.contact, self.kin, self.ddelta = free, contact, kin, ddelta

    def force(self, y):
        d, v = self.kin(y)
        return KI * d + CI * v

    def indicator(self, y):
        d, v = self.kin(y)
        return min(KI * d, KI * d + CI * v)

    def rates(self, y, f):
        """d(delta)/dt and dF/dt, from the state and its derivative in the present mode."""
        _, v = self.kin(y)
        return v, KI * v + CI * self.ddelta(y, f[1])

    def parameters(self):
        p = {"a0_m": A0, "contact_ci_n_s_per_m": CI, "contact_ki_n_per_m": KI, "contact_law": "spring-dashpot",
             "drive_rad_per_s": self.w, "frequency_hz": self.f, "gap_m": self.gap, "gap_mm": self.gap_mm,
             "mass_kg": M_HAMMER, "natural_frequency_hz_for_ratio": OMEGA_HZ[self.name], "ratio": self.ratio,
             "rig": self.name, "start": "rest relative to the cart at drive phase 0"}
        if self.wires:
            p.update(gravity_m_per_s2=GRAV, wire_length_m=WIRE_L, torque="literal: theta_ddot has -F/(m l)")
        else:
            p.update(damping_c_n_s_per_m=self.c, damping_ratio=ZETA, stiffness_k_n_per_m=self.k,
                     kappa_n_per_m3=self.kappa)
        return p


class Runner:
    """Integrates one case; contacts as dicts (times are cycle number plus time in that cycle)."""

    def __init__(self, rig, settings):
        s = SETTINGS[settings]
        self.rig = rig
        self.rtol = s["rtol"]
        a = ATOL_PER_RTOL["wires" if rig.wires else "beam"]
        self.atol = np.array([self.rtol * a[0], self.rtol * a[1]])
        self.flight_max = rig.T / s["flight_steps_per_period"]
        self.c_max, self.c_late = s["contact_step_s"], s["late_step_s"]
        self.y = np.zeros(2)
        self.cycle, self.tau = 0, 0.0
        self.contacts, self.open = [], None
        self.strobes = [self._strobe()]
        self.double_crossings = 0
        self.first = None
        # At rest with no gap the cart pushes from t = 0 on (delta grows as t^3): contact, approach speed 0.
        if rig.gap == 0.0:
            self._onset(self.y, 0.0)

    # ---- bookkeeping
    def _strobe(self):
        d, v = self.rig.kin(self.y)
        r = {"cycle": self.cycle, "time_s": self.cycle * self.rig.T, "x_rel_m": d + self.rig.gap,
             "v_rel_m_per_s": v}
        if self.rig.wires:
            r["x_rel_m"] = WIRE_L * math.sin(self.y[0])
            r["theta_rad"], r["theta_dot_rad_per_s"] = float(self.y[0]), float(self.y[1])
        else:
            r["x_rel_m"] = float(self.y[0])
        return r

    def _onset(self, y, tau):
        d, v = self.rig.kin(y)
        F = KI * d + CI * v
        kind = "start" if (self.cycle == 0 and tau == 0.0) else ("force" if v < 0.0 else "touch")
        self.open = {"onset_cycle": self.cycle, "onset_tau_s": tau, "v_on": v, "kind": kind,
                     "peak": max(F, 0.0), "peak_cycle": self.cycle, "peak_tau_s": tau}
        self.first = 1e-6

    def _release(self, y, tau, acc_free):
        d, v = self.rig.kin(y)
        o = self.open
        T = self.rig.T
        o["duration_s"] = (self.cycle - o["onset_cycle"]) * T + (tau - o["onset_tau_s"])
        o["v_off"], o["delta_off_m"] = v, d
        self.contacts.append(o)
        self.open = None
        slope = KI * v + CI * acc_free
        self.first = self.flight_max * 0.01
        if acc_free > 0.0 and slope < 0.0:
            self.first = min(self.first, 0.1 * (-2.0 * slope / (KI * acc_free)))

    # ---- one drive period
    def run_cycle(self):
        T = self.rig.T
        while T - self.tau > 1e-14:
            if self.open is None:
                self._segment_free()
            else:
                self._segment_contact()
        self.tau = 0.0
        self.cycle += 1
        self.strobes.append(self._strobe())

    def _solver(self, fun, bound, max_step):
        span = bound - self.tau
        first = min(self.first if self.first else max_step, max_step, span)
        return DOP853(fun, self.tau, self.y, bound, max_step=max_step, rtol=self.rtol, atol=self.atol,
                      first_step=first)

    @staticmethod
    def _step(s):
        msg = s.step()
        if s.status == "failed":
            raise RuntimeError(msg)

    def _segment_free(self):
        rig = self.rig
        s = self._solver(rig.free, rig.T, self.flight_max)
        r_old = rig.rates(s.y, s.f)
        while True:
            self._step(s)
            ind = rig.indicator(s.y)
            r_new = rig.rates(s.y, s.f)
            hit = None
            if ind > 0.0 or any(a > 0.0 >= b for a, b in zip(r_old, r_new)):
                sol = s.dense_output()
                g = lambda t: rig.indicator(sol(t))
                if ind > 0.0:
                    hit = (s.t_old, s.t)
                else:  # interior maximum of delta or of F: is there a double crossing?
                    ts = np.linspace(s.t_old, s.t, 33)
                    vals = [g(t) for t in ts]
                    i = max(range(1, 33), key=lambda j: vals[j])  # the start may be 0+rounding after a release
                    lo, hi = ts[max(i - 1, 0)], ts[min(i + 1, 32)]
                    m = minimize_scalar(lambda t: -g(t), bounds=(lo, hi), method="bounded",
                                        options={"xatol": 1e-13})
                    if -m.fun > 0.0 and g(lo) < 0.0:
                        hit = (lo, float(m.x))
                        self.double_crossings += 1
                if hit:
                    lo, hi = hit
                    if g(lo) >= 0.0:  # lo is the release itself, F = 0 to rounding: start from a point in flight
                        lo = next((t for t in np.linspace(lo, hi, 257)[1:-1] if g(t) < 0.0), None)
                        if lo is None:
                            raise RuntimeError("hop shorter than the first step")
                    te = brentq(g, lo, hi, xtol=1e-18, rtol=8.9e-16)
                    self.tau, self.y = te, sol(te)
                    self._onset(self.y, te)
                    return
            r_old = r_new
            if s.status == "finished":
                self.tau, self.y, self.first = rig.T, s.y.copy(), self.flight_max
                return

    def _segment_contact(self):
        rig, o = self.rig, self.open
        T = rig.T
        age = (self.cycle - o["onset_cycle"]) * T + self.tau - o["onset_tau_s"]
        late = age >= LATE_AFTER_S * (1 - 1e-9)
        bound = T if late else min(T, self.tau + LATE_AFTER_S - age)
        if T - bound < 1e-12:
            bound = T
        s = self._solver(rig.contact, bound, self.c_late if late else self.c_max)
        rate_old = rig.rates(s.y, s.f)[1]
        while True:
            self._step(s)
            F = rig.force(s.y)
            rate = rig.rates(s.y, s.f)[1]
            hit = None
            if F <= 0.0 or rate_old * rate <= 0.0:
                sol = s.dense_output()
                g = lambda t: rig.force(sol(t))
                gd = lambda t: (lambda y: rig.rates(y, rig.contact(t, y))[1])(sol(t))
                if rate_old > 0.0 >= rate:      # a maximum of F inside this step
                    tp = brentq(gd, s.t_old, s.t, xtol=1e-18, rtol=8.9e-16) if gd(s.t_old) > 0 > gd(s.t) else s.t
                    if g(tp) > o["peak"]:
                        o["peak"], o["peak_cycle"], o["peak_tau_s"] = g(tp), self.cycle, tp
                if F <= 0.0:
                    hit = (s.t_old, s.t)
                elif rate_old < 0.0 <= rate:    # a minimum of F inside this step: did F dip below 0?
                    tm = brentq(gd, s.t_old, s.t, xtol=1e-18, rtol=8.9e-16) if gd(s.t_old) < 0 < gd(s.t) else s.t
                    if g(tm) < 0.0:
                        hit = (s.t_old, tm)
                        self.double_crossings += 1
                if hit:
                    lo, hi = hit
                    if g(lo) <= 0.0:
                        lo = next((t for t in np.linspace(lo, hi, 257)[1:-1] if g(t) > 0.0), None)
                        if lo is None:
                            raise RuntimeError("contact shorter than the first step")
                    te = brentq(g, lo, hi, xtol=1e-18, rtol=8.9e-16)
                    self.tau, self.y = te, sol(te)
                    acc = rig.ddelta(self.y, rig.free(te, self.y)[1])
                    self._release(self.y, te, acc)
                    return
            rate_old = rate
            if s.status == "finished":
                if F > o["peak"]:
                    o["peak"], o["peak_cycle"], o["peak_tau_s"] = F, self.cycle, bound
                self.tau, self.y, self.first = bound, s.y.copy(), s.h_abs
                return


def contact_record(c, T):
    return {"onset_time_s": c["onset_cycle"] * T + c["onset_tau_s"], "onset_cycle": c["onset_cycle"],
            "onset_time_in_cycle_s": c["onset_tau_s"], "onset_kind": c["kind"], "duration_s": c["duration_s"],
            "approach_speed_m_per_s": c["v_on"], "rebound_speed_m_per_s": -c["v_off"],
            "release_penetration_m": c["delta_off_m"], "peak_force_n": c["peak"],
            "peak_time_s": c["peak_cycle"] * T + c["peak_tau_s"]}


# ------------------------------------------------------------------------------------ 1. single contacts
def single_contact(law, m, v0, ki, ci=None, n=None, lam=None, e=None):
    """Mass m meets a fixed wall at speed v0; state: delta, delta_dot, impulse, work done on the wall."""
    def force(y):
        d, v = float(y[0]), float(y[1])
        if law == "spring-dashpot":
            return ki * d + ci * v
        h = ki * max(d, 0.0) ** n
        if law == "hertz":
            return h
        if law == "hunt-crossley":
            return h * (1.0 + lam * v)
        return h * (1.0 + 0.75 * (1.0 - e * e) * v / v0)

    def rhs(t, y):
        F = force(y)
        return [y[1], -F / m, F, F * y[1]]

    leave = (lambda t, y: force(y)) if law == "spring-dashpot" else (lambda t, y: y[0])
    leave.terminal, leave.direction = True, -1
    deepest = lambda t, y: y[1]
    sol = solve_ivp(rhs, (0.0, 0.1), [0.0, v0, 0.0, 0.0], method="DOP853", rtol=1e-13,
                    atol=[1e-19, 1e-16, 1e-15, 1e-17], max_step=1e-5, first_step=1e-8, events=[leave, deepest],
                    dense_output=True)
    tc, yc = float(sol.t_events[0][-1]), sol.y_events[0][-1]
    Fs = [force(y) for y in sol.y.T]
    i = int(np.argmax(Fs))
    lo, hi = sol.t[max(i - 1, 0)], sol.t[min(i + 1, len(Fs) - 1)]

    def fdot(t):
        y = sol.sol(t)
        d, v = float(y[0]), float(y[1])
        a = -force(y) / m
        if law == "spring-dashpot":
            return ki * v + ci * a
        b = {"hertz": 0.0, "hunt-crossley": lam, "lankarani-nikravesh": 0.0 if e is None else 0.75 * (1 - e * e) / v0}[law]
        return ki * n * d ** (n - 1) * v * (1 + b * v) + ki * d ** n * b * a
    tp = brentq(fdot, lo, hi, xtol=1e-18, rtol=8.9e-16)
    v1 = -float(yc[1])
    r = {"law": law, "mass_kg": m, "approach_speed_m_per_s": v0, "contact_ki_n_per_m_pow_n": ki, "exponent_n": n or 1.0,
         "contact_time_s": tc, "rebound_speed_m_per_s": v1, "restitution": v1 / v0,
         "peak_force_n": force(sol.sol(tp)), "peak_time_s": tp, "impulse_n_s": float(yc[2]),
         "energy_lost_j": 0.5 * m * (v0 * v0 - v1 * v1), "work_on_surface_j": float(yc[3]),
         "max_penetration_m": float(sol.y_events[1][0][0]), "max_penetration_time_s": float(sol.t_events[1][0]),
         "release_penetration_m": float(yc[0]) if law == "spring-dashpot" else 0.0}
    if ci is not None:
        r["contact_ci_n_s_per_m"] = ci
    if lam is not None:
        r["hunt_crossley_lambda_s_per_m"] = lam
    if e is not None:
        r["lankarani_nikravesh_e"] = e
        r["note"] = "e is the parameter of the law; the restitution that comes out is `restitution`"
    return r


def all_single():
    out = [single_contact("spring-dashpot", M_HAMMER, 0.08, KI, ci=CI),
           single_contact("hertz", M_HAMMER, 0.08, 2.1e8, n=1.6),
           single_contact("hunt-crossley", M_HAMMER, 0.08, 2.1e8, n=1.6, lam=0.6)]
    out += [single_contact("hunt-crossley", 2.0, v, 2.1e8, n=1.6, lam=0.6) for v in (0.1, 0.3, 0.5)]
    out += [single_contact("lankarani-nikravesh", M_HAMMER, 0.08, 2.1e8, n=1.6, e=0.8)]
    return out


# ------------------------------------------------------------------------------------ 2. sequences from rest
SEQUENCES = [("wires", g, r) for g, r in ((0.0, 1.5), (1.0, 1.5), (2.4, 1.4), (0.0, 2.7))] + \
            [(b, g, r) for b in ("beam-170", "beam-150", "beam-135") for g, r in ((0.0, 1.6), (1.0, 1.5), (3.0, 1.3))] + \
            [("wires", 0.0, 0.5), ("beam-150", 0.0, 0.6)]     # hops that pile up; contacts that begin at F = 0
N_CONTACTS, N_STROBES = 12, 10


def run_sequence(name, gap, ratio, settings):
    run = Runner(Rig(name, gap, ratio), settings)
    while run.cycle < N_STROBES or (len(run.contacts) < N_CONTACTS and run.cycle < 60):
        run.run_cycle()
    return run


def sequence(case):
    rig = Rig(*case)
    runs = [run_sequence(*case, s) for s in ("tight", "loose")]
    recs = [[contact_record(c, rig.T) for c in r.contacts[:N_CONTACTS]] for r in runs]
    agree = len(recs[0]) == len(recs[1])
    spread = {}
    if agree:
        for key in ("onset_time_s", "duration_s", "approach_speed_m_per_s", "peak_force_n"):
            spread["max_abs_difference_" + key] = float(f"{max([abs(a[key] - b[key]) for a, b in zip(*recs)] or [0]):.1e}")
    for key in ("x_rel_m", "v_rel_m_per_s"):
        spread["max_abs_difference_strobe_" + key] = float(
            f"{max(abs(a[key] - b[key]) for a, b in zip(runs[0].strobes[:N_STROBES + 1], runs[1].strobes)):.1e}")
    spread["same_contact_count"] = agree
    return {"parameters": rig.parameters(), "contacts": recs[0], "cycles_integrated": runs[0].cycle,
            "strobes": runs[0].strobes[1:N_STROBES + 1], "tight_minus_loose_run": spread}


# ------------------------------------------------------------------------------------ 3. settled regimes
REGIMES = [("wires", 0.0, r) for r in (0.9, 1.0, 1.1, 1.5, 2.7, 3.0, 3.8)] + [("wires", 1.0, r) for r in (1.5, 3.3)] + \
          [("wires", 2.4, r) for r in (1.2, 1.4, 2.7)] + \
          [(b, 0.0, 1.6) for b in ("beam-170", "beam-150", "beam-135")]
CURVE = [("wires", 0.0, round(1.2 + 0.1 * i, 1)) for i in range(15)]


def run_regime(case, settings):
    rig = Rig(*case)
    run = Runner(rig, settings)
    for _ in range(TRANSIENT + WINDOW):
        run.run_cycle()
    # let a contact that began in the window finish (another may always be under way at the strobe)
    while run.open is not None and run.open["onset_cycle"] < TRANSIENT + WINDOW:
        run.run_cycle()
    st = run.strobes[TRANSIENT:TRANSIENT + WINDOW + 1]
    con = [c for c in run.contacts if TRANSIENT <= c["onset_cycle"] < TRANSIENT + WINDOW]

    def residual(n):
        return max(max(abs(b["x_rel_m"] - a["x_rel_m"]) / A0, abs(b["v_rel_m_per_s"] - a["v_rel_m_per_s"]) / (A0 * rig.w))
                   for a, b in zip(st, st[n:]))
    period = next((n for n in range(1, NMAX + 1) if residual(n) <= SECTION_TOL), None)
    per_cycle = [sum(1 for c in con if c["onset_cycle"] == TRANSIENT + i) for i in range(WINDOW)]
    out = {"periods": period, "onsets_in_window": len(con), "onsets_per_cycle": per_cycle,
           "section_residual": residual(period) if period else residual(1), "settled": period is not None}
    if period is not None:
        full = WINDOW // period * period
        groups = [sum(per_cycle[i:i + period]) for i in range(0, full, period)]
        out["impacts"] = groups[-1]
        if len(set(groups)) != 1:
            out["settled"] = False
    # chatter: three or more onsets within one period, the last of which begins a stay longer than 5 ms
    chatter = False
    for i, c in enumerate(con):
        if c["duration_s"] > STICK_S and i >= 2:
            first = con[i - 2]
            gap_t = (c["onset_cycle"] - first["onset_cycle"]) * rig.T + c["onset_tau_s"] - first["onset_tau_s"]
            chatter = chatter or gap_t < rig.T
    out["longest_contact_s"] = max((c["duration_s"] for c in con), default=0.0)
    if not con:
        out["label"] = "none"
    elif chatter:
        out["label"] = "chatter"
    elif period is None:
        out["label"] = "aperiodic"
    else:
        out["label"] = f"{out['impacts']}/{period}"
    if con:
        top = max(con, key=lambda c: c["peak"])
        if period is not None:  # the same contact recurs: take the last cycle of the section
            last = [c for c in con if c["onset_cycle"] >= TRANSIENT + WINDOW - period]
            out["contacts_of_last_period"] = [dict(contact_record(c, rig.T), onset_phase_of_drive=c["onset_tau_s"] / rig.T)
                                              for c in last]
            top = max(last, key=lambda c: c["peak"], default=top)
        out.update(strongest_peak_force_n=top["peak"], force_ratio=top["peak"] / (M_HAMMER * GRAV),
                   strongest_approach_speed_m_per_s=top["v_on"], strongest_rebound_speed_m_per_s=-top["v_off"],
                   strongest_contact_time_s=top["duration_s"])
    out["section_last"] = {k: v for k, v in st[-1].items() if k != "time_s"}
    out["double_crossings_in_one_step"] = run.double_crossings
    return out


def regime_key(r):
    return (r["label"], r.get("impacts"), r["periods"])


def regime(case):
    tight, loose = run_regime(case, "tight"), run_regime(case, "loose")
    both = {"label": loose["label"], "same_regime": regime_key(tight) == regime_key(loose)}
    if "force_ratio" in tight and "force_ratio" in loose:
        both["force_ratio_relative_difference"] = float(f"{abs(loose['force_ratio'] / tight['force_ratio'] - 1):.1e}")
    return {"parameters": Rig(*case).parameters(), "transient_cycles": TRANSIENT, "window_cycles": WINDOW,
            "result": tight, "loose_run": both}


# ------------------------------------------------------------------------------------ checks
def check():
    """Closed forms, and one sequence repeated with solve_ivp's own events (DOP853 and Radau)."""
    sd = single_contact("spring-dashpot", M_HAMMER, 0.08, KI, ci=CI)
    w = math.sqrt(KI / M_HAMMER)
    z = CI / (2.0 * math.sqrt(KI * M_HAMMER))
    q = math.sqrt(1 - z * z)
    tc = (math.pi - math.atan2(2 * z * q, 1 - 2 * z * z)) / (w * q)
    # F = ki d + ci v is 0 first where tan(wd t) = -2 z q / (1 - 2 z^2), wd t in (0, pi)
    e = math.exp(-2 * z / q * math.atan(q / z))
    worst = {"contact_time_rel": sd["contact_time_s"] / tc - 1, "restitution_rel": sd["restitution"] / e - 1}
    h = single_contact("hertz", M_HAMMER, 0.08, 2.1e8, n=1.6)
    n = 1.6
    dm = ((n + 1) * M_HAMMER * 0.08 ** 2 / (2 * 2.1e8)) ** (1 / (n + 1))
    th = 2 * dm / 0.08 * math.gamma(1 + 1 / (n + 1)) * math.sqrt(math.pi) / math.gamma(0.5 + 1 / (n + 1))
    worst.update(hertz_depth_rel=h["max_penetration_m"] / dm - 1, hertz_time_rel=h["contact_time_s"] / th - 1,
                 hertz_peak_rel=h["peak_force_n"] / (2.1e8 * dm ** n) - 1, hertz_restitution=h["restitution"] - 1)
    for r in all_single():
        worst[f"{r['law']} m={r['mass_kg']} v={r['approach_speed_m_per_s']} impulse"] = \
            r["impulse_n_s"] / (r["mass_kg"] * (r["approach_speed_m_per_s"] + r["rebound_speed_m_per_s"])) - 1
        if r["law"] != "hertz":
            worst[f"{r['law']} m={r['mass_kg']} v={r['approach_speed_m_per_s']} energy"] = \
                r["work_on_surface_j"] / r["energy_lost_j"] - 1
    for k, v in worst.items():
        print(f"{k:60s} {v:.2e}")
        assert abs(v) < 1e-8, k
    for case in (("wires", 1.0, 1.5), ("wires", 2.4, 1.4), ("beam-150", 1.0, 1.5)):
        run = run_sequence(*case, "tight")
        rig = Rig(*case)
        ref = [contact_record(c, rig.T) for c in run.contacts[:4]]
        for method, rt, ms in (("DOP853", 1e-12, 1e-5), ("Radau", 1e-10, 1e-5)):
            t, y, worst_t = 0.0, [0.0, 0.0], 0.0
            atol = [1e-15, 1e-13] if method == "DOP853" else [1e-13, 1e-11]
            up = lambda t, y: rig.indicator(y)
            up.terminal, up.direction = True, 1
            down = lambda t, y: rig.force(y)
            down.terminal, down.direction = True, -1
            for c in ref:
                s = solve_ivp(rig.free, (t, t + 60), y, method=method, rtol=rt, atol=atol, max_step=rig.T / 400,
                              first_step=1e-7, events=up)
                on, y = s.t[-1], s.y[:, -1]
                s = solve_ivp(rig.contact, (on, on + 1), y, method=method, rtol=rt, atol=atol, max_step=ms,
                              first_step=1e-7, events=down)
                worst_t = max(worst_t, abs(on - c["onset_time_s"]), abs(s.t[-1] - on - c["duration_s"]))
                t, y = s.t[-1], s.y[:, -1]
            print(case, method, f"first {len(ref)} contacts, worst time difference {worst_t:.1e} s")


# ------------------------------------------------------------------------------------ output
def rounded(o):
    if isinstance(o, dict):
        return {k: rounded(v) for k, v in o.items()}
    if isinstance(o, (list, tuple)):
        return [rounded(v) for v in o]
    if isinstance(o, (float, np.floating)):
        return float(f"{float(o):.15g}")
    return o


def job(j):
    kind, case = j
    return {"sequence": sequence, "regime": regime}[kind](case)


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("--check", action="store_true")
    ap.add_argument("--processes", type=int, default=2)
    args = ap.parse_args()
    if args.check:
        check()
        return
    from multiprocessing import Pool
    jobs = [("regime", c) for c in REGIMES + [c for c in CURVE if c not in REGIMES]] + [("sequence", c) for c in SEQUENCES]
    done = {}
    with Pool(args.processes) as pool:
        for j, r in zip(jobs, pool.imap(job, jobs, chunksize=1)):
            done[j] = r
            if j[0] == "regime":
                x = r["result"]
                print(j[1], x["label"], x["periods"], x.get("impacts"), x.get("force_ratio"), f"{x['section_residual']:.1e}",
                      r["loose_run"], flush=True)
            else:
                print(j[1], len(r["contacts"]), r["tight_minus_loose_run"], flush=True)
    curve = []
    for c in CURVE:
        x = done[("regime", c)]
        keep = ("label", "impacts", "periods", "force_ratio", "strongest_peak_force_n", "strongest_approach_speed_m_per_s",
                "strongest_contact_time_s", "section_residual", "settled")
        curve.append(dict({k: x["result"].get(k) for k in keep}, ratio=c[2], frequency_hz=Rig(*c).f, gap_mm=c[1], rig=c[0],
                          loose_run=x["loose_run"]))
    a = SETTINGS["tight"]
    doc = {
        "about": {
            "generated_by": "tests/data/scipy_reference.py",
            "python_version": platform.python_version(), "numpy_version": np.__version__, "scipy_version": scipy.__version__,
            "method": "scipy.integrate.DOP853, restarted at every onset, release and drive period; events by brentq on the "
                      "dense output; single contacts by solve_ivp with DOP853 (rtol 1e-13, max_step 1e-5 s)",
            "rtol": a["rtol"],
            "atol_wires_rad_and_rad_per_s": [a["rtol"] * v for v in ATOL_PER_RTOL["wires"]],
            "atol_beams_m_and_m_per_s": [a["rtol"] * v for v in ATOL_PER_RTOL["beam"]],
            "max_step_flight": "drive period / 200", "max_step_contact_s": a["contact_step_s"],
            "max_step_contact_after_2_ms_s": a["late_step_s"],
            "loose_run": "the same with " + json.dumps(SETTINGS["loose"], sort_keys=True),
            "equations": {
                "wires": "theta_ddot = (a0 w^2/l) cos(theta) sin(w t) - (g/l) sin(theta) - [contact] F/(m l); "
                         "delta = l sin(theta) - gap; delta_dot = l theta_dot cos(theta)",
                "beams": "m x_ddot + c x_dot + k x + kappa x^3 + [contact] F = m a0 w^2 sin(w t), x relative to the cart; "
                         "delta = x - gap",
                "contact": "F = ki delta + ci delta_dot; contact while delta > 0 and F > 0",
            },
            "conventions": {
                "approach_speed_m_per_s": "delta_dot at onset, signed: negative where onset_kind is force",
                "rebound_speed_m_per_s": "minus delta_dot at release (F = 0, delta still > 0)",
                "onset_kind": "start: pressed by the cart from t = 0 (gap 0, at rest); touch: delta rises through 0; "
                              "force: F rises through 0 while delta > 0",
                "strobe": "state at drive phase 0 after `cycle` whole periods; x_rel_m = l sin(theta) (wires) or x (beams)",
                "section_residual": "largest of |x(k+n)-x(k)|/a0 and |v(k+n)-v(k)|/(a0 w) over the window (n = periods, or 1)",
                "periods": f"smallest n <= {NMAX} with section_residual <= {SECTION_TOL}; null if there is none",
                "impacts": "onsets in the last n periods of the window",
                "chatter": f"three or more onsets within one period, the last beginning a stay longer than {STICK_S} s",
                "force_ratio": "peak force of the strongest contact / (m g)",
                "settled": "false where no n was found or the onset count does not repeat",
            },
        },
        "single_contacts": all_single(),
        "sequences": [done[("sequence", c)] for c in SEQUENCES],
        "regimes": [done[("regime", c)] for c in REGIMES],
        "wires_gap_zero_curve": curve,
    }
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "scipy_reference.json")
    with open(path, "w") as fh:
        json.dump(rounded(doc), fh, indent=1, sort_keys=True, allow_nan=False)
        fh.write("\n")
    print("wrote", path)


if __name__ == "__main__":
    sys.exit(main())
