"""Sweeps: thousands of searches or journeys on one machine or a cluster, behind `tgvdp.sweep` and ``tgvdp sweep``.

Data flows ``spec → scenario → batches → engine → journal, parts → tables``: a `spec` is a sequence of scenarios, each
known by its key; `batches` groups what is still to be done by measured cost; `engine` has Dask's workers solve them
(`work` is what runs there) and finds the scenario that kills its worker; `journal` and `parts` keep each result as soon
as it is there; `tables` makes the data set of them, in the order of the spec. `run` drives all of it, `iterate` is the
same without files, `summary` reads a finished data set.

Invariants: a result is in the journal only after its rows are safe on disk, so that whatever is killed, nothing is lost
and nothing is there twice; rows depend on the scenario alone, not on workers or order. Start reading at `run`.
"""
