"""Loops of which every quantity of a test report is known in closed form."""

from __future__ import annotations

import numpy as np
from scipy.special import gamma

from springpot.testreport import LoopRecord

OMEGA, STROKE = 2.0 * np.pi * 1.3, 10.0


def loop(kind, per_cycle=200, cycles=6):
    """Time, displacement, force and the truth, from rest on the mean."""
    t = np.arange(per_cycle * cycles + 1) * (2.0 * np.pi / OMEGA / per_cycle)
    x, v = STROKE * np.sin(OMEGA * t), STROKE * OMEGA * np.cos(OMEGA * t)
    force, top, middle, work, stiffness = globals()[f"_{kind}"](t, x, v)
    truth = {"D+": STROKE, "D-": -STROKE, "F+": top, "F-": -top, "F0": middle, "W_d": work}
    truth |= {"K_eff": top / STROKE, "K''": work / (np.pi * STROKE**2)}
    truth |= {"C_eff": truth["K''"] / OMEGA, "v_peak": STROKE * OMEGA}
    if top:
        truth["xi_eff"] = work / (2.0 * np.pi * top * STROKE)
    if stiffness is not None:
        truth |= {"K'": stiffness}
        if stiffness:
            truth["eta"] = truth["K''"] / stiffness
    return t, x, force, truth


def _linear(t, x, v, k=0.8, c=0.05):
    return k * x + c * v, k * STROKE, c * OMEGA * STROKE, np.pi * c * OMEGA * STROKE**2, k


def _coulomb(t, x, v, k=0.3, slip=2.0):
    # Past the turning point by a hair: a computed cosine of zero has either sign.
    force = k * x + slip * np.sign(np.cos(OMEGA * t + 1e-9))
    return force, k * STROKE + slip, slip, 4.0 * slip * STROKE, k


def _power(t, x, v, c=1.0, alpha=0.35):
    lam = 2.0 ** (2.0 + alpha) * gamma(1.0 + alpha / 2.0) ** 2 / gamma(2.0 + alpha)
    most = c * (OMEGA * STROKE) ** alpha
    return c * np.sign(v) * np.abs(v) ** alpha, 0.0, most, lam * most * STROKE, 0.0


def _bilinear(t, x, v, first=2.0, second=0.3, yields=4.0):
    """A spring beside an elastic one that slips, in which each turn begins a stiff branch."""
    soft, slip = first - second, yields * (first - second) / first
    force, held = np.empty_like(x), 0.0
    force[0] = second * x[0]
    for i in range(1, len(x)):
        # Exact between samples on the same branch; a turn between two is passed at its peak.
        turn = np.sign(v[i - 1]) * STROKE if v[i] * v[i - 1] < 0.0 else x[i - 1]
        for way in (turn - x[i - 1], x[i] - turn):
            held = np.clip(held + soft * way, -slip, slip)
        force[i] = second * x[i] + held
    work = 4.0 * slip * (STROKE - yields / first)
    return force, second * STROKE + slip, slip, work, None


def noisy(kind, rng, noise, per_cycle=200, cycles=6, drift=0.0):
    """A record with noise of a share of the peaks, three times less in displacement, and drift."""
    t, x, force, truth = loop(kind, per_cycle, cycles)
    most = np.abs(force).max()
    pulled = force + most * (noise * rng.standard_normal(len(t)) + drift * t / t[-1])
    moved = x + STROKE * (noise / 3.0 * rng.standard_normal(len(t)) - drift * t / t[-1])
    return LoopRecord(t, moved, pulled, "mm", "kN", kind), truth
