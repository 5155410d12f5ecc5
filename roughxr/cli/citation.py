"""`cite`: what to cite in a paper that uses roughxr, the program and the work whose method it implements."""

from __future__ import annotations

from .._version import __version__

_BIBTEX = f"""\
@software{{roughxr,
  author  = {{{{The roughxr developers}}}},
  title   = {{roughxr: contact and adhesion of a small sphere on AFM scans of rough surfaces}},
  version = {{{__version__}}},
  year    = {{2026}},
  license = {{BSD-3-Clause}},
}}

@article{{cheng_dunn_brach,
  author  = {{Cheng, W. and Dunn, P. F. and Brach, R. M.}},
  title   = {{Contact between a smooth microsphere and an anisotropic rough surface}},
  journal = {{The Journal of Adhesion}},
  volume  = {{79}},
  number  = {{8--9}},
  pages   = {{749--776}},
  year    = {{2003}},
}}"""


def cite(_) -> None:
    """Print both for BibTeX."""
    print(_BIBTEX)
