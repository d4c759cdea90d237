"""Shares of bands, PAR and lux beside peers. In: nothing. Out: the shares of core/site/bands.rs, integrated from ASTM G173-03; how diffuse the
PAR of a day is by them and by Spitters et al. (1986) in pvlib; lux by Perez et al. (1990) in numpy and in ladybug.

    pip install pvlib ladybug-core && python tools/peers/bands.py
"""

import math

import numpy as np
import pvlib
from ladybug.skymodel import estimate_illuminance_from_irradiance

BANDS = {"uv": (280, 380), "visible": (380, 780), "par": (400, 700), "nir": (780, 4000)}
# Table 4 of Perez et al. (1990), diffuse and direct: a, b, c, d of each bin of clearness.
BIN_ENDS = [1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2]
DIFFUSE = np.array([
    [97.24, -0.46, 12.00, -8.91], [107.22, 1.15, 0.59, -3.95], [104.97, 2.96, -5.53, -8.77], [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74], [106.42, 3.83, -36.15, -28.83], [141.88, 1.90, -53.24, -14.03], [152.23, 0.35, -45.27, -7.98]])
DIRECT = np.array([
    [57.20, -4.55, -2.98, 117.12], [98.99, -3.46, -1.21, 12.38], [109.83, -4.90, -1.71, -8.81], [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16], [107.19, -1.25, -1.51, -26.73], [105.75, 0.77, -1.26, -34.44], [101.18, 1.58, -1.10, -8.29]])


def shares():
    """Shares of the direct spectrum, and of what the hemispherical one has beyond it on the plane of 37 degrees at an air mass of 1.5."""
    spectra = pvlib.spectrum.get_reference_spectra()
    nm = spectra.index.to_numpy(float)
    direct = spectra["direct"].to_numpy()
    sky = spectra["global"].to_numpy() - direct * math.cos(math.radians(48.19 - 37))

    def integral(values, low, high):
        at = np.unique(np.concatenate([nm[(nm >= low) & (nm <= high)], [low, high]]))
        return np.trapezoid(np.interp(at, nm, values), at)

    whole = [integral(spectrum, 280, 4000) for spectrum in (direct, sky)]
    print(f"sun {whole[0]:.2f} W/m2, sky {whole[1]:.2f} W/m2")
    found = {}
    for name, (low, high) in BANDS.items():
        found[name] = [integral(spectrum, low, high) / all_of_it for spectrum, all_of_it in zip((direct, sky), whole)]
        print(f"{name:8} sun {found[name][0]:.4f} sky {found[name][1]:.4f}")
    photons = nm * 1e-9 / (6.62607015e-34 * 2.99792458e8 * 6.02214076e23) * 1e6
    for name, spectrum in (("sun", direct), ("sky", sky)):
        print(f"{name}: {integral(spectrum * photons, 400, 700) / integral(spectrum, 400, 700):.3f} umol/J of 400 to 700 nm")
    return found


def spitters(found):
    """Diffuse share of a day's PAR, by the shares above and by Spitters, over the diffuse share of all light; zenith angle 50 degrees."""
    print("diffuse share of all light, of PAR by the shares, by Spitters et al.; PAR over all light by the shares")
    sun, sky = found["par"]
    for diffuse in (0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0):
        whole = sky * diffuse + sun * (1 - diffuse)
        peer = pvlib.irradiance.diffuse_par_spitters(50.0, diffuse)
        print(f"{diffuse:.1f} {sky * diffuse / whole:.3f} {float(peer):.3f} {whole:.3f}")


def lux(altitude_deg, dni, dhi, dew_point_c):
    """Direct normal and diffuse horizontal illuminance."""
    zenith = math.radians(90 - altitude_deg)
    z3 = 1.041 * zenith**3
    clearness = ((dhi + dni) / dhi + z3) / (1 + z3)
    air_mass = 1 / (math.cos(zenith) + 0.15 * (93.885 - math.degrees(zenith)) ** -1.253)
    brightness = dhi * air_mass / 1367
    row = int(np.searchsorted(BIN_ENDS, clearness, side="right"))
    water = math.exp(0.07 * dew_point_c - 0.075)
    a, b, c, d = DIRECT[row]
    direct = max(0.0, a + b * water + c * math.exp(5.73 * zenith - 5) + d * brightness)
    a, b, c, d = DIFFUSE[row]
    return dni * direct, dhi * (a + b * water + c * math.cos(zenith) + d * math.log(brightness))


def illuminance():
    """Both, in numpy and in ladybug."""
    print("altitude, DNI, DHI, dew point: direct normal and diffuse lux here, by ladybug")
    for altitude, dni, dhi, dew_point in [
        (10, 300, 98, 5), (30, 700, 150, 10), (60, 850, 114, 15), (45, 0, 250, 8), (20, 100, 146, -3), (75, 400, 314, 20)]:
        ghi = dhi + dni * math.sin(math.radians(altitude))
        own = lux(altitude, dni, dhi, dew_point)
        _, direct, diffuse, _ = estimate_illuminance_from_irradiance(altitude, ghi, dni, dhi, dew_point)
        print(f"{altitude} {dni} {dhi} {dew_point}: {own[0]:.0f} {own[1]:.0f}, {direct:.0f} {diffuse:.0f}")


if __name__ == "__main__":
    spitters(shares())
    illuminance()
