"""Phases long enough to drive: runs of the front method without those that no driver would drive (docs/phases.md).

A run is told from its rows as phases of one regime each (`regimes`), of which a speed that is held is one (`held`).
Short ones go where the phase before them comes to their end (`approach`), and are left out of the run's `plan`.
Where the plan differs from the run the train leaves it (`leave`) and comes back to it farther on (`track`), on the same
cells and under the same envelope (`way`). What stays short is driven longer at a partial effort (`widen`), and the run
gets its running time back (`retime`). `prune` does all that for whole runs.

Invariants: each new row keeps to the efforts and limits; E + λT never rises by more than it is allowed to; a run whose
running time cannot be kept stays as it is; each turn of a loop goes on by a row or uses up room. Start reading at
`prune`.
"""
