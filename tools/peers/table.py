"""Errors and tables. In: results against `Truth`. Out: `Row`s, a table for reading, a CSV."""
import csv
from dataclasses import asdict, dataclass, fields

import numpy as np


@dataclass
class Row:
    """Errors in percent of the reference's mean; CPU seconds (user + system) a receiver."""
    scene: str
    method: str
    hourly_rmse_pct: float
    hourly_rmse_clear_of_edges_pct: float
    bias_pct: float
    receiver_sum_rmse_pct: float
    cpu_trace_s: float
    cpu_suns_s: float
    cpu_year_s: float
    cpu_total_s: float


def row(scene, method, found, truth, trace_s, suns_s, year_s, receivers):
    """Errors of `found` [condition][receiver], W/m2; the three costs are CPU seconds of all `receivers`."""
    mean, off, clear = truth.total.mean(), found - truth.total, ~truth.near_edge
    sums = off.sum(axis=0) / truth.total.sum(axis=0).mean()
    costs = [s / receivers for s in (trace_s, suns_s, year_s)]
    return Row(scene, method, rms(off) / mean * 100, rms(off[clear]) / mean * 100, off.mean() / mean * 100, rms(sums) * 100,
               *costs, sum(costs))


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


HEAD = (f"{'scene':<10}{'method':<28}{'hourly %':>9}{'no edge %':>10}{'bias %':>8}{'sums %':>8}"
        f"{'trace s':>9}{'suns s':>8}{'year s':>8}{'all s':>8}")


def line(r):
    return (f"{r.scene:<10}{r.method:<28}{r.hourly_rmse_pct:>9.2f}{r.hourly_rmse_clear_of_edges_pct:>10.2f}{r.bias_pct:>8.2f}"
            f"{r.receiver_sum_rmse_pct:>8.2f}"
            f"{r.cpu_trace_s:>9.4f}{r.cpu_suns_s:>8.4f}{r.cpu_year_s:>8.4f}{r.cpu_total_s:>8.4f}")


def parts(scene, method, found, truth):
    """One line: RMSE and bias of heliotile's direct sun, direct sky and reflected light (`found` by name), in percent of
    the mean total."""
    mean, out = truth.total.mean() / 100, []
    known = {"sun": truth.sun, "sky": truth.sky, "reflected": truth.total - truth.sun - truth.sky}
    for name, values in known.items():
        off = found[name] - values
        out.append(f"{name} {rms(off) / mean:.2f} (bias {off.mean() / mean:+.2f})")
    return f"{scene:<10}{method:<28}{', '.join(out)}"


def write(rows, path):
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(f.name for f in fields(Row))
        for r in rows:
            out.writerow(v if isinstance(v, str) else f"{v:.5f}" for v in asdict(r).values())


def reference(scene, total, error, truth):
    """One line: the reference path tracer [condition][receiver] beside the reference, and what the noise of both explains."""
    mean, off = truth.total.mean() / 100, total - truth.total
    noise = np.sqrt(np.mean(error**2 + truth.error**2))
    clear = ~truth.near_edge
    within = np.mean(np.abs(off[clear]) <= 3 * np.hypot(error, truth.error)[clear])
    return (f"{scene:<10}{'path tracer of audit':<28}RMSE {rms(off) / mean:.2f} %, {rms(off[clear]) / mean:.2f} clear of edges, where noise "
            f"explains {noise / mean:.2f}; bias {off.mean() / mean:+.3f} %; {100 * within:.1f} % clear of edges within 3 standard errors of both")
