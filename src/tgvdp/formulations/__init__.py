"""The optimisation models beside search, as tested parts; no quantum package is loaded here (docs/formulations.md).

`problem`: instances, motion, demand and replay; `qubo`: encodings, penalties, QUBO and Ising forms; `program`:
mixed-integer programs and their files; `circuit`: QAOA as plain data and its exact simulation. Start reading at
`problem.instances`.
"""
