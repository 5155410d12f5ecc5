"""roughxr: how hard a small sphere presses, and how hard it sticks, wherever it lands on a rough surface.

Scans, asperity catalogues and contact solutions are labelled xarray Datasets; the functions here are also
methods of ``ds.contact``.

>>> import roughxr
>>> scan = roughxr.open_sample("glass").contact.assign_pair(
...     sphere_radius=3000, young_modulus=75, poisson_ratio=0.22, surface_energy=0.675)
>>> elastic = scan.contact.direct(delta=[5.08, 15.4], subregions=(2, 2))
>>> elastic.force.units
'nN'
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.util import find_spec, spec_from_loader
from typing import TYPE_CHECKING, Any

from ._version import __version__ as __version__

if TYPE_CHECKING:
    from ._public import *  # noqa: F403

#: Public modules by their short names, whichever room they lie in.
_SHORT = {
    f"{__name__}.{where.rpartition('.')[2]}": f"{__name__}.{where}"
    for where in (*("contact.reference", "vocabulary.schema"),)
}


class _ByShortName(MetaPathFinder, Loader):
    """Imports a public module by its short name, as in ``import roughxr.figures``."""

    def __init__(self) -> None:
        self._own: dict[str, Any] = {}

    def find_spec(self, fullname, path=None, target=None):
        return spec_from_loader(fullname, self) if fullname in _SHORT else None

    def create_module(self, spec):
        module = import_module(_SHORT[spec.name])
        self._own[module.__name__] = module.__spec__
        return module

    def exec_module(self, module):
        module.__spec__ = self._own.pop(module.__name__)  # the import system has written the short name's over it


class _Later:
    """An accessor that is imported when it is first used."""

    def __init__(self, name: str):
        self._name = name

    def _accessor(self) -> Any:
        return getattr(import_module(f"{__name__}.accessor"), self._name)

    def __call__(self, of: Any) -> Any:
        return self._accessor()(of)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._accessor(), name)


def _register(xarray: Any) -> None:
    xarray.register_dataset_accessor("contact")(_Later("ContactAccessor"))
    xarray.register_dataarray_accessor("contact")(_Later("ContactArrayAccessor"))


class _AfterXarray(MetaPathFinder):
    """Registers the accessors once xarray is imported, by whomever: the command line's help has no need of it."""

    def find_spec(self, fullname, path=None, target=None):
        if fullname != "xarray":
            return None
        sys.meta_path.remove(self)
        spec = find_spec(fullname)
        loader: Any = spec and spec.loader
        if loader is not None:
            execute = loader.exec_module

            def executed(module: Any) -> None:
                execute(module)
                _register(module)

            loader.exec_module = executed
        return spec


def __getattr__(name: str) -> Any:
    if name.startswith("__") and name != "__all__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if find_spec(f"{__name__}.{name}"):
        return import_module(f"{__name__}.{name}")
    public = import_module(f"{__name__}._public")
    try:
        found = globals()[name] = getattr(public, name)
    except AttributeError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *import_module(f"{__name__}._public").__all__})


if not any(isinstance(finder, _ByShortName) for finder in sys.meta_path):
    sys.meta_path.append(_ByShortName())
    sys.meta_path.insert(0, _AfterXarray())
if "xarray" in sys.modules:
    _register(sys.modules["xarray"])
