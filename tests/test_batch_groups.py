"""What containers and jobs of clusters may use, told by files as the kernel has them."""

import math
from pathlib import Path

import pytest

from poisson_cli.batch import groups, running

STAT = "anon 300\ninactive_file 80\nactive_file 20"
NO_LIMIT = 2**63  # of the first kind


@pytest.fixture
def root(tmp_path, monkeypatch):
    monkeypatch.setattr(groups, "_MEMBERSHIP", tmp_path / "self")
    monkeypatch.setattr(groups, "_ROOT", tmp_path / "fs")
    return tmp_path / "fs"


def belongs_to(root: Path, text: str) -> None:
    (root.parent / "self").write_text(text)


def group(folder: Path, **files: object) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, value in files.items():
        (folder / name.replace("_", ".", 1)).write_text(f"{value}\n")


def test_a_limit_may_be_that_of_a_group_around(root):
    """And what is kept of files makes way."""
    belongs_to(root, "0::/job_7/step_0/task_1\n")
    group(root, memory_stat=STAT)  # the outermost has no limit
    job = root / "job_7"
    group(job, memory_max=1000, memory_current=400, memory_stat=STAT, cpu_max="max 100000")
    step = job / "step_0"
    group(step, memory_max="max", memory_current=400, memory_stat=STAT, cpu_max="250000 100000")
    group(step / "task_1", memory_max="max", memory_current=400, memory_stat=STAT, cpu_max="max 100000")
    assert groups.memory() == 1000 - 400 + 100
    assert groups.cores() == 2.5
    group(step, memory_max=500)
    group(job, cpu_max="50000 100000")
    assert groups.memory() == 500 - 400 + 100
    assert groups.cores() == 0.5


def test_groups_of_the_first_kind(root):
    belongs_to(root, "11:cpu,cpuacct:/slurm\n9:memory:/slurm/job_7\n0::/other\n")
    stat = "inactive_file 1\ntotal_inactive_file 80\ntotal_active_file 20"
    slurm = root / "memory" / "slurm"
    for folder, limit in ((root / "memory", NO_LIMIT), (slurm, NO_LIMIT), (slurm / "job_7", 1000)):
        group(folder, memory_limit_in_bytes=limit, memory_usage_in_bytes=400, memory_stat=stat)
    group(root / "cpu", cpu_cfs_quota_us=-1, cpu_cfs_period_us=100_000)
    group(root / "cpu" / "slurm", cpu_cfs_quota_us=400_000, cpu_cfs_period_us=100_000)
    assert groups.memory() == 1000 - 400 + 100
    assert groups.cores() == 4


def test_a_container_that_does_not_see_its_name(root):
    belongs_to(root, "0::/../docker/abc\n")
    group(root, memory_max=1000, memory_current=400, memory_stat=STAT, cpu_max="100000 100000")
    assert groups.memory() == 1000 - 400 + 100
    assert groups.cores() == 1


def test_where_there_are_no_groups_there_are_no_limits(root):
    assert (groups.memory(), groups.cores()) == (math.inf, math.inf)
    belongs_to(root, "0::/somewhere\n")
    assert (groups.memory(), groups.cores()) == (math.inf, math.inf)


@pytest.mark.parametrize(("allowed", "expected"), [(0.5, 1), (2.0, 2), (2.5, 3), (math.inf, 8)])
def test_there_are_as_many_workers_as_a_container_may_use(monkeypatch, allowed, expected):
    monkeypatch.setattr("solvers.team.available_cores", lambda: 8)
    monkeypatch.setattr(groups, "cores", lambda: allowed)
    assert running.cores() == expected
