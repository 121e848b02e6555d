"""What a run says about itself, word by word."""

import json
from pathlib import Path

import pytest

from poisson_cli import report
from poisson_cli.editing import EditReport
from poisson_cli.hints import hints
from poisson_cli.job import Summary
from poisson_cli.settings import Reporting

EDIT = EditReport(
    tool="clone",
    rectangle=(60, 40, 180, 200),
    unknowns=12345,
    solver="multigrid",
    cycle="F",
    method="multigrid F",
    iterations=6,
    tolerance=5e-4,
    error_estimate=1.53e-4,
    floating=False,
    boundary_mismatch=(12.345, 6.0, 0.04),
    clipped=0,
    seconds={"solve": 0.02},
)
SUMMARY = Summary(
    edit=EDIT,
    selected=12345,
    output=Path("out.png"),
    seconds={"read": 0.01, "solve": 0.02, "write": 0.001},
    profile_dropped=False,
)


def changed(**changes: object) -> Summary:
    edit = {name: value for name, value in changes.items() if hasattr(EDIT, name) and name != "seconds"}
    rest = {name: value for name, value in changes.items() if name not in edit}
    return SUMMARY._replace(edit=EDIT._replace(**edit), **rest)


def test_the_line():
    assert report.line(SUMMARY) == (
        "clone: 12,345 pixels at 40,60 (200x180), multigrid F x 6, error < 0.0002 levels, 31 ms -> out.png"
    )


@pytest.mark.parametrize(
    ("changes", "part"),
    [
        ({"unknowns": 1}, "clone: 1 pixel at"),
        ({"method": "multigrid V, then F"}, ", multigrid V then F x 6, "),
        ({"method": "directly and by multigrid F"}, ", directly and by multigrid F x 6, "),
        ({"method": "directly", "iterations": 0}, ", directly, "),
        ({"solver": "sor", "cycle": None, "method": "sor omega=1.96", "iterations": 400}, ", sor x 400, "),
        ({"error_estimate": 0.0}, ", error < 0.000001 levels, "),
        ({"error_estimate": 2e-9}, ", error < 0.000001 levels, "),
        ({"error_estimate": 2e-4}, ", error < 0.0002 levels, "),
        ({"error_estimate": 2.01e-4}, ", error < 0.0003 levels, "),
        ({"error_estimate": 9.5e-4}, ", error < 0.0010 levels, "),
        ({"error_estimate": 0.31}, ", error < 0.4 levels, "),
        ({"error_estimate": 1.0}, ", error < 1 levels, "),
        ({"error_estimate": 37.2}, ", error < 38 levels, "),
        ({"floating": True}, ", no known pixel around a part: its mean is kept, "),
        ({"offset": (3, -60)}, ", patch from 60 left, 3 down (--from -60,3), "),
        ({"offset": (-84, 74)}, ", patch from 74 right, 84 up (--from 74,-84), "),
        ({"offset": (0, 5)}, ", patch from 5 right (--from 5,0), "),
        ({"offset": (-1, 0)}, ", patch from 1 up (--from 0,-1), "),
        ({"offset": (0, 0)}, ", patch from where it is (--from 0,0), "),
        ({"edge_share": 0.0314}, ", 3.1% edges, "),
        ({"scale": 0.8349}, ", gradients x 0.83 to fit the range, "),
        ({"beside": {"edges": Path("e.png")}}, " -> out.png, edges -> e.png"),
        ({"clipped": 1}, ", 1 value clipped, "),
        ({"clipped": 5678}, ", 5,678 values clipped, "),
        ({"profile_dropped": True}, ", colour profile dropped: the format cannot hold it, "),
        ({"seconds": {"solve": 0.9996}}, ", 1000 ms -> "),
        ({"seconds": {"read": 0.7, "solve": 1.75}}, ", 2.5 s -> "),
    ],
    ids=str,
)
def test_parts_of_the_line(changes, part):
    assert part in report.line(changed(**changes))


def test_that_nothing_is_known_of_a_whole_picture_is_understood():
    assert "no known pixel" not in report.line(changed(floating=True, selected=None))


def test_the_details():
    told = changed(selected=13000, clipped=1, outliers=0.0123, overshoot=2.34)
    assert report.details(told).splitlines() == [
        "  selected  13,000 pixels, 12,345 of them inside the picture",
        "  mismatch  12.3, 6.0, 0.0 levels between source and destination along the boundary, mean; "
        "exceptional at 1.2% of it",
        "  method    multigrid F",
        "  error     0.00015 levels estimated, 0.0005 allowed",
        "  clipped   1 value outside the picture's range, by 2.3 levels at most",
        "  stages    read 10 ms, solve 20 ms, write 1 ms",
    ]
    shorter = report.details(changed(boundary_mismatch=None))
    assert "mismatch" not in shorter
    assert "0 values outside the picture's range\n" in shorter
    assert "selected" not in report.details(changed(selected=None))
    assert shorter.startswith("  selected  12,345 pixels, all of them inside the picture\n")


def test_the_object():
    told = json.loads(json.dumps(report.as_dict(SUMMARY)))
    assert told["rectangle"] == {"x": 40, "y": 60, "width": 200, "height": 180}
    assert told["boundary_mismatch"] == [12.345, 6.0, 0.04]
    assert told["seconds"]["total"] == pytest.approx(0.031)
    assert report.as_dict(changed(boundary_mismatch=None))["boundary_mismatch"] is None


def test_the_object_of_a_tool_with_more_to_say():
    told = report.as_dict(changed(offset=(3, -60), edge_share=0.25, beside={"preview": Path("p.png")}))
    assert told["offset"] == {"x": -60, "y": 3}
    assert told["edge_share"] == 0.25
    assert told["beside"] == {"preview": "p.png"}
    json.dumps(told)


def test_hints_come_after_the_line_and_in_the_object(capsys):
    summary = changed(boundary_mismatch=(3.0, 100.4, 3.0), scale=0.3)
    report.tell(summary, Reporting())
    lines = capsys.readouterr().err.splitlines()[1:]
    assert len(lines) == 2
    assert lines == [f"poisson: hint: {hint}" for hint in hints(summary)]
    assert report.as_dict(summary)["hints"] == hints(summary)


def test_a_clone_onto_itself_has_something_to_say(folder, poisson):
    ran = poisson("clone", "grey.png", "grey.png", "-m", "dest-mask.png", "-o", "out.png")
    assert "error < 0.000001 levels" in ran.err
    assert ran.code == 0
