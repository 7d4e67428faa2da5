"""The standard atmosphere up to 20 km, as text of expressions in the height `y`.

U.S. Standard Atmosphere, 1976 (NOAA-S/T 76-1562), that of ICAO Doc 7488 to this height: in the
troposphere the temperature falls by 6.5 K over a kilometre, in the tropopause above it stays.
"""

from __future__ import annotations

import numpy as np

from rodgen.arrays import Array

RADIUS = 6356766.0  # of the earth, by which heights become geopotential ones [m]
GRAVITY, GAS = 9.80665, 287.05287  # [m/s^2], of dry air [J/(kg K)]
TEMPERATURE, PRESSURE, LAPSE = 288.15, 101325.0, 0.0065  # at the sea [K], [Pa]; [K/m]
TROPOPAUSE, HIGHEST = 11000.0, 20000.0  # [m]
RATIO = 1.4  # of the heat capacities of air


def _geopotential(height: float) -> str:
    """Text of the geopotential height of a point; height: of y = 0 above the sea [m]."""
    above = f"(y + {height!r})" if height else "y"
    return f"{RADIUS!r}*{above}/({RADIUS!r} + {above})"


def density_text(height: float) -> str:
    """Text of the density of the air [kg/m^3]; height: of y = 0 above the sea [m]."""
    h, share = _geopotential(height), LAPSE / TEMPERATURE
    power = GRAVITY / (GAS * LAPSE) - 1
    ground = PRESSURE / (GAS * TEMPERATURE)
    coldest = TEMPERATURE - LAPSE * TROPOPAUSE
    scale = GAS * coldest / GRAVITY
    below = f"{ground!r}*(1 - {share!r}*min({h}, {TROPOPAUSE!r}))**{power!r}"
    return f"{below}*exp(min({TROPOPAUSE!r} - {h}, 0)/{scale!r})"


def speed_of_sound(y: Array, height: float) -> Array:
    """Speed of sound at places y of a scene [m/s]; height: of y = 0 above the sea [m]."""
    above = y + height
    h = RADIUS * above / (RADIUS + above)
    temperature = TEMPERATURE - LAPSE * np.minimum(h, TROPOPAUSE)
    return np.asarray(np.sqrt(RATIO * GAS * temperature))
