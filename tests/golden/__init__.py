"""Golden pictures: small edits whose right answer is stored beside them, made by the oracle and not by our code.

Each folder in `cases` is one case: ``destination.png``, ``mask.png``, ``source.png`` and ``edges.png`` where the tool
takes them, ``case.json`` with the tool and its arguments, and ``expected.png``.  `tests/test_golden.py` runs them all.

Add a case, from pictures of any size (keep it under 40 kB), or make its expected picture anew after its inputs or
arguments were edited::

    python -m tests.golden add NAME clone --destination D.png --source S.png --mask M.png --offset ROW COL
    python -m tests.golden add NAME recolor --destination D.png --mask M.png --space lab --set gain=[1.5,0.5,0.5]
    python -m tests.golden refresh [NAME ...]

``near_ties`` in ``case.json`` lists the values, as [row, column, channel], whose exact answer lies so near to a
half that a right answer may be rounded either way; the commands fill it in.  Every other value must be the same.
"""

from tests.golden.case import Case, Stored, all_cases

__all__ = ["Case", "Stored", "all_cases"]
