"""The recommended model for a scan and a pair of bodies, and the usual formulas for comparison."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..asperity.catalogue import catalogue_of
from ..bodies.pair_record import read_pair
from ..kernels.adhesion import potentials
from ..kernels.asperity.maugis import PER_TABOR
from ..scans import regions
from ..scans.fine_scales import smooth
from ..scans.levelling import level
from ..specimen import Specimen, specimen_of
from ..vocabulary import schema
from ..vocabulary.adhesion_laws import HAMAKER, LONG_RANGE, SHORT_RANGE, read_law
from ..vocabulary.refusal import Refusal
from ..vocabulary.units import Places
from . import reference
from .estimates import automatic_law, median_tabor
from .rigid.attraction import read_options
from .rigid.bodies import rigid


@schema.recorded
def regime(ds: xr.Dataset | Specimen, *, subregions: Places = (4, 4), mesh: int = 8) -> xr.Dataset:
    """Recommend a model for a scan and its pair: rigid bodies, the adhesive simulation, or a sum over asperities.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned sphere and work of adhesion. Tabor's parameter uses the pair's range of adhesion,
        ``yields`` its ``hardness``, else its ``hardness_estimate``.
    subregions : (int, int), (array, array) or Dataset
        Contact centres at which the attraction between rigid bodies is summed; by default a grid of 4 × 4.
    mesh : int
        Cells along a side of a pixel, see `rigid`.

    Returns
    -------
    Dataset
        ``sphere_tabor``, ``asperity_tabor`` (of the median asperity), ``share_beyond_contact`` (median over the
        centres), ``pixels_per_contact`` (below 1 the scan does not resolve a contact), ``peak_pressure`` (GPa) and, for
        a known hardness, ``yields``; ``recommended`` ("rigid", "adhesive" or "superpose"), in words by `answer`. For a
        humid pair Tabor's parameters are the larger of those of the liquid's law and of the solids' law under it, and
        ``sphere_maugis`` is Maugis's parameter of the liquid's law.

    Raises
    ------
    ValueError
        If the scan has no peaks, or the pair no work of adhesion.

    Notes
    -----
    Asperities with a Tabor parameter below 0.1 hardly deform: take `rigid`. From 5 on the range of adhesion may be
    neglected. A sum over asperities is then fast and valid, if less than half of the adhesion force comes from outside
    contact. Otherwise take the adhesive simulation, with the law that its "auto" chooses: without range ("jkr")
    from 5 on; of finite range ("exponential") below, with a hardness, and for a humid pair. The attribute ``law`` names
    it.

    References
    ----------
    Tabor, J. Colloid Interface Sci. 58 (1977) 2, doi:10.1016/0021-9797(77)90366-6; Johnson & Greenwood, J. Colloid
    Interface Sci. 192 (1997) 326, doi:10.1006/jcis.1997.4984.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> found = scan.contact.regime(subregions=(2, 2))
    >>> found.recommended.item(), found.law
    ('adhesive', 'exponential')
    """
    specimen = need_sphere(ds)
    bodies = specimen.bodies
    pair = read_pair(bodies, "contact_modulus", half_space=True)
    radius = pair.sphere_radius
    modulus = pair.contact_modulus
    w = pair.work
    humid = pair.menisci is not None
    tip = 1 / (1 / radius + 1 / _asperity_radius(catalogue_of(specimen.scan)))
    contact, _ = pair.contact_at_pull_off(tip, w)
    close = rigid(specimen, subregions=subregions, mesh=mesh, delta=[0.0])
    result = {
        "sphere_tabor": float(max(pair.tabor_parameters(radius))),
        "asperity_tabor": float(max(pair.tabor_parameters(tip))) if humid else median_tabor(specimen),
        "share_beyond_contact": float(close.share_beyond_contact.median()),
        "pixels_per_contact": contact / specimen.pixel,
        "peak_pressure": _peak_pressure(tip, modulus, w),
    }
    if humid:
        result["sphere_maugis"] = PER_TABOR * float(pair.tabor_parameters(radius)[-1])
    if np.isfinite(pair.hardness):
        result["yields"] = result["peak_pressure"] > pair.hardness
    beyond = 1.0 if humid else result["share_beyond_contact"]
    result["recommended"] = _recommended(result["asperity_tabor"], beyond)
    out = xr.Dataset(result, schema.pair_coordinates(bodies)).set_coords("recommended")
    out.attrs["law"] = automatic_law(result["asperity_tabor"], yields=pair.yields, humid=humid)
    return schema.label(out)


def _recommended(tabor: float, beyond: float) -> str:
    if tabor < LONG_RANGE:
        return "rigid"
    # largest share of the adhesion force from outside contact for which a sum over asperities is recommended
    return "superpose" if tabor >= SHORT_RANGE and beyond < 0.5 else "adhesive"


def _peak_pressure(radius: float, modulus: float, w: float) -> float:
    """Return Hertz's largest pressure (GPa) of a stiff summit under its adhesion force 2πwR."""
    return (12 * w * modulus**2 / (np.pi**2 * radius)) ** (1 / 3)


@schema.recorded
def formulas(
    ds: xr.Dataset | Specimen, *, subregions: Places = (4, 4), law: str = HAMAKER, mesh: int = 8
) -> xr.Dataset:
    """Return the pull-off on a scan by the usual formulas, and by the sum over the scan itself.

    Parameters
    ----------
    ds : Dataset
        A scan with an assigned sphere and work of adhesion.
    subregions : (int, int), (array, array) or Dataset
        Contact centres at which the scan is summed; by default a grid of 4 × 4.
    law, mesh
        Options of that sum, see `rigid`.

    Returns
    -------
    Dataset
        ``pull_off_force`` (nN) and ``formula_ratio``, its ratio to the row "sum", along ``formula``; see Notes for the
        rows. Attributes contain the formulas' inputs from the scan: ``rms``, ``wavelength`` (the mean distance between
        summits), ``asperity_radius`` (median of the summits), ``long_rms``, ``long_wavelength``, nm, and
        ``hamaker_constant``, nN nm, or ``meniscus_height``, nm.

    Raises
    ------
    ValueError
        If the scan has no peaks, or the pair no work of adhesion.

    Notes
    -----
    Customary are "rumpf_rms", which needs the rms height alone, and "rabinovich", with the distance of summits. All
    formulas but "gaussian_heights" have one asperity under the sphere's lowest point, at w = A/(12π z₀²).

    Rows of a dry pair:

    - "sum": attraction between rigid bodies, summed over the scan itself; the median of the places;
    - "bradley": a smooth sphere on a smooth flat, 2πwR as by DMT;
    - "rumpf": a hemisphere of the summits' median radius on a flat;
    - "rumpf_rms": the same with a radius of 1.48 rms;
    - "rabinovich": a spherical cap of height 1.82 rms and radius λ²/(58 rms), λ being ``wavelength``;
    - "rabinovich_two_scales": such caps on larger ones, whose wavelengths exceed four mean distances between summits;
      NaN on a scan too small for them;
    - "gaussian_heights": 2πR times the work of adhesion of a flat over Gaussian heights of this rms.

    Rows of a humid pair: "sum" and "gaussian_heights" as above; "smooth", 4πRγ cos θ for equal angles; "summit", the
    same for the composite radius of the sphere and a summit of the median radius; "plane_below", the sphere over a
    plane 1.82 rms below it.

    References
    ----------
    Rumpf, Particle Technology (1990); Rabinovich et al., J. Colloid Interface Sci. 232 (2000) 10 and 17,
    doi:10.1006/jcis.2000.7167 and .7168; of liquid McFarlane & Tabor, Proc. R. Soc. A 202 (1950) 224,
    doi:10.1098/rspa.1950.0096; Rabinovich et al., Adv. Colloid Interface Sci. 96 (2002) 213.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> table = scan.contact.formulas(subregions=(2, 1))
    >>> float(table.formula_ratio.sel(formula="sum")), bool(table.formula_ratio.sel(formula="bradley") > 5)
    (1.0, True)
    """
    specimen = need_sphere(ds)
    law = read_law(law, "rigid")
    summed = rigid(specimen, subregions=subregions, delta=[0.0], law=law, mesh=mesh)
    pull_offs = _humid_formulas if specimen.pair.menisci is not None else _dry_formulas
    result, inputs = pull_offs(specimen, law, _inputs(specimen))
    force = np.array([float(summed.pull_off_force.median()), *result.values()])
    columns = {"pull_off_force": ("formula", force), "formula_ratio": ("formula", force / force[0])}
    out = xr.Dataset(columns, {"formula": ["sum", *result]}, attrs=inputs)
    if np.isnan(force).any():
        out.attrs["missing"] = "NaN: the scan is too small for wavelengths of four mean distances between summits"
    return schema.label(out)


def _dry_formulas(specimen: Specimen, law: str, inputs: dict[str, float]) -> tuple[dict[str, float], dict[str, float]]:
    """Return the pull-offs (nN) of a dry pair by formulas, and their inputs."""
    radius = specimen.pair.sphere_radius
    w = specimen.pair.work
    z0 = specimen.pair.closest_approach
    sphere = {"radius": radius, "hamaker_constant": 12 * np.pi * z0**2 * w, "closest_approach": z0}
    short = {"rms": inputs["short_rms"], "wavelength": inputs["wavelength"]}
    long = {name: inputs[name] for name in ("long_rms", "long_wavelength")}
    mean_work = reference.gaussian_work(rms=inputs["rms"], length=z0, work_of_adhesion=w, law=HAMAKER)
    result = {
        "bradley": 2 * np.pi * w * radius,
        "rumpf": reference.rumpf(asperity_radius=inputs["asperity_radius"], **sphere),
        "rumpf_rms": reference.rumpf(rms=inputs["rms"], **sphere),
        "rabinovich": reference.rabinovich(rms=inputs["rms"], wavelength=inputs["wavelength"], **sphere),
        "rabinovich_two_scales": reference.rabinovich(**short, **long, **sphere) if long["long_rms"] > 0 else np.nan,
        "gaussian_heights": 2 * np.pi * radius * mean_work,
    }
    return result, inputs | {name: sphere[name] for name in ("hamaker_constant", "closest_approach")}


def _humid_formulas(
    specimen: Specimen, law: str, inputs: dict[str, float]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the pull-offs (nN) of a humid pair by formulas (thin menisci over the solids), and their inputs."""
    radius = specimen.pair.sphere_radius
    menisci = specimen.pair.menisci
    assert menisci is not None
    summit = 1 / (1 / radius + 1 / inputs["asperity_radius"])
    # height of summits over the mean plane, in rms heights, by Rabinovich et al.
    open_gap = max(1 - 1.82 * inputs["rms"] / menisci.height, 0.0)
    over_heights = potentials.gaussian_mean(read_options(specimen, law).law, inputs["rms"])
    bodies_and_works = {
        "smooth": (radius, specimen.pair.work),
        "summit": (summit, specimen.pair.work),
        "plane_below": (radius, menisci.work * open_gap),
        "gaussian_heights": (radius, over_heights),
    }
    result = {name: 2 * np.pi * R * w for name, (R, w) in bodies_and_works.items()}
    return result, inputs | {"meniscus_height": menisci.height}


def _inputs(specimen: Specimen) -> dict[str, float]:
    """Return the formulas' inputs from a scan, nm."""
    flat = _flat(specimen)
    catalogue = catalogue_of(flat.scan)
    distance = _mean_distance(catalogue)
    inputs = {"rms": float(flat.heights.std()), "wavelength": distance}
    inputs["asperity_radius"] = _asperity_radius(catalogue)
    # wavelength, in mean distances between summits, that divides Rabinovich's two scales
    long_wavelength = 4.0
    if long_wavelength * distance > 2 * flat.pixel * max(flat.heights.shape):  # the scan has no wavelengths that long
        return inputs | {"short_rms": inputs["rms"], "long_rms": np.nan, "long_wavelength": np.nan}
    smoothed = Specimen(smooth(flat.scan, shortest=long_wavelength * distance))
    return inputs | {
        "short_rms": float((flat.heights - smoothed.heights).std()),
        "long_rms": float(smoothed.heights.std()),
        "long_wavelength": _mean_distance(catalogue_of(smoothed.scan)),
    }


def _flat(specimen: Specimen) -> Specimen:
    """Return the specimen without its mean plane; unchanged if the tilt is rounding."""
    levelled = Specimen(level(specimen.scan))
    heights = specimen.heights
    # largest tilt by rounding, as a part of the range of heights
    return specimen if np.ptp(levelled.heights - heights) <= 1e-12 * np.ptp(heights) else levelled


def _mean_distance(catalogue: xr.Dataset) -> float:
    """Return the mean distance (nm) between summits: the root of the area per summit."""
    along_x, along_y = regions.sides(catalogue)
    return float(np.sqrt(along_x * along_y / max(catalogue.sizes["asperity"], 1)))


def _asperity_radius(catalogue: xr.Dataset) -> float:
    """Return the median radius (nm) of the summits, each the geometric mean of its two principal radii."""
    both = catalogue["curvature_min"].values * catalogue["curvature_max"].values
    peaks = catalogue["curvature_min"].values > 0
    if not peaks.any():
        raise Refusal("height", "peaks on the scan", "none (is it flat?)")
    return float(np.median(1 / np.sqrt(both[peaks])))


def need_sphere(ds: xr.Dataset | Specimen) -> Specimen:
    """Return the specimen of a scan, computed at once; raise unless a sphere and adhesion are assigned."""
    specimen = specimen_of(ds)
    specimen = Specimen(specimen.scan) if specimen.lazy else specimen
    specimen.pair.need("sphere_radius", "work_of_adhesion")
    return specimen
