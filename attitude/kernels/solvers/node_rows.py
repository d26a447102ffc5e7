"""Numbers at the nodes of a step, in a workspace of rows of so many numbers as the step has nodes."""

from ..intrinsics import inlined


def accessors(nodes):
    """Functions that read and write numbers of node i in successive rows, for steps of so many nodes.

    Returns two_at, three_at, four_at (work, row, i), tuples of numbers from a row on; and put_two, put_three,
    put_four (work, row, i, numbers), which write them.
    """

    @inlined
    def two_at(work, row, i):
        first = row * nodes + i
        return work[first], work[first + nodes]

    @inlined
    def three_at(work, row, i):
        first = row * nodes + i
        return work[first], work[first + nodes], work[first + 2 * nodes]

    @inlined
    def four_at(work, row, i):
        first = row * nodes + i
        return work[first], work[first + nodes], work[first + 2 * nodes], work[first + 3 * nodes]

    @inlined
    def put_two(work, row, i, numbers):
        first = row * nodes + i
        work[first], work[first + nodes] = numbers

    @inlined
    def put_three(work, row, i, numbers):
        first = row * nodes + i
        work[first], work[first + nodes], work[first + 2 * nodes] = numbers

    @inlined
    def put_four(work, row, i, numbers):
        first = row * nodes + i
        work[first], work[first + nodes], work[first + 2 * nodes], work[first + 3 * nodes] = numbers

    return two_at, three_at, four_at, put_two, put_three, put_four
