"""Telling LLVM which loops it may vectorise without looking.

A loop that writes one array and reads others can be vectorised only if what it writes is not read in a later iteration.
LLVM proves that when the loop runs: it compares the bounds of all the arrays, some sixty instructions for a loop over
four arrays, each time the loop is entered.  On a short run of pixels that takes as long as the loop itself; and beyond
eight comparisons LLVM gives up.  The author of a kernel knows that the arrays do not overlap.  numba has no way to say
so, LLVM's own language has: all accesses to memory in such a function are made members of a group, and its loops are
marked as having no dependence among that group.

Nothing depends on it but time: iterations compute the same values in any order.
"""

import re
from collections.abc import Iterable
from itertools import pairwise

_FUNCTION = re.compile(r"^define [^\n]*? @(\S+?)\([^\n]*\{\n(.*?)^\}", re.MULTILINE | re.DOTALL)
_LABEL = re.compile(r"^([\w.]+|\"[^\"]+\"):", re.MULTILINE)
_ALLOCA = re.compile(r"^  (%\S+|%\"[^\"]+\") = alloca", re.MULTILINE)
_ACCESS = re.compile(
    r"^  (?:%\S+ = load [^,\n]+|store [^\n]+?), ptr (%[\w.]+|%\"[^\"]+\")[^\n]*", re.MULTILINE
)
_JUMP = re.compile(r"^  br label %([\w.]+|\"[^\"]+\")$", re.MULTILINE)
_NUMBERED = re.compile(r"^!(\d+) =", re.MULTILINE)


def mangled(module: str, function: str) -> str:
    """How numba's name for a function goes, in part."""
    return "".join(f"{len(part)}{part}" for part in [*module.split("."), function]) + "B"


def mark(module: str, names: Iterable[str]) -> str:
    """The text of an LLVM module in which the loops of some functions are marked.

    Parameters
    ----------
    module : str
        As numba writes it, not optimised.
    names : iterable of str
        From `mangled`.
    """
    names = tuple(names)
    free = max((int(n) for n in _NUMBERED.findall(module)), default=-1) + 1
    group, independent = free, free + 1
    loops = 0

    def marked(function: re.Match[str]) -> str:
        nonlocal loops
        if not any(name in function[1] for name in names):
            return function[0]
        body = function[2]
        variables = set(_ALLOCA.findall(body))
        above: list[str] = []

        def access(line: re.Match[str]) -> str:
            return line[0] if line[1] in variables else f"{line[0]}, !llvm.access.group !{group}"

        def jump(line: re.Match[str]) -> str:
            nonlocal loops
            # Back to a block that stands above.  LLVM reads what the last jump of a loop says, and no other.
            if line[1] not in above:
                return line[0]
            loops += 1
            return f"{line[0]}, !llvm.loop !{independent + loops}"

        blocks = []
        for block in _blocks(body):
            label = _LABEL.match(block)
            above += [label[1]] if label else []
            blocks.append(_JUMP.sub(jump, _ACCESS.sub(access, block)))
        start = function[0].index("{\n") + 2
        return function[0][:start] + "".join(blocks) + "}"

    text = _FUNCTION.sub(marked, module)
    if not loops:
        return module
    metadata = [
        f"!{group} = distinct !{{}}",
        f'!{independent} = !{{!"llvm.loop.parallel_accesses", !{group}}}',
    ]
    metadata += [f"!{k} = distinct !{{!{k}, !{independent}}}" for k in range(free + 2, free + 2 + loops)]
    return text + "\n" + "\n".join(metadata) + "\n"


def _blocks(body: str) -> list[str]:
    """A function's basic blocks, each from its label on."""
    starts = [match.start() for match in _LABEL.finditer(body)]
    edges = sorted({0, *starts, len(body)})
    return [body[a:b] for a, b in pairwise(edges)]
