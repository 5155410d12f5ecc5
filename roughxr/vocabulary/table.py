"""Every name of a roughxr Dataset: its units, sign and meaning, in one table.

Signs: heights point out of the material; ``delta`` > 0 brings the bodies together; ``force`` and ``pressure`` > 0 push,
< 0 pull; ``gap`` >= 0; a pull-off force is a positive magnitude.
"""

from __future__ import annotations

from typing import NamedTuple


class Variable(NamedTuple):
    """The meaning of one name: its units (UDUNITS; empty for another's, as of an ``estimate``), label, and sign."""

    units: str
    long_name: str
    comment: str = ""


#: Every variable and coordinate name that roughxr writes.
VARIABLES: dict[str, Variable] = {
    # scan
    "x": Variable("nm", "x", "pixel centres"),
    "y": Variable("nm", "y", "pixel centres"),
    "height": Variable("nm", "height", "points out of the material"),
    "sphere_radius": Variable("nm", "sphere radius"),
    "contact_modulus": Variable("GPa", "contact modulus E*", "1/E* = (1-nu1^2)/E1 + (1-nu2^2)/E2"),
    "work_of_adhesion": Variable("J/m^2", "work of adhesion w", "w = 2 gamma for equal bodies"),
    "adhesion_range": Variable(
        "nm", "range of adhesion", "w over the largest pull; the length of each law: rho, Dugdale's gap, z0"
    ),
    "hardness": Variable("GPa", "hardness H", "the largest pressure; beyond it the softer body yields"),
    "hardness_estimate": Variable("GPa", "estimated hardness", "of named materials; only `extrapolated` yields at it"),
    "hamaker_constant": Variable("nN nm", "Hamaker constant A", "across what lies between; 1 nN nm = 1e-18 J"),
    "retardation": Variable("nm", "wavelength of retardation", "of van der Waals forces across gaps beyond some 10 nm"),
    "humidity": Variable("1", "relative humidity", "relative vapour pressure of the liquid that condenses"),
    "kelvin_radius": Variable("nm", "Kelvin radius", "of the condensed liquid's surface"),
    "surface_tension": Variable("J/m^2", "surface tension of the liquid"),
    "contact_angle_1": Variable("rad", "contact angle on the first body"),
    "contact_angle_2": Variable("rad", "contact angle on the second body"),
    "liquid_film": Variable("nm", "film of liquid", "adsorbed on each body"),
    "share_under_liquid": Variable("1", "work of adhesion of the solids under the liquid", "over that without it"),
    "indenter_height": Variable("nm", "indenter height", "points out of the indenter; its maximum touches first"),
    "indenter_x": Variable("nm", "x from the contact centre"),
    "indenter_y": Variable("nm", "y from the contact centre"),
    # indenters that are rough themselves
    "placement": Variable("1", "placement", "one way in which a rough indenter lands"),
    "rotation": Variable("rad", "rotation of the indenter's roughness", "from x towards y"),
    "patch_x": Variable("nm", "x of the part of the roughness that faces the surface", "its middle, on its scan"),
    "patch_y": Variable("nm", "y of the part of the roughness that faces the surface", "its middle, on its scan"),
    "fitted_radius": Variable("nm", "radius of the fitted sphere"),
    "apex_x": Variable("nm", "x of the fitted sphere's apex"),
    "apex_y": Variable("nm", "y of the fitted sphere's apex"),
    "apex_tilt": Variable("rad", "inclination of the fitted sphere in the middle of the scan"),
    # roughness: the paper's two about height 0, those of ISO 25178-2 about the mean plane
    "r_a_datum": Variable("nm", "mean height R_a about the datum", "mean |Z|, the mean taken as 0"),
    "r_q_datum": Variable("nm", "rms height R_q about the datum", "root of mean Z^2, the mean taken as 0"),
    "s_a": Variable("nm", "arithmetical mean height S_a"),
    "s_q": Variable("nm", "root mean square height S_q"),
    "s_p": Variable("nm", "maximum peak height S_p"),
    "s_v": Variable("nm", "maximum pit depth S_v", "positive"),
    "s_z": Variable("nm", "maximum height S_z", "S_p + S_v"),
    "s_sk": Variable("1", "skewness S_sk"),
    "s_ku": Variable("1", "kurtosis S_ku", "3 for Gaussian heights"),
    "s_dq": Variable("1", "root mean square slope S_dq"),
    "s_dr": Variable("1", "developed interfacial area ratio S_dr"),
    "psd": Variable("nm^4", "power spectrum", "ring mean of |dx dy FFT(h)|^2/A; sum(psd modes)/A = mean h^2"),
    "psd_modes": Variable("1", "modes in the ring"),
    "psd_between_std": Variable("nm^4", "standard deviation of the power spectrum between scans"),
    "psd_scans": Variable("1", "scans that reach the wavevector"),
    "wavevector": Variable("1/nm", "wavevector", "2 pi over wavelength"),
    "acf": Variable("nm^2", "autocorrelation", "mean h(r) h(r + lag) over pixels with a partner"),
    "lag": Variable("nm", "lag"),
    "hurst_exponent": Variable("1", "Hurst exponent H", "psd falls as q^-2(1 + H) below the roll-off wavelength"),
    "rolloff_wavelength": Variable("nm", "roll-off wavelength"),
    "psd_plateau": Variable("nm^4", "power spectrum above the roll-off wavelength"),
    "psd_error": Variable("1", "standard error of the logarithm of the power spectrum", "at the shortest wavelength"),
    "hurst_error": Variable("1", "standard error of the Hurst exponent", "towards shorter waves"),
    "lay_strength": Variable("1", "how far grooves lie along one direction", "0 none, 1 all"),
    "lay_direction": Variable("degree", "direction along which grooves lie", "from x towards y, 0 to 180"),
    "pixel_x": Variable("nm", "pixel size along x"),
    "pixel_y": Variable("nm", "pixel size along y"),
    "size_x": Variable("nm", "scan size along x", "pixels times pixel size"),
    "size_y": Variable("nm", "scan size along y", "pixels times pixel size"),
    # asperities
    "asperity": Variable("1", "asperity"),
    "curvature_min": Variable("1/nm", "smaller principal curvature", "1/R', positive for a peak"),
    "curvature_max": Variable("1/nm", "larger principal curvature", "1/R'', positive for a peak"),
    "orientation": Variable("rad", "orientation of the flattest direction", "from x towards y, in [-pi/2, pi/2)"),
    "axis_ratio": Variable("1", "axis ratio b/a of the Hertz contact ellipse"),
    "fit_rms": Variable("nm", "rms residual of the fit", "of a paraboloid to an asperity, of a sphere to a probe"),
    "datum_height": Variable("nm", "height of the datum", "the highest point of the whole scan"),
    "scan_x_min": Variable("nm", "outer edge of the scan", "smallest x"),
    "scan_x_max": Variable("nm", "outer edge of the scan", "largest x"),
    "scan_y_min": Variable("nm", "outer edge of the scan", "smallest y"),
    "scan_y_max": Variable("nm", "outer edge of the scan", "largest y"),
    "patch_radius": Variable("nm", "half-width of the fitted patch"),
    "shortest_wavelength": Variable("nm", "shortest wavelength", "all but 5 % of the mean square curvature is longer"),
    "rms_slope": Variable("1", "slope of the scan, root mean square"),
    "pixel": Variable("nm", "pixel size", "the larger of the two"),
    "plateau_size": Variable("1", "pixels of equal height at the peak"),
    "saddle": Variable("1", "the fit is no peak (curvature_min <= 0)"),
    "edge": Variable("1", "the fitted patch is clipped by the scan's edge"),
    "vertex_fixed": Variable("1", "the vertex was fixed at the peak pixel"),
    "tip_radius": Variable("nm", "apex radius of the tip"),
    "sharper_than_tip": Variable("1", "the summit is sharper than the tip"),
    "beyond_tip": Variable("1", "sharper than any image that the tip can draw"),
    "curvature_recovered": Variable("1/nm", "larger principal curvature, the tip taken off"),
    # solutions
    "subregion": Variable("1", "subregion"),
    "subregion_x": Variable("nm", "x of the contact centre"),
    "subregion_y": Variable("nm", "y of the contact centre"),
    "subpixel_x": Variable("nm", "contact centre's offset along x from the field's origin"),
    "subpixel_y": Variable("nm", "contact centre's offset along y from the field's origin"),
    "delta": Variable("nm", "displacement", "positive brings the bodies together; counted from the datum"),
    "load": Variable("nN", "prescribed load", "positive pushes"),
    "force": Variable("nN", "contact force", "positive pushes, negative pulls"),
    "contact_area": Variable("nm^2", "contact area"),
    "pressure": Variable("GPa", "contact pressure", "positive pushes, negative pulls"),
    "displacement": Variable("nm", "surface displacement", "of both bodies together, into the material"),
    "gap": Variable("nm", "gap", "between the deformed surfaces, zero in contact"),
    "converged": Variable("1", "the solve met its tolerance"),
    "iterations": Variable("1", "iterations of the solve"),
    "residual": Variable(
        "1", "largest violation of the contact conditions", "over the deepest overlap, or the largest pull of adhesion"
    ),
    "truncated": Variable("1", "contact or overlap reaches the scan's edge"),
    "contacts": Variable("1", "asperities in contact"),
    "contact_patches": Variable("1", "patches of contact", "connected cells that are more closed than open"),
    "contacts_beyond_patch": Variable("1", "contacts larger than their fitted patch"),
    "contacts_overlapping": Variable("1", "contacts that overlap a neighbour's"),
    "excluded_asperities": Variable("1", "asperities left out", "no peak under this sphere"),
    # adhesive contact
    "cycle": Variable("1", "cycle", "number of times that the place has been pressed on"),
    # yield
    "yielded_fraction": Variable(
        "1", "share of the force at or above the hardness", "of the elastic, or yielding, cells"
    ),
    "yielded_area_fraction": Variable("1", "share of the contact area at or above the hardness"),
    "yielded_area": Variable("nm^2", "area that has yielded", "at the hardness now, or earlier on the way"),
    "plastic_work": Variable("nN nm", "plastic work", "hardness times the volume that gave way"),
    "residual_height": Variable("nm", "height that is left", "negative where the surface has yielded"),
    "branch": Variable("1", "branch", "loading: delta grows; retraction: it falls, from the largest on"),
    "energy": Variable("nN nm", "potential energy", "elastic energy less the energy of adhesion"),
    "dissipated": Variable("nN nm", "energy dissipated so far", "freed in jumps"),
    "resolution": Variable("1", "radius of the smallest contact that matters in pixels of the solve"),
    "pull_off_resolution": Variable("1", "radius of the smallest contact that matters at pull-off, in pixels"),
    "preload": Variable("nN", "preload", "force at which the indenter turned back; 0: it settled by itself"),
    "preload_delta": Variable("nm", "displacement at the preload", "counted from the datum"),
    "refinement": Variable("1", "cells along a side of a pixel"),
    "pull_off_error": Variable("1", "estimated relative error of the pull-off force", "of mesh and step together"),
    "mesh_error": Variable("1", "change of the pull-off force from the mesh before"),
    "step_error": Variable("1", "change of the pull-off force by steps twice as long"),
    "interpolation_error": Variable("1", "change of the pull-off force by splines between the pixels"),
    "settling_error": Variable("1", "change of the pull-off force by a preload as large as it"),
    "complete": Variable("1", "the cycle could be followed to its end"),
    "snap_in_force": Variable("nN", "snap-in force", "positive magnitude of the pull right after first contact"),
    "snap_in_delta": Variable("nm", "displacement of first contact", "counted from the datum"),
    "detachment_delta": Variable("nm", "displacement at which all contact is lost", "counted from the datum"),
    "work_of_separation": Variable("nN nm", "work of separation", "done against the pull on retraction"),
    "hysteresis": Variable("nN nm", "energy lost in one cycle of approach and retraction"),
    "tabor_parameter": Variable("1", "Tabor's parameter", "large: short range (JKR), small: long range (DMT)"),
    # certificate
    "check": Variable("1", "condition of the contact"),
    "violation": Variable("1", "largest violation"),
    "limit": Variable("1", "largest that is allowed"),
    "met": Variable("1", "the violation is at most the limit"),
    "words": Variable("1", "in words"),
    # rigid bodies
    "touch_delta": Variable("nm", "displacement of first touch", "counted from the datum"),
    "meniscus_error": Variable(
        "1", "part of the pull that thin menisci leave out", "their edge's; the law is too high"
    ),
    "cell_error": Variable(
        "1", "relative error of the pull-off force by the cells", "how much less the exact touch pulls"
    ),
    "pull_beyond_contact": Variable("1", "part of the pull from beyond contact", "gaps over twice the length"),
    "formula": Variable("1", "formula for a sphere on a rough surface"),
    "formula_ratio": Variable("1", "pull-off by formula / by the sum over the scan"),
    "shortest_kept": Variable("nm", "shortest wavelength", "shorter waves are cut off, or were added"),
    "seed": Variable("1", "seed of the added roughness"),
    "sphere_maugis": Variable("1", "Maugis's parameter of the sphere", "with the pull and the work of the liquid"),
    "sphere_tabor": Variable("1", "Tabor's parameter of the sphere"),
    "asperity_tabor": Variable("1", "Tabor's parameter of the median asperity"),
    "pixels_per_contact": Variable("1", "radius of the median asperity's contact in pixels", "JKR"),
    "peak_pressure": Variable("GPa", "largest pressure under the median asperity", "Hertz's, under 2 pi w R"),
    "yields": Variable("1", "the median asperity yields under its own adhesion"),
    "recommended": Variable("1", "recommended model"),
    # statistics
    "pull_off_force": Variable("nN", "pull-off force", "positive magnitude of the largest pull"),
    "pull_off_delta": Variable("nm", "displacement at pull-off", "counted from the datum"),
    "bracketed": Variable("1", "the largest pull lies inside the sweep, not at its end"),
    "pull_off_ratio": Variable("1", "pull-off force, rough / smooth", "over that of the same sphere from a flat"),
    "debris": Variable("1", "debris", "far above what is usual at the other places"),
    "independent_places": Variable("1", "independent places", "effective sample size of correlated places"),
    "force_superposed": Variable("nN", "superposed force", "positive pushes"),
    "force_direct": Variable("nN", "force of the direct simulation", "positive pushes"),
    "force_difference": Variable("1", "superposed / direct force − 1"),
    "mean_difference": Variable("1", "superposed / direct mean force − 1"),
    "agreeing": Variable("1", "share of places where both agree", "of those in contact"),
    "parting_delta": Variable("nm", "displacement from which on both part", "counted from the datum"),
    "mean_parting_delta": Variable("nm", "displacement from which on the means part", "counted from the datum"),
    "overlap_fraction": Variable("1", "contacts that overlap a neighbour's", "of all contacts"),
    "pdf": Variable("", "probability density", "per unit of the variable"),
    "cdf": Variable("1", "cumulative probability"),
    "statistic": Variable("1", "statistic"),
    "resampling": Variable(
        "1", "resampling", "block: whole blocks of neighbouring places; naive: each place by itself"
    ),
    "estimate": Variable("", "estimate"),
    "low": Variable("", "lower end of the confidence interval"),
    "high": Variable("", "upper end of the confidence interval"),
    "law": Variable("1", "probability law"),
    "location": Variable("", "location of the law"),
    "scale": Variable("", "scale of the law"),
    "shape": Variable("1", "shape of the law"),
    "log_likelihood": Variable("1", "log-likelihood"),
    "aic": Variable("1", "Akaike's information criterion"),
    "aic_difference": Variable("1", "Akaike's criterion less that of the best law"),
    "akaike_weight": Variable("1", "Akaike weight", "how likely the law is the best of those compared"),
    "ks_distance": Variable("1", "Kolmogorov-Smirnov distance"),
    "ks_p_value": Variable("1", "p-value of the Kolmogorov-Smirnov distance", "by simulation, the law fitted anew"),
    # measured
    "predicted": Variable("", "predicted"),
    "predicted_low": Variable("", "predicted, lower end of the confidence interval"),
    "predicted_high": Variable("", "predicted, upper end of the confidence interval"),
    "measured": Variable("", "measured"),
    "measured_low": Variable("", "measured, lower end of the confidence interval"),
    "measured_high": Variable("", "measured, upper end of the confidence interval"),
    "ratio": Variable("1", "measured / predicted"),
    "ratio_low": Variable("1", "measured / predicted, lower end of the confidence interval"),
    "ratio_high": Variable("1", "measured / predicted, upper end of the confidence interval"),
    "probability": Variable("1", "probability"),
    "predicted_quantile": Variable("nN", "predicted pull-off force", "quantile at the probability"),
    "measured_quantile": Variable("nN", "measured pull-off force", "quantile at the probability"),
    "distribution_distance": Variable("1", "largest difference of the cumulative distributions"),
    "distribution_p_value": Variable("1", "p-value of that difference", "for the effective sample sizes"),
    "predicted_places": Variable("1", "independent places, predicted"),
    "measured_places": Variable("1", "independent places, measured"),
    "shift_x": Variable("nm", "shift along x", "from measured to predicted places"),
    "shift_y": Variable("nm", "shift along y", "from measured to predicted places"),
    "place_correlation": Variable("1", "correlation place by place", "of normal scores, after the shift"),
    "place_p_value": Variable("1", "p-value of that correlation", "by chance at any of the shifts tried"),
    "predicted_force": Variable("nN", "predicted pull-off force", "at the measured places, after the shift"),
    "measured_force": Variable("nN", "measured pull-off force", "positive magnitude"),
    "piezo": Variable("nm", "travel of the piezo", "grows towards the surface, from any zero"),
    "pull_off_uncertainty": Variable("nN", "standard error of the pull-off force", "by noise and baseline"),
    "pull_off_distance": Variable("nm", "distance from zero force to pull-off", "on retraction"),
    "force_noise": Variable("nN", "noise of the force", "standard deviation about the baseline"),
    "contact_point": Variable("nm", "travel of the piezo where the force is zero", "on retraction"),
    "contact_slope": Variable("nN/nm", "slope in contact", "force over the piezo's travel, in the upper half"),
    "baseline_offset": Variable("nN", "force of the baseline at the contact point", "as recorded"),
    "baseline_tilt": Variable("nN/nm", "tilt of the baseline", "force over the piezo's travel"),
    "piezo_distance": Variable("nm", "distance of the piezo from the contact point", "positive away from the surface"),
    "file": Variable("1", "file"),
    "fitted_work_of_adhesion": Variable("J/m^2", "fitted work of adhesion w"),
    "fitted_work_low": Variable("J/m^2", "fitted work of adhesion, lower end of the confidence interval"),
    "fitted_work_high": Variable("J/m^2", "fitted work of adhesion, upper end of the confidence interval"),
    "fitted_adhesion_range": Variable("nm", "fitted range of adhesion"),
    "fitted_range_low": Variable("nm", "fitted range of adhesion, lower end of the confidence interval"),
    "fitted_range_high": Variable("nm", "fitted range of adhesion, upper end of the confidence interval"),
    "trial_adhesion_range": Variable("nm", "range of adhesion tried"),
    "fitted_hardness": Variable("GPa", "fitted hardness"),
    "fitted_hardness_low": Variable("GPa", "fitted hardness, lower end of the confidence interval"),
    "fitted_hardness_high": Variable("GPa", "fitted hardness, upper end of the confidence interval"),
    "trial_hardness": Variable("GPa", "hardness tried"),
    "fitted_sphere_radius": Variable("nm", "fitted radius of the sphere"),
    "fitted_sphere_radius_low": Variable("nm", "fitted radius, lower end of the confidence interval"),
    "fitted_sphere_radius_high": Variable("nm", "fitted radius, upper end of the confidence interval"),
    "trial_sphere_radius": Variable("nm", "radius of the sphere tried"),
    "force_exponent": Variable("1", "d ln force / d ln fitted value", "near 0 the forces do not determine it"),
    "work_trade": Variable("1", "d ln fitted value / d ln w", "its change with the fixed work of adhesion"),
    "trial_work_of_adhesion": Variable("J/m^2", "work of adhesion tried"),
    "quantile_distance": Variable("1", "distance of the distributions", "rms of ln(measured / predicted quantile)"),
    "spread_ratio": Variable("1", "spread, measured / predicted", "standard deviations of the logarithms' quantiles"),
    "modulus_trade": Variable("1", "d ln w / d ln E*", "its change with the assumed modulus"),
    "surface": Variable("1", "surface"),
    "inside": Variable("1", "the measured statistic is within the predicted interval"),
    "was_fitted": Variable("1", "the work of adhesion was fitted on this surface"),
    # several scans
    "scan": Variable("1", "scan"),
    "pooled": Variable("", "pooled"),
    "pooled_low": Variable("", "pooled, lower end of the confidence interval"),
    "pooled_high": Variable("", "pooled, upper end of the confidence interval"),
    "between_std": Variable("", "standard deviation between scans", "beyond the scatter of their places"),
    "between_p_value": Variable("1", "p-value of the differences", "by the scatter of places alone"),
    "standard_error": Variable("", "standard error"),
    # error budget
    "factor": Variable("1", "changed assumption"),
    "setting": Variable("1", "changed value"),
    "parameter_ratio": Variable("1", "changed parameter over the assigned one"),
    "slope": Variable("1", "slope of ln pull-off with ln parameter"),
    "pull_off_mean": Variable("nN", "mean pull-off force"),
    "pull_off_std": Variable("nN", "standard deviation of the pull-off force"),
    "pull_off_median": Variable("nN", "median pull-off force"),
    "pull_off_change": Variable(
        "1", "change of the mean pull-off force", "over the base case on cells of the same size"
    ),
    "reason": Variable("1", "why it was not computed"),
    "entry": Variable("1", "source of error"),
    "relative_error": Variable("1", "error of the mean pull-off force", "one standard deviation over the mean"),
    "how": Variable("1", "how it was computed"),
    "total_error": Variable("1", "error of the mean pull-off force, all entries", "root of the sum of squares"),
    "total_standard_error": Variable("1", "standard error of that"),
    "known_bias": Variable("1", "the change is a known bias, taken off the mean"),
    "pull_off_corrected": Variable("nN", "mean pull-off force without known biases"),
    "places": Variable("1", "places known in both cases"),
    "missing_places": Variable("1", "places that could not be followed"),
    "contact_radius_pixels": Variable("1", "radius of the smallest contact that matters", "pixels of the scan"),
    # extrapolated below the scan
    "pull_off_lower": Variable("nN", "mean pull-off force, lower end of its 95 % interval"),
    "pull_off_upper": Variable("nN", "mean pull-off force, upper end of its 95 % interval"),
    "scale_pull_off": Variable("nN", "mean pull-off force at a few places", "as shorter waves are added"),
    "added_rms": Variable("nm", "standard deviation of the waves that were added"),
    # rolling, sliding, lifting
    "direction": Variable("rad", "direction of rolling", "from x towards y"),
    "resisting_moment": Variable("nN nm", "resisting moment", "the largest as the sphere begins to roll"),
    "hinge_distance": Variable("nm", "distance of the contact's edge", "from the sphere's axis, towards the direction"),
    "tipping_pull": Variable("nN", "pull at the axis that tips the sphere", "inf where the edge lies behind the axis"),
    "tipping_hinge_distance": Variable("nm", "distance of the contact's edge under the tipping pull"),
    "lever": Variable("nm", "lever", "resisting moment over pull-off force"),
    "weakest_direction": Variable("rad", "direction of the smallest resisting moment", "from x towards y"),
    "stiffest_direction": Variable("rad", "direction of the largest resisting moment", "from x towards y"),
    "weakest_ties": Variable("1", "another direction resists as little", "to a millionth of the largest moment"),
    "stiffest_ties": Variable("1", "another direction resists as much", "to a millionth of the largest moment"),
    "rest_delta": Variable("nm", "displacement at rest", "under the load, counted from the highest peak"),
    # coming to rest
    "landing_share": Variable("1", "share of particles", "of the area from which they come to lie there; sums to 1"),
    "rest_height": Variable("nm", "height of the sphere's lowest point at rest", "over the scan's zero"),
    "carriers": Variable("1", "summits that carry the sphere", "rigid bodies"),
    "carrier": Variable("1", "carrying summit"),
    "carrier_x": Variable("nm", "x where the sphere touches the summit"),
    "carrier_y": Variable("nm", "y where the sphere touches the summit"),
    "barrier": Variable("nm", "height of the lowest pass over the rest"),
    "pass_x": Variable("nm", "x of the lowest pass"),
    "pass_y": Variable("nm", "y of the lowest pass"),
    "pass_to": Variable("1", "place of rest beyond the lowest pass", "-1: the sphere rolls off the scan"),
    "critical_friction_velocity": Variable("m/s", "critical friction velocity", "at which the sphere comes off"),
    "critical_acceleration": Variable("m/s^2", "critical acceleration", "at which the sphere comes off"),
    "critical_angle": Variable("rad", "critical angle of tilt", "at which the sphere comes off"),
    "mode": Variable("1", "what gives way first", "roll, slide, lift, none or no contact"),
    "in_range": Variable("1", "the load's formulas are valid"),
    "friction_velocity": Variable("m/s", "friction velocity"),
    "time": Variable("s", "time"),
    "remaining": Variable("1", "fraction remaining", "mean over places"),
    "remaining_low": Variable("1", "fraction remaining, lower end of its confidence interval"),
    "remaining_high": Variable("1", "fraction remaining, upper end of its confidence interval"),
    "remaining_here": Variable("1", "probability that the particle is still there"),
    # what other codes take
    "moment_mean": Variable("nN nm", "resisting moment, geometric mean over places and directions"),
    "moment_spread": Variable("1", "resisting moment, geometric standard deviation"),
    "moment_over_directions": Variable("nN nm", "resisting moment, mean over directions"),
    "moment_least": Variable("nN nm", "resisting moment, smallest over directions"),
    "moment_largest": Variable("nN nm", "resisting moment, largest over directions"),
    "adhesion_mean": Variable("1", "pull-off over that of the smooth sphere, geometric mean of a log-normal law"),
    "adhesion_spread": Variable("1", "pull-off over that of the smooth sphere, geometric standard deviation of it"),
    "adhesion_law_distance": Variable("1", "Kolmogorov-Smirnov distance of the places from that law"),
    "work_of_adhesion_median": Variable(
        "J/m^2", "work of adhesion of a smooth JKR sphere that pulls off as hard, median"
    ),
    "work_of_adhesion_low": Variable("J/m^2", "work of adhesion of a smooth JKR sphere that pulls off as hard, 5 %"),
    "work_of_adhesion_high": Variable("J/m^2", "work of adhesion of a smooth JKR sphere that pulls off as hard, 95 %"),
    "surface_energy_median": Variable("J/m^2", "half of that work, median (gamma of LAMMPS' jkr)"),
    "lever_median": Variable("1", "lever over the sphere's radius, median"),
    "lever_low": Variable("1", "lever over the sphere's radius, 5 %"),
    "lever_high": Variable("1", "lever over the sphere's radius, 95 %"),
    "rolling_friction_median": Variable(
        "1", "half of that lever, median (mu_roll of LAMMPS' rolling sds, without load)"
    ),
    "asperity_density": Variable("1/nm^2", "asperities on each area (denasp of code_saturne)"),
    "asperity_radius": Variable("nm", "median radius of asperities (rayasp of code_saturne)"),
    "asperity_coverage": Variable(
        "1", "pi times density and squared radius of asperities", "1 at most, of hemispheres"
    ),
    "large_asperity_spacing": Variable("nm", "mean distance of large asperities (espasg of code_saturne)"),
    "large_asperity_radius": Variable("nm", "median radius of large asperities (rayasg of code_saturne)"),
    # one asperity, one sphere
    "thin_force": Variable("nN", "contact force by the law of thin menisci", "positive pushes, negative pulls"),
    "distance": Variable("nm", "distance from the plane", "of the sphere's lowest point"),
    "semi_axis_a": Variable("nm", "longer semi-axis of the contact ellipse"),
    "semi_axis_b": Variable("nm", "shorter semi-axis of the contact ellipse"),
}

#: What each kind of Dataset must hold: variable name -> dimensions.
KINDS: dict[str, dict[str, tuple[str, ...]]] = {
    "scan": {"height": ("x", "y")},
    "asperities": {
        "height": ("asperity",),
        "curvature_min": ("asperity",),
        "curvature_max": ("asperity",),
        "orientation": ("asperity",),
    },
    "solution": {"force": ("subregion", "delta")},
    "pull_off": {"pull_off_force": ("subregion",)},
    "line": {"height": ("x",)},
}

#: Scalar coordinates of a scan once a pair is assigned; they travel into every result and archive.
PAIR = ("sphere_radius", "contact_modulus", "work_of_adhesion")

#: The same, with what may be assigned beside it.
TRAVELLING = (
    *(*PAIR, "adhesion_range", "hamaker_constant", "retardation", "hardness", "hardness_estimate"),
    *("humidity", "kelvin_radius", "surface_tension", "contact_angle_1", "contact_angle_2"),
    *("liquid_film", "share_under_liquid"),
)


def attributes(name: str) -> dict[str, str]:
    """Return the attributes of a variable of this name: long name, and units and comment where there are any."""
    known = VARIABLES[name]
    attrs = {"long_name": known.long_name, **({"units": known.units} if known.units else {})}
    return {**attrs, "comment": known.comment} if known.comment else attrs


def axis_label(name: str) -> str:
    """Return the label of an axis: long name and units."""
    known = VARIABLES[name]
    return known.long_name if known.units in ("1", "") else f"{known.long_name} [{known.units}]"
