"""roughxr: the force that detaches a small sphere from a rough surface, at many places of an AFM scan.

Scans, asperity catalogues and contact solutions are labelled xarray Datasets; the functions here are also
methods of ``ds.contact``.

>>> import roughxr
>>> scan = roughxr.open_sample("glass").contact.assign_pair(sphere_radius="3 um", materials="glass")
>>> elastic = scan.contact.direct(delta=[5.08, 15.4], subregions=(2, 2))
>>> elastic.force.units
'nN'
"""

from importlib import import_module
from typing import Any

import lazy_loader
import xarray

#: Modules with further public functions.
_ROOMS = ("archive", "figures", "measured", "particles", "reference", "report", "scans", "statistics")

_loaded, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name not in __all__:
        from .mechanics.vocabulary.text import did_you_mean

        places = {inner: f"{room}.{inner}" for room in _ROOMS for inner in _loaded(room).__all__}
        similar = f" (did you mean {places[name]}?)" if name in places else did_you_mean(name, __all__)
        raise AttributeError(f"roughxr: no {name!r}{similar}; list its names by dir(roughxr)")
    from .mechanics.vocabulary.calls import public_functions

    value = _loaded(name)
    globals().update(public_functions({name: value}, [name], __name__))  # in place of what the loader keeps
    return globals().get(name, value)


class _LazyAccessor:
    """An accessor that is imported when it is first used."""

    def __init__(self, name: str):
        self._name = name

    def _accessor(self) -> Any:
        return getattr(import_module(f"{__name__}.accessor"), self._name)

    def __call__(self, obj: Any) -> Any:
        return self._accessor()(obj)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._accessor(), name)


xarray.register_dataset_accessor("contact")(_LazyAccessor("ContactAccessor"))
xarray.register_dataarray_accessor("contact")(_LazyAccessor("ContactArrayAccessor"))
