"""Comparison of two runs of one model. In: their series. Out: deviations in percent of the first, which is EnergyPlus's own."""

from dataclasses import dataclass

import numpy as np

import parts

ABSORBED, TRANSMITTED, GLASS = parts.SUN


@dataclass
class Deviation:
    """Percent of EnergyPlus's own, but for `transmitted_rms_w_m2`, the largest of the windows."""

    heating: float
    cooling: float
    daily_rms: float
    transmitted_rms_w_m2: float
    sun: dict  # (surface, absorbed, transmitted or glass) -> percent of the period's sum

    def worst(self):
        """The surface whose sun deviates most, and by how much."""
        return max(self.sun.items(), key=lambda pair: abs(pair[1]), default=((("none", ""), 0.0)))


def percent(ours, own):
    """How much `ours` differs from `own`, percent; nothing where both are nothing."""
    return 100.0 * (ours - own) / own if own else (0.0 if ours == own else float("inf"))


def load(series, name):
    """J of all zones by step."""
    return sum(series.of(name).values())


def deviation(own, ours, areas):
    """Deviation of a run from EnergyPlus's own; `areas` are m2 by window in capitals."""
    found, rms = [], []
    for name in parts.LOADS:
        a, b = load(own, name), load(ours, name)
        found.append(percent(b.sum(), a.sum()))
        days_a, days_b = own.days(a), ours.days(b)
        if len(days_a) > 3 and a.sum() > 0:
            rms.append(100.0 * np.sqrt(np.mean((days_b - days_a) ** 2)) / days_a.mean())
    windows = own.of(TRANSMITTED)
    hourly = [np.sqrt(np.mean((ours.values[(key, TRANSMITTED)] - watts) ** 2)) / areas[key] for key, watts in windows.items()]
    return Deviation(*found, max(rms, default=0.0), max(hourly), sun(own, ours, areas))


def sun(own, ours, areas):
    """Sums over the period of what each surface absorbs and each window transmits, percent of EnergyPlus's own."""
    found = {}
    for variable, word in ((ABSORBED, "absorbed"), (TRANSMITTED, "transmitted"), (GLASS, "absorbed by glass")):
        for key, values in own.of(variable).items():
            if values.sum() > 0.0 and (variable == ABSORBED or key in areas):
                found[(key, word)] = percent(ours.values[(key, variable)].sum(), values.sum())
    return found
