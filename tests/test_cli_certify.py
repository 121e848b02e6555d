"""`--certify`, and the advice to use multigrid: from the option to every place where a run speaks of itself."""

import json
import math

import numpy as np
import pytest

import poisson_cli
from poisson_cli import editing, report
from poisson_cli.settings import Reporting
from tests import oracles
from tests.small_pictures import GREY
from tests.test_report import SUMMARY, changed

MASK = np.zeros(GREY.shape, bool)
MASK[2:-3, 3:-2] = True

FLOAT32 = (
    2e-5  # levels: what float32 makes of the differences between two pictures, before any solver sees them
)


@pytest.mark.parametrize("solver", ["multigrid", "sor"])
def test_the_bound_is_printed_and_in_the_json(folder, poisson, solver):
    words = ["fill", "grey.png", "--rect", "1,1,9,9", "-o", "out.png", "--certify", "--solver", solver]
    ran = poisson(*words, "--json", "-v")
    assert ran.code == 0
    said = json.loads(ran.out)
    assert 0 < said["error_bound"] < 1e-3
    assert " levels, proven, " in ran.err
    assert f"at most {said['error_bound']:.2g} proven" in ran.err


def test_without_the_option_nothing_is_proven(folder, poisson):
    ran = poisson("fill", "grey.png", "--rect", "1,1,9,9", "-o", "out.png", "--json", "-v")
    assert json.loads(ran.out)["error_bound"] is None
    assert "proven" not in ran.err


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_bound_of_an_edit_of_floats_holds(dtype):
    image, source = (np.array(picture / 255.0, dtype) for picture in (GREY, GREY[::-1, ::-1]))
    edit = editing.clone(image, source, MASK, mask_on="destination", certify=True)
    exact = oracles.clone(image, source, MASK, mask_on="destination")
    assert np.abs(edit.image - exact).max() * 255 <= edit.report.error_bound + FLOAT32
    assert edit.report.error_bound <= 5e-4


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_bound_of_an_edit_of_integers_holds_before_rounding(dtype):
    scale = np.iinfo(dtype).max // 255
    image = GREY.astype(dtype) * dtype(scale)
    source = image[::-1, ::-1].copy()
    edit = editing.clone(image, source, MASK, mask_on="destination", certify=True)
    exact = oracles.clone(image, source, MASK, mask_on="destination")
    off = np.abs(edit.image - np.clip(exact, 0, np.iinfo(dtype).max)).max()
    assert off <= 0.5 + edit.report.error_bound * scale
    assert edit.report.error_bound <= 5e-4


def test_the_functions_that_return_images_take_the_option_too():
    plain, certified = (poisson_cli.fill(GREY, MASK, certify=certify) for certify in (False, True))
    np.testing.assert_array_equal(plain, certified)


def test_progress_reaches_the_solver():
    told: list[int] = []
    edit = editing.fill(GREY, MASK, progress=lambda iteration, error: told.append(iteration))
    assert told[-1] == edit.report.iterations


@pytest.mark.parametrize(
    ("bound", "part", "detail", "in_json"),
    [
        (None, ", error < 0.0002 levels, ", "0.00015 levels estimated, 0.0005 allowed", None),
        (3.01e-4, ", error < 0.0004 levels, proven, ", "estimated, at most 0.0003 proven, 0.0005", 3.01e-4),
        (math.inf, ", error < 0.0002 levels, ", "estimated, no bound proven, 0.0005", None),
    ],
)
def test_the_report_of_a_bound(bound, part, detail, in_json):
    summary = changed(error_bound=bound)
    assert part in report.line(summary)
    assert detail in report.details(summary)
    assert report.as_dict(summary)["error_bound"] == in_json
    json.dumps(report.as_dict(summary), allow_nan=False)


@pytest.mark.parametrize("quiet", [False, True])
def test_advice_is_a_line_of_its_own(capsys, quiet):
    advice = "multigrid would be about 40 times as fast"
    edit = SUMMARY.edit._replace(advice=advice)
    report.tell(SUMMARY._replace(edit=edit), Reporting(quiet=quiet))
    hints = [line for line in capsys.readouterr().err.splitlines() if "hint" in line]
    assert hints == ([] if quiet else [f"poisson: hint: {advice}"])
    assert report.as_dict(SUMMARY._replace(edit=edit))["advice"] == advice
