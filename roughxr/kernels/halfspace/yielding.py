"""What yields at a hardness H: the shape that a contact leaves behind.

Loading to a displacement δ (``displacement_control``, ``load_control``) meets, with A p the elastic displacement,

    0 ≤ p ≤ H,     g = S + A p − δ,     g ≥ 0 where p = 0,     g = 0 where 0 < p < H,     g ≤ 0 where p = H

(Almqvist et al. 2007; Weber et al. 2018): cells at the hardness give way by −g. As δ grows their pressure stays and no
other falls, since a flat punch presses down everywhere; nor does any cell sink elastically by more than δ grows. So a
cell that yields goes on yielding, and what is left at δ hangs on δ alone, not on the way there: the height −g lost
where p = H. On the surface without it the same pressures are the elastic solution. From there retraction, and loading
again up to δ, are elastic, with pressures that fall with δ everywhere: nothing yields twice.

The work done by H on the volume lost, H Σ −g dx², is what one cycle dissipates. Source: own, on the works cited.
"""

import numpy as np

#: What rounding may take off a pressure at the hardness.
_ROUNDING = 1e-9


def residual_heights(pressures, displacements, separation, deltas, hardness):
    """Return the heights (nm, ≤ 0) that are left after loading: zero but where the pressure reached the hardness.

    Parameters
    ----------
    pressures, displacements : (delta, nx, ny) array
        Of the solutions, GPa and nm.
    separation : (nx, ny) array
        nm.
    deltas : (delta,) array
        Displacements, nm.
    hardness : float
        GPa.
    """
    gaps = displacements + separation - np.asarray(deltas)[:, None, None]
    return np.where(pressures >= hardness * (1.0 - _ROUNDING), np.minimum(gaps, 0.0), 0.0)
