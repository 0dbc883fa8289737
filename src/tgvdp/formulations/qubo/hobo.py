"""The efficiency objective as it was meant, cubic in the bits, and its reduction to degree two.

The binary formulation replaces the mean speed of a step by s_i and drops the bit x_i, which makes the objective
quadratic, and constant but for −Δη·Σs² once distance and end speed are fixed. Meant was energy drawn in steps of
traction alone: Σ x_i·a·v_avg,i·(η0 − Δη·s_i) with v_avg,i = v_i + a/2 and s_i = v_{i+1} = v_i + a, of degree three.
"""

from collections import Counter
from fractions import Fraction
from itertools import combinations
from typing import TypeAlias

from tgvdp.formulations.problem.instances import BinaryInstance, decimal
from tgvdp.formulations.qubo.parts import Builder

#: Coefficient of each product of different bits; the empty product is the constant.
Polynomial: TypeAlias = dict[frozenset[int], Fraction]


def cubic_efficiency(instance: BinaryInstance, x: list[int], y: list[int]) -> Polynomial:
    """The intended objective over the bits x and y, in (m/s)²: exact where no step both accelerates and brakes."""
    a = instance.acc_units
    eta0, deta = decimal(instance.eta0), decimal(instance.deta)
    total: Polynomial = {}
    for i, accelerate in enumerate(x):
        v: Polynomial = {frozenset((bit,)): Fraction(a) for bit in x[:i]}
        v |= {frozenset((bit,)): Fraction(-instance.dec_units) for bit in y[:i]}
        mean = _sum(v, {frozenset(): Fraction(a, 2)})
        factor = _sum({frozenset(): eta0 - deta * a}, {key: -deta * value for key, value in v.items()})
        traction: Polynomial = {frozenset((accelerate,)): Fraction(a) * decimal(instance.dv_mps) ** 2}
        total = _sum(total, _product(traction, _product(mean, factor)))
    return total


def _sum(one: Polynomial, other: Polynomial) -> Polynomial:
    result = dict(one)
    for key, value in other.items():
        result[key] = result.get(key, Fraction(0)) + value
    return result


def _product(one: Polynomial, other: Polynomial) -> Polynomial:
    result: Polynomial = {}
    for key, value in one.items():
        for other_key, other_value in other.items():
            result[key | other_key] = result.get(key | other_key, Fraction(0)) + value * other_value
    return result


def add_reduced(parts: Builder, polynomial: Polynomial) -> None:
    """Add a polynomial of degree three to the objective, with a bit for each product of two bits that it needs.

    A product p·q becomes the bit w with the term M·(p·q − 2p·w − 2q·w + 3w) of Rosenberg (1975), which is 0 where
    w = p·q and at least M elsewhere. M exceeds what the terms with w can gain, so that the least value over all w is
    the polynomial, for every string of the other bits.
    """
    cubic = {key: value for key, value in polynomial.items() if len(key) == 3 and value}
    for key, value in polynomial.items():
        if len(key) < 3:
            _add_quadratic(parts, key, value)
    while cubic:
        counts = Counter(pair for key in cubic for pair in combinations(sorted(key), 2))
        (p, q), _ = min(counts.items(), key=lambda item: (-item[1], item[0]))
        w = parts.add_variable(f"w{p}_{q}")
        replaced = {key: value for key, value in cubic.items() if {p, q} <= key}
        for key, value in replaced.items():
            del cubic[key]
            _add_quadratic(parts, (key - {p, q}) | {w}, value)
        m = sum(map(abs, replaced.values()), Fraction(0))
        for pair, weight in (((p, q), 1), ((p, w), -2), ((q, w), -2), ((w,), 3)):
            _add_quadratic(parts, frozenset(pair), m * weight)


def _add_quadratic(parts: Builder, key: frozenset[int], value: Fraction) -> None:
    if not key:
        parts.objective.add_constant(float(value))
    else:
        parts.objective.add_quadratic(min(key), max(key), float(value))
