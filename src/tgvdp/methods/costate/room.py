"""Arrays that the kernels of the front method write: a set for each thread, which stays from one search to the next."""

import threading

import numpy as np

from tgvdp.methods.costate import backward as costate
from tgvdp.methods.costate.interpolate import SAMPLES
from tgvdp.physics.cell import MOST_ROWS, Rows, room_for_marches, room_for_rows

#: Rows of one march for which there is room at first.
_MARCH_ROWS = 4096
#: Rows of runs that are driven side by side for which there is room at once: 16 MB.
_MOST_KEPT = 2**20


class Room:
    """What one thread writes.

    Attributes
    ----------
    rows : Rows
        Of the run that was driven last.
    kept : Rows
        Of several runs, one behind the other.
    march : Rows
        Of one march at a time.
    passed : (K + 1, 3) float64
        As of `interpolate.Scratch`, for at least as many cells as were asked for last.
    samples, resumed : (SAMPLES, 2) float64, (3,) float64
        As of `interpolate.Scratch`.
    costates : (6, size) float64
        Scratch for costates.
    """

    def __init__(self) -> None:
        self.rows = self.kept = Rows(*np.empty((2, 0)))
        self.march = room_for_marches(_MARCH_ROWS, "driving: march")
        self.passed = np.empty((0, 3))
        self.samples, self.resumed = np.empty((SAMPLES, 2)), np.array([-1.0, 0.0, 0.0])
        self.costates = np.empty((6, costate.ROOM))

    def fit(self, cells: int) -> None:
        """Make room for runs through so many cells, usual ones."""
        if len(self.passed) <= cells:
            self.passed = np.empty((cells + 1, 3))
            # More than are allowed are no more than a guess: most runs take a tenth of that.
            self.rows = room_for_rows(max(min(24 * cells + 8192, MOST_ROWS), len(self.rows.x)), "driving")

    def double_march(self) -> None:
        """Make room for marches of twice as many rows."""
        self.march = room_for_marches(2 * len(self.march.x), "driving: march")

    def double_rows(self) -> None:
        """Make room for a run of twice as many rows."""
        self.rows = room_for_rows(2 * len(self.rows.x), "driving")

    def fit_kept(self, count: int) -> None:
        """Make room for so many rows of runs, or as many as may be at once."""
        if len(self.kept.x) < min(count, _MOST_KEPT):
            self.kept = room_for_rows(min(count, _MOST_KEPT), "driving: kept")

    def double_kept(self) -> None:
        """Make room for twice as many rows of runs."""
        self.kept = room_for_rows(2 * len(self.kept.x), "driving: kept")


_threads = threading.local()


def room_for(cells: int) -> Room:
    """The room of this thread, for runs through so many cells: what is in it stands until it is asked for again."""
    room: Room | None = getattr(_threads, "room", None)
    if room is None:
        room = _threads.room = Room()
    room.fit(cells)
    return room
