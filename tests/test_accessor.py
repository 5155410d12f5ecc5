"""``ds.contact.verb`` is the plain function of the same name, and importing costs little."""

import inspect
import pickle
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.accessor import ContactAccessor

from .surfaces import glass_pair, rough, scan

VERBS = [name for name, value in vars(ContactAccessor).items() if inspect.isfunction(value) and name[0] != "_"]


def plain(verb):
    """Return the plain function of a verb: at the top, or in its room."""
    rooms = (roughxr, roughxr.statistics, roughxr.particles, roughxr.figures)
    return next(getattr(room, verb) for room in rooms if hasattr(room, verb))


@pytest.fixture(scope="module")
def surface():
    return glass_pair(scan(rough(48, seed=1)))


@pytest.mark.door
@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_is_the_public_function_of_its_name(verb):
    function = plain(verb)
    method = getattr(ContactAccessor, verb)
    assert method.__wrapped__ is function
    assert method.__doc__ == function.__doc__
    assert "Parameters" in function.__doc__ and "Returns" in function.__doc__


def test_the_help_of_adhesive_takes_250_words_before_its_sources():
    text, _, _ = roughxr.adhesive.__doc__.partition("References")
    assert len(text.split()) <= 250


def test_misspelt_options_and_verbs_name_the_nearest(surface):
    with pytest.raises(
        TypeError, match=r"load: expected an option of adhesive, found no such option \(did you mean preload\?\)"
    ):
        surface.contact.adhesive(load=3)
    with pytest.raises(roughxr.Refusal, match="direct: expected arguments by their names, found 1 without a name"):
        surface.contact.direct([5.0])
    with pytest.raises(roughxr.Refusal, match="vary: expected solve, found none; see help"):
        surface.contact.vary(sphere_radius=[500, 1000])
    with pytest.raises(AttributeError, match=r"no verb 'pulloff' \(did you mean pull_off\?\)"):
        surface.contact.pulloff()


def test_plain_functions_and_classes_refuse_wrong_calls_in_the_words_of_the_verbs(surface):
    with pytest.raises(roughxr.Refusal, match=r"crop: expected at most 1 argument without a name \(ds\), found 3 .*y="):
        roughxr.scans.crop(surface, [0, 100], [0, 100])
    with pytest.raises(TypeError, match=r"statistic: expected an option of bootstrap.*did you mean statistics\?"):
        roughxr.statistics.bootstrap(surface, statistic="mean")
    with pytest.raises(roughxr.Refusal, match=r"vary: expected solve, found none; see help\(roughxr.vary\)"):
        roughxr.vary(surface, sphere_radius=[500, 1000])
    with pytest.raises(roughxr.Refusal, match="ds: expected one value, found two, one of them without a name"):
        roughxr.level(surface, ds=surface)
    with pytest.raises(roughxr.Refusal, match="hertz: expected contact_modulus, found none"):
        roughxr.reference.hertz([5.0], radius=3000)
    with pytest.raises(roughxr.Refusal, match=r"thicknes: expected an option of Layer.*\(did you mean thickness\?\)"):
        roughxr.Layer(thicknes=5)
    with pytest.raises(roughxr.Refusal, match="densty: expected an option of Flow"):
        roughxr.particles.Flow(densty=1000)


@pytest.mark.parametrize("room", [roughxr, roughxr.scans, roughxr.statistics, roughxr.particles, roughxr.figures])
def test_public_functions_are_pickled_by_their_names(room):
    for name in room.__all__:
        if inspect.isfunction(function := getattr(room, name)):
            assert pickle.loads(pickle.dumps(function)) is function
            assert function is getattr(room, name)


@pytest.mark.door
def test_verbs_chain(surface):
    sweep = surface.contact.superpose(delta=np.arange(-2, 6, 0.5), subregions=(2, 2))
    density = sweep.contact.pull_off().contact.pdf("pull_off_force", bins=2)
    assert float((density * np.diff(density.attrs["bin_edges"])).sum()) == pytest.approx(1)
    assert "mean" in sweep.contact.summary().statistic


def test_results_share_one_line_of_history(surface):
    sweep = surface.contact.level().contact.superpose(delta=[0.0, 1.0])
    steps = [step["operation"] for step in roughxr.schema.history(sweep)]
    assert steps == ["assign_pair", "level", "superpose"]


def test_a_name_that_the_package_lacks_is_answered_with_the_nearest():
    with pytest.raises(AttributeError, match=r"no 'read_scan' \(did you mean open_scan\?\)"):
        roughxr.read_scan  # noqa: B018


def test_a_name_of_a_room_is_found_there():
    with pytest.raises(AttributeError, match=r"no 'open_curves' \(did you mean measured.open_curves\?\)"):
        roughxr.open_curves  # noqa: B018
    with pytest.raises(AttributeError, match=r"no 'critical_load' \(did you mean particles.critical_load\?\)"):
        roughxr.critical_load  # noqa: B018


def test_what_is_no_function_of_a_dataset_is_not_varied(surface):
    for solve, kind in ((surface, "a Dataset"), ("adhesive", "'adhesive'"), (surface.contact.rigid, "a verb of one")):
        with pytest.raises(roughxr.Refusal, match=f"solve: expected a function.*found {kind}"):
            roughxr.vary(surface, solve, sphere_radius=[2000, 3000])


def test_figures_refuse_unknown_options_and_what_they_cannot_draw(surface):
    with pytest.raises(roughxr.Refusal, match="colour: expected an option of scan_map"):
        surface.contact.plot(colour="red")
    with pytest.raises(roughxr.Refusal, match="expected a Dataset or DataArray, to be drawn, found str"):
        roughxr.figures.plot("run")
    with pytest.raises(roughxr.Refusal, match="expected a Dataset with variables, to be drawn, found none"):
        xr.Dataset().contact.plot()
    with pytest.raises(roughxr.Refusal, match="run: expected the groups of a run"):
        roughxr.figures.overview(surface)
    with pytest.raises(roughxr.Refusal, match="expected one of height, found 'pull_off_force'"):
        roughxr.figures.distribution(surface)


def test_displacements_of_a_sum_are_asked_about_as_those_of_a_simulation(surface):
    with pytest.warns(roughxr.RoughxrWarning, match="delta: 1000000 nm is more than a tenth of the sphere's radius"):
        surface.contact.superpose(delta=[1e6], law="hertz")
    with pytest.warns(roughxr.IncompleteResult, match="delta: nothing touches down to .* all forces are 0"):
        surface.contact.superpose(delta=[-5000.0], law="hertz")


def test_the_name_of_a_file_is_no_dataset_of_measured_forces():
    ds = glass_pair(scan(rough(16)))
    with pytest.raises(ValueError, match=r"measured: expected an xarray.* 'forces', found str; .*open_pull_off"):
        ds.contact.fit_pair("m.csv")


def test_a_scan_has_no_pull_off_before_a_simulation():
    with pytest.raises(ValueError, match="found variables: height; run superpose, adhesive or rigid first"):
        scan(rough(16)).contact.pull_off()


def test_import_takes_little_more_than_that_of_xarray_registers_accessors_and_reaches_each_public_name():
    """What reads, solves and draws is imported by the first name that is used; the shell's help needs none of it."""
    program = """
import sys, xarray, roughxr, roughxr.application.cli
assert "contact" in vars(xarray.Dataset) and "contact" in vars(xarray.DataArray)
roughxr.application.cli.command_line()
assert not {"numba", "scipy", "dask.array", "matplotlib", "netCDF4"} & set(sys.modules), "imported too early"
roughxr.rigid
assert not {"matplotlib", "distributed", "pint"} & set(sys.modules), "imported too early"
assert sorted(dir(roughxr)) == sorted(roughxr.__all__), "names that are not public"
for room in ("archive", "figures", "measured", "particles", "report", "scans", "statistics"):
    for name in getattr(roughxr, room).__all__:
        getattr(getattr(roughxr, room), name)
assert xarray.Dataset().contact is not None and xarray.DataArray().contact is not None
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_the_accessor_says_what_it_is_about_and_what_it_can_do(surface):
    shown = repr(surface.contact)
    assert shown.startswith("<roughxr: scan; sphere_radius 3000 nm, contact_modulus 39.4")
    fitting = set(dir(surface.contact))
    assert {"adhesive", "assign_pair", "level"} <= fitting <= set(VERBS)
    assert not {"answer", "critical_load", "compare"} & fitting
    groups = [line.rstrip(":") for line in shown.splitlines()[1:] if not line.startswith(" ")]
    assert groups == ["the paper's", "adhesion", "particles", "studies"]
    assert shown.index(".direct ") < shown.index("adhesion:") < shown.index(".adhesive ")
    assert all((f"  .{verb} " in shown) == (verb in fitting) for verb in VERBS)
    assert ".adhesive" in surface.contact._repr_html_()
    pull = xr.Dataset({"pull_off_force": ("subregion", [1.0, 2.0])}).contact
    assert {"answer", "bootstrap", "compare", "plot"} <= set(dir(pull)) and "level" not in dir(pull)
    assert "statistics:" in repr(pull) and "studies:" not in repr(pull)
    assert "no pair of bodies assigned" in repr(xr.Dataset().contact)


def test_the_accessor_shows_the_sentence_of_an_answer(surface, capsys):
    pull_off = xr.Dataset({"pull_off_force": ("subregion", [388.0, 575.0, 817.0], {"units": "nN"})})
    mean = pull_off.contact.answer()
    assert capsys.readouterr().out == ""
    assert mean.sentence.startswith("Mean pull-off 590 nN (95 % interval 230 … 1610 nN, 3 places)")
    assert repr(mean.contact).splitlines()[1:][: mean.sentence.count("\n") + 1] == mean.sentence.splitlines()
    assert mean.sentence.splitlines()[0] not in repr(xr.concat([mean, mean], "scan").contact)
    assert ".plot" in repr(surface.height.contact)


def test_concatenated_answers_keep_the_wavelength_of_each_whatever_the_defaults_of_xarray():
    forces = {"pull_off_force": ("subregion", [388.0, 575.0, 817.0], {"units": "nN"})}
    shortest = [39.0, 76.0]
    solutions = [xr.Dataset(forces, {"sphere_radius": 500.0, "shortest_wavelength": nm}) for nm in shortest]
    answers = [solution.contact.answer() for solution in solutions]
    for new_defaults in (False, True):
        with xr.set_options(use_new_combine_kwarg_defaults=new_defaults):
            together = xr.concat(answers, "scan", coords="different", compat="equals")
        assert together.shortest_wavelength.values.tolist() == shortest
