"""The dense block of the paper's experiment. In: a period. Out: a model of 14 zones on a plaza under two towers of 110 storeys,
among lower blocks: 2,189 shading polygons, the panels of their facades, some of them half glass. Generated from one seed."""

import random

import models
import parts

POLYGONS = 2189
SEED = 110
TOWERS = {"North tower": (-95, 10, -32, 73), "South tower": (-45, -112, 18, -49)}
TOWER_HEIGHT_M = 415.0
# Floor plan, height in metres, panels across and up.
BLOCKS = (
    ((-112, -62, -72, -6), 73.0, 3, 5),
    ((45, -112, 115, -62), 36.0, 4, 3),
    ((62, 42, 142, 102), 36.0, 5, 3),
    ((-62, 96, 22, 141), 32.0, 5, 3),
    ((-32, 171, 50, 216), 186.0, 5, 8),
    ((88, -32, 128, 26), 60.0, 4, 5),
    ((152, -122, 202, -72), 226.0, 4, 8),
    ((152, -52, 202, 10), 120.0, 4, 6),
    ((162, 32, 212, 92), 90.0, 4, 5),
    ((-62, -192, 0, -142), 158.0, 4, 7),
    ((26, -192, 86, -142), 110.0, 4, 5),
    ((106, -192, 146, -142), 80.0, 3, 5),
    ((82, 132, 142, 177), 70.0, 4, 4),
)
PLAN, STOREYS, STOREY_M = (30.0, -2.0, 54.0, 14.0), 7, 3.6
BANDS = [(0.05, 0.95, 0.25, 0.85)]
WEEK = ((5, 15), (5, 21))


def dense(period=WEEK, steps=1, update=None):
    """The block; `update` are days between updates of the shadows, without it every step has its own."""
    model = parts.base(parts.GOLDEN, period, steps)
    x0, y0, x1, y1 = PLAN
    middle = (x0 + x1) / 2
    windows = {side: BANDS for side in parts.SIDES}
    for storey in range(STOREYS):
        low, top, bottom = storey * STOREY_M, storey == STOREYS - 1, storey == 0
        for name, plan, inside in (("west", (x0, y0, middle, y1), ("east",)), ("east", (middle, y0, x1, y1), ("west",))):
            parts.zone(model, f"{name} {storey + 1}", plan, low, low + STOREY_M, inside, windows, "Wall 40", top, bottom)
    city(model)
    if update:
        model["ShadowCalculation"]["Shadows"].update(
            shading_calculation_update_frequency_method="Periodic", shading_calculation_update_frequency=update
        )
    else:
        # With shadows of every step a day of warming up costs EnergyPlus's own reflections as much as a day of the week.
        model["Building"]["Study"].update(
            loads_convergence_tolerance_value=0.04, temperature_convergence_tolerance_value=0.4, minimum_number_of_warmup_days=3
        )
    return parts.outputs(model)


def city(model):
    """Towers, blocks and, so that there are 2,189 polygons, kiosks and canopies on the plaza."""
    dice = random.Random(SEED)
    for name, plan in TOWERS.items():
        parts.block(model, name, plan, TOWER_HEIGHT_M, 6, 20, 0.35, some(dice, 0.25))
    for k, (plan, height, across, up) in enumerate(BLOCKS):
        parts.block(model, f"Block {k + 1}", plan, height, across, up, round(dice.uniform(0.15, 0.5), 2), some(dice, 0.1))
    left = POLYGONS - len(model["Shading:Site:Detailed"])
    for k in range(left // 5):
        x, y = 62.0 + 9.0 * (k % 3), -55.0 + 6.5 * (k // 3)
        parts.block(model, f"Kiosk {k + 1}", (x, y, x + 3.0, y + 2.5), 2.8, 1, 1, 0.3)
    for k in range(left % 5):
        x, y = 2.0 + 6.0 * k, 24.0
        parts.shade(model, f"Canopy {k + 1}", [(x, y + 4.0, 4.0), (x, y, 4.0), (x + 5.0, y, 4.0), (x + 5.0, y + 4.0, 4.0)], 0.4)


def some(dice, share):
    """Half glazed panels, a share of all."""
    return lambda i, k: 0.5 if dice.random() < share else 0.0


def case(period=WEEK, steps=1, update=None):
    return models.Case("dense", dense(period, steps, update), models.GOLDEN_EPW, 2.0, "dense block")
