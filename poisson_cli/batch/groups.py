"""What a container, or a job of a cluster, may use (Linux, control groups of both kinds)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Final

__all__ = ["cores", "memory"]

_MEMBERSHIP: Final = Path("/proc/self/cgroup")
"""The file that tells the groups of this process."""

_ROOT: Final = Path("/sys/fs/cgroup")
"""Where they are mounted."""


def memory() -> float:
    """Bytes that may still be taken; inf if there is no limit."""
    return min((_room(group) for group in _groups("memory")), default=math.inf)


def cores() -> float:
    """How many cores' time may be used, whatever the number of cores; inf if there is no limit."""
    return min((_share(group) for group in _groups("cpu")), default=math.inf)


def _groups(controller: str) -> Iterator[Path]:
    """The group of this process and those around it: a limit of any of them holds for all below."""
    try:
        lines = [line.split(":", 2) for line in _MEMBERSHIP.read_text().splitlines()]
    except OSError:
        return
    for _, controllers, name in lines:
        if controllers and controller not in controllers.split(","):
            continue
        top = _ROOT / controller if controllers else _ROOT
        group = top / name.lstrip("/")
        if (
            not group.is_dir()
        ):  # seen from inside a container it lies at the top, whatever it is called outside
            group = top
        for folder in (group, *group.parents):
            yield folder
            if folder == top:
                break


def _room(group: Path) -> float:
    """Bytes that one group may still take."""
    for limit, used in (
        ("memory.max", "memory.current"),
        ("memory.limit_in_bytes", "memory.usage_in_bytes"),  # of the first kind
    ):
        try:
            most = float((group / limit).read_text().strip().replace("max", "inf"))
            now = float((group / used).read_text())
            kept = dict(line.split() for line in (group / "memory.stat").read_text().splitlines())
        except (OSError, ValueError):
            continue
        # What is kept of files, only because there is room for it, counts as used, but makes way.
        files = sum(
            float(kept.get(f"total_{name}", kept.get(name, 0))) for name in ("inactive_file", "active_file")
        )
        return max(0.0, most - now + min(files, now))
    return math.inf


def _share(group: Path) -> float:
    """How many cores' time one group may use."""
    try:
        if (group / "cpu.max").exists():
            time, period = (group / "cpu.max").read_text().split()
        else:
            time, period = ((group / f"cpu.cfs_{name}_us").read_text() for name in ("quota", "period"))
        return math.inf if time == "max" or float(time) < 0 else float(time) / float(period)
    except (OSError, ValueError, ZeroDivisionError):
        return math.inf
