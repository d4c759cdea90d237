"""Suns and skies. In: an EPW file. Out: conditions (sun, DNI, DHI), and for each the same sky and sun as heliotile's, written
for Radiance: a function of the direction for `rtrace`, radiances of Reinhart patches for matrices."""
import csv
import math
import random
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SUN_RADIUS_RAD = math.radians(0.533 / 2)
E0_W_M2 = 1367.0
PEREZ = Path(__file__).resolve().parents[2] / "src/core/sky/perez.rs"


@dataclass
class Condition:
    name: str
    azimuth_deg: float
    altitude_deg: float
    dni_w_m2: float
    dhi_w_m2: float

    def sun(self):
        a, h = math.radians(self.azimuth_deg), math.radians(self.altitude_deg)
        return np.array([math.sin(a) * math.cos(h), math.cos(a) * math.cos(h), math.sin(h)])


def sun_position(day, hour, latitude_deg, longitude_deg, zone_h):
    """(azimuth, altitude) in degrees at a local standard time; Spencer's 1971 series, good to some 0.2 degrees, which is enough
    here: everyone gets the same sun."""
    g = 2 * math.pi * (day - 1) / 365
    decl = (0.006918 - 0.399912 * math.cos(g) + 0.070257 * math.sin(g) - 0.006758 * math.cos(2 * g) + 0.000907 * math.sin(2 * g)
            - 0.002697 * math.cos(3 * g) + 0.00148 * math.sin(3 * g))
    equation_min = 229.18 * (0.000075 + 0.001868 * math.cos(g) - 0.032077 * math.sin(g) - 0.014615 * math.cos(2 * g)
                             - 0.040849 * math.sin(2 * g))
    w = math.radians(15 * (hour + (longitude_deg - 15 * zone_h) / 15 + equation_min / 60 - 12))
    p = math.radians(latitude_deg)
    up = math.sin(p) * math.sin(decl) + math.cos(p) * math.cos(decl) * math.cos(w)
    north = math.cos(p) * math.sin(decl) - math.sin(p) * math.cos(decl) * math.cos(w)
    east = -math.cos(decl) * math.sin(w)
    return math.degrees(math.atan2(east, north)) % 360, math.degrees(math.asin(up))


def conditions(epw, clear, mixed, overcast):
    """So many hours of each kind of sky from each quarter of the year, sun above 3 degrees, DHI of 15 W/m2 and more, drawn with
    a fixed seed. Clear is clearness of 4.5 and more, overcast below 1.065."""
    with open(epw, newline="") as file:
        rows = list(csv.reader(file))
    place = [float(v) for v in rows[0][6:9]]
    found = {}
    for i, row in enumerate(rows[8:]):
        day, hour = i // 24 + 1, int(row[3]) - 0.5
        azimuth, altitude = sun_position(day, hour, *place)
        dni, dhi = float(row[14]), float(row[15])
        if altitude < 3 or dhi < 15:
            continue
        c = Condition(f"d{day:03}h{int(row[3]):02}", round(azimuth, 4), round(altitude, 4), dni, dhi)
        epsilon = clearness(c)
        kind = "clear" if epsilon >= 4.5 else "overcast" if epsilon < 1.065 else "mixed"
        found.setdefault((min((day - 1) // 91, 3), kind), []).append(c)
    draw, chosen = random.Random(1993), []
    for quarter in range(4):
        for kind, count in (("clear", clear), ("mixed", mixed), ("overcast", overcast)):
            chosen += draw.sample(found[quarter, kind], count)
    return chosen


def write_conditions(chosen, path):
    """`conditions.csv` of `heliotile replay`."""
    lines = [f"{c.name},{c.azimuth_deg},{c.altitude_deg},{c.dni_w_m2},{c.dhi_w_m2}" for c in chosen]
    Path(path).write_text("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n" + "\n".join(lines) + "\n")


def clearness(c):
    """Perez et al. 1990, equation 1, kappa 1.041."""
    z3 = 1.041 * math.radians(90 - c.altitude_deg) ** 3
    return ((c.dhi_w_m2 + c.dni_w_m2) / c.dhi_w_m2 + z3) / (1 + z3)


def coefficients():
    """Table 1 of Perez et al. 1993 as [bin][a..e][4], read from heliotile's source so that both hold the same numbers."""
    table = PEREZ.read_text().split("const COEFFICIENTS")[1].split("= [", 1)[1].split("];")[0]
    return np.array([float(v) for v in re.findall(r"-?\d+\.\d+", table)]).reshape(8, 5, 4)


def perez(c):
    """(a, b, c, d, e, floor of cos zenith) of a condition; rules as in src/core/sky/perez.rs and sky.rs."""
    zenith = math.radians(90 - c.altitude_deg)
    mass = 1 / (math.cos(zenith) + 0.15 * (93.885 - math.degrees(zenith)) ** -1.253)
    epsilon, delta = clearness(c), c.dhi_w_m2 * mass / E0_W_M2
    delta = min(max(delta, 0.2 if 1.065 < epsilon < 2.8 else 0.01), 0.6)
    place = sum(end <= epsilon for end in (1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2))
    k = coefficients()[place]
    a, b, cc, d, e = (x[0] + x[1] * zenith + delta * (x[2] + x[3] * zenith) for x in k)
    if place == 0:
        cc = math.exp((delta * (k[2][0] + k[2][1] * zenith)) ** k[2][2]) - k[2][3]
        d = k[3][2] + delta * k[3][3] - math.exp(delta * (k[3][0] + k[3][1] * zenith))
    return a, b, cc, d, e, 0.1 if b > 0 else 0.01


def relative(c, directions):
    """Relative radiance in directions [...][3] of the upper hemisphere."""
    a, b, cc, d, e, floor = perez(c)
    cos_gamma = np.clip(directions @ c.sun(), -1, 1)
    gradation = 1 + a * np.exp(b / np.maximum(directions[..., 2], floor))
    glow = 1 + cc * np.exp(d * np.arccos(cos_gamma)) + e * cos_gamma**2
    return np.maximum(gradation, 0) * np.maximum(glow, 0)


def grid(z, azimuth):
    """Directions [z][azimuth][3]."""
    z, azimuth = np.meshgrid(z, azimuth, indexing="ij")
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.sin(azimuth), flat * np.cos(azimuth), z], axis=-1)


def level(c):
    """W/(m2 sr) of a relative radiance of 1: the horizontal integral over 1200 x 1440 directions is DHI."""
    z = (np.arange(1200) + 0.5) / 1200
    azimuth = (np.arange(1440) + 0.5) * 2 * math.pi / 1440
    integral = (relative(c, grid(z, azimuth)).mean(axis=1) * z).mean() * 2 * math.pi
    return c.dhi_w_m2 / integral


SKY_CAL = """{ Perez all-weather sky: A1..A5 parameters, A6 level, A7..A9 sun, A10 floor of the cosine of the zenith angle }
positive(x) : if(x, x, 0);
above = if(Dz - A10, Dz, A10);
cosine = Dx*A7 + Dy*A8 + Dz*A9;
cg = if(cosine - 1, 1, if(-1 - cosine, -1, cosine));
radiance = A6 * positive(1 + A1*exp(A2/above)) * positive(1 + A3*exp(A4*acos(cg)) + A5*cg*cg);
"""


def sky_text(c):
    """A source over the upper hemisphere for `rtrace`; needs SKY_CAL as sky.cal."""
    a, b, cc, d, e, floor = perez(c)
    numbers = " ".join(f"{v:.10g}" for v in (a, b, cc, d, e, level(c), *c.sun(), floor))
    return (f"void brightfunc distribution\n2 radiance sky.cal\n0\n10 {numbers}\n\n"
            "distribution glow sky_glow\n0\n0\n4 1 1 1 0\n\nsky_glow source sky\n0\n0\n4 0 0 1 180\n")


def sun_text(direction, radiance, radius_rad, name="sun"):
    """A distant disc."""
    x, y, z = direction
    return (f"void light {name}\n0\n0\n3 {radiance:.8g} {radiance:.8g} {radiance:.8g}\n\n"
            f"{name} source {name}_disc\n0\n0\n4 {x:.9f} {y:.9f} {z:.9f} {math.degrees(2 * radius_rad):.6f}\n\n")


def solid_angle(radius_rad):
    return 2 * math.pi * (1 - math.cos(radius_rad))


def disc(c, radius_rad, count):
    """`count` directions spread evenly over a disc around the sun (sunflower)."""
    sun = c.sun()
    u = np.cross(sun, [0, 0, 1.0])
    u /= np.linalg.norm(u)
    v = np.cross(sun, u)
    k = np.arange(count)
    r, turn = np.tan(radius_rad) * np.sqrt((k + 0.5) / count), k * math.pi * (3 - math.sqrt(5))
    d = sun + (r * np.cos(turn))[:, None] * u + (r * np.sin(turn))[:, None] * v
    return d / np.linalg.norm(d, axis=1)[:, None]
