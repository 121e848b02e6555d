"""The same bits for any number of threads, on every shape, with every operation and every level shared out.

Large problems are cut into parts; here small ones are, so that borders between parts lie everywhere.
"""

import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import solvers.canvas
from poisson_cli.editing import clone, fill, mix
from solvers import Guidance, PoissonProblem, build_hierarchy, cycles, solve_multigrid, solve_sor, team
from solvers.layout import aligned_zeros, field_size
from solvers.memory import Arena
from solvers.team import Team
from tests.photographs import crop
from tests.regions import SHAPES

SIZES = ((90, 75), (33, 160))


@pytest.fixture
def tiny_parts(monkeypatch):
    """Call it to have the smallest things shared out from then on, in pieces of about so many values."""

    def tiny(piece: int = 300, between_bands: int = 1) -> None:
        monkeypatch.setattr(team, "WORTH_SHARING", 1)
        monkeypatch.setattr(team, "PIECE", piece)
        monkeypatch.setattr(cycles, "WORTH_SHARING", between_bands)

    return tiny


def problem_on(shape: str, size: tuple[int, int], scale: float = 1.0) -> PoissonProblem:
    """Equations of whole numbers times `scale`; float32 holds them exactly if that is 1."""
    whole = np.random.default_rng(7).integers(0, 256, (*size, 2))
    values = whole.astype(np.float32) if scale == 1 else whole * scale
    return PoissonProblem(SHAPES[shape](*size), values, Guidance.of(values[::-1].copy()))


# What lies between bands is handed out like the bands themselves, or done by one thread.
@pytest.mark.parametrize("between_bands", [1, 1500])
@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("cycle", cycles.CYCLES)
@pytest.mark.parametrize("shape", SHAPES)
def test_any_number_of_threads_gives_the_same_bits(shape, cycle, size, between_bands, tiny_parts):
    problem = problem_on(shape, size)
    alone = solve_multigrid(problem, cycle=cycle, threads=1, direct=False)
    tiny_parts(between_bands=between_bands)
    for threads in (2, 3, 5):
        shared = solve_multigrid(problem, cycle=cycle, threads=threads, direct=False)
        assert shared.solution.tobytes() == alone.solution.tobytes()
        assert shared.history == alone.history


@pytest.mark.parametrize("shape", ["disk", "noise", "spiral", "unknown_frame", "everything"])
@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_equations_that_float32_does_not_hold(shape, solve, tiny_parts):
    problem = problem_on(shape, (45, 38), 0.1)
    alone = solve(problem, tolerance=1e-6, threads=1, certify=True)
    tiny_parts()
    for threads in (2, 3, 5):
        shared = solve(problem, tolerance=1e-6, threads=threads, certify=True)
        assert shared.solution.tobytes() == alone.solution.tobytes()
        assert (shared.history, shared.error_bound) == (alone.history, alone.error_bound)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_single_thread_that_goes_step_by_step(shape, monkeypatch):
    """As it does where calls would be long."""
    problem = problem_on(shape, SIZES[0])
    at_once = solve_multigrid(problem, threads=1, direct=False)
    monkeypatch.setattr(team, "LONG_CALL", 100)
    steps = solve_multigrid(problem, threads=1, direct=False)
    assert steps.solution.tobytes() == at_once.solution.tobytes()
    assert steps.history == at_once.history


def test_large_levels_are_visited_in_calls_of_bounded_length_and_cycles_told_as_they_end(monkeypatch):
    monkeypatch.setattr(team, "LONG_CALL", 100_000)
    hierarchy = build_hierarchy(SHAPES["disk"](600, 600), Arena())
    x, b = (aligned_zeros(field_size(hierarchy.table, 2)) for _ in range(2))
    values = []  # of the finest level that a call changes, at most, with one of its operations
    with Team(1, 1) as team_:

        def run(operation, parts):
            for *_, segments, _table, steps, channels in parts:
                places = [0]
                for step in steps[steps[:, 1] == 0]:
                    ranges = [segments[a:e] for a, e in step[3:].reshape(-1, 2)]
                    places += [int((r[:, 1] - r[:, 0]).sum()) for r in ranges]
                values.append(4 * channels * max(places))
            return [operation(*part) for part in parts]

        monkeypatch.setattr(team_, "run", run)
        told = [len(values) for _ in cycles.Cycling(hierarchy, "F", 2, team_).run(x, b, 3)]
    assert 0 < told[0] < told[1] < told[2] == len(values)
    assert max(values) <= 1.5 * team.LONG_CALL


@pytest.mark.parametrize("shape", SHAPES)
def test_the_hierarchy_is_the_same(shape, tiny_parts):
    region = SHAPES[shape](*SIZES[0])
    region[0, 0] = False
    alone = build_hierarchy(region, Arena())
    tiny_parts(piece=50)
    for threads in (2, 5):
        with Team(threads, region.size) as team_:
            shared = build_hierarchy(region, Arena(), team_)
        for field in alone._fields:
            if field != "coarsest":
                assert np.array_equal(getattr(shared, field), getattr(alone, field)), field
        assert np.array_equal(shared.coarsest.band, alone.coarsest.band)


@pytest.mark.parametrize("tool", [clone, mix, fill])
@pytest.mark.parametrize("dtype", [np.uint8, np.float64])
@pytest.mark.parametrize("shape", ["lasso", "noise", "edge_touching", "everything"])
def test_pictures(tool, dtype, shape, tiny_parts, monkeypatch):
    scale = 1 if dtype is np.uint8 else 1 / 255
    pictures = [(crop(name, 47, 38) * scale).astype(dtype) for name in ("coffee.png", "chelsea.png")]
    mask = SHAPES[shape](47, 38)
    arguments = (pictures[0], mask) if tool is fill else (*pictures, mask)
    monkeypatch.setattr(solvers.canvas, "BAND", 1)
    monkeypatch.setattr(solvers.canvas, "FEWEST_ROWS", 2)
    alone = tool(*arguments, threads=1)
    tiny_parts()
    for threads in (2, 3, 5):
        shared = tool(*arguments, threads=threads)
        assert shared.image.tobytes() == alone.image.tobytes()
        assert shared.report.clipped == alone.report.clipped


# --- nothing is lost, and that would be seen ---------------------------------------------------------------------

LARGE = (300, 300)  # enough segments for several bands, and with a small tolerance there are several stages

# What a part returns that was not done.
SHARED = {
    "find_runs": 0,
    "weigh_region": None,
    "coarsen": None,
    "weigh": 0,
    "assemble": True,
    "run_steps": None,
    "move": None,
    "fold": None,
    "subtract": 0,
    "clear": None,
    "paint": None,
}


def name_of(operation) -> str:
    """As in SHARED: a kernel's name, or for what is done row by row the method in which it is written."""
    *_, outer, _, inner = ("", "", "", *operation.__qualname__.split("."))
    return outer if inner == "rows" else inner


@pytest.fixture
def losing(monkeypatch):
    """Call it with a name to have that operation's last part left undone; returns the number of parts, by name."""

    def lose(lost: str | None) -> dict[str, int]:
        parts_of: dict[str, int] = {}
        real = Team.run

        def run(self, operation, parts):
            name = name_of(operation)
            parts_of[name] = max(parts_of.get(name, 0), len(parts))
            if name == lost and len(parts) > 1:
                return [*real(self, operation, parts[:-1]), SHARED[name]]
            return real(self, operation, parts)

        monkeypatch.setattr(Team, "run", run)
        return parts_of

    return lose


def test_every_operation_is_shared_out(losing, tiny_parts):
    tiny_parts()
    parts_of = losing(None)
    solve_multigrid(problem_on("corner_touching", LARGE), tolerance=1e-6, threads=3)
    assert set(parts_of) == set(SHARED)
    assert all(parts >= 3 for parts in parts_of.values()), parts_of


@pytest.mark.parametrize("lost", SHARED)
def test_a_lost_part_is_seen(lost, losing, tiny_parts):
    """The tests above compare bits: here they are seen to differ where an operation leaves out a part."""
    problem = problem_on("corner_touching", LARGE)
    right = solve_multigrid(problem, tolerance=1e-6, threads=1)
    tiny_parts()
    losing(lost)
    with np.errstate(all="ignore"):
        wrong = solve_multigrid(problem, tolerance=1e-6, threads=3)
    same = wrong.solution.tobytes() == right.solution.tobytes()
    assert not same


# --- the team itself ---------------------------------------------------------------------------------------------


@given(
    st.lists(st.integers(0, 50), min_size=1, max_size=40), st.integers(1, 6), st.integers(1, 2000), st.data()
)
def test_pieces_are_the_whole_in_order(lengths, threads, values, data):
    starts = np.cumsum([0, *lengths[:-1]])
    stretches = np.stack([starts, starts + lengths, starts, starts], 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(team, "WORTH_SHARING", 1)
        patch.setattr(team, "PIECE", data.draw(st.integers(1, 500)))
        patch.setattr(team, "LONG_CALL", data.draw(st.integers(1, 500)))
        with Team(threads, 1) as team_:
            pieces = team_.pieces(stretches, 0, values)
            rows = team_.rows(len(lengths), values)
            bands = team_.bands(np.array(lengths), first=3)
    assert np.array_equal(np.concatenate(pieces), stretches)
    assert all(len(piece) for piece in pieces)
    assert [row for first, end in rows for row in range(first, end)] == list(range(len(lengths)))
    assert all(first % 2 == 0 and first < end for first, end in rows)
    assert [k - 3 for first, end in bands for k in range(first, end)] == list(range(len(lengths)))
    assert len(bands) <= threads


def test_pieces_are_about_as_long_as_they_should_be():
    lengths = np.full(1000, 10)
    stretches = np.stack([np.arange(1000), np.arange(1000) * 10, np.arange(1000) * 10 + lengths], 1)
    with Team(2, 1) as team_:
        pieces = team_.pieces(stretches, 1, 5 * team.PIECE)
        assert [len(piece) for piece in pieces] == pytest.approx([1000 / 6] * 6, abs=1)
        assert len(team_.pieces(stretches, 1, team.WORTH_SHARING - 1)) == 1
    with Team(1, 1) as team_:
        assert len(team_.pieces(stretches, 1, team.LONG_CALL)) == 1
        assert len(team_.pieces(stretches, 1, 3 * team.LONG_CALL)) == 3


@pytest.mark.parametrize("threads", [1, 2, 3, 7])
def test_results_come_in_the_order_of_the_parts(threads):
    with Team(threads, 1) as team_:
        assert team_.run(divmod, [(k, 3) for k in range(20)]) == [divmod(k, 3) for k in range(20)]
        assert team_.run(divmod, []) == []


def test_parts_really_run_side_by_side():
    meeting = threading.Barrier(3)
    with Team(3, 1) as team_:
        team_.run(meeting.wait, [(60,)] * 3)  # a BrokenBarrierError if fewer than three are there at a time


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_after_an_error_no_further_part_is_begun(threads, error):
    begun = []
    meeting = threading.Barrier(threads)

    def operation(k):
        begun.append(k)
        if k < threads:
            meeting.wait(60)
        if k == threads - 1:
            raise error
        time.sleep(0.01)  # so that 100 parts take far longer than it takes to hear of the error

    with Team(threads, 1) as team_, pytest.raises(error):
        team_.run(operation, [(k,) for k in range(100)])
    assert len(begun) < 50
