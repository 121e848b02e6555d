"""Elimination and over-relaxation on narrow parts of a region; see `solvers.narrow` for what it makes of them."""

import math

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.layout import BEYOND, FOUR
from solvers.native.prefetch import prefetch

u = np.uint64  # what arrays are indexed with, see solvers.kernels

WINDOW = 8  # equations at hand in `solve_in_window`
# What elimination leaves of a residual, by max|x|: each of the 8 that a row of A sums up to is rounded 3 WINDOW times.
ELIMINATED = 8 * 3 * WINDOW * 2.0**-53

# Over-relaxation.
CHUNK = 128  # slots, see `sweep_slots`: what some chunks of both colours hold stays in the second-level cache
TOGETHER = 4  # slots that are compared in one go
FIRST_OMEGA, FIRST_SWEEPS = 1.5, 7  # before anything is known of a part,
FIRST_GAIN = 0.04  # and what these make of |r|, about
MOST_SWEEPS = 16  # in one go,
LONGEST_RUN = 20_000_000  # or unknowns to sweep
LEFT = 3.0  # |r| before a sweep of Gauss and Seidel by what it leaves, at least
READY = 12  # getting a part ready takes as long as so many sweeps
SWEEPS = 90  # after so many, or if so many would be needed, a part is given up: multigrid is not slower then
# What rho is: 1 - 0.31 / max z in a stripe, 1 - 0.36 / max z in a square, 1 - 0.25 / max z at most.
STANDING_OUT = 0.31
FASTEST = 0.2  # what a sweep is expected to contract by, at best
# A stage makes |r| smaller by so much, or by this share of the softness: float32 is not good for more.
GAIN, BLIND = 1e-4, 2e-6
# Rounding: the share of b that x in float64 leaves, and the share of a stage's |r| that it gets and leaves in float32.
FLOOR, ROUNDED = 4e-16, 1e-6

AHEAD = 24  # unknowns: how far before its turn one is asked for

ABS_BITS = np.int64(0x7FFFFFFFFFFFFFFF)  # all but the sign of a float64
SHORT_ABS_BITS = np.int32(0x7FFFFFFF)  # and of a float32


@inlined
def bits_of(value):
    """The bit pattern of |value|: as integers these order like the values, with NaN on top."""
    return np.float64(value).view(np.int64) & ABS_BITS


@inlined
def short_bits_of(value):
    """The same of a float32."""
    return np.int32(np.float32(value).view(np.int32) & SHORT_ABS_BITS)


@inlined
def short_float_of(bits):
    """The value of a float32's bit pattern, in float64."""
    return np.float64(np.int32(bits).view(np.float32))


@inlined
def float_of(bits):
    """The value of a bit pattern."""
    return np.int64(bits).view(np.float64)


# --- sums and residuals -------------------------------------------------------------------------------------------
#
# The channels of an unknown, and behind them the solution z of A z = 1, lie side by side in lanes: four of them are one
# vector.  x begins with two unknowns more, BEYOND and KNOWN, which are zero, so that nothing need be asked when
# neighbours are added up.


@loops
def add_four(x, to, y, at, factor):
    """x[to ...] += factor * y[at ...]."""
    for lane in range(u(FOUR)):
        x[u(to) + lane] += factor * y[u(at) + lane]


@loops
def scale_four(x, to, y, at, factor):
    """x[to ...] = factor * y[at ...]."""
    for lane in range(u(FOUR)):
        x[u(to) + lane] = factor * y[u(at) + lane]


@inlined
def add_scaled(x, to, y, at, factor, n):
    """x[to ...] += factor * y[at ...], n of them, a multiple of four.  Piece by piece: LLVM would make masked stores of
    twelve values, and what is stored through a mask takes long to be read again.
    """
    for piece in range(0, n, FOUR):
        add_four(x, to + piece, y, at + piece, factor)


@inlined
def scale(x, to, y, at, factor, n):
    """x[to ...] = factor * y[at ...], n of them, a multiple of four."""
    for piece in range(0, n, FOUR):
        scale_four(x, to + piece, y, at + piece, factor)


@inlined
def neighbours(near, i):
    """How many neighbours of unknown i are inside the image."""
    north, west, east, south = near[u(i), 0], near[u(i), 1], near[u(i), 2], near[u(i), 3]
    inside = 4.0
    if min(min(north, west), min(east, south)) == BEYOND:  # hardly ever
        for side in (north, west, east, south):
            inside -= side == BEYOND
    return inside


@loops
def find_four_residuals(residual, largest, lanes, x, own, north, west, east, south, d, b, at):
    """residual = b - A x in four lanes from `lanes` on, in float64; largest: the bits of the largest one so far."""
    for lane in range(u(FOUR)):
        along = np.float64(x[north + lane]) + np.float64(x[south + lane])
        across = np.float64(x[west + lane]) + np.float64(x[east + lane])
        left = (np.float64(b[at + lane]) - d * np.float64(x[own + lane])) + (along + across)
        residual[u(lanes) + lane] = left
        bits = bits_of(left)
        largest[u(lanes) + lane] = bits if bits > largest[u(lanes) + lane] else largest[u(lanes) + lane]


@inlined
def residuals_of(residual, largest, x, b, near, i, lanes):
    """residual = b - A x in the lanes of unknown i; largest: the bits of the largest one so far."""
    at, own, d = lanes * i, lanes * (i + 2), neighbours(near, i)
    north, west = lanes * (np.int64(near[u(i), 0]) + 2), lanes * (np.int64(near[u(i), 1]) + 2)
    east, south = lanes * (np.int64(near[u(i), 2]) + 2), lanes * (np.int64(near[u(i), 3]) + 2)
    for k in range(0, lanes, FOUR):
        places = u(own + k), u(north + k), u(west + k), u(east + k), u(south + k)
        find_four_residuals(residual, largest, k, x, *places, d, b, u(at + k))


@inlined
def largest_channel(largest, channels):
    """The largest residual of a channel, from what `residuals_of` found in all lanes."""
    bits = np.int64(0)
    for c in range(channels):
        bits = max(bits, largest[u(c)])
    return float_of(bits)


# --- elimination in reading order --------------------------------------------------------------------------------


@jit
def reach_of(x, b, near, order, rank, start, n, lanes):
    """How far apart neighbours in a part are, in reading order, or WINDOW if no less; the part's n unknowns begin at
    `start` in `order`.
    """
    reach = np.int64(0)
    neighbours_, last = near.reshape(-1), order.shape[0] - 1
    for at in range(start, start + n):
        if reach >= WINDOW:
            break
        i = order[u(at)]
        # What the next parts need lies wherever their rows are.
        ahead = np.int64(order[u(min(at + AHEAD, last))])
        prefetch(neighbours_, 4 * ahead)
        prefetch(b, lanes * ahead)
        prefetch(x, lanes * (ahead + 2))
        north, west = near[u(i), 0], near[u(i), 1]
        if west >= 0:
            reach = max(reach, np.int64(1))
        if north >= 0:
            reach = max(reach, at - rank[u(north)])
    return reach


@inlined
def enter(window, b, near, order, rank, start, k, lanes):
    """Writes the equation of a part's unknown k into the window: what is known of it, and of earlier unknowns."""
    span, slot = WINDOW + lanes, k % WINDOW
    own, i = slot * span, np.int64(order[u(start + k)])
    for j in range(u(WINDOW)):
        window[u(own) + j] = 0.0
    window[u(own + slot)] = neighbours(near, i)
    for side in range(2):
        other = np.int64(near[u(i), side])
        if other >= 0:
            there = (rank[u(other)] - start) % WINDOW
            window[u(own + there)] = window[u(there * span + slot)] = -1.0
    scale(window, own + WINDOW, b, lanes * i, 1.0, lanes)


@inlined
def subtract_known(sums, at, row, k, last, span):
    """What the equation at `row` says of four lanes, at `at` in it, the unknowns k + 1 ... last being known by now."""
    one, two, three, four = sums[u(at)], sums[u(at + 1)], sums[u(at + 2)], sums[u(at + 3)]
    for other in range(k + 1, last + 1):
        weight, of = sums[u(row + other % WINDOW)], u(at + (other - k) * span)
        one -= weight * sums[of]
        two -= weight * sums[of + u(1)]
        three -= weight * sums[of + u(2)]
        four -= weight * sums[of + u(3)]
    sums[u(at)], sums[u(at + 1)], sums[u(at + 2)], sums[u(at + 3)] = one, two, three, four


@inlined
def solve_in_window(sums, window, b, near, order, rank, start, n, reach, lanes):
    """Solves A x = b on a part in which neighbours are at most `reach` < WINDOW apart, eliminating in reading order.

    Eliminating an unknown changes no equation but the next `reach`.  The window holds those: row and column of unknown
    k are its k mod WINDOW, and the lanes of b follow.  Row k of `sums` is what its equation was at its turn, by d_k; x
    takes the place of b there.
    """
    span = WINDOW + lanes
    entered = np.int64(0)
    for k in range(n):
        last = min(k + reach, n - 1)
        while entered <= last:
            enter(window, b, near, order, rank, start, entered, lanes)
            entered += 1
        slot = k % WINDOW
        own, row = slot * span, k * span
        inverse = 1.0 / window[u(own + slot)]
        scale(sums, row, window, own, inverse, span)
        for other in range(k + 1, last + 1):
            there = other % WINDOW * span
            weight = window[u(there + slot)]
            add_scaled(window, there, sums, row, -weight, span)
            window[u(there + slot)] = 0.0
    for back in range(n):
        k = n - 1 - back
        for lane in range(0, lanes, FOUR):
            subtract_known(sums, k * span + WINDOW + lane, k * span, k, min(k + reach, n - 1), span)


# --- over-relaxation ---------------------------------------------------------------------------------------------
#
# A part is coloured like a checkerboard, and its unknowns are put into *slots*: first the red ones in reading order,
# then the black ones.  Behind each colour lies a slot more, which is always zero and stands for all known pixels.  A
# half sweep goes through its own colour from one end to the other, and reads the other colour a few rows at a time.
#
# As in multigrid it is float32 that is swept, in stages: `solvers.refinement`.


@inlined
def put_into_slots(slot, members, colour, order, start, n):
    """The slots of a part's n unknowns, which begin at `start` in `order`; returns how many are red.

    slot: int32, of each unknown.  members: (n,) int32, the red unknowns, then the black ones.
    """
    red = n
    for k in range(start, start + n):
        red -= colour[u(order[u(k)])]
    reds, blacks = np.int64(0), red
    for k in range(start, start + n):
        i = order[u(k)]
        is_black = np.int64(colour[u(i)])
        at = blacks if is_black else reds
        members[u(at)] = i
        slot[u(i)] = at + is_black
        blacks += is_black
        reds += 1 - is_black
    return red


@inlined
def slot_beside(slot, near, i, side):
    """The slot of a neighbour of unknown i; -1 if that is none."""
    j = np.int64(near[u(i), side])
    at = np.int64(slot[u(max(j, np.int64(0)))])
    return at if j >= 0 else np.int64(-1)


@inlined
def linking(one, other, red, lanes):
    """Two of the slots of neighbours, as a link; that which is always zero in place of none."""
    first, second = np.int64(one if one >= 0 else red), np.int64(other if other >= 0 else red)
    return lanes * first | lanes * second << 32


@inlined
def join_slots(links, inverse, reach, near, slot, members, red, n, lanes):
    """What connects the slots of a part.

    links: (2 slots,) int64, where among all lanes those of the neighbours begin: north and west, east and south, two
    numbers of 32 bits in one, as a sweep waits for what it loads.  inverse: 1 / d.  reach: (2, chunks) int32, of each
    chunk of a colour the last slot of the other one that it reads; -1 if it reads none.

    Returns whether d is 4 everywhere, the part being away from the image's edge.
    """
    is_inside = True
    for is_black in range(2):
        first, end = (red, n) if is_black else (np.int64(0), red)
        last = np.int64(-1)
        for k in range(first, end):
            i, own = np.int64(members[u(k)]), k + is_black
            north, west = slot_beside(slot, near, i, 0), slot_beside(slot, near, i, 1)
            east, south = slot_beside(slot, near, i, 2), slot_beside(slot, near, i, 3)
            links[u(2 * own)] = linking(north, west, red, lanes)
            links[u(2 * own + 1)] = linking(east, south, red, lanes)
            last = max(last, max(max(north, west), max(east, south)))
            d = neighbours(near, i)
            inverse[u(own)] = 1.0 / d
            is_inside &= d == 4.0
            if (k + 1 - first) % CHUNK == 0 or k + 1 == end:
                reach[is_black, u((k - first) // CHUNK)] = last
                last = np.int64(-1)
    return is_inside


@inlined
def linked(links, k):
    """Where the lanes of a slot's neighbours begin."""
    one, other = links[u(2 * k)], links[u(2 * k + 1)]
    return one & 0xFFFFFFFF, one >> 32, other & 0xFFFFFFFF, other >> 32


@loops
def relax_four(x, r, at, one, two, three, four, inverse, omega):
    """Over-relaxation of four lanes; those of the neighbours begin at one ... four."""
    for lane in range(u(FOUR)):
        around = (x[one + lane] + x[four + lane]) + (x[two + lane] + x[three + lane])
        x[at + lane] += omega * (inverse * (around + r[at + lane]) - x[at + lane])


@inlined
def relax_slots(x, r, links, inverse, first, end, omega, lanes):
    """Over-relaxation of slots first ... end."""
    for k in range(first, end):
        one, two, three, four = linked(links, k)
        for p in range(0, lanes, FOUR):
            at = u(lanes * k + p)
            relax_four(x, r, at, u(one + p), u(two + p), u(three + p), u(four + p), inverse[u(k)], omega)


@loops
def look_at_four(found, to, x, r, at, one, two, three, four, inverse):
    """found = (r - A x) / d in four lanes."""
    for lane in range(u(FOUR)):
        around = (x[one + lane] + x[four + lane]) + (x[two + lane] + x[three + lane])
        found[to + lane] = inverse * (around + r[at + lane]) - x[at + lane]


@loops
def raise_to(largest, values, first, n):
    """largest[k] = the bits of the largest |values[first + k]| so far, n of them."""
    for k in range(u(n)):
        bits = short_bits_of(values[u(first) + k])
        largest[k] = bits if bits > largest[k] else largest[k]


@inlined
def look_at_slots(seen, found, x, r, links, inverse, first, end, lanes):
    """Raises `seen` to the bits of (r - A x) / d in slots first ... end.

    seen: (TOGETHER lanes,) int32.  found: as many float32, scratch.
    """
    for begin in range(first, end, TOGETHER):
        slots = min(TOGETHER, end - begin)
        for k in range(begin, begin + slots):
            one, two, three, four = linked(links, k)
            for p in range(0, lanes, FOUR):
                to, at = u(lanes * (k - begin) + p), u(lanes * k + p)
                look_at_four(
                    found, to, x, r, at, u(one + p), u(two + p), u(three + p), u(four + p), inverse[u(k)]
                )
        raise_to(seen, found, 0, lanes * slots)


@jit
def sweep_slots(x, r, links, inverse, reach, done, seen, found, red, n, lanes, omega, last, count, looks):
    """`count` sweeps over a part, in a wave: each half sweep goes on as far as the one before it has been where the
    neighbours are, a chunk at a time, and finds in the cache what that one left.  So do looks: none, or one at the red
    unknowns, or one at both.

    x, r: float32, the lanes of all slots.  done: (2 * count + 2,) int64, scratch: the chunks that a half sweep did.
    seen, found: of `look_at_slots`.  omega, last: float32; the latter is that of the last sweep.
    """
    halves = 2 * count + looks
    for half in range(halves):
        done[u(half)] = 0
    for k in range(TOGETHER * lanes):
        seen[u(k)] = 0
    while done[u(halves - 1)] * CHUNK < (red if halves & 1 else n - red):
        for half in range(halves):
            is_black = half & 1
            base, size = (red + 1, n - red) if is_black else (np.int64(0), red)
            base_before, size_before = (np.int64(0), red) if is_black else (red + 1, n - red)
            k = done[u(half)]
            if k * CHUNK >= size:
                continue
            if half > 0:
                seen_before = min(done[u(half - 1)] * CHUNK, size_before)
                if base_before + seen_before <= reach[is_black, u(k)]:
                    break
            done[u(half)] = k + 1
            first, end = base + k * CHUNK, base + min((k + 1) * CHUNK, size)
            factor = omega if half < 2 * count - 2 else last
            # Of known length the loop over lanes is gone.
            if half >= 2 * count:
                if lanes == FOUR:
                    look_at_slots(seen, found, x, r, links, inverse, first, end, FOUR)
                else:
                    look_at_slots(seen, found, x, r, links, inverse, first, end, lanes)
            elif lanes == FOUR:
                relax_slots(x, r, links, inverse, first, end, factor, FOUR)
            else:
                relax_slots(x, r, links, inverse, first, end, factor, lanes)


@inlined
def largest_of_lane(seen, lane, lanes):
    """The largest value of a lane."""
    bits = seen[u(lane)]
    for k in range(1, TOGETHER):
        other = seen[u(k * lanes + lane)]
        bits = other if other > bits else bits
    return short_float_of(bits)


@inlined
def largest_z(seen, x, n, lanes, channels):
    """The largest z of all slots; `seen` is scratch."""
    for k in range(TOGETHER * lanes):
        seen[u(k)] = 0
    for first in range(0, n + 2, TOGETHER):
        raise_to(seen, x, lanes * first, lanes * min(TOGETHER, n + 2 - first))
    return largest_of_lane(seen, channels, lanes)


@loops
def round_four(r, to, b, at):
    """r = b, rounded to float32, in four lanes."""
    for lane in range(u(FOUR)):
        r[to + lane] = np.float32(b[at + lane])


@loops
def raise_four(largest, lane, b, at):
    """largest: from `lane` on, the bits of the largest |b| so far, in four lanes."""
    for k in range(u(FOUR)):
        bits = bits_of(b[at + k])
        largest[u(lane) + k] = bits if bits > largest[u(lane) + k] else largest[u(lane) + k]


@loops
def take_four(total, to, x, at, more):
    """total = more * total + x, and x = 0, in four lanes."""
    for lane in range(u(FOUR)):
        total[to + lane] = (total[to + lane] if more else 0.0) + np.float64(x[at + lane])
        x[at + lane] = np.float32(0.0)


@inlined
def end_stage(total, x, members, red, n, lanes, stage):
    """What a stage found is added to the lanes of `total`, which begin with two unknowns more; x = 0."""
    for k in range(n):
        to, at = lanes * (np.int64(members[u(k)]) + 2), lanes * (k + (k >= red))
        for p in range(0, lanes, FOUR):
            take_four(total, u(to + p), x, u(at + p), stage > 0)


@inlined
def begin_stage(r, residual, largest, total, b, near, members, red, n, lanes, channels, stage):
    """r = b - A total, rounded to float32; total is zero in the first stage.  Returns the largest |r| of a channel."""
    for lane in range(lanes):
        largest[u(lane)] = 0
    for k in range(n):
        i, at = np.int64(members[u(k)]), lanes * (k + (k >= red))
        if stage > 0:
            residuals_of(residual, largest, total, b, near, i, lanes)
        for p in range(0, lanes, FOUR):
            if stage > 0:
                round_four(r, u(at + p), residual, u(p))
            else:
                round_four(r, u(at + p), b, u(lanes * i + p))
                raise_four(largest, p, b, u(lanes * i + p))
    return largest_channel(largest, channels)


# What is known of a part that is being relaxed: whether there is one, how many of its unknowns are red, the sweeps so
# far, the stage, omega, max|r| before the first stage, before this one, and by now, max z, a bound of A^-1 1, and
# whether the part is away from the image's edge.  The last one: how many there are.
BEGUN, REDS, SWEPT, STAGE, OMEGA, WHOLE, START, NOW, LARGEST_Z, SOFTNESS, INSIDE, KEPT = range(12)


@inlined
def sweeps_to(aim, worst, contraction):
    """How many sweeps make `worst` as small as `aim`; at least one, and no more than are of interest."""
    count = np.int64(1)
    worst *= contraction
    while worst > aim and count <= SWEEPS:
        worst *= contraction
        count += 1
    return count


@jit
def relax_part(
    state, x, r, links, inverse, reach, done, found, seen, residual, largest, total, b, near, members, n, lanes,
    channels, precision, budget,
):  # fmt: skip
    """Over-relaxation of a part until the error is at most `precision`, or `budget` is spent.

    All is known of the convergence that there is to know while it goes on, since A z = 1 is solved beside A x = b.  For
    a matrix like this, where |1 - A z| <= t < 1: A^-1 1 <= z / (1 - t), and max|b - A x| max A^-1 1 bounds the error.
    Jacobi's iteration contracts by rho <= 1 - 1 / (d max z) (Collatz 1942), by less where the largest z stands out from
    its surroundings, and rho gives the best omega (Young 1954).

    A stage ends where float32 should be at its end; what is left then is computed in float64.  The last one ends with a
    sweep of Gauss and Seidel, which leaves nothing at the black unknowns and less at the red ones than over-relaxation.
    The error is bounded by max|r| max A^-1 (1 if red, else 0) then.  Away from the image's edge that is hardly more
    than half of A^-1 1 <= s: for w = s / 2 + (1/8 if red, else 0), A w >= 1 at red unknowns and >= 0 at black ones.

    state[BEGUN] becomes 0 when the part is done; state[SWEPT] is -1 then if it was given up.  Returns what is left of
    the budget, and the bound.
    """
    red, most = np.int64(state[REDS]), 4.0  # neighbours
    while budget > 0:
        start, z, softness = state[START], state[LARGEST_Z], state[SOFTNESS]
        known = softness < np.inf
        softness_of_red = softness / 2.0 + 0.125 if state[INSIDE] else softness
        contraction = max(state[OMEGA] - 1.0, FASTEST)  # in the long run
        # How large |r| may be in the end, and at the end of this stage.
        enough = max(precision / (softness_of_red if known else z), FLOOR * state[WHOLE])
        aim = (max(GAIN, BLIND * z) if known or state[STAGE] == 0 else FIRST_GAIN) * start
        is_last = known and enough >= aim
        first = state[SWEPT] == 0
        count = (
            FIRST_SWEEPS if first else sweeps_to(LEFT * enough if is_last else aim, state[NOW], contraction)
        )
        if not first and state[SWEPT] + max(count, sweeps_to(enough, state[NOW], contraction)) > SWEEPS:
            state[BEGUN], state[SWEPT] = 0, -1
            return budget, np.inf
        now = max(min(count, MOST_SWEEPS, LONGEST_RUN // n), 2)
        is_end = now >= count and not first
        looks = is_last and is_end
        omega = np.float32(state[OMEGA])
        sweep_slots(
            x, r, links, inverse, reach, done, seen, found, red, n, lanes, omega,
            np.float32(1.0) if looks else omega, now, np.int64(looks),
        )  # fmt: skip
        state[SWEPT] += now
        budget -= n * (now + 1)
        if looks:
            state[NOW] = 0.0
            for c in range(channels):
                state[NOW] = max(state[NOW], most * largest_of_lane(seen, c, lanes))
            bound = state[NOW] * softness_of_red + ROUNDED * max(1.0, softness) * start * softness
            if bound <= max(precision, FLOOR * state[WHOLE] * softness):
                end_stage(total, x, members, red, n, lanes, state[STAGE])
                state[BEGUN] = 0
                return budget, bound
            continue
        for _ in range(now):
            state[NOW] *= contraction
        if first:
            state[NOW] = FIRST_GAIN * start
        if not known:
            found_z = largest_z(seen, x, n, lanes, channels)
            state[LARGEST_Z] = found_z if state[STAGE] == 0 else z + found_z
            rho = max(1.0 - STANDING_OUT / state[LARGEST_Z], 0.0)
            state[OMEGA] = 2.0 / (1.0 + math.sqrt(1.0 - rho * rho))
        if is_end:
            end_stage(total, x, members, red, n, lanes, state[STAGE])
            state[STAGE] += 1
            state[START] = state[NOW] = begin_stage(
                r, residual, largest, total, b, near, members, red, n, lanes, channels, state[STAGE]
            )
            missing = float_of(largest[u(channels)])
            if not known and missing < 1.0:
                state[SOFTNESS] = state[LARGEST_Z] / (1.0 - missing)
            budget -= READY * n
    return budget, np.inf


# --- all parts ----------------------------------------------------------------------------------------------------


@inlined
def eliminate_part(x, largest, sums, window, b, near, order, rank, start, n, reach, lanes, channels):
    """`solve_in_window`, and a bound of the error: elimination leaves a residual of so many roundings."""
    solve_in_window(sums, window, b, near, order, rank, start, n, reach, lanes)
    for lane in range(lanes):
        largest[u(lane)] = 0
    for k in range(n):
        to, at = lanes * (np.int64(order[u(start + k)]) + 2), k * (WINDOW + lanes) + WINDOW
        scale(x, to, sums, at, 1.0, lanes)
        for lane in range(0, lanes, FOUR):
            raise_four(largest, lane, sums, u(at + lane))
    return ELIMINATED * largest_channel(largest, channels) * float_of(largest[u(channels)])


@jit
def solve_parts(
    x, bounds, sweeps, state, swept, r, links, inverse, reach, done, found, seen, slot, members, residual, largest,
    sums, window, b, near, colour, order, rank, starts, channels, first, end, precision, budget,
):  # fmt: skip
    """Solves A x = b, and A z = 1 in the lane behind the channels, on the parts first ... end of the region.

    x: (2 + n, lanes) float64.  bounds: per part, of the error.  sweeps: per part, how many it took; -1 if it was given
    up.  state: (KEPT,) float64, of `relax_part`, 0 at first.  The arrays in between are scratch for the largest part,
    `slot` for all unknowns.  b: (n, lanes) float64.  near, colour, order, rank, starts: of `link` and `sort_parts`.
    precision: of x, absolute.  budget: how many unknowns to sweep, about.

    Returns the part to go on with.
    """
    lanes = b.shape[1]
    flat, rhs = x.reshape(-1), b.reshape(-1)
    for part in range(first, end):
        if budget <= 0:
            return part
        start = np.int64(starts[u(part)])
        n = np.int64(starts[u(part + 1)]) - start
        if n == 1:
            i = np.int64(order[u(start)])
            scale(flat, lanes * (i + 2), rhs, lanes * i, 1.0 / neighbours(near, i), lanes)
            sweeps[u(part)], bounds[u(part)] = 0, 0.0
            budget -= 1
            continue
        if not state[BEGUN]:
            reach_ = reach_of(flat, rhs, near, order, rank, start, n, lanes)
            if reach_ < WINDOW:
                if lanes == FOUR:  # of known length the loops over lanes are gone
                    bounds[u(part)] = eliminate_part(
                        flat, largest, sums, window, rhs, near, order, rank, start, n, reach_, FOUR, channels
                    )
                else:
                    bounds[u(part)] = eliminate_part(
                        flat, largest, sums, window, rhs, near, order, rank, start, n, reach_, lanes, channels
                    )
                sweeps[u(part)] = 0
                budget -= WINDOW * n
                continue
            red = put_into_slots(slot, members, colour, order, start, n)
            state[INSIDE] = join_slots(links, inverse, reach, near, slot, members, red, n, lanes)
            for k in range(u(lanes * (n + 2))):
                swept[k] = np.float32(0.0)
            most = begin_stage(r, residual, largest, flat, rhs, near, members, red, n, lanes, channels, 0)
            state[BEGUN], state[REDS], state[SWEPT], state[STAGE] = 1, red, 0, 0
            state[OMEGA], state[LARGEST_Z], state[SOFTNESS] = FIRST_OMEGA, 1.0, np.inf
            state[WHOLE] = state[START] = state[NOW] = most
            budget -= READY * n
        budget, bounds[u(part)] = relax_part(
            state, swept, r, links, inverse, reach, done, found, seen, residual, largest, flat, rhs, near, members, n,
            lanes, channels, precision, budget,
        )  # fmt: skip
        if state[BEGUN]:
            return part
        sweeps[u(part)] = np.int32(state[SWEPT])
    return end
