"""The referee: an independent judge of profiles.

Replays every row of a profile by its own integrator (`drive`), its own view of the line, looked up in the track
itself (`line`), and the force law that a row's mean effort implies (`law`); `replay` compares and returns a
`Verdict`.

Invariant: nothing that makes runs is used, no arc, no cells, no resolved line; only the model and the pointwise
forces and energies of `physics`. A test reads the imports. Start reading at `replay`.
"""
