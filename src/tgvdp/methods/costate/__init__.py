"""The front method: a costate dynamic program for a few multipliers, and runs between them (docs/front-method.md).

The multiplier λ, J/s, is the price of time. For each, the backward pass carries the costate over the mesh (`backward`,
`step`, `step_regions`, `characteristics`, `brake_jumps`, `polyline`); the forward pass drives the policy that it yields
(`forward`, `forward_cell`, `forward_brakes`, `forward_rows`). Noisy effort curves count by their `trend` in the
backward pass. What was solved and driven for one multiplier is an
extremal (`extremal`, on a `mesh` of `stations`, of which `doubt` asks whether its cells are short enough); runs between
two of them are blended (`blend`, `interpolate`), and `multipliers` chooses multipliers until the front is whole, by
what two extremals may hide (`surprises`) and by blends that do not do. Phases that are too short to drive are left out
of its runs (`drivable`).

Invariants: every run is feasible by construction; an error of the costate costs energy, never validity. Start
reading at `front`.
"""
