"""Unknowns one by one, where a region is sparse: found, linked to their neighbours; right-hand sides, and solution.

They are numbered in reading order; see `solvers.narrow` for what is made of them.
"""

import numpy as np

from solvers.kernels.policy import inlined, jit, loops
from solvers.layout import BEYOND, FOUR, KNOWN
from solvers.native.prefetch import prefetch

u = np.uint64  # what arrays are indexed with, see solvers.kernels

TILE = 32  # columns, see `survey`
AHEAD = 24  # unknowns: how far before its turn its pixels are asked for


# --- a first look -------------------------------------------------------------------------------------------------


@jit
def survey(region, first, end, step):
    """Unknowns in rows first ... end, and pixels of the tiles of 2 x TILE that hold some; `first` is even.

    Of the pairs of rows one in `step` is looked at.
    """
    width = region.shape[1]
    unknowns = pixels = np.int64(0)
    for row in range(first, end, 2 * step):
        upper, lower = region[row], region[min(row + 1, end - 1)]
        for low in range(0, width, TILE):
            a, b = upper[low : min(low + TILE, width)], lower[low : min(low + TILE, width)]
            count = np.int32(0)
            for i in range(a.shape[0]):
                count += np.int32(a[i]) + np.int32(b[i])
            if count > 0:
                pixels += a.shape[0] * min(2, end - row)
            unknowns += count
        if row + 1 == end:  # the last row was counted twice
            for i in range(width):
                unknowns -= upper[i]
    return unknowns, pixels


# --- parts -------------------------------------------------------------------------------------------------------


@jit
def locate(place, count, words, pixels, marked, first, end):
    """The places of unknowns among words first ... end of the region, behind `count` that are known already.

    words: the region's pixels in eights; the last word may lack some, and is none then.  pixels: (height * width,)
    bool.  marked: (any,) int64, scratch.  place: one longer than there are unknowns.  Returns how many are known now.
    """
    whole = min(end, words.shape[0])
    for low in range(first, whole, marked.shape[0]):
        hits = np.int64(0)
        for word in range(low, min(low + marked.shape[0], whole)):
            marked[u(hits)] = word  # if it is none, the next one comes here: a branch could not be foreseen
            hits += words[u(word)] != 0
        for k in range(hits):
            for i in range(8 * marked[u(k)], 8 * marked[u(k)] + 8):
                place[u(count)] = i
                count += pixels[u(i)]
    if end > whole:
        for i in range(8 * whole, pixels.shape[0]):
            place[u(count)] = i
            count += pixels[u(i)]
    return count


@inlined
def root_of(part, i):
    """The first unknown of those that are known to be in the part of unknown i; makes the way there shorter."""
    while part[u(i)] != i:
        part[u(i)] = part[u(part[u(i)])]
        i = np.int64(part[u(i)])
    return i


@inlined
def first_from(place, i, least):
    """The first unknown up to i whose place is `least` or more."""
    while i > 0 and place[u(i - 1)] >= least:
        i -= 1
    return np.int64(i)


@jit
def link(near, part, colour, last, place, height, width, first, end):
    """The neighbours of unknowns first ... end, which are numbered in reading order.

    near: (n, 4) int32, the numbers of the north, west, east and south neighbour, or KNOWN, or BEYOND.  part: (n,)
    int32, a lower number in the same part, or an unknown's own if there is none: what `number_parts` starts from.
    colour: (n,) int32, RED or BLACK, as on a chessboard.  last: (width,) int32, -1 at first, the last unknown of each
    column so far.  place: (n,) int64, row * width + column of the unknowns, ascending.

    Where a run of unknowns begins or ends cannot be foreseen: there is a choice of values here, but next to no branch.
    """
    row = place[first] // width
    next_row = (row + 1) * width
    of_row = first_from(place, first, row * width)  # the first unknown of this row,
    of_row_above = first_from(place, of_row, (row - 1) * width)  # and of the row above
    root = root_of(part, np.int64(first - 1)) if first > 0 else np.int64(0)  # of the unknown before
    for i in range(first, end):
        at = place[u(i)]
        while at >= next_row:
            row += 1
            next_row += width
            of_row_above, of_row = of_row, np.int64(i)
        col = at - (next_row - width)
        above, before = np.int64(last[u(col)]), max(i - 1, 0)
        has_north = above >= of_row_above
        has_west = (place[u(before)] == at - 1) & (col > 0)
        last[u(col)] = i
        colour[u(i)] = (row + col) & 1
        east, south = BEYOND if col == width - 1 else KNOWN, BEYOND if row == height - 1 else KNOWN
        near[u(i), 0] = above if has_north else BEYOND if row == 0 else KNOWN
        near[u(i), 1] = before if has_west else BEYOND if col == 0 else KNOWN
        near[u(i), 2], near[u(i), 3] = east, south
        near[u(before if has_west else i), 2] = i if has_west else east
        near[u(above if has_north else i), 3] = i if has_north else south
        root = root if has_west else np.int64(i)
        part[u(i)] = root
        if has_north and part[u(above)] != root:
            other = root_of(part, above)
            part[u(max(root, other))] = min(root, other)
            root = min(root, other)
            part[u(i)] = root


@jit
def number_parts(part, starts, pairs, near, count, first, end):
    """Numbers of the parts of unknowns first ... end, `count` parts having been found in those before.

    Parts are numbered in the order of their first unknowns.  part: of `link`; becomes the part's number.  starts: (n +
    1,) int32, the size of part k goes to starts[k + 1].  pairs: (n,) int32, the pairs of neighbours in each.
    """
    for i in range(first, end):
        ahead = np.int64(part[u(i)])
        k = count
        if ahead == i:
            starts[u(k + 1)], pairs[u(k)] = 0, 0
            count += 1
        else:
            k = np.int64(part[u(ahead)])  # a number already
        part[u(i)] = k
        starts[u(k + 1)] += 1
        for side in range(2):
            pairs[u(k)] += near[u(i), side] >= 0
    return count


@jit
def sort_parts(order, rank, ends, part, starts):
    """Unknowns part by part, in reading order within each.

    order: (n,) int32, their numbers.  rank: (n,) int32, where a number stands in it.  ends: (n_parts,) int32, scratch.
    starts: (n_parts + 1,) int32, of `number_parts`; becomes where each part begins, and where the last one ends.
    """
    starts[0] = 0
    for k in range(ends.shape[0]):
        ends[u(k)] = starts[u(k)]
        starts[u(k + 1)] += starts[u(k)]
    for i in range(part.shape[0]):
        k = part[u(i)]
        at = ends[u(k)]
        order[u(at)], rank[u(i)] = i, at
        ends[u(k)] = at + 1


# --- right-hand side and solution --------------------------------------------------------------------------------
#
# The channels of an unknown lie side by side in *lanes*, as many as make whole fours: four lanes are one vector.  There
# is at least one lane more, for A z = 1.


@loops
def sum_four_differences(sums, to, f, north, west, own, east, south):
    """The sum over the neighbours q of f_q - f_p in four lanes, in float64; the others say where each begins in f."""
    for lane in range(u(FOUR)):
        here = np.float64(f[own + lane])
        total = (np.float64(f[north + lane]) - here) + (np.float64(f[south + lane]) - here)
        sums[to + lane] = total + ((np.float64(f[west + lane]) - here) + (np.float64(f[east + lane]) - here))


@loops
def add_four_pairs(sums, to, across, west, east, down, north, south):
    """The sum over the neighbours q of v_pq in four lanes, added in float64; the others say where each pair begins."""
    for lane in range(u(FOUR)):
        total = (sums[to + lane] - np.float64(down[north + lane])) + np.float64(down[south + lane])
        sums[to + lane] = (total - np.float64(across[west + lane])) + np.float64(across[east + lane])


@jit
def sum_pairs(b, place, values, across, down, rhs, height, top, low, high):
    """b_p = rhs_p + sum over q of v_pq - (f_p - f_q), in float64, for the unknowns low ... high.

    b: (n, lanes) float64; behind the channels comes the 1 of A z = 1.  values: (rows, width, channels) f, known outside
    the region, first guess inside; row `top` of the image of this height comes first.  across, down: v on pixel pairs
    (`Guidance`); rhs: like values; arrays without rows stand for zeros.
    """
    width, channels = values.shape[1:]
    lanes, line = b.shape[1], width * channels
    f, v_across, v_down, more = values.reshape(-1), across.reshape(-1), down.reshape(-1), rhs.reshape(-1)
    sums = b.reshape(-1)
    guided, weighed = across.shape[0] + down.shape[0] > 0, rhs.shape[0] > 0
    # Three channels and one value more, which means nothing, are four lanes, as long as the arrays reach so far.
    both = across.shape[0] > 0 and down.shape[0] > 0
    as_four = channels == 3 and not weighed and (both or not guided)
    last, last_down, last_across = f.shape[0] - FOUR, v_down.shape[0] - FOUR, v_across.shape[0] - FOUR
    row, next_row = np.int64(top), (np.int64(top) + 1) * width
    for i in range(low, high):
        at = place[u(i)]
        while at >= next_row:
            row += 1
            next_row += width
        y, x = row - top, at - (next_row - width)
        to, own, pair = lanes * i, (y * width + x) * channels, (y * (width - 1) + x) * channels

        ahead = (place[u(min(i + AHEAD, high - 1))] - top * width) * channels
        prefetch(f, ahead)
        prefetch(f, ahead - line)
        prefetch(f, ahead + line)
        if guided:
            prefetch(v_down, ahead)
            prefetch(v_down, ahead - line)
            prefetch(v_across, ahead - y * channels)
        if weighed:
            prefetch(more, ahead)

        north, south, west, east = row > 0, row < height - 1, x > 0, x < width - 1
        if as_four and north and south and west and east and own + line <= last:
            if not guided or (own <= last_down and pair <= last_across):
                where = u(own - line), u(own - channels), u(own), u(own + channels), u(own + line)
                sum_four_differences(sums, u(to), f, *where)
                if guided:
                    beside, under = (u(pair - channels), u(pair)), (u(own - line), u(own))
                    add_four_pairs(sums, u(to), v_across, *beside, v_down, *under)
                sums[u(to + channels)] = 1.0
                continue
        # In place of a pixel beyond the edge stands the pixel itself.
        above, below, left, right = north * line, south * line, west * channels, east * channels
        for c in range(channels):
            o, p = own + c, pair + c
            here = np.float64(f[u(o)])
            total = (np.float64(f[u(o - above)]) - here) + (np.float64(f[u(o + below)]) - here)
            total += (np.float64(f[u(o - left)]) - here) + (np.float64(f[u(o + right)]) - here)
            if guided:
                if north:
                    total -= np.float64(v_down[u(o - line)])
                if south:
                    total += np.float64(v_down[u(o)])
                if west:
                    total -= np.float64(v_across[u(p - channels)])
                if east:
                    total += np.float64(v_across[u(p)])
            if weighed:
                total += np.float64(more[u(o)])
            sums[u(to + c)] = total
        for lane in range(channels, lanes):
            sums[u(to + lane)] = lane == channels


@inlined
def known_beside(ring, at, is_known, lanes):
    """Where the lanes begin of the rim's pixel at a place of the ring; 0, where zeros are, if that pixel is none."""
    which = np.int64(ring[u(at if is_known else 0)]) + 1
    return u(lanes * which if is_known else 0)


@loops
def sum_four(b, to, known, north, west, east, south):
    """b = the sum of known values beside an unknown, in four lanes."""
    for lane in range(u(FOUR)):
        b[to + lane] = np.float64(
            (known[north + lane] + known[south + lane]) + (known[west + lane] + known[east + lane])
        )


@inlined
def enter_known(known, values, lanes):
    """known = the values of the rim's pixels in lanes, behind zeros in the place of none."""
    channels = values.shape[1]
    flat = values.reshape(-1)
    for k in range(u(lanes)):
        known[k] = np.float32(0.0)
    for k in range(values.shape[0]):
        to, at = u(lanes * (1 + k)), u(channels * k)
        for c in range(u(channels)):
            known[to + c] = flat[at + c]
        for c in range(u(channels), u(lanes)):
            known[to + c] = np.float32(0.0)


@inlined
def sum_known(sums, ring, known, place, near, rows, cols, width, lanes, channels):
    """`sum_rim`, once the known values are there."""
    pixels = rows.shape[0]
    row, next_row = np.int64(-1), np.int64(0)
    above = here = below = np.int64(0)  # where the rows begin in the ring
    entered = np.int64(0)
    ring[0] = 0
    for i in range(place.shape[0]):
        at = place[u(i)]
        if at >= next_row:
            row = at // width
            next_row = (row + 1) * width
            above, here, below = (row + 2) % 3 * width, row % 3 * width, (row + 1) % 3 * width
            while entered < pixels and rows[u(entered)] <= row + 1:
                ring[u(rows[u(entered)] % 3 * width + cols[u(entered)])] = entered
                entered += 1
        col = at - (next_row - width)
        north = known_beside(ring, above + col, near[u(i), 0] == KNOWN, lanes)
        west = known_beside(ring, here + col - 1, near[u(i), 1] == KNOWN, lanes)
        east = known_beside(ring, here + col + 1, near[u(i), 2] == KNOWN, lanes)
        south = known_beside(ring, below + col, near[u(i), 3] == KNOWN, lanes)
        for p in range(u(0), u(lanes), u(FOUR)):
            sum_four(sums, u(lanes * i) + p, known, north + p, west + p, east + p, south + p)
        sums[u(lanes * i + channels)] = 1.0


@jit
def sum_rim(b, ring, known, place, near, values, rows, cols, width):
    """The same where the first guess and v are zero: b = the sum of the known values beside each unknown.

    ring: (3 * width,) int32, scratch: of the pixels in three rows, which of the rim's each is.  known: ((1 + m) lanes,)
    float32, scratch.  near: of `link`.  values: (m, channels) float32 of the known pixels in `rows` and `cols`, in
    reading order: all that have an unknown neighbour.  They are integers, or halves, below 2^18: float32 sums them up
    exactly.
    """
    lanes, channels = b.shape[1], values.shape[1]
    sums = b.reshape(-1)
    enter_known(known, values, lanes)
    if lanes == FOUR:  # of known length the loop over lanes is gone
        sum_known(sums, ring, known, place, near, rows, cols, width, FOUR, channels)
    else:
        sum_known(sums, ring, known, place, near, rows, cols, width, lanes, channels)


@jit
def add_at(guess, solution, place, low, high, top):
    """guess += solution at the unknowns low ... high.

    guess: (rows, width, channels), of which row `top` of the image comes first.  solution: (n, channels or more)
    float64.
    """
    width, channels = guess.shape[1:]
    flat, before = guess.reshape(-1), top * width
    for i in range(low, high):
        prefetch(flat, (place[u(min(i + AHEAD, high - 1))] - before) * channels)
        at = (place[u(i)] - before) * channels
        for c in range(channels):
            flat[u(at + c)] += solution[u(i), u(c)]
