"""Full disks, signals and sudden death while an output is written over an old one: what is lost?

``python -m tests.faults`` tries each many times and prints how often the old file, or a whole new one, was not there
afterwards: never. The test suite tries a few.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from tests.small_pictures import encoded, smooth

REPOSITORY = Path(__file__).resolve().parent.parent
OLD = b"the only copy of something"
WORDS = "fill picture.png --rect 20,20,260,200 -o out.png --overwrite -q".split()
STOPPED = {
    # code of the shell, or signal before Python listens to it; or 1, when Python itself was still being loaded
    signal.SIGINT: (130, -signal.SIGINT, 1),
    signal.SIGTERM: (143, -signal.SIGTERM),
    signal.SIGHUP: (129, -signal.SIGHUP),
    signal.SIGKILL: (-signal.SIGKILL,),
}


def prepare(folder: Path) -> None:
    (folder / "picture.png").write_bytes(encoded(smooth(300, 320, 3)))


def start(folder: Path, *, limit: int | None = None) -> subprocess.Popen[bytes]:
    """`poisson`, about to replace the old file; a file that it writes can have so many bytes at most."""
    (folder / "out.png").write_bytes(OLD)

    def prepare_child() -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    return subprocess.Popen(
        [sys.executable, "-m", "poisson_cli", *WORDS],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=prepare_child,
    )


def verdict(folder: Path, process: subprocess.Popen[bytes], whole: bytes, failures: tuple[int, ...]) -> str:
    """``done``, ``kept``, or what was lost; leftovers of a process that was killed are removed and counted."""
    _, err = process.communicate(timeout=60)
    found = (folder / "out.png").read_bytes()
    left = [path for path in folder.iterdir() if path.name not in ("picture.png", "out.png")]
    for path in left:
        path.unlink()
    if left and process.returncode != -signal.SIGKILL:
        return f"LOST: left behind {left}"
    if found == whole and process.returncode in (0, -signal.SIGKILL):
        return "done"
    if found == OLD and process.returncode in failures:
        return "kept, and a temporary file" if left else "kept"
    same = {OLD: "old", whole: "new"}.get(found, "damaged")
    return f"LOST: code {process.returncode} with a {same} file: {err.decode()[-300:]}"


def undisturbed(folder: Path) -> tuple[bytes, float]:
    """The whole new file, and seconds that it takes."""
    begun = time.monotonic()
    process = start(folder)
    _, err = process.communicate()
    assert process.returncode == 0, err
    return (folder / "out.png").read_bytes(), time.monotonic() - begun


def signalled(folder: Path, number: signal.Signals, times: int, rng: np.random.Generator) -> Counter[str]:
    """A signal at random times, most of them near the end, when the file is written."""
    undisturbed(folder)
    whole, seconds = undisturbed(folder)
    verdicts: Counter[str] = Counter()
    for count in range(times):
        process = start(folder)
        time.sleep(seconds * (rng.uniform(0, 1.1) if count % 2 else rng.uniform(0.8, 1.05)))
        process.send_signal(number)
        verdicts[verdict(folder, process, whole, STOPPED[number])] += 1
    return verdicts


def limited(folder: Path, times: int) -> Counter[str]:
    """No room for the whole file, from none at all to all but a byte."""
    whole, _ = undisturbed(folder)
    verdicts: Counter[str] = Counter()
    for limit in np.linspace(0, len(whole) - 1, times).astype(int):
        verdicts[verdict(folder, start(folder, limit=int(limit)), whole, (4,))] += 1
    return verdicts


def small_disk(folder: Path, times: int) -> Counter[str]:
    """A disk that is full, if this user may make one."""
    disk = folder / "disk"
    disk.mkdir()
    whole, _ = undisturbed(folder)
    size = len(whole) // 2 + (folder / "picture.png").stat().st_size + 8192
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(disk)], capture_output=True
    )
    if made.returncode:
        disk.rmdir()
        return Counter({"not tried: no leave to mount": 1})
    verdicts: Counter[str] = Counter()
    try:
        (disk / "picture.png").write_bytes((folder / "picture.png").read_bytes())
        for _ in range(times):
            verdicts[verdict(disk, start(disk), whole, (4,))] += 1
    finally:
        subprocess.run(["umount", str(disk)], check=True)
        disk.rmdir()
    return verdicts


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--times", type=int, default=50, help="runs of each kind")
    times = parser.parse_args().times
    rng = np.random.default_rng(50)
    lost = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        prepare(folder)
        kinds = {
            "no room": lambda: limited(folder, times),
            "full disk": lambda: small_disk(folder, times),
        } | {number.name: lambda number=number: signalled(folder, number, times, rng) for number in STOPPED}
        for kind, run in kinds.items():
            verdicts = run()
            lost += sum(count for said, count in verdicts.items() if said.startswith("LOST"))
            print(f"{kind}: {', '.join(f'{count} {said}' for said, count in verdicts.items())}", flush=True)
    print(f"{lost} lost")
    return bool(lost)


if __name__ == "__main__":
    raise SystemExit(main())
