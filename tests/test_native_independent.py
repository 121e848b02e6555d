"""Loops that are marked as independent in the text of an LLVM module."""

import re

import numba
import pytest

from solvers.native import building, independent
from tests import tiny_kernels

MODULE = "tests.tiny_kernels"


@pytest.fixture(scope="module")
def text():
    """What numba makes of `smooth`, whose only loop stands in `add_neighbours`."""
    kernel = tiny_kernels.smooth
    with numba.core.compiler_lock.global_compiler_lock, building._optimised_later():
        function = building._twin(MODULE).smooth
        entry = building._entry(function, kernel.signatures[0])
        return numba.cfunc(building._c_signature(kernel.signatures[0]))(entry).inspect_llvm()


def accesses(text: str) -> list[str]:
    return re.findall(r"^.*!llvm\.access\.group.*$", text, re.MULTILINE)


def test_elements_are_marked_and_variables_are_not(text):
    marked = independent.mark(text, [independent.mangled(MODULE, "add_neighbours")])
    assert re.search(r"^  br .*!llvm\.loop", marked, re.MULTILINE)
    name = independent.mangled(MODULE, "add_neighbours")
    (function,) = re.findall(rf"^define [^\n]*{name}.*?^}}", marked, re.MULTILINE | re.DOTALL)
    assert len(accesses(function)) == len(accesses(marked))
    variables = set(re.findall(r"^  (%\S+) = alloca", function, re.MULTILINE))
    pointers = {re.search(r", ptr (%[^,\s]+)", line)[1] for line in accesses(function)}
    assert len(pointers) >= 4  # out, weights and two neighbours
    assert not pointers & variables
    building.llvm.parse_assembly(marked).verify()


@pytest.mark.parametrize("names", [[], [independent.mangled("elsewhere", "add_neighbours")]])
def test_other_functions_stay_as_they_are(text, names):
    assert independent.mark(text, names) == text


def test_a_marked_loop_has_no_overlap_tests(text):
    """They would decide between the vectorised loop and a scalar copy of it."""

    def divided(module: str) -> int:
        whole = building.llvm.parse_assembly(
            building._REFERENCE_COUNTING.sub("", module).replace("noinline", "nounwind")
        )
        visible = next(f.name for f in whole.functions if f.name.startswith("cfunc"))
        building._optimise(whole, visible)
        assert "x float>" in str(whole)  # vectorised it is in any case
        return str(whole).count("memcheck")

    assert divided(text) > 0
    assert divided(independent.mark(text, [independent.mangled(MODULE, "add_neighbours")])) == 0


def test_only_functions_that_say_so_are_named():
    assert building._independent(MODULE) == (independent.mangled(MODULE, "add_neighbours"),)
