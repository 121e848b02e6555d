"""Pictures through pipes and devices, and files with any name."""

import json
import os
import socket
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from poisson_cli import editing
from poisson_cli.streams import printable
from tests.kinds import DEEP_RGB, FLOAT_RGB, pillow, tiff
from tests.small_pictures import DESTINATION, DESTINATION_MASK, GREY, load

REPOSITORY = Path(__file__).resolve().parent.parent
POISSON = f"{sys.executable} -m poisson_cli"
FILLED = editing.fill(GREY, DESTINATION_MASK).image


@pytest.fixture(autouse=True)
def environment(folder, monkeypatch):
    paths = [str(REPOSITORY), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, paths)))


def shell(line: str, **more) -> subprocess.CompletedProcess:
    """Runs a line of a shell in which `poisson` is ours; fails if any command of a pipe does."""
    script = f'set -o pipefail; poisson() {{ {POISSON} "$@"; }}\n{line}'
    return subprocess.run(["bash", "-c", script], capture_output=True, timeout=60, **more)


def test_a_picture_comes_from_stdin_and_goes_to_stdout():
    ran = shell("poisson fill - -m dest-mask.png -o - --format png < grey.png > out.png")
    assert (ran.returncode, ran.stdout) == (0, b"")
    assert ran.stderr.endswith(b" -> standard output\n")
    np.testing.assert_array_equal(load("out.png"), FILLED)


def test_a_mask_can_come_from_stdin_too():
    assert shell("cat dest-mask.png | poisson fill grey.png -m - -o out.png -q").returncode == 0
    np.testing.assert_array_equal(load("out.png"), FILLED)


def test_a_part_of_a_mask_from_stdin():
    labels = np.where(DESTINATION_MASK, np.uint8(3), np.uint8(7))
    Path("labels.png").write_bytes(pillow(labels, "PNG"))
    assert shell("poisson fill grey.png -m -:index=3 -o out.png -q < labels.png").returncode == 0
    np.testing.assert_array_equal(load("out.png"), FILLED)
    ran = shell("poisson fill source.png -m - -o out2.png -q < labels.png")
    assert ran.stderr.startswith(
        b"poisson: error: mask standard input is 48x40, but the image source.png is "
    )


@pytest.mark.parametrize(
    ("form", "pixels"), [("png", DEEP_RGB), ("tif", DEEP_RGB), ("tif", FLOAT_RGB), ("pfm", FLOAT_RGB)]
)
def test_commands_in_a_pipe_lose_nothing(form, pixels):
    Path("deep.tif").write_bytes(tiff(pixels, photometric="rgb"))
    one, two = "--rect 2,2,9,9", "--rect 20,12,15,9"
    line = (
        f"poisson fill - {one} -o - --format {form} -q < deep.tif | "
        f"poisson fill - {two} -o - --format {form} -q > piped; "
        f"poisson fill deep.tif {one} -o one.{form} -q; poisson fill one.{form} {two} -o two.{form} -q; "
        f"cmp piped two.{form}"
    )
    ran = shell(line)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, b"", b"")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_nobody_reading_the_picture_is_quiet(monkeypatch, unbuffered):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    ran = shell("poisson fill destination.png -m dest-mask.png -o - --format bmp -q | head -c1")
    assert (ran.stdout, ran.stderr) == (b"B", b"")
    Path("large.png").write_bytes(pillow(np.zeros((400, 500, 3), np.uint8), "PNG"))
    ran = shell("poisson fill large.png --rect 5,5,9,9 -o - --format bmp -q | head -c1")
    assert (ran.returncode, ran.stdout, ran.stderr) == (141, b"B", b"")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_slow_reader_gets_all_of_it(monkeypatch, unbuffered):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    Path("large.png").write_bytes(pillow(np.zeros((400, 500, 3), np.uint8), "PNG"))
    ran = shell("poisson fill large.png --rect 5,5,9,9 -o - --format bmp -q | (sleep .5; wc -c)")
    assert int(ran.stdout) == 54 + 400 * 500 * 3


@pytest.mark.parametrize("output", ["/dev/null", "/dev/stdout", "/dev/stderr", "/dev/fd/1"])
def test_devices_are_written_into(output):
    before = os.stat("/dev/null").st_mode
    ran = shell(f"poisson fill grey.png -m dest-mask.png -o {output} --format png -q")
    assert ran.returncode == 0
    assert os.stat("/dev/null").st_mode == before
    sent = {"/dev/null": b"", "/dev/stderr": ran.stderr}.get(output, ran.stdout)
    assert (len(sent) > 100) == (output != "/dev/null")
    if sent:
        Path("sent.png").write_bytes(sent)
        np.testing.assert_array_equal(load("sent.png"), FILLED)


def test_stdout_that_is_a_file_is_written_into():
    ran = shell("poisson fill grey.png -m dest-mask.png -o /dev/stdout --format png -q > sent.png")
    assert ran.returncode == 0, ran.stderr
    np.testing.assert_array_equal(load("sent.png"), FILLED)


@pytest.mark.parametrize("name", ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"])
def test_what_others_wrote_to_stdout_stays(name):
    """A file that is opened by the name of stdout is opened anew, and written from its beginning."""
    Path("log").write_bytes(b"precious")
    ran = shell(f"poisson fill grey.png -m dest-mask.png -o {name} --format png -q >> log")
    assert ran.returncode == 0, ran.stderr
    assert Path("log").read_bytes()[:16] == b"precious\x89PNG\r\n\x1a\n"
    ran = shell(f"{{ echo one; poisson fill grey.png -m dest-mask.png -o {name} --format png -q; }} > both")
    assert Path("both").read_bytes()[:8] == b"one\n\x89PNG"


def test_a_socket_is_a_standard_output_too(folder):
    ours, theirs = socket.socketpair()
    words = "fill grey.png -m dest-mask.png -o /dev/stdout --format ppm -q".split()
    with ours, theirs:
        ran = subprocess.run([*POISSON.split(), *words], stdout=theirs, stderr=subprocess.PIPE, timeout=60)
        theirs.close()
        assert (ran.returncode, ran.stderr) == (0, b"")
        assert ours.recv(2) == b"P5"


def test_nowhere_needs_no_format():
    assert shell("poisson fill alpha.png -m dest-mask.png -o /dev/null").returncode == 0


def test_a_report_that_finds_no_room_is_an_error_but_the_picture_is_there():
    ran = shell("poisson fill grey.png -m dest-mask.png -o out.png --json -q > /dev/full")
    assert (ran.returncode, ran.stderr) == (
        4,
        b"poisson: error: standard output: the report cannot be written (No space left on device), "
        b"but out.png was\n",
    )
    np.testing.assert_array_equal(load("out.png"), FILLED)


@pytest.mark.parametrize("words", ["--help", "fill --help", "--version"])
def test_help_that_finds_no_room_is_an_error(words):
    ran = shell(f"poisson {words} > /dev/full")
    assert (ran.returncode, ran.stderr) == (
        4,
        b"poisson: error: standard output: cannot be written (No space left on device)\n",
    )


def test_a_named_pipe_is_written_into_and_stays_one(folder, poisson):
    os.mkfifo("pipe.png")
    got = []
    reader = threading.Thread(target=lambda: got.append(Path("pipe.png").read_bytes()))
    reader.start()
    assert poisson("fill", "grey.png", "-m", "dest-mask.png", "-o", "pipe.png").code == 0
    reader.join()
    assert Path("pipe.png").is_fifo()
    Path("got.png").write_bytes(got[0])
    np.testing.assert_array_equal(load("got.png"), FILLED)


def test_a_full_device_is_an_error():
    ran = shell("poisson fill grey.png -m dest-mask.png -o - --format png -q > /dev/full")
    assert (ran.returncode, ran.stderr) == (
        4,
        b"poisson: error: standard output: cannot be written (No space left on device)\n",
    )


def test_what_never_ends_is_refused():
    for line in ("cat /dev/zero | poisson fill - --rect 1,1,9,9 -o out.png",
                 "yes | poisson fill - --rect 1,1,9,9 -o out.png --max-pixels 9"):  # fmt: skip
        ran = shell(line)
        assert ran.stderr.startswith(b"poisson: error: standard input: "), ran.stderr
        assert ran.stderr.count(b"\n") == 1


def test_no_stdin_at_all():
    ran = shell("poisson fill - --rect 1,1,9,9 -o out.png <&-")
    assert (ran.returncode, ran.stderr) == (3, b"poisson: error: standard input: it is closed; name a file\n")


def test_no_stdout_for_the_picture():
    ran = shell("poisson fill grey.png -m dest-mask.png -o - --format png >&-")
    assert (ran.returncode, ran.stderr) == (
        4,
        b"poisson: error: standard output: it is closed; name a file with -o\n",
    )


@pytest.mark.parametrize("streams", ["2>&-", ">&-", ">&- 2>&-", "<&-"])
def test_closed_streams_change_nothing(streams):
    assert shell(f"poisson fill grey.png -m dest-mask.png -o out.png {streams}").returncode == 0
    np.testing.assert_array_equal(load("out.png"), FILLED)


def test_no_colour_and_no_terminal_no_escapes(monkeypatch):
    for value in ("", "1"):
        monkeypatch.setenv("NO_COLOR", value)
        ran = shell(
            "poisson --help; poisson fill grey.png -m dest-mask.png -o out.png -v --overwrite; poisson fill"
        )
        assert b"\x1b" not in ran.stdout + ran.stderr


NAMES = [
    "with spaces.png",
    " .png",
    "ünïcödé 画.png",
    "-leading-dash.png",
    "two\nlines.png",
    "[b]*?.png",
    "frame%03d.png",
    "http:",
    "a\x1b[31m.png",
    "~",
    "$HOME.png",
    "imageio:chelsea.png",
    "<bytes>.png",
    "-",
]


@pytest.mark.parametrize("name", [*NAMES, os.fsdecode(b"not\xff\xfeutf-8.png")], ids=ascii)
def test_a_name_is_a_file_whatever_it_looks_like(folder, poisson, name):
    path = f"./{name}" if name.startswith("-") else name
    Path(folder / name).write_bytes(Path("grey.png").read_bytes())
    Path(folder / "out").mkdir()
    output = folder / "out" / name
    ran = poisson("fill", path, "-m", "dest-mask.png", "-o", output, "--format", "png", "--json")
    assert ran.code == 0, ran.err
    assert [entry.name for entry in (folder / "out").iterdir()] == [name]
    np.testing.assert_array_equal(load(output), FILLED)
    assert json.loads(ran.out)["output"] == str(output)
    assert ran.err.count("\n") == 1
    assert "\x1b" not in ran.err
    missing = poisson("fill", f"{path}.missing", "-m", "dest-mask.png", "-o", "new.png")
    assert (missing.code, missing.err.count("\n")) == (3, 1)
    assert "\x1b" not in missing.err


def test_an_address_is_never_asked(monkeypatch, poisson):
    def connect(*_):
        pytest.fail("somebody was asked")

    monkeypatch.setattr(socket, "socket", connect)
    for name in (
        "http://localhost/a.png",
        "https://localhost/a.png",
        "ftp://localhost/a.png",
        "file:///etc/passwd",
    ):
        assert poisson("fill", name, "--rect", "1,1,9,9", "-o", "out.png").code == 3
        assert poisson("fill", "grey.png", "--rect", "1,1,9,9", "-o", name).code == 4


def test_only_text_is_printed():
    assert printable("plain, ünïcödé 画") == "plain, ünïcödé 画"
    assert printable("a\nb\x1b\x07\u202e") == "a\\nb\\x1b\\x07\\u202e"
    assert printable("\udcff") == "\\xff"


def test_an_output_over_an_input_through_links(folder, poisson):
    Path("link.png").symlink_to("destination.png")
    ran = poisson("fill", "destination.png", "-m", "dest-mask.png", "-o", "link.png", "--overwrite")
    assert ran.code == 0
    assert Path("link.png").is_symlink()
    np.testing.assert_array_equal(load("destination.png"), editing.fill(DESTINATION, DESTINATION_MASK).image)
