"""What pyproject.toml promises."""

import re
import tomllib
from pathlib import Path

import pytest

import poisson_cli

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def requirements(*extras: str) -> set[str]:
    project = PROJECT["project"]
    lists = [project["dependencies"], *(project["optional-dependencies"][extra] for extra in extras)]
    return {re.split(r"[^\w-]", line)[0] for one in lists for line in one}


def test_every_package_is_listed():
    """Packages are listed by hand, so that a new folder cannot be forgotten, nor the tests be installed."""
    found = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for top in ("poisson_cli", "solvers")
        for path in (ROOT / top).rglob("__init__.py")
    }
    assert set(PROJECT["tool"]["setuptools"]["packages"]) == found


def test_types_are_published():
    for package, files in PROJECT["tool"]["setuptools"]["package-data"].items():
        assert all((ROOT / package / file).exists() for file in files)
    assert PROJECT["tool"]["setuptools"]["package-data"].keys() == {"poisson_cli", "solvers"}


def test_core_dependencies_are_few():
    assert requirements() == {"numpy", "numba", "imageio", "pillow", "click"}


@pytest.mark.parametrize("line", PROJECT["project"]["dependencies"])
def test_dependencies_have_a_lower_bound_only(line):
    assert re.fullmatch(r"[\w-]+>=[\d.]+", line)


def test_every_third_party_import_of_the_tests_is_in_the_test_extra():
    from tests.test_imports import STANDARD, imports

    ours = {"poisson_cli", "solvers", "tests", "benchmarks", "tools"}
    import_names = {"skimage": "scikit-image", "PIL": "pillow", "cv2": "opencv-python-headless"}
    needed = {
        import_names.get(top, top)
        for path in (ROOT / "tests").rglob("*.py")
        for top in {one.module.partition(".")[0] for one in imports(path)}
        if top not in STANDARD | ours
    }
    assert needed <= requirements("test")


def test_the_changelog_knows_this_version():
    assert re.search(
        rf"^## {re.escape(poisson_cli.__version__)}\b",
        (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
