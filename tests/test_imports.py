"""Who may know whom: the rules of the house, held by reading the imports."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parent.parent
STANDARD = sys.stdlib_module_names


class Import(NamedTuple):
    module: str
    at_top: bool
    """False inside a function, or where only a type checker looks."""


def imports(path: Path) -> Iterator[Import]:
    """Every import of a file, by the module's full name."""

    def visit(node: ast.AST, at_top: bool) -> Iterator[Import]:
        if isinstance(node, ast.Import):
            for name in node.names:
                yield Import(name.name, at_top)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            assert node.module is not None
            yield Import(node.module, at_top)
            for name in node.names:  # a module of ours may be imported by name from its package
                yield Import(f"{node.module}.{name.name}", at_top)
        only_types = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)
        inside = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) or only_types
        for child in ast.iter_child_nodes(node):
            yield from visit(child, at_top and not inside)

    yield from visit(ast.parse(path.read_text(encoding="utf-8"), str(path)), True)


def within(module: str, *packages: str) -> bool:
    return any(module == package or module.startswith(f"{package}.") for package in packages)


def files(*places: str) -> list[Path]:
    found = [
        path
        for place in places
        for path in ([ROOT / place] if place.endswith(".py") else sorted((ROOT / place).rglob("*.py")))
    ]
    assert found
    return found


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def foreign(path: Path) -> list[Import]:
    return [one for one in imports(path) if one.module.partition(".")[0] not in STANDARD]


@pytest.mark.parametrize("path", files("solvers"), ids=name)
def test_solvers_know_numpy_numba_and_themselves(path):
    for one in foreign(path):
        # llvmlite comes with numba, and links what numba compiled where numba is not imported.
        linking = within(one.module, "llvmlite") and name(path).startswith("solvers/native/")
        assert within(one.module, "numpy", "numba", "solvers") or linking, one


@pytest.mark.parametrize("path", files("poisson_cli/editing"), ids=name)
def test_editing_knows_numpy_and_solvers(path):
    """And cv2, but only inside the function that needs it."""
    allowed = ("numpy", "solvers", "poisson_cli.editing", "poisson_cli.errors")
    for one in foreign(path):
        lazily = within(one.module, "cv2") and not one.at_top
        package = one.module == "poisson_cli"  # half of "from poisson_cli import errors"
        assert within(one.module, *allowed) or lazily or package, one


ALL = files("poisson_cli", "solvers")


@pytest.mark.parametrize("path", ALL, ids=name)
def test_only_images_knows_decoders(path):
    """The demo draws its sheets with PIL, which decodes nothing of the user's."""
    for one in foreign(path):
        if within(one.module, "imageio", "tifffile", "imagecodecs", "PIL", "skimage"):
            assert name(path).startswith(("poisson_cli/images/", "poisson_cli/demo/")), one
            assert not within(one.module, "imageio") or name(path).startswith("poisson_cli/images/"), one


@pytest.mark.parametrize("path", ALL, ids=name)
def test_only_the_command_line_knows_click(path):
    """And the lines of a batch, which say what a command line says."""
    command_line = (
        "poisson_cli/main.py",
        "poisson_cli/options.py",
        "poisson_cli/params.py",
        "poisson_cli/commands/",
        "poisson_cli/batch/reading.py",
        "poisson_cli/batch/grammar.py",
    )
    for one in foreign(path):
        if within(one.module, "click"):
            assert name(path).startswith(command_line), one


def closure(*modules: str) -> set[str]:
    """Everything that importing some modules imports at once: theirs and, among ours, their imports' imports."""
    seen: set[str] = set()
    left = list(modules)
    while left:
        module = left.pop()
        if module in seen:
            continue
        seen.add(module)
        base = ROOT.joinpath(*module.split("."))
        for path in (base.with_suffix(".py"), base / "__init__.py"):
            if path.exists():
                left += [one.module for one in imports(path) if one.at_top]
        left += [module.rpartition(".")[0]] if "." in module else []
    return seen


def test_nothing_heavy_is_imported_for_the_help():
    commands = [f"poisson_cli.commands.{path.stem}" for path in files("poisson_cli/commands")]
    reached = closure("poisson_cli", "poisson_cli.main", "poisson_cli.__main__", *commands)
    assert {"click", "poisson_cli.options", "poisson_cli.params"} <= reached
    ours_or_click = {module for module in reached if module.partition(".")[0] not in STANDARD}
    assert all(within(module, "click", "poisson_cli") for module in ours_or_click)
    assert not any(
        within(module, "poisson_cli.editing", "poisson_cli.images", "poisson_cli.demo") for module in reached
    )


def test_the_rules_can_be_broken(tmp_path):
    path = tmp_path / "bad.py"
    path.write_text(
        "import numpy.linalg\n"
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    import click\n"
        "def f():\n    from cv2 import dnn\n"
    )
    assert list(imports(path)) == [
        ("numpy.linalg", True),
        ("typing", True),
        ("typing.TYPE_CHECKING", True),
        ("click", False),
        ("cv2", False),
        ("cv2.dnn", False),
    ]
