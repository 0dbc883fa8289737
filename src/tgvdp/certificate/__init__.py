"""Certificates: no run, of whatever kind, takes less energy in that time (docs/certificate.md).

For a multiplier and any costate the minimum of the Hamiltonian bounds E + λT from below (`hamiltonian`, `minimum`
over the pieces of `efforts`, summed by `cell_bounds` under a `speed_bound` that no run passes). Costates come from
a run: its `rows` and `cells`, their `regimes`, and the adjoint along them (`costates`, `regime_costates`,
`costates_at_bound`), are raised by `ascent` (in `steps` on a `chain`, along its `slopes`), and may be others in `bands`
of speeds, and grow with speed (`curved`): those are the best ones for `sampled` speeds, found by an `interior` point
method (`banded`). `line` is one such bound, `lines` says which are worth the time, `front` is the certificate of a
front.

Invariant: whatever the costate, the bound is valid; a poor one only loosens it. Start reading at `front`, then
`line`.
"""
