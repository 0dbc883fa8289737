"""Arrays that the kernels of the front method write: a set for each thread that works on a mesh."""

import numpy as np

from tgvdp.methods.costate import backward as costate
from tgvdp.methods.costate.interpolate import SAMPLES
from tgvdp.physics.cell import Rows, room_for_marches, room_for_rows

#: Rows of one march for which there is room at first.
_MARCH_ROWS = 4096
#: Rows of runs that are kept for which there is room at once: 16 MB, most of which nobody touches.
_MOST_KEPT = 2**20


class Room:
    """What one thread writes, whatever mesh of a trip it works on; of a mesh of so many cells at first.

    Attributes
    ----------
    rows : Rows
        Of the run that was driven last.
    kept : Rows
        Of runs that are kept, of which the first ``stored`` are taken.
    march : Rows
        Of one march at a time.
    samples, resumed : (SAMPLES, 2) float64, (3,) float64
        As of `interpolate.Scratch`.
    costates : (6, size) float64
        Scratch for costates.
    """

    def __init__(self, cells: int) -> None:
        self.rows = room_for_rows(24 * cells + 8192)
        self.kept, self.stored = Rows(*np.empty((2, 0))), 0
        self.march = room_for_marches(_MARCH_ROWS)
        self.samples, self.resumed = np.empty((SAMPLES, 2)), np.array([-1.0, 0.0, 0.0])
        self.costates = np.empty((6, costate.ROOM))

    def double_march(self) -> None:
        """Make room for marches of twice as many rows."""
        self.march = room_for_marches(2 * len(self.march.x))

    def double_rows(self) -> None:
        """Make room for a run of twice as many rows."""
        self.rows = room_for_rows(2 * len(self.rows.x))

    def keep(self, count: int, anew: bool = False) -> None:
        """Make room for runs that are kept: for so many more rows, or as many as may be at once."""
        count = count if anew else min(count, _MOST_KEPT)
        if anew or len(self.kept.x) - self.stored < count:
            self.kept, self.stored = room_for_rows(count), 0


class Rooms:
    """The rooms of a trip, by number; each is made when it is first asked for."""

    def __init__(self, cells: int) -> None:
        self._cells = cells
        self._rooms: list[Room] = []

    def __getitem__(self, number: int) -> Room:
        while len(self._rooms) <= number:
            self._rooms.append(Room(self._cells))
        return self._rooms[number]
