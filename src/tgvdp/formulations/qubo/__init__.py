"""The binary model as a QUBO: encodings (`bits`, `unary`, made of `parts`), `penalties`, and the forms `qubo` and
`ising`.

`encodings` is the one door, `names` what it is asked for, `encoded` what it returns; `hobo` reduces the cubic
objective; `couplers` is the graph for drawing and embedding.
"""
