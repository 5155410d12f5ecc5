"""Bodies too stiff to deform: the attraction of the whole surface under the indenter, in contact or not."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ...jobs import spread
from ...kernels.adhesion import potentials
from ...kernels.adhesion import rigid as kernels
from ...specimen import Specimen, need_wide_scan, specimen_of
from ...vocabulary import schema
from ...vocabulary.adhesion_laws import ADHESION_LAWS, HAMAKER, read_law
from ...vocabulary.text import Argument, Phrase, warn
from ...vocabulary.units import Places, Quantities, whole_number
from ..mesh import UnresolvedContact
from ..problem import first_touches, read_problem
from ..solving import solve
from .attraction import Options, read_options, window_half_width
from .rigid_places import rigid_layout, rigid_record

#: Number of default displacements.
_COUNT = 60

#: Height (nm) above the first touch of all places where they start.
_START_HEIGHT = 10.0


@schema.recorded
def rigid(
    ds: xr.Dataset | Specimen,
    *,
    delta: Quantities | None = None,
    subregions: Places = None,
    law: str = HAMAKER,
    mesh: int = 1,
    datum: str = "highest_peak",
    fields: bool = False,
) -> xr.Dataset:
    """Sum the attraction between the assigned indenter and the scan across the gap, both too stiff to deform.

    Parameters
    ----------
    ds : Dataset
        A scan with square pixels and an assigned pair with a work of adhesion.
    delta : array_like, optional
        Displacements, nm, ascending; by default 60, from 10 nm above the highest first touch to the lowest.
    subregions : (int, int), (array, array) or Dataset, optional
        Contact centres: a grid, x and y (nm), or a Dataset with them, see `regions.centres`. By default those on
        ``ds``, else one in its middle.
    law : {"hamaker", "lennard_jones", "exponential", "dugdale"}
        Traction across a gap; all laws have the same work of adhesion. "hamaker" ends at
        the closest approach z₀ = √(A/(12πw)), 0.165 nm where no Hamaker constant is assigned. It is retarded if the
        pair has a wavelength of retardation. The other laws have the pair's range of adhesion.
    mesh : int
        Sum over mesh × mesh cells in each pixel, with heights interpolated without wavelengths below two pixels.
    datum : {"highest_peak", "first_contact"}
        Where delta = 0, as in `direct`.
    fields : bool
        Keep pressure and gap on the window around each centre.

    Returns
    -------
    Dataset
        ``force`` (nN) along (subregion, delta), NaN where the bodies cannot come so close; along subregion
        ``pull_off_force`` and ``pull_off_delta``, the largest adhesion force at any displacement; ``touch_delta`` (nm),
        the first touch; ``share_beyond_contact``, the share of the pull-off force from gaps above twice the law's
        length; ``cell_error``, the relative excess of the pull-off force by the cells (divide by 1 + ``cell_error``);
        ``truncated``, if more than 1 % of the pull-off force comes from beyond the scan. For a humid pair also
        ``meniscus_error``, the probable relative excess by the law of thin menisci, and ``work_of_separation`` (nN nm),
        from the pull-off on at constant humidity. Lazy if the scan is a dask array.

    Raises
    ------
    ValueError
        If the pair has no work of adhesion, ``law`` is not among those listed, or ``mesh`` is no whole number.

    Warns
    -----
    UserWarning
        If a cell at closest approach gives more than a fifth of the adhesion force at most centres (input in memory
        only).

    Notes
    -----
    The adhesion force is the sum of tractions over the gaps of all pixels: those on the indenter's front less those on
    its back. Where the indenter has risen by more than 300 nm (or ten times the range of heights), the surface is its
    mean plane. Each cell has the gap of its centre, also at first touch. This overestimates the force by
    ``cell_error``, which is proportional to the square of the cell size. Near a summit of radius r, cells should be
    smaller than √(2 r z₀), about 3 nm: choose ``mesh`` accordingly.

    Liquid adds the tension γ/r_K where the gap, counted from contact, is below the height of a meniscus. The solids
    under the liquid keep a share of their attraction (`assign_pair`).

    References
    ----------
    Bhattacharjee & Elimelech, J. Colloid Interface Sci. 193 (1997) 273, doi:10.1006/jcis.1997.5076; Rajupet et al.,
    Langmuir 37 (2021) 13208. For liquid Butt & Kappl, Adv. Colloid Interface Sci. 146 (2009) 48,
    doi:10.1016/j.cis.2008.10.002, and see `assign_pair`.

    Examples
    --------
    >>> import roughxr
    >>> scan = roughxr.open_sample("rough").contact.assign_pair(sphere_radius=500, materials="glass")
    >>> stiff = scan.contact.rigid(subregions=(2, 2), mesh=4)
    >>> dict(stiff.force.sizes), bool((stiff.pull_off_force > 0).all())
    ({'subregion': 4, 'delta': 60}, True)
    """
    specimen = specimen_of(ds)
    need_wide_scan(specimen.heights, specimen.sides, specimen.pair.sphere_radius)
    law = read_law(law, "rigid")
    mesh = whole_number(mesh, "mesh", least=1, most=64)
    options = read_options(specimen, law)
    options = options._replace(area=options.area / mesh**2)
    positions = specimen.centres(subregions)
    steps = _default_deltas(specimen) if delta is None else delta
    problem = read_problem(specimen, positions, delta=steps, datum=datum, refine=mesh)
    out = solve(
        rigid_record,
        specimen,
        problem,
        rigid_layout(problem, is_humid="humidity" in specimen.bodies.coords),
        options,
        name="rigid",
        positions=positions,
        reach=window_half_width(specimen, problem),
        fields=fields,
    )
    length = {"closest_approach" if ADHESION_LAWS[law].has_closest_approach else "adhesion_range": options.law.length}
    out.attrs = {"datum": datum, "method": "rigid", "law": law, "mesh": mesh, **length}
    out.attrs["missing"] = "NaN where the bodies cannot come so close"
    out = spread.finish(schema.label(out))
    if not specimen.lazy:
        _warn(out, options)
    return out


def _warn(out: xr.Dataset, options: Options) -> None:
    """Warn if a single cell dominates the adhesion force."""
    pull = out["pull_off_force"]
    if pull.chunks:
        return
    law = options.law
    largest = law.closest if law.closest is not None else potentials.LARGEST_AT * law.length
    share = options.area * potentials.traction(max(largest, kernels.smallest_gap(law)), law) / float(pull.median())
    # the result depends on the cell size if one cell gives a larger share of the adhesion force than this
    if share > 0.2:
        warn(
            Phrase(
                f"rigid: a single cell at closest approach gives {min(share, 1):.0%} of the median pull-off, which "
                "therefore depends on the size of the cells; set ",
                Argument("mesh", ...),
                ", or use a scan on finer pixels",
            ),
            UnresolvedContact,
        )


def _default_deltas(specimen: Specimen) -> np.ndarray:
    """Return displacements (nm) from above the first touch of all places to the lowest height."""
    middle = specimen.centres(tuple(min(16, count) for count in specimen.heights.shape))
    deepest = float(first_touches(specimen, middle).max())
    return np.linspace(-_START_HEIGHT, deepest, _COUNT)
