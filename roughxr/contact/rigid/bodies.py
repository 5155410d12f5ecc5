"""Bodies too stiff to deform: the pull of the whole surface that faces the indenter, in contact or not."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...jobs import spread
from ...kernels.adhesion import potentials
from ...kernels.adhesion import rigid as kernels
from ...specimen import Specimen, specimen_of
from ...vocabulary import schema
from ...vocabulary.text import warn
from ...vocabulary.units import Places, Quantities, whole_number
from ..problem import first_touches, read_problem
from .attraction import Options, options_of
from .rigid_places import at_places

#: Default displacements: their number, and the height (nm) above the first touch of all places where they start.
_COUNT, _START_HEIGHT = 60, 10.0

#: Share of the pull in one cell above which the result depends on the size of cells.
_ONE_CELL_SHARE = 0.2


def rigid(
    ds: xr.Dataset | Specimen,
    *,
    delta: Quantities | None = None,
    subregions: Places = None,
    law: str = "hamaker",
    refine: int = 1,
    datum: str = "highest_peak",
    fields: bool = False,
) -> xr.Dataset:
    """Sum the attraction between the assigned indenter and the scan across the gap, both too stiff to deform.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair with a work of adhesion.
    delta : array_like, optional
        Displacements, nm, ascending; by default 60 from 10 nm above the highest touch to the deepest.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres, see `regions.centres`.
    law : {"hamaker", "lennard_jones", "exponential", "dugdale"}
        Traction across a gap; all laws have the same work of adhesion. "hamaker" ends at
        the closest approach z₀ = √(A/(12πw)), 0.165 nm where no Hamaker constant is assigned, and is retarded where a
        wavelength of retardation is; the others have the pair's range of adhesion.
    refine : int
        Sum over refine × refine cells in each pixel, heights interpolated without waves shorter than two pixels.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0, as in `direct`.
    fields : bool
        Keep pressure and gap on the window around each centre.

    Returns
    -------
    Dataset
        ``force`` (nN) along (subregion, delta), NaN where the bodies cannot come so close; along subregion
        ``pull_off_force`` and ``pull_off_delta``, the largest pull at any displacement, ``touch_delta`` (nm, of first
        touch), ``pull_beyond_contact``, the share of that pull from cells more than twice the law's length apart,
        ``cell_error``, the part by which it is too high (divide by 1 + ``cell_error``), and ``truncated``, where more
        than 1 % of it comes from beyond the scan. Of a humid pair also ``meniscus_error``, the share by which the law
        of thin menisci is probably too high, and ``work_of_separation`` (nN nm, from the largest pull on at constant
        humidity). Lazy where the scan is a dask array.

    Warns
    -----
    UserWarning
        If a cell at closest approach holds more than a fifth of the pull at most centres (input in memory only).

    Notes
    -----
    The pull is the sum of tractions over the gaps of all pixels, on the indenter's front less those on its back. Where
    the indenter has risen by more than 300 nm (or ten times the range of heights), the ground is its mean plane. Within
    a cell the gap is that of its middle, also where bodies first touch: ``cell_error`` states by how much this pulls
    too hard; it falls with the square of the cells. Near a summit of radius r these should be smaller than √(2 r z₀),
    some 3 nm: ``refine`` makes them so.

    Liquid adds its pull γ/r_K where the gap, counted from contact, is less than the height of a meniscus, and leaves
    the solids a share of their own (`assign_pair`).

    References
    ----------
    Bhattacharjee & Elimelech, J. Colloid Interface Sci. 193 (1997) 273; Rajupet et al., Langmuir 37 (2021) 13208. For
    liquid Butt & Kappl, Adv. Colloid Interface Sci. 146 (2009) 48, and see `assign_pair`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius=3000, materials="glass")
    >>> found = rigid(scan, subregions=(2, 2))
    >>> dict(found.force.sizes), bool((found.pull_off_force > 0).all())
    ({'subregion': 4, 'delta': 60}, True)
    """
    specimen = specimen_of(ds)
    refine = whole_number(refine, "refine", least=1, most=64)
    options = options_of(specimen, law)
    options = options._replace(area=options.area / refine**2)
    positions = specimen.centres(subregions)
    steps = _default_deltas(specimen) if delta is None else delta
    problem = read_problem(specimen, positions, delta=steps, datum=datum, refine=refine)
    out = at_places(specimen, positions, problem, options, fields=fields)
    length = {"closest_approach" if law == "hamaker" else "adhesion_range": options.law.length}
    out.attrs = {"datum": datum, "method": "rigid", "law": law, "refine": refine, **length}
    out.attrs["missing"] = "NaN where the bodies cannot come so near"
    arguments = {"delta": problem.steps, "subregions": subregions, "datum": datum, "law": law, "refine": refine}
    out = schema.record(schema.label(out), "rigid", specimen.bodies, fields=fields, **arguments)
    out = spread.finish(out)
    if not specimen.lazy:
        _warn(out, options)
    return out


def _warn(out: xr.Dataset, options: Options) -> None:
    """Warn where the pull is that of a single cell at its closest approach."""
    pull = out["pull_off_force"]
    if pull.chunks:
        return
    law = options.law
    largest = law.closest if law.closest is not None else potentials.LARGEST_AT * law.length
    share = options.area * potentials.traction(max(largest, kernels.floor(law)), law) / float(pull.median())
    if share > _ONE_CELL_SHARE:
        warn(
            f"rigid: a single cell at closest approach makes up {min(share, 1):.0%} of the median pull-off, which so "
            "depends on the size of the cells; take refine, or a scan with add_fine_roughness"
        )


def _default_deltas(specimen: Specimen) -> np.ndarray:
    """Return displacements (nm) from above the highest touch of all places to where the lowest height is reached."""
    middle = specimen.centres(tuple(min(16, count) for count in specimen.heights.shape))
    deepest = float(first_touches(specimen, middle).max())
    return np.linspace(-_START_HEIGHT, deepest, _COUNT)
