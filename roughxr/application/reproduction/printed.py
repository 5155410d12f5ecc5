"""The values printed by Cheng, Dunn & Brach: their pair of bodies, and the rows of our tables, with notes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...mechanics.contact.reference import gilman_surface_energy

#: The paper's pair. Its printed pull-off of the smooth sphere, 19.1 µN, takes E/(1 − ν²) for E in eq. 43.
PAIR: dict[str, Any] = {
    "sphere_radius": 3000.0,
    "young_modulus": 75.0,
    "poisson_ratio": 0.22,
    "surface_energy": gilman_surface_energy(young_modulus=75.0, poisson_ratio=0.22),
}

#: How to read a value. A target is one that the twin's spectrum, debris and seed were fitted to, through the published
#: formulas: a run that comes near it confirms nothing. Inferred values are not printed, but follow from printed ones;
#: "in words" is stated in the text without a number. All other values are printed, and were not fitted.
_TARGET, _INFERRED, _WORDS, _LIMIT = "target", "inferred", "in words", "upper limit"
_BOTH, _DIFFERENT = f"{_TARGET}, {_INFERRED}", f"{_WORDS}: different"

#: The paper's values and how to read them, by the rows of the tables. R_q and the reconstruction's residual are the
#: text's values, printed as 0.0253, 0.0256 and 0.0034 nm, times √(MN) = 512, a factor that they lack.
SCAN = {
    "size along x [µm]": (5.0, ""),
    "size along y [µm]": (5.0, ""),
    "height, least [nm]": (4.0, _BOTH),
    "height, greatest [nm]": (27.0, _BOTH),
    "height, mean [nm]": (12.842, _TARGET),
    "height, std [nm]": (1.7, _BOTH),
    "R_q about zero, original [nm]": (0.0253 * 512, _BOTH),
    "R_q about zero, reconstructed [nm]": (0.0256 * 512, _INFERRED),
    "R_a about zero, original [nm]": (12.842, _TARGET),
    "R_a about zero, reconstructed [nm]": (12.880, ""),
    "R_a, reconstructed above original [%]": (0.30, ""),
    "R_q, reconstructed above original [%]": (1.14, ""),
    "original - reconstructed, rms [nm]": (0.0034 * 512, _INFERRED),
    "peak height, median [nm]": (15.0, _TARGET),
    "peak height, second group, mean [nm]": (27.0, _TARGET),
    "axis ratio b/a, mean": (0.6, _TARGET),
    "axis ratio b/a, skewness": (0.0, f"{_WORDS}: Gaussian"),
    "axis ratio b/a, cdf off Gaussian's [%]": (0.0, f"{_WORDS}: Gaussian"),
    "isotropy of directions (1: isotropic)": (1.0, _WORDS),
    "asperities with a < 10 b [%]": (np.nan, f"{_WORDS}: most"),
}
PULL_OFF = {
    "pull-off, smooth sphere [µN]": (19.1, ""),
    "pull-off, mean [µN]": (2.0, _TARGET),
    "pull-off, std [µN]": (1.37, _TARGET),
    "pull-off, rough / smooth": (0.1, _TARGET),
    "pull-off, reduced by roughness [%]": (90.0, _TARGET),
    "displacement at pull-off, mean [nm]": (9.7, _TARGET),
    "displacement at pull-off, std [nm]": (2.52, _TARGET),
    "places that adhere": (64, ""),
    "figure 15, pull-off [µN]": (8.6, ""),
    "figure 15, rough / smooth": (0.5, ""),
    "figure 15, attraction from [nm]": (9.8, ""),
    "figure 15, attraction to [nm]": (12.4, ""),
    "figure 15, above smooth from [nm]": (18.0, ""),
}
CONCLUSION = {
    "overlapping contacts [%]": (0.0, _WORDS),
    "places with overlapping contacts [%]": (0.0, _WORDS),
    "sum / simulation, of the means": (1.0, _WORDS),
}
FORCE = {
    "smooth flat, difference from Hertz [%]": (1.0, _LIMIT),
    "at 5.08 nm, mean [µN]": (0.4, _TARGET),
    "at 5.08 nm, std [µN]": (3.0, _TARGET),
    "at 5.08 nm, std / mean": (10.0, _TARGET),
    "at 5.08 nm, second group [µN]": (20.0, _TARGET),
    "at 15.4 nm, mean [µN]": (21.0, _TARGET),
    "at 15.4 nm, std [µN]": (11.0, _TARGET),
    "at 15.4 nm, second group [µN]": (80.0, _TARGET),
    "rough / smooth at 10 nm": (0.1, _LIMIT),
    "rough / smooth at 20 nm": (0.25, ""),
    "places without debris": (58, _TARGET),
    "sum / direct at 9 nm": (1.0, _WORDS),
    "sum / direct at 10 nm": (1.0, _WORDS),
    "sum / direct at 11 nm": (1.0, _WORDS),
    "sum / direct at 12 nm": (np.nan, _DIFFERENT),
    "places within 2 % at 11 nm": (np.nan, f"{_WORDS}: similar"),
    "places within 2 % at 12 nm": (np.nan, _DIFFERENT),
    "places within 2 % at 13 nm": (np.nan, _DIFFERENT),
}

#: Notes below the paper's tables.
TWIN = (
    "The scan is a synthetic twin. Its spectrum and debris were fitted to the rows marked 'target', and its seed was "
    "selected among some sixty, so the agreement of these rows confirms nothing. 'inferred': not printed, but follows "
    "from printed values. 'in words': stated without a number. All other values are printed and were not fitted. "
)
