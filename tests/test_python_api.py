"""The functions of `poisson_cli`: those of `poisson_cli.editing`, returning the image alone."""

import inspect
import pickle

import numpy as np
import pytest

import poisson_cli
from poisson_cli import editing, errors
from tests.small_pictures import DESTINATION, DESTINATION_MASK, MASK, SOURCE


def test_they_return_the_image_alone():
    for name, arguments in [
        ("clone", (DESTINATION, SOURCE, MASK)),
        ("mix", (DESTINATION, SOURCE, MASK)),
        ("fill", (DESTINATION, DESTINATION_MASK)),
    ]:
        image = getattr(poisson_cli, name)(*arguments)
        assert type(image) is np.ndarray
        np.testing.assert_array_equal(image, getattr(editing, name)(*arguments).image)


def test_keywords_are_passed_on():
    keywords = {
        "offset": (3, -4),
        "gradients": "average",
        "monochrome": True,
        "solver": "sor",
        "tolerance": 1e-3,
    }
    np.testing.assert_array_equal(
        poisson_cli.clone(DESTINATION, SOURCE, MASK, **keywords),
        editing.clone(DESTINATION, SOURCE, MASK, **keywords).image,
    )


@pytest.mark.parametrize("name", ["clone", "mix", "fill"])
def test_they_describe_themselves(name):
    ours, original = getattr(poisson_cli, name), getattr(editing, name)
    assert ours.__name__ == name
    assert inspect.signature(ours).parameters == inspect.signature(original).parameters
    assert inspect.signature(ours).return_annotation is np.ndarray
    assert inspect.getdoc(ours).startswith(inspect.getdoc(original))
    assert inspect.getdoc(ours).endswith(f"`poisson_cli.editing.{name}` returns all of it.")


def test_the_package_names_what_it_has():
    assert {"clone", "mix", "fill", "InputError", "NotConverged", "__version__"} <= set(dir(poisson_cli))
    assert all(hasattr(poisson_cli, name) for name in poisson_cli.__all__)
    assert poisson_cli.InputError is errors.InputError
    with pytest.raises(AttributeError, match="module 'poisson_cli' has no attribute 'flatten_all'"):
        _ = poisson_cli.flatten_all


def test_errors_are_those_of_python_as_well():
    with pytest.raises(ValueError, match="empty") as caught:
        poisson_cli.fill(DESTINATION, np.zeros_like(DESTINATION_MASK))
    assert isinstance(caught.value, poisson_cli.InputError)


def test_an_edit_tells_the_same_after_its_pictures_have_changed_and_in_another_process():
    """The report is made when it is asked for; what it is made of was kept."""
    destination, source, mask = DESTINATION.copy(), SOURCE.copy(), MASK.copy()
    expected = editing.clone(destination, source, mask).report
    edit = editing.clone(destination, source, mask)
    destination[:], source[:], mask[:] = 0, 255, False
    copy = pickle.loads(pickle.dumps(edit))
    assert np.array_equal(copy.image, edit.image)
    for report in (edit.report, copy.report):
        assert report._replace(seconds={}) == expected._replace(seconds={})
    assert max(expected.boundary_mismatch) > 1
