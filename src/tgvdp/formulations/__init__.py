"""The optimisation models beside search, as tested parts; no quantum package is loaded here (docs/formulations.md).

`problem`: instances, motion, demand and replay; `qubo`: encodings, penalties, QUBO and Ising forms; `program`:
mixed-integer programs and their files; `circuit`: QAOA as plain data and its exact simulation. Imports flow from
`problem` to `qubo` and `program`, and from `qubo` to `circuit`. Start reading at `problem.instances`.
"""
