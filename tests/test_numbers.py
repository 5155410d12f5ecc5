"""Numbers for readers: every one that once came out as "1e+02 %", "1.26e+03 pN" or "nan %"."""

import numpy as np
import pytest
import xarray as xr

import roughxr
from roughxr.application.wording import render_sentence
from roughxr.application.wording.intervals import value_and_interval
from roughxr.mechanics.vocabulary.numbers import format_number, format_percent, format_quantity, prefixed


@pytest.mark.parametrize("share", [0.995, 0.9951, 0.99999, 1.0, 1.004])
def test_nearly_all_is_a_hundred_per_cent(share):
    assert format_percent(share) in ("99.5 %", "100 %")


@pytest.mark.parametrize("scale", 10.0 ** np.arange(-14, 9))
@pytest.mark.parametrize("digits", [0.99949, 0.9996, 1.0, 5.005, 9.995])
def test_no_number_is_written_by_a_machine(scale, digits):
    """Never "e+02"; read again it is the number to three digits; the prefix leaves one to three digits in front."""
    size_shown = digits * scale
    for text in (
        format_number(size_shown),
        format_quantity(size_shown),
        format_percent(size_shown),
        *value_and_interval(size_shown, -size_shown, size_shown),
    ):
        assert "e" not in text and "nan" not in text
    plain = format_number(size_shown).replace(" × 10", "e").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    assert float(plain) == pytest.approx(size_shown, rel=0.00501)
    unit, size = prefixed(size_shown)
    if 1e-3 < size_shown < 1e9:
        assert 1 <= float(f"{size_shown / size:.3g}") < 1000, (size_shown, unit)


@pytest.mark.parametrize("formatted", [format_number, format_percent, format_quantity])
def test_nothing_is_a_dash_and_zero_is_zero(formatted):
    assert formatted(np.nan) == "–"
    assert formatted(0.0).startswith("0") and formatted(-0.0).startswith("0")
    assert formatted(-2.0).startswith("−2")
    assert formatted(np.inf).startswith("∞")


def test_shares_are_stated_in_per_cent_too():
    forces = xr.Dataset({"pull_off_force": ("subregion", np.arange(1.0, 30.0), {"units": "nN"})})
    in_percent, as_number = (forces.contact.bootstrap(confidence=part) for part in ("90 %", 0.9))
    xr.testing.assert_equal(in_percent, as_number)
    assert roughxr.figures.distribution(forces, interval="90 %").get_xlabel() == "pull-off force [nN]"


def test_a_value_with_the_name_of_a_sentence_is_an_error_and_not_left_out():
    assert render_sentence("answer.toml", "count", {"places": 3, "several_places": True}) == "3 places"
    with pytest.raises(ValueError, match="'plural' is a value and an entry"):
        render_sentence("answer.toml", "count", {"places": 3, "plural": "s"})
