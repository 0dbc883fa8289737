"""The speed at which a dynamic brake cuts out as a train slows down: the least energy has a kink there, or nearly."""

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.forces import piece_effort, resistance_at

#: A dynamic brake that begins at a speed with so many times the resistance cuts out there: runs that coast through it
#: do not use it just above, as what it saves is a share of R/(R + D) of what a joule of it is worth.
_CUTS_OUT = 5.0
#: ... or, where it rises steeply, at the speed at which it comes to that, found in so many halvings: within this factor
#: of the speed at which it begins to rise, and with no more than this share of what it has at most.
_HALVINGS = 40
_STEEP = 1.3
_BY_THEN = 1.0 / 3.0
#: ... and below which it has no more than this share of that effort.
NOTHING = 0.01


@kernel
def cut_out_w(train):
    """Squared speed below which the dynamic brake gives next to nothing, and above which it gives much; 0 if none.

    Where it rises steeply from nothing, that is where it has so much that runs use it.
    """
    table = train.braking
    last = table.shape[0] - 1
    most = 0.0
    for i in range(last + 1):
        most = max(most, piece_effort(table, i, table[i, 0]))
    first = 0
    while first < last and piece_effort(table, first, table[first + 1, 0]) <= NOTHING * most >= piece_effort(
        table, first, table[first, 0]
    ):
        first += 1
    begins = table[first, 0]
    for i in range(first, last + 1):
        v = table[i, 0]
        if i < last and not _is_used(train, i, v) and _is_used(train, i, table[i + 1, 0]):
            v = _rises_to(train, i, v, table[i + 1, 0])
        if _is_used(train, i, v):
            is_steep = v <= _STEEP * begins and piece_effort(table, i, v) <= _BY_THEN * most
            return v * v if v == begins or is_steep else 0.0
    return 0.0


@leaf
def _is_used(train, i, v):
    """Whether the dynamic brake has, by the piece i of its curve, so much at a speed that it cuts out below."""
    return piece_effort(train.braking, i, v) > _CUTS_OUT * resistance_at(train, 0.0, v)


@part
def _rises_to(train, i, before, after):
    """Speed between two on the piece i from which on the dynamic brake has so much."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (before + after)
        if _is_used(train, i, middle):
            after = middle
        else:
            before = middle
    return after
