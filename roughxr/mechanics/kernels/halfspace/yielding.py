"""The residual heights of a contact that yields at a hardness H.

Loading to a displacement δ (``displacement_control``, ``load_control``) meets, with A p the elastic displacement,

    0 ≤ p ≤ H,     g = S + A p − δ,     g ≥ 0 where p = 0,     g = 0 where 0 < p < H,     g ≤ 0 where p = H

(Almqvist et al. 2007; Weber et al. 2018): cells at the hardness yield by −g. As δ increases, their pressure stays
constant and no other pressure falls, since a flat punch presses down everywhere; nor does any cell sink elastically by
more than δ increases. So yielding cells continue to yield, and the residual height at δ, g where p = H, depends on δ
alone and not on the path. On the surface lowered by it, the same pressures are the elastic solution. Retraction from
there, and loading again up to δ, are elastic, with pressures that fall with δ everywhere: nothing yields twice.

The work done by H on the lost volume, H Σ −g dx², is dissipated in one cycle. Source: own, on the works cited.
"""

import numpy as np


def residual_heights(pressures, displacements, separation, deltas, hardness):
    """Return the residual heights (nm, ≤ 0) after loading: zero except where the pressure reached the hardness."""
    gaps = displacements + separation - np.asarray(deltas)[:, None, None]
    # largest relative rounding error of a pressure at the hardness
    rounding = 1e-9
    return np.where(pressures >= hardness * (1.0 - rounding), np.minimum(gaps, 0.0), 0.0)
