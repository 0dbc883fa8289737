"""Verification on the user's own machine, behind ``tgvdp selftest`` (docs/verification.md).

Each part holds what tgvdp computes against something that does not share its code: formulas (`closed_forms`), the order
in which errors fall (`convergence`), enumeration (`exhaustive`), other methods (`agreement`), the conservation of
energy (`balance`), optima by others where they are at hand (`references`), and its own referee and certificate on
random trips (`survey`). A `case.Case` counts the digits that agree; `report` runs all parts and writes them down.

An edge, like `cli`: it may use every room, and nothing but `cli` uses it.
"""
