"""Manifests: what a line may say is what the command line may say, and every mistake is found before anything runs."""

import json
import shlex
from pathlib import Path

import pytest

from poisson_cli import attended
from poisson_cli.batch import checking, grammar, manifest
from poisson_cli.batch.mistakes import Mistakes
from poisson_cli.main import cli
from poisson_cli.masks.plan import selection_of
from poisson_cli.options import Chatter


def tasks(*lines: dict, **choices):
    return checking.check(manifest.parse("\n".join(map(json.dumps, lines)).encode()), **choices)


def mistakes(text: str, **choices) -> list[tuple[int, str]]:
    with pytest.raises(Mistakes) as caught:
        checking.check(manifest.parse(text.encode()), **choices)
    return [tuple(found) for found in caught.value.found]


def by_command_line(line: str) -> list:
    """The jobs of a command line, by way of the program itself."""
    with (
        attended.handed_over() as jobs,
        cli.make_context("poisson", shlex.split(line), obj=Chatter()) as context,
    ):
        cli.invoke(context)
    return jobs


SAME = {
    "fill a.png -m m.png -o o.png": {"tool": "fill", "image": "a.png", "mask": "m.png", "output": "o.png"},
    "clone a.png b.png -m m.png -m n.json:cat --at=-4,7 --mask-on destination --monochrome --tolerance .01 -o o.png": {
        "tool": "clone", "source": "a.png", "destination": "b.png", "mask": ["m.png", "n.json:cat"], "at": [-4, 7],
        "mask-on": "destination", "monochrome": True, "tolerance": 0.01, "output": "o.png",
    },
    "mix a.png b.png --rect 1,2,3,4 --rect 5,6,7,8 --flatten --high 30 --show-edges e.png -o o.png": {
        "tool": "mix", "source": "a.png", "destination": "b.png", "rect": [[1, 2, 3, 4], "5,6,7,8"], "flatten": True,
        "high": 30, "show_edges": "e.png", "output": "o.png",
    },
    'fill a.png --polygon "1,2 3.5,4 5,6" -o o.png --overwrite': {
        "tool": "fill", "image": "a.png", "polygon": [[1, 2], [3.5, 4], [5, 6]], "output": "o.png", "overwrite": True,
    },
    'fill a.png --lasso "1,2 3,4 5,6" --lasso "0,0 9,0 9,9" -o o.png': {
        "tool": "fill", "image": "a.png", "lasso": [[[1, 2], [3, 4], [5, 6]], "0,0 9,0 9,9"], "output": "o.png",
    },
    "fill a.png --ellipse 0,0,9,9 --subtract --rect 1,1,2,2 --invert-mask -o o.png": {  # order counts
        "tool": "fill", "image": "a.png", "ellipse": [0, 0, 9, 9], "subtract": True, "rect": [1, 1, 2, 2],
        "invert_mask": True, "output": "o.png",
    },
    "recolor a.png -m m.png --gain 1.5,.5,.5 --hue -30 -o o.png": {
        "tool": "recolor", "image": "a.png", "mask": "m.png", "gain": [1.5, 0.5, 0.5], "hue": -30, "output": "o.png",
    },
    "heal a.png -m m.png --from=-60,0 -o o.png": {
        "tool": "heal", "image": "a.png", "mask": "m.png", "from": [-60, 0], "output": "o.png", "screen": None,
    },
    "tile a.png b.png -o c.png -o d.png --axis x": {
        "tool": "tile", "images": ["a.png", "b.png"], "output": ["c.png", "d.png"], "axis": "x",
    },
    "mask a.png --rect 1,2,3,4 --over -o o.png": {
        "tool": "mask", "image": "a.png", "rect": [1, 2, 3, 4], "over": True, "output": "o.png",
    },
    "fill -m m.png -o o.png -- -a.png": {"tool": "fill", "image": "-a.png", "mask": "m.png", "output": "o.png"},
}  # fmt: skip


@pytest.mark.parametrize("line", SAME)
def test_a_line_says_what_the_command_line_says(line):
    given = SAME[line] if SAME[line]["tool"] == "mask" else {"threads": None, **SAME[line]}
    (task,) = tasks(given)
    assert list(task.jobs) == by_command_line(line)
    assert list(task.jobs) == by_command_line(shlex.join([task.tool, *task.words]))


def test_every_tool_is_in_that_table():
    assert {line["tool"] for line in SAME.values()} | {"flatten", "focus", "relight", "tonemap"} == set(
        grammar.tools()
    )


def test_one_thread_is_the_default_of_a_batch():
    fill = {"tool": "fill", "image": "a.png", "rect": [1, 1, 5, 5], "output": "o.png"}
    assert tasks(fill)[0].jobs[0].solver.threads == 1
    assert tasks({**fill, "threads": 2})[0].jobs[0].solver.threads == 2
    assert tasks({**fill, "threads": None})[0].jobs[0].solver.threads is None


SELECTIONS = [
    {"mask": ["m.png:alpha"], "selection": [{"rect": [0, 0, 50, 50]}, {"grow": 3}]},
    {
        "selection": [
            {"rect": [0, 0, 50, 50]}, {"subtract": {"ellipse": [10, 10, 20, 20]}}, {"shrink": 2},
            {"subtract": {"mask": "m.json:hole"}}, {"polygon": [[1, 2], [30.5, 4], [5, 60]]},
            {"intersect": {"lasso": [[1, 2], [30, 4], [5, 60]]}}, {"add": {"rect": [1, 1, 2, 2]}},
        ],
        "invert_mask": True, "mask_threshold": 9,
    },
]  # fmt: skip


@pytest.mark.parametrize("selection", SELECTIONS)
def test_the_steps_of_a_selection(selection):
    """Read in two ways that know nothing of each other."""
    (task,) = tasks({"tool": "fill", "image": "a.png", "output": "o.png", **selection})
    assert task.jobs[0].selection == selection_of(selection)


def test_paths_are_relative_to_the_manifest():
    line = {
        "tool": "clone", "source": "a.png", "destination": "/d/b.png", "mask": ["m.png:red", "/m.png"],
        "selection": [{"mask": "n.png"}], "flatten": True, "edges": "e.png", "output": "o.png",
    }  # fmt: skip
    (task,) = tasks(line, folder="some/where", make_folders=True)
    (job,) = task.jobs
    assert (job.source, job.destination) == (Path("some/where/a.png"), Path("/d/b.png"))
    assert [step.area.name for step in job.selection.steps] == [
        "some/where/m.png:red",
        "/m.png",
        "some/where/n.png",
    ]
    assert job.then.flatten.file == Path("some/where/e.png")
    assert task.outputs == (Path("some/where/o.png"),)


def test_defaults():
    first = {"defaults": {"tolerance": 0.5, "cycle": "V", "at": [1, 2], "mask": "m.png"}}
    clone = {"tool": "clone", "source": "a.png", "destination": "b.png", "output": "o.png"}
    fill = {"tool": "fill", "image": "a.png", "output": "p.png", "tolerance": 0.25, "mask": "n.png"}
    one, two = tasks(first, clone, fill, defaults=(("cycle", "W"),))
    assert one.jobs[0].placement.offset == (2, 1)
    assert (one.jobs[0].solver.tolerance, two.jobs[0].solver.tolerance) == (0.5, 0.25)
    assert {job.jobs[0].solver.cycle for job in (one, two)} == {"W"}
    assert [step.area.name for step in two.jobs[0].selection.steps] == ["n.png"]
    assert (one.line, two.line, one.number, two.number) == (2, 3, 1, 2)


def test_csv():
    text = (
        "\ufefftool,image,rect,subtract, rect ,output,certify\r\n"
        'fill,a.png,"0,0,9,9",yes,"2,2,3,3",o.png,true\r\n'
        "\r\n"
        'fill,"b\n.png","0,0,9,9",,,p.png,0\r\n'
        'fill,c.png,"0,0,9,9",,,q.png,\r\n'
    )
    one, two, three = checking.check(manifest.parse(text.encode()))
    assert list(one.jobs) == by_command_line(
        "fill a.png --rect 0,0,9,9 --subtract --rect 2,2,3,3 -o o.png --certify --threads 1"
    )
    assert two.jobs[0].destination == Path("b\n.png")
    assert not two.jobs[0].solver.certify
    assert (one.line, two.line, three.line) == (2, 4, 6)


@pytest.mark.parametrize("divider", [";", "\t"])
def test_csv_of_other_spreadsheets(divider):
    text = f"tool;image;rect;output\r\nfill;a.png;0,0,9,9;o.png\r\nfill;{'b' * 3};0,0,9,9;p.png".replace(
        ";", divider
    )
    one, two = checking.check(manifest.parse(text.encode()))
    assert list(one.jobs) == by_command_line("fill a.png --rect 0,0,9,9 -o o.png --threads 1")
    assert two.jobs[0].destination == Path("bbb")


def test_each_bad_row_of_csv_is_found():
    text = 'tool,image,rect,output\nfill,"a"x,"0,0,9,9",o.png\nfill,a\nfill,a,"0,0,9,9",p.png\nfill,a,"0,0,9,q.png\n'
    assert [line for line, _ in mistakes(text)] == [2, 3, 5]


@pytest.mark.parametrize(
    ("text", "line", "part"),
    [
        (
            "tool,image,maks,output\nfill,a,m,o.png\nfill,b,m,p.png\n",
            1,
            'no tool knows what the column "maks" says',
        ),
        ("\nimage,mask,output\na,m,o.png\nb,m,p.png\n", 2, 'no column is named "tool"'),
        ("PK\3\4 and so on\nmore of it\n", 1, "neither a job in JSON nor, for CSV, names of columns"),
        ('# jobs\n{"tool": "fill"}\n', 1, "neither a job in JSON"),
    ],
)
def test_a_bad_head_of_csv_is_one_mistake(text, line, part):
    ((at, found),) = mistakes(text)
    assert (at, part in found) == (line, True)


def test_the_tool_may_be_a_default_of_csv():
    (task,) = checking.check(manifest.parse(b"image,mask,output\na,m,o.png\n"), defaults=(("tool", "fill"),))
    assert task.tool == "fill"


def test_whole_numbers_may_have_a_point():
    """As programs write them that know floats only."""
    line = {"tool": "clone", "source": "a", "destination": "b", "at": [-4.0, 7.0],
            "rect": [[1.0, 2, 3, 4], [5, 6, 7, 8e0]], "grow": 2.0, "page": 1.0, "tolerance": 1.0,
            "output": "o.png"}  # fmt: skip
    (task,) = tasks(line)
    assert list(task.jobs) == by_command_line(
        "clone a b --at=-4,7 --rect 1,2,3,4 --rect 5,6,7,8 --grow 2 --page 1 --tolerance 1 -o o.png --threads 1"
    )
    assert mistakes(json.dumps({**line, "at": [0.5, 1]}))[0][0] == 1


# Lines that say the same options are read in a short way.  Whatever the order, each must be read as by itself.

ALIKE = [
    {"tool": "clone", "source": "a", "destination": "b", "mask": "m", "output": "1.png"},
    {"tool": "clone", "source": "c", "destination": "d", "mask": "n", "output": "2.png"},
    {"tool": "clone", "source": "c", "destination": "d", "mask": "n", "output": "3.png", "at": [3, 4], "cycle": "V"},
    {"tool": "clone", "source": "c", "destination": "d", "rect": [1, 2, 3, 4], "output": "4.png", "flatten": True},
    {"tool": "clone", "source": "c", "destination": "d", "rect": [5, 6, 7, 8], "output": "5.png", "flatten": True},
    {"tool": "clone", "source": "c", "destination": "d", "rect": [5, 6, 7, 8], "mask": "m", "output": "6.png"},
    {"tool": "clone", "source": "c", "destination": "d", "mask": "m", "rect": [5, 6, 7, 8], "output": "7.png"},
    {"tool": "clone", "source": "c", "destination": "d", "mask": "m", "monochrome": False, "output": "8.png"},
    {"tool": "clone", "source": "c", "destination": "d", "mask": "m", "monochrome": True, "output": "9.png"},
    {"tool": "clone", "source": "c", "destination": "d", "mask": "m", "output": "10.png", "solver": "sor"},
    {"tool": "fill", "image": "c", "mask": "m", "output": "11.png", "solver": "sor"},
    {"tool": "fill", "image": "c", "mask": "m", "output": "12.png"},
    {"tool": "tile", "images": ["c", "d"], "output": ["13.png", "14.png"]},
    {"tool": "tile", "images": ["e"], "output": ["15.png"]},
    {"tool": "mask", "image": "c", "ellipse": [0, 0, 9, 9], "subtract": True, "rect": [1, 2, 3, 4], "output": "16.png"},
    {"tool": "mask", "image": "d", "ellipse": [0, 0, 8, 8], "subtract": True, "rect": [1, 2, 3, 3], "output": "17.png"},
    {"tool": "mask", "image": "e", "selection": [{"rect": [1, 2, 3, 3]}, {"grow": 2}, {"rect": [9, 9, 9, 9]}],
     "output": "18.png"},
    {"tool": "mask", "image": "e", "selection": [{"rect": [1, 2, 3, 3]}, {"rect": [9, 9, 9, 9]}, {"grow": 2}],
     "output": "19.png"},
]  # fmt: skip


@pytest.mark.parametrize("order", [1, -1])
def test_lines_that_are_alike_do_not_mix(order):
    together = tasks(*ALIKE[::order])
    alone = [tasks(line)[0] for line in ALIKE[::order]]
    assert [task.jobs for task in together] == [task.jobs for task in alone]


@pytest.mark.parametrize(
    ("right", "wrong", "text"),
    [
        ({"at": [1, 2]}, {"at": "here"}, "'here' is not X,Y"),
        ({"flatten": True, "sigma": 3}, {"sigma": 2}, "--sigma belongs to --flatten; add that"),
        ({"solver": "multigrid", "cycle": "W"}, {"solver": "sor", "cycle": "W"}, "--cycle belongs to"),
        (
            {"rect": [1, 2, 3, 4], "grow": 2},
            {"grow": 2, "rect": [1, 2, 3, 4]},
            "--grow works on what was selected",
        ),
    ],
)
def test_what_is_wrong_is_found_behind_lines_that_are_alike(right, wrong, text):
    start = {"tool": "clone", "source": "a", "destination": "b"}
    end = {} if "rect" in right else {"mask": "m"}
    lines = [{**start, **which, **end} for which in (right, right, wrong, wrong, right)]
    found = mistakes("\n".join(json.dumps({**line, "output": f"{k}.png"}) for k, line in enumerate(lines)))
    assert [line for line, _ in found] == [3, 4]
    assert all(text in said for _, said in found)


def test_every_mistake_is_found_at_once():
    fill = '{"tool": "fill", "image": "a.png", "rect": [0,0,9,9], '
    text = "\n".join(
        [
            '{"defaults": {"colour": 3}}',
            fill + '"output": "o.png"}',
            "",
            "{nonsense",
            "[1]",
            '{"tool": "fill", "tool": "mix"}',
            '{"image": "a.png"}',
            '{"tool": "demo", "directory": "d"}',
            fill + '"maks": "m.png", "output": "1.png"}',
            fill + '"json": true, "output": "2.png"}',
            fill + '"certify": "perhaps", "output": "3.png"}',
            fill + '"tolerance": true, "output": "4.png"}',
            fill + '"tolerance": -1, "output": "5.png"}',
            fill + '"output": "-"}',
            '{"tool": "fill", "image": "a.png", "output": "7.png"}',
            '{"tool": "fill", "rect": [0,0,9,9], "output": "8.png"}',
            '{"tool": "fill", "image": "a.png", "selection": [{"grow": 3}], "output": "9.png"}',
            '{"tool": "fill", "image": "a.png", "selection": [{"hue": 3}], "output": "10.png"}',
            fill + '"solver": "sor", "cycle": "W", "output": "11.png"}',
            fill + '"output": "./o.png"}',
            '{"tool": "fill", "image": "o.png", "rect": [0,0,9,9], "output": "12.png"}',
            '{"tool": "fill", "image": "13.png", "rect": [0,0,9,9], "output": "13.png", "overwrite": true}',
            fill + '"tolerance": NaN, "output": "14.png"}',
            fill + '"zzz": "source", "output": "15.png"}',
            fill + '"max_iterations": 3, "max-iterations": 4, "output": "16.png"}',
            '{"defaults": {"cycle": "V"}}',
            "7",
            fill + '"output": ""}',
            fill + '"output": "no/17.png"}',
            fill + '"output": "18.xyz"}',
            fill + '"output": "19"}',
            fill + '"output": "20.png", "quality": 90}',
            '{"tool": "tile", "images": ["a.png", "b.png"], "output": ["21.png", "./21.png"]}',
            '{"tool": "tile", "images": ["a.png"], "output": ["22.png"], "preview": "23.xyz"}',
            '{"tool": "fill", "image": "a.png", "mask": "22.png:red", "output": "24.png"}',
            fill + r'"output": "\ud800.png"}',
        ]
    )
    found = mistakes(text)
    expected = [
        (1, 'no tool has the default "colour"'), (4, "not JSON"), (5, "a JSON list; write each job in a line"),
        (6, '"tool" is there twice'),
        (7, '"tool" is missing; it can be clone, fill'), (8, 'no tool "demo"'), (9, 'did you mean "mask"?'),
        (10, 'fill has no "json"'), (11, '"certify" is "perhaps", not true or false'),
        (12, '"tolerance" is true, not text or a number'), (13, "'-1' is not a number greater than 0"),
        (14, '"output" is "-"'), (15, "No selection given"), (16, '"image" is missing'),
        (17, "--grow works on what was selected before it"), (18, 'step 1 of the selection has no "hue"'),
        (19, "--cycle belongs to --solver multigrid"), (20, "o.png is also written by line 2"),
        (21, "o.png is written by line 2; read it in another batch"), (22, "13.png is read and written"),
        (23, "NaN is no number"), (24, 'fill has no "zzz"; it has image'), (25, '"max_iterations" is there twice'),
        (26, '"defaults" belong into the first line'), (27, "not a JSON object"), (28, '"output" is ""'),
        (29, "there is no folder no for an output"), (30, "18.xyz: the ending .xyz does not tell"),
        (31, "19: a name without an ending does not tell"), (32, "20.png: PNG has no quality to choose"),
        (33, "21.png is written twice"), (34, "23.xyz: the ending .xyz does not tell"),
        (35, "22.png is written by line 34; read it"), (36, "which no file can be called"),
    ]  # fmt: skip
    assert [line for line, _ in found] == [line for line, _ in expected]
    for (_, text), (_, part) in zip(found, expected, strict=True):
        assert part in text


@pytest.mark.parametrize(
    ("data", "line", "text"),
    [
        (b"tool,image\nfill\n", 2, "1 cells, but the first line names 2 columns"),
        (b"tool,,image\nfill,a,b\n", 1, "column 2 has no name"),
        (b'tool,image\nfill,a\nfill,"a"b\n', 3, "not CSV"),
        (b'{"tool": "fill"}\n\xff\n', 2, "not UTF-8"),
        (b'{"defaults": 3}\n', 1, '"defaults" is no object'),
        (b"[" * 100_000, 1, ""),
        (b'[{"tool": "fill"},\n {"tool": "fill"}]\n', 1, "JSON over several lines"),
        (b'\n{\n "tool": "fill"\n}\n', 2, "JSON over several lines"),
    ],
)
def test_what_cannot_be_read_at_all(data, line, text):
    found = manifest.parse(data).mistakes
    assert [mistake.line for mistake in found] == [line]
    assert text in found[0].text


def test_two_names_of_one_output(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    lines = [
        {"tool": "fill", "image": "a.png", "rect": [0, 0, 9, 9], "output": f"{name}/o.png"}
        for name in ("real", "link")
    ]
    found = mistakes("\n".join(map(json.dumps, lines)), folder=str(tmp_path))
    assert [line for line, _ in found] == [2]
