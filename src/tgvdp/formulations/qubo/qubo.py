"""Quadratic unconstrained binary optimisation: minimise c + Σ aᵢ·xᵢ + Σ_{i<j} qᵢⱼ·xᵢ·xⱼ over bits x.

The constant is there for penalties, which need one. A `Qubo` is a value: arrays, nothing else, and no quantum package.
A `QuboBuilder` collects its terms, among them the squared constraints that make penalties. Coefficients that are
integers stay exact, so that energies compare with ==.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError

#: Terms that a builder holds before it adds up those of equal pairs: bounds its memory at about 100 MB.
_PENDING_TERMS = 4_000_000

#: Most variables of which `Qubo.all_energies` makes the whole list: 2²⁶ doubles are half a gigabyte.
MAX_ENUMERATED = 26

#: Rows that `Qubo.energy` multiplies at once.
_ENERGY_ROWS = 1 << 14


class QuboStats(NamedTuple):
    """Size of a QUBO.

    Attributes
    ----------
    variables, couplers : int
        Bits, and pairs of them with a coefficient other than zero.
    coefficient_range : (float, float)
        Smallest and largest magnitude of the coefficients other than zero, without the offset; (0, 0) where all vanish.
        Their ratio is the precision that an analogue machine needs.
    """

    variables: int
    couplers: int
    coefficient_range: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Qubo:
    """A quadratic function of bits.

    Attributes
    ----------
    linear : (n,) float64
        Coefficient of each bit. Arrays are read-only copies.
    rows, cols : (m,) int32
        Pairs of bits, rows < cols, each pair once.
    values : (m,) float64
        Coefficient of each pair.
    offset : float
        The constant.
    labels : tuple of str
        Names of the bits, all different.

    Raises
    ------
    InputError
        When shapes disagree, a pair is out of order, out of range or given twice, or a number is not finite.
    """

    linear: NDArray[np.float64]
    rows: NDArray[np.int32]
    cols: NDArray[np.int32]
    values: NDArray[np.float64]
    offset: float
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        for name, kind in (("linear", np.float64), ("rows", np.int32), ("cols", np.int32), ("values", np.float64)):
            array = np.array(getattr(self, name), dtype=kind)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(self, "offset", float(self.offset))
        object.__setattr__(self, "labels", tuple(self.labels))
        self._check()

    def _check(self) -> None:
        n = len(self.labels)
        if self.linear.shape != (n,) or len(set(self.labels)) != n:
            raise InputError(f"qubo: {n} labels, all different, must name {self.linear.size} linear coefficients")
        if not self.rows.shape == self.cols.shape == self.values.shape or self.rows.ndim != 1:
            raise InputError("qubo: rows, cols and values must be vectors of one length")
        if self.rows.size:
            if self.rows.min() < 0 or self.cols.max() >= n or np.any(self.rows >= self.cols):
                raise InputError(f"qubo: pairs must have 0 ≤ row < col < {n}")
            key = self.rows.astype(np.int64) * n + self.cols
            if np.unique(key).size != key.size:
                raise InputError("qubo: a pair is given twice")
        finite = np.isfinite(self.linear).all() and np.isfinite(self.values).all() and np.isfinite(self.offset)
        if not finite:
            raise InputError("qubo: coefficients must be finite")

    @property
    def n(self) -> int:
        """Number of bits."""
        return len(self.labels)

    @property
    def stats(self) -> QuboStats:
        """Size of the problem."""
        magnitude = np.abs(np.concatenate((self.linear, self.values)))
        magnitude = magnitude[magnitude > 0.0]
        span = (float(magnitude.min()), float(magnitude.max())) if magnitude.size else (0.0, 0.0)
        return QuboStats(self.n, int(np.count_nonzero(self.values)), span)

    def upper(self) -> NDArray[np.float64]:
        """Matrix U, (n, n) float64 and upper triangular, with energy = offset + xᵀ·U·x; the diagonal is `linear`."""
        matrix = np.diag(self.linear)
        matrix[self.rows, self.cols] = self.values
        return matrix

    def energy(self, bits: ArrayLike) -> NDArray[np.float64]:
        """Evaluate bit strings.

        Parameters
        ----------
        bits : (..., n) of 0 and 1

        Returns
        -------
        (...) float64

        Raises
        ------
        InputError
            When the last axis has not n entries, or an entry is neither 0 nor 1.
        """
        x = np.asarray(bits)
        if x.ndim == 0 or x.shape[-1] != self.n:
            raise InputError(f"qubo: bit strings must have {self.n} entries, got shape {x.shape}")
        if not np.all((x == 0) | (x == 1)):
            raise InputError("qubo: bits must be 0 or 1")
        flat = x.reshape(math.prod(x.shape[:-1]), self.n)
        result = np.empty(len(flat))
        upper = self.upper()
        for start in range(0, len(flat), _ENERGY_ROWS):
            block = flat[start : start + _ENERGY_ROWS].astype(np.float64)
            result[start : start + _ENERGY_ROWS] = np.einsum("ki,ki->k", block @ upper, block)
        return (result + self.offset).reshape(x.shape[:-1])

    def all_energies(self) -> NDArray[np.float64]:
        """Evaluate all 2ⁿ bit strings with 2ⁿ⁺¹ additions.

        Returns
        -------
        (2**n,) float64
            Entry z belongs to the bits xᵢ = (z >> i) & 1: the first bit is the lowest, as in registers of qubits.

        Raises
        ------
        InputError
            When n is above `MAX_ENUMERATED`.
        """
        if self.n > MAX_ENUMERATED:
            raise InputError(f"qubo: {self.n} bits are too many to enumerate (at most {MAX_ENUMERATED})")
        energy = np.empty(1 << self.n)
        energy[0] = self.offset
        upper = self.upper()
        for bit in range(self.n):
            half = 1 << bit
            step = _doubled(upper[:bit, bit], self.linear[bit])  # what setting this bit adds to each string below it
            np.add(energy[:half], step, out=energy[half : 2 * half])
        return energy


def bits_of(index: ArrayLike, n: int) -> NDArray[np.int8]:
    """Bit strings of numbers, lowest bit first, as `Qubo.all_energies` counts them: (...) → (..., n) int8."""
    z = np.asarray(index, dtype=np.int64)
    return ((z[..., None] >> np.arange(n)) & 1).astype(np.int8)


def _doubled(weights: NDArray[np.float64], start: float) -> NDArray[np.float64]:
    """Sums start + Σ wᵢ·xᵢ over all bit strings, lowest bit first: (k,) → (2**k,)."""
    sums = np.empty(1 << len(weights))
    sums[0] = start
    for bit, weight in enumerate(weights):
        half = 1 << bit
        np.add(sums[:half], weight, out=sums[half : 2 * half])
    return sums


class QuboBuilder:
    """Collects the terms of a QUBO; terms of the same bit or pair add up.

    Parameters
    ----------
    labels : iterable of str
        Names of the first bits; `add_variable` appends more.
    """

    def __init__(self, labels: Iterable[str] = ()) -> None:
        self._labels = list(labels)
        self._offset = 0.0
        self._parts: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]] = []
        self._pending = 0

    def add_variable(self, label: str) -> int:
        """Append a bit and return its index."""
        self._labels.append(label)
        return len(self._labels) - 1

    def add_constant(self, value: float) -> None:
        """Add a constant."""
        self._offset += value

    def add_linear(self, bit: int, weight: float) -> None:
        """Add weight·x."""
        self.add_quadratic(bit, bit, weight)

    def add_quadratic(self, first: int, second: int, weight: float) -> None:
        """Add weight·x·x'; with itself a bit is linear, because x² = x."""
        self._append(np.array([first]), np.array([second]), np.array([weight], dtype=np.float64))

    def add_square(
        self, terms: Mapping[int, float] | Iterable[tuple[int, float]], constant: float = 0.0, weight: float = 1.0
    ) -> None:
        """Add weight·(constant + Σ aᵢ·xᵢ)², the penalty of an equality.

        Parameters
        ----------
        terms : mapping or iterable of (bit, coefficient)
            Coefficients of the same bit add up.
        constant, weight : float
        """
        total: dict[int, float] = {}
        for bit, coefficient in terms.items() if isinstance(terms, Mapping) else terms:
            total[bit] = total.get(bit, 0.0) + coefficient
        bits = np.fromiter(total, np.int64, len(total))
        a = np.fromiter(total.values(), np.float64, len(total))
        self._offset += weight * constant**2
        self._append(bits, bits, weight * a * (a + 2.0 * constant))
        first, second = np.triu_indices(len(bits), k=1)
        self._append(bits[first], bits[second], 2.0 * weight * a[first] * a[second])

    def build(self) -> Qubo:
        """Add up, drop pairs that cancel, and return the QUBO.

        Raises
        ------
        InputError
            When a term names a bit beyond the labels, or as `Qubo` says.
        """
        self._merge()
        n = len(self._labels)
        rows, cols, values = self._parts[0]
        if rows.size and cols.max() >= n:
            raise InputError(f"qubo: a term names a bit beyond the {n} labels")
        own = rows == cols
        linear = np.zeros(n)
        linear[rows[own]] = values[own]
        pair = ~own & (values != 0.0)
        return Qubo(
            linear,
            rows[pair].astype(np.int32),
            cols[pair].astype(np.int32),
            values[pair],
            self._offset,
            tuple(self._labels),
        )

    def _append(self, first: NDArray[np.int64], second: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        if first.size and min(first.min(), second.min()) < 0:
            raise InputError("qubo: a term names a bit below 0")
        self._parts.append((np.minimum(first, second), np.maximum(first, second), values))
        self._pending += len(values)
        if self._pending > _PENDING_TERMS:
            self._merge()

    def _merge(self) -> None:
        """Add up the terms of equal pairs, in the order in which they came."""
        empty = (np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
        rows, cols, values = (np.concatenate(column) for column in zip(empty, *self._parts, strict=True))
        order = np.lexsort((cols, rows))
        rows, cols, values = rows[order], cols[order], values[order]
        first = np.flatnonzero((np.diff(rows, prepend=-1) != 0) | (np.diff(cols, prepend=-1) != 0))
        total = np.add.reduceat(values, first) if first.size else values
        self._parts = [(rows[first], cols[first], total)]
        # What is left after adding up counts as none: else a problem with many pairs would be merged at every term.
        self._pending = 0
