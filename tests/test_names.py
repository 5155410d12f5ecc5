"""The names under which the package can be reached."""

import ast
import importlib
import importlib.util
import inspect
import pkgutil
from pathlib import Path

import pytest
import xarray as xr

import roughxr

MODULES = sorted(module.name for module in pkgutil.walk_packages(roughxr.__path__, "roughxr."))


@pytest.mark.parametrize("name", MODULES)
def test_no_function_hides_a_module(name):
    package, _, last = name.rpartition(".")
    module = importlib.import_module(name)
    assert getattr(importlib.import_module(package), last) is module


def public():
    """Return the public functions by name: those at the top, and those of the rooms shown beside them."""
    shown = ("particles", "reference", "report", "archive", "scans", "statistics", "measured")
    rooms = {"": roughxr} | {f"{name}.": getattr(roughxr, name) for name in shown}
    names = [(prefix, name, room) for prefix, room in rooms.items() for name in getattr(room, "__all__", vars(room))]
    found = {f"{prefix}{name}": getattr(room, name) for prefix, name, room in names if not name.startswith("_")}
    return {name: value for name, value in found.items() if inspect.isfunction(value)}


#: The one verb with more than eight options: each is one property of the bodies, with its own unit and a coordinate of
#: its own, asked for in one place and nowhere else. An object in between would be one more name to import for a number.
MORE = {"assign_pair": 13}


def test_no_verb_has_more_than_eight_options():
    counted = {
        name: sum(one.kind is one.KEYWORD_ONLY for one in inspect.signature(function).parameters.values())
        for name, function in public().items()
    }
    assert {name: count for name, count in counted.items() if count > MORE.get(name, 8)} == {}


@pytest.mark.parametrize(
    ("call", "option"),
    [
        (lambda pull, **given: roughxr.particles.to_dem(pull, code="rock_n_roll", **given), {"classes": 3}),
        (lambda pull, **given: roughxr.particles.to_dem(pull, code="rock_n_roll", **given), {"poisson_ratio": 0.2}),
    ],
)
def test_an_option_that_a_mode_does_not_use_is_refused(call, option):
    sweep = {"force": (("subregion", "delta"), [[0.0, -3.0, 1.0], [0.0, -2.0, 1.0], [0.0, -1.0, 1.0]])}
    pull = xr.Dataset(sweep, {"delta": [-1.0, 0.0, 1.0], "sphere_radius": 100.0, "work_of_adhesion": 0.1})
    pull = pull.assign_coords(contact_modulus=40.0).assign(pull_off_force=("subregion", [3.0, 2.0, 1.0]))
    call(pull.drop_vars("force"))
    (name,) = option
    with pytest.raises(ValueError, match=f"{name}: not used"):
        call(pull, **option)


#: Names that say nothing of the quantity.
VAGUE = {"found", "told", "said", "asked", "held", "kept", "one", "those", "here", "there", "back", "well", "wet"}
VAGUE |= {"gain", "apart", "sharper", "beside", "around", "among"}


@pytest.mark.parametrize("name", MODULES)
def test_no_name_is_vague(name):
    source = importlib.util.find_spec(name).origin
    nodes = list(ast.walk(ast.parse(Path(source).read_text(encoding="utf-8"))))
    names = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    names |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    names |= {node.name for node in nodes if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    assert not {name for name in names if name.strip("_") in VAGUE}
