"""Compiled kernels on disk: declared, compiled, stored and loaded, and what happens where one of these fails."""

import ctypes
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from solvers.kernels import policy
from solvers.native import building, image, store
from solvers.native.signature import Kind, Signature
from tests import tiny_kernels

ROOT = Path(__file__).resolve().parent.parent

PROBE = """
import sys
import numpy as np
from tests import tiny_kernels as tiny
heard = []
tiny.library.listener = lambda volume, seconds: heard.append(seconds)
values = np.linspace(-1, 7, 21, dtype=np.float32).reshape(3, 7)
out = np.empty(3, np.float32)
last = tiny.scale(out, values, 0.7)
out8 = np.empty(3)
last8 = tiny.scale(out8, values.astype(np.float64), 0.7)
roots = np.empty(6)
tiny.flatten(roots, np.arange(12.0).reshape(2, 2, 3), 1)
low, high = tiny.extremes(values[1])
smoothed, line = np.zeros(21, np.float32), values.reshape(-1)
second = tiny.smooth(smoothed, line, line[::-1].copy())
flags = bool(tiny.every(np.ones(4, np.bool_), True)), bool(tiny.every(np.ones(4, np.bool_), False))
strided = np.zeros((3, 14), np.float32)[:, ::2]
strided[:] = values
out_strided = np.empty(3, np.float32)
if len(sys.argv) > 1:
    tiny.scale(out_strided, strided, np.float32(0.7))
numbers = (np.float32(last), np.float64(last8), np.float32(low), np.float32(high), np.float32(second))
print(b"".join(a.tobytes() for a in (out, out8, roots, smoothed, *numbers)).hex(), *flags)
print(out_strided.tobytes() == out.tobytes(), "numba" in sys.modules, len(heard), tiny.library.trouble, sep="|")
"""


def probe(place: Path, *words: str, kernels: str = "native", before: str = "") -> tuple[str, list[str]]:
    """Runs the tiny kernels in a process of their own: their results, and how they were had."""
    environment = {**os.environ, "POISSON_CACHE_DIR": str(place), "POISSON_KERNELS": kernels}
    environment.pop("NUMBA_DISABLE_JIT", None)
    ran = subprocess.run(
        [sys.executable, "-c", before + PROBE, *words],
        capture_output=True,
        text=True,
        env=environment,
        cwd=ROOT,
    )
    assert ran.returncode == 0, ran.stderr
    results, how = ran.stdout.splitlines()
    return results, how.split("|")


def stored(place: Path) -> list[Path]:
    return sorted(place.glob(f"*{store.ENDING}"))


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """A folder that holds the compiled tiny kernels, and their results."""
    place = tmp_path_factory.mktemp("cache") / "poisson"
    results, how = probe(place)
    assert how[1:] == ["True", "2", "None"]  # compiled: numba was imported, and it was said before and after
    return place, results


def test_later_processes_load_without_numba(warm):
    place, results = warm
    assert len(stored(place)) == 1
    again, how = probe(place)
    assert again == results
    assert how[1:] == ["False", "0", "None"]


def test_what_few_need_is_compiled_when_it_is_called(tmp_path):
    program = (
        "import sys; import numpy as np; from tests import tiny_kernels as tiny\n"
        "heard = []; tiny.library.listener = lambda volume, seconds: heard.append(volume)\n"
        "values = np.arange(3, dtype=sys.argv[1]); tiny.halve(values); print(*values, *heard)\n"
    )

    def halved(dtype):
        environment = {**os.environ, "POISSON_CACHE_DIR": str(tmp_path), "POISSON_KERNELS": "native"}
        ran = subprocess.run(
            [sys.executable, "-c", program, dtype], capture_output=True, text=True, env=environment, cwd=ROOT
        )
        assert ran.returncode == 0, ran.stderr
        return ran.stdout.split()[3:]

    assert halved("float32") == ["usual", "usual"]
    assert len(stored(tmp_path)) == 1
    assert halved("float64") == ["further", "further"]
    assert len(stored(tmp_path)) == 2
    assert halved("float64") == halved("float32") == []


@pytest.mark.parametrize("kernels", ["numba", "python"])
def test_the_other_ways_give_the_same_bits(warm, kernels, tmp_path):
    _, results = warm
    again, how = probe(tmp_path / "none", "strided", kernels=kernels)
    assert again == results
    assert how == ["True", str(kernels == "numba"), "0", "None"]
    assert not (tmp_path / "none").exists()


def test_unforeseen_arguments_are_left_to_numba(warm):
    place, results = warm
    again, how = probe(place, "strided")
    assert again == results
    assert how == ["True", "True", "0", "None"]


def test_an_unknown_way_is_refused(tmp_path):
    with pytest.raises(
        AssertionError, match="POISSON_KERNELS is 'fast', but must be one of native, numba, python"
    ):
        probe(tmp_path, kernels="fast")


@pytest.mark.parametrize("damage", ["cut", "bit", "empty", "longer"])
def test_a_damaged_file_is_compiled_anew(warm, damage, tmp_path):
    place, results = warm
    original = stored(place)[0]
    data = original.read_bytes()
    flipped = bytearray(data)
    flipped[len(data) // 2] ^= 1
    broken = {"cut": data[:-9], "bit": bytes(flipped), "empty": b"", "longer": data + b"\0"}[damage]
    other = tmp_path / "poisson"
    other.mkdir(mode=0o700)
    copy = other / original.name
    copy.write_bytes(broken)
    copy.chmod(0o600)
    again, how = probe(other, "strided")  # numba itself still works after that
    assert again == results
    assert how[0] == "True"
    assert how[1:] == ["True", "2", "None"]
    assert store.Shelf(copy.stem, other).read() is not None


def test_a_whole_file_of_something_else_is_compiled_anew(warm, tmp_path):
    place, results = warm
    other = tmp_path / "poisson"
    shelf = store.Shelf(stored(place)[0].stem, other)
    assert shelf.write(b"something else")
    again, how = probe(other)
    assert again == results
    assert how[1:] == ["True", "2", "None"]


SIDE_BY_SIDE = """
import sys
from solvers.native import building
from tests import tiny_kernels
tiny_kernels.library.helpers = True
building.available_cores = lambda: 3
"""


@pytest.mark.parametrize(
    "helper", ["", "sys.executable = '/bin/false'\n"], ids=["helpers", "helpers that fail"]
)
def test_compiling_side_by_side_gives_the_same(warm, helper, tmp_path):
    _, results = warm
    place = tmp_path / "poisson"
    again, how = probe(place, before=SIDE_BY_SIDE + helper)
    assert again == results
    assert how[1:] == ["True", "2", "None"]
    again, how = probe(place)
    assert again == results
    assert how[1:] == ["False", "0", "None"]


@pytest.mark.parametrize("missing", ["possible = lambda: False", "link = refuse"])
def test_without_an_image_llvm_links_the_objects(warm, missing, tmp_path):
    """Where objects are of another kind, and where they hold what an image cannot."""
    _, results = warm
    before = (
        "import sys\nfrom solvers.native import image\n"
        "def refuse(*_):\n    raise image.ImageError('no')\n"
        f"image.{missing}\n"
    )
    place = tmp_path / "poisson"
    assert probe(place, before=before)[0] == results
    again, how = probe(place, before=before)
    assert again == results
    assert how[1:] == ["False", "0", "None"]
    [content] = stored(place)
    assert b"\x7fELF" in content.read_bytes() or not image.possible()


def test_many_processes_at_once_on_an_empty_cache(warm, tmp_path):
    _, results = warm
    place = tmp_path / "poisson"
    environment = {**os.environ, "POISSON_CACHE_DIR": str(place), "POISSON_KERNELS": "native"}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", PROBE],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
            cwd=ROOT,
        )
        for _ in range(20)
    ]
    answers = [process.communicate() for process in running]
    assert all(process.returncode == 0 for process in running), answers
    lines = [out.decode().splitlines() for out, _ in answers]
    assert {first for first, _ in lines} == {results}
    assert sum("|True|2|" in second for _, second in lines) == 1  # one compiled, the others waited
    assert len(stored(place)) == 1
    assert not list(place.glob("*.tmp"))


def test_helpers_end_when_nobody_waits_for_them(monkeypatch):
    """Whatever became of the process that started them: here it has work for them, and says nothing more."""
    queue, entrance = os.pipe()
    helper = building._start_helper(tiny_kernels.library, "usual", queue)
    with helper:
        assert helper.poll() is None
        helper.stdin.close()
        assert helper.wait(timeout=60) == 1
    os.close(queue)
    os.close(entrance)


def test_that_nothing_can_be_kept_is_known_before_it_is_compiled(tmp_path):
    program = (
        "from tests import tiny_kernels as tiny\n"
        "tiny.library._tell = lambda volume, seconds: print(seconds is None, tiny.library.unkept)\n"
        "tiny.library.addresses('usual')\n"
    )
    tmp_path.chmod(0o770)
    ran = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env={**os.environ, "POISSON_CACHE_DIR": str(tmp_path), "POISSON_KERNELS": "native"},
        cwd=ROOT,
    )
    reason = f"{tmp_path} can be written to by others"
    assert ran.stdout.splitlines() == [f"True {reason}", f"False {reason}"]


def test_what_stands_in_the_way_of_a_folder(tmp_path):
    assert store.obstacle(tmp_path / "a" / "b") is None
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("")
    assert store.obstacle(tmp_path / "file") == f"{tmp_path / 'file'} is not a folder"
    assert store.obstacle(tmp_path / "file" / "b") == f"{tmp_path / 'file'}: File exists"


def test_a_compiler_that_fails_is_spoken_of(warm, tmp_path):
    _, results = warm
    broken = (
        "from solvers.native import building\n"
        "def fail(*_):\n    raise building.BuildError('no such processor')\n"
        "building.build = fail\n"
    )
    again, how = probe(tmp_path / "poisson", before=broken)
    assert again == results
    assert how[1:] == ["True", "2", "BuildError: no such processor"]


def test_where_nothing_can_be_written_it_works_all_the_same(warm, tmp_path):
    _, results = warm
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    again, how = probe(blocked / "poisson")
    assert again == results
    assert how[1:] == ["True", "2", "None"]


def test_a_folder_open_to_others_is_neither_read_nor_written(warm, tmp_path):
    place, results = warm
    other = tmp_path / "poisson"
    other.mkdir()
    copy = other / stored(place)[0].name
    copy.write_bytes(stored(place)[0].read_bytes())
    copy.chmod(0o600)
    other.chmod(0o777)
    shelf = store.Shelf(copy.stem, other)
    assert shelf.read() is None
    assert "can be written to by others" in str(shelf.trouble)
    assert not shelf.write(b"new")
    again, how = probe(other)
    assert again == results
    assert how[1:] == ["True", "2", "None"]


def test_a_file_open_to_others_is_not_read(tmp_path):
    shelf = store.Shelf("key", tmp_path / "poisson")
    assert shelf.write(b"content")
    assert shelf.read() == b"content"
    shelf.path.chmod(0o620)
    assert shelf.read() is None
    assert "can be written to by others" in str(shelf.trouble)


def test_a_link_is_not_followed(tmp_path):
    shelf = store.Shelf("key", tmp_path / "poisson")
    assert shelf.write(b"content")
    real = shelf.path.rename(tmp_path / "elsewhere")
    shelf.path.symlink_to(real)
    assert shelf.read() is None
    assert shelf.trouble is not None


def test_what_another_user_owns_is_not_read(tmp_path, monkeypatch):
    shelf = store.Shelf("key", tmp_path / "poisson")
    assert shelf.write(b"content")
    owner = shelf.path.stat().st_uid
    real_stat, real_fstat = os.stat, os.fstat

    def foreign(status):
        return os.stat_result((*status[:4], owner + 1234, *status[5:]))

    with monkeypatch.context() as patched:
        patched.setattr(store.os, "stat", lambda path, **how: foreign(real_stat(path, **how)))
        assert shelf.read() is None
        assert "belongs to another user" in str(shelf.trouble)
        assert not shelf.write(b"new")
    with monkeypatch.context() as patched:
        patched.setattr(store.os, "fstat", lambda descriptor: foreign(real_fstat(descriptor)))
        assert shelf.read() is None
        assert "belongs to another user" in str(shelf.trouble)
    assert shelf.read() == b"content"


@pytest.mark.parametrize("umask", [0o022, 0o002, 0, 0o077])
def test_others_may_read_but_not_write(umask, tmp_path):
    place = tmp_path / "a" / "poisson"
    before = os.umask(umask)
    try:
        assert store.Shelf("key", place).write(b"content")
    finally:
        os.umask(before)
    assert place.stat().st_mode & 0o777 == 0o755 & ~umask
    assert (place / f"key{store.ENDING}").stat().st_mode & 0o777 == 0o644 & ~umask
    assert store.Shelf("key", place).read() == b"content"


def test_the_place(monkeypatch, tmp_path):
    monkeypatch.setenv("POISSON_CACHE_DIR", str(tmp_path))
    assert store.folder() == tmp_path
    monkeypatch.delenv("POISSON_CACHE_DIR")
    monkeypatch.setattr(store.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert store.folder() == tmp_path / "xdg" / "poisson"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # which the standard says to ignore
    monkeypatch.setenv("HOME", str(tmp_path))
    assert store.folder() == tmp_path / ".cache" / "poisson"


def test_the_key_knows_sources_compilers_machine_and_settings(monkeypatch, tmp_path):
    library = tiny_kernels.library
    key = store.key_of(library, "usual", "machine")
    assert key == store.key_of(library, "usual", "machine")
    keys = {
        key,
        store.key_of(library, "usual", "another machine"),
        store.key_of(library, "further", "machine"),
    }
    with monkeypatch.context() as patched:
        patched.setattr(store, "version_of", lambda _: b"another")
        keys.add(store.key_of(library, "usual", "machine"))
    with monkeypatch.context() as patched:
        patched.setenv("NUMBA_CPU_NAME", "generic")
        keys.add(store.key_of(library, "usual", "machine"))
    changed = tmp_path / "tiny_kernels.py"
    changed.write_bytes(Path(tiny_kernels.__file__).read_bytes() + b"\n")
    real = store._origin
    with monkeypatch.context() as patched:
        patched.setattr(
            store, "_origin", lambda name: str(changed) if name == "tests.tiny_kernels" else real(name)
        )
        keys.add(store.key_of(library, "usual", "machine"))
    assert len(keys) == 6


def test_numbas_version_is_told_without_importing_it():
    import numba

    assert numba.__version__.encode() in store.version_of("numba")


on_known_systems = pytest.mark.skipif(not image.possible(), reason="objects of another kind")


@on_known_systems
def test_an_image_is_loaded_without_llvm(warm):
    place, results = warm
    forbid = (
        "import sys\nclass Forbid:\n"
        "    def find_spec(self, name, *_):\n        assert name != 'llvmlite.binding'\n"
        "sys.meta_path.insert(0, Forbid())\n"
    )
    again, how = probe(place, before=forbid)
    assert again == results
    assert how[1:] == ["False", "0", "None"]
    [content] = stored(place)
    assert b"\x7fELF" not in content.read_bytes()


def emitted(source: str) -> bytes:
    """An object from LLVM's language."""
    from solvers.native import linker

    machine = linker.target_machine()
    return bytes(machine.emit_object(linker.llvm.parse_assembly(source)))


CALLS = """
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
define i64 @second(i64 %x) {
  %y = mul i64 %x, 3
  ret i64 %y
}
define i64 @first(ptr %p, i64 %n) noinline {
  call void @llvm.memset.p0.i64(ptr %p, i8 7, i64 %n, i1 false)
  %y = call i64 @second(i64 %n)
  ret i64 %y
}
"""


@on_known_systems
def test_an_image_holds_what_its_objects_do():
    """Calls within, constants, and calls of the C library, from an object that is not the first."""
    half = emitted("define double @half(double %x) {\n %y = fmul double %x, 0.3\n ret double %y\n}\n")
    code, offsets = image.link([half, emitted(CALLS)], ["first", "half"])
    first, half_of = image.load(code, offsets)
    buffer = (ctypes.c_uint8 * 100)()
    call = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64)(first)
    assert call(ctypes.addressof(buffer), 90) == 270
    assert bytes(buffer) == b"\7" * 90 + bytes(10)
    assert ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(half_of)(1.5) == 1.5 * 0.3


@on_known_systems
def test_what_cannot_be_an_image_is_refused():
    def refusal(source: bytes | str, name: str = "f") -> str:
        with pytest.raises(image.ImageError) as caught:
            image.link([source if isinstance(source, bytes) else emitted(source)], [name])
        return str(caught.value)

    assert "variables" in refusal("@v = global i64 1\ndefine ptr @f() {\n ret ptr @v\n}\n")
    assert "need puts" in refusal(
        "declare i32 @puts(ptr)\ndefine i32 @f(ptr %p) {\n %x = call i32 @puts(ptr %p)\n ret i32 %x\n}\n"
    )
    assert "relocations of kind" in refusal("declare i32 @puts(ptr)\ndefine ptr @f() {\n ret ptr @puts\n}\n")
    assert "not in the objects: g" in refusal("define void @f() {\n ret void\n}\n", "g")
    whole = emitted(CALLS)
    for damaged in (b"", b"something else", whole[:30], whole[: len(whole) // 2], b"MZ" + whole[2:]):
        assert refusal(damaged)
    with pytest.raises(image.ImageError, match="not an image"):
        image.load(b"short", [100])


@on_known_systems
@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be chosen")
def test_the_processor_says_the_same_on_every_core():
    from solvers.native.processor import processor

    cores = os.sched_getaffinity(0)
    try:
        said = set()
        for core in cores:
            os.sched_setaffinity(0, {core})
            said.add(processor())
    finally:
        os.sched_setaffinity(0, cores)
    assert len(said) == 1


def test_lists_of_bytes():
    parts = [b"", b"abc", b"\0" * 300]
    assert store.unpacked_list(store.packed_list(parts)) == parts
    with pytest.raises(ValueError, match="cut short"):
        store.unpacked_list(store.packed_list(parts)[:-1])


def test_signatures():
    signature = Signature.of("f4[:], i8[:,:], b1[:,:,:], f8 -> i4, i4")
    assert signature.arguments == (Kind("f4", 1), Kind("i8", 2), Kind("b1", 3), Kind("f8", 0))
    assert signature.results == (Kind("i4", 0), Kind("i4", 0))
    assert Signature.of("i8").results == ()
    for wrong in ("f2[:]", "f4[]", "f4[:] -> f4[:]", "f4 -> i4, i8"):
        with pytest.raises(ValueError, match=r"no type|one kind"):
            Signature.of(wrong)


def test_every_entry_point_of_the_solvers_is_declared_as_it_is():
    """A kernel whose parameters change is left to numba until its signature follows: that is slow, not wrong."""
    declared = {kernel.__name__: len(kernel.signatures) for kernel in policy.library.kernels()}
    volumes = policy.ENTRY_POINTS, policy.FURTHER
    assert declared == Counter(name for volume in volumes for name, texts in volume.items() for _ in texts)


SOLVE = """
import sys, hashlib
import numpy as np
from poisson_cli import editing
random = np.random.default_rng(3)
source, destination = random.integers(0, 256, (2, 24, 29, 3), np.uint8)
mask = np.zeros((24, 29), np.bool_)
mask[3:20, 4:25] = True
mask[8:11, 9] = False
ways = {}, {"solver": "sor"}, {"cycle": "W"}
images = [editing.clone(destination, source, mask, **options).image for options in ways]
images.append(editing.fill(destination / 255, mask).image)
destination, source = (destination / 255).astype(np.float32), (source / 255).astype(np.float32)
images.append(editing.clone(destination, source, mask).image)
numba = "numba" in sys.modules
print(*(hashlib.sha256(image.tobytes()).hexdigest() for image in images), numba)
"""


def test_the_solvers_give_the_same_bits_from_every_way():
    answers = {}
    for kernels in ("native", "native", "numba", "python"):  # the first one may have to compile
        environment = {**os.environ, "POISSON_KERNELS": kernels}
        ran = subprocess.run(
            [sys.executable, "-c", SOLVE], capture_output=True, text=True, env=environment, cwd=ROOT
        )
        assert ran.returncode == 0, ran.stderr
        answers[kernels] = ran.stdout.split()
    assert answers["native"][:-1] == answers["numba"][:-1] == answers["python"][:-1]
    assert [answers[kernels][-1] for kernels in ("native", "numba", "python")] == ["False", "True", "False"]
