"""Search of an explicit graph: stations × speeds, joined by arcs of constant acceleration (docs/grid-search.md).

The grid (`points`, `arcs`, `grid`) is a `layered` graph of two costs; `exact` returns all Pareto-optimal paths of
it by labels that are merged station by station (`exact_kernel`) and pruned by bounds (`exact_bounds`,
`exact_ceiling`); `best_first` is the search by a priority queue (`best_first_kernel`), whose `node` people can
read. `to_go` holds the bounds of both, `paths` what they return, `networkx_view` the same graph for drawing and for
a second opinion.

Invariants: sums of costs are bitwise the same in both searches; a label is dropped only where another is as good in
both costs. Start reading at `grid`, then `exact`.
"""
