"""Bit strings from outside: samples that other programs drew of a QUBO that `exchange` wrote.

Three forms are told apart by what they hold: JSON of a ``dimod.SampleSet`` (``to_serializable``); JSON of counts as
qiskit returns them, ``{"0110": 12}``, whose last bit is the first qubit; and CSV with a column for each bit, named as
in the file of the QUBO, and perhaps one ``count``. Bits are 0 and 1; spins of −1 and 1 mean x = (1 + s)/2.
"""

import csv
import io
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.extras import extra
from tgvdp.solvers.samplers.sampling import Samples

#: Column of a CSV that says how often a string was drawn.
COUNTS = ("count", "num_occurrences")
#: Largest count of one string; sums of millions of them still fit into 64 bits.
MOST_COUNTED = 10**12


def samples_of_file(content: bytes, name: str, qubo: Qubo) -> Samples:
    """Read samples of a QUBO; ``name`` is that of the file, for errors.

    Raises
    ------
    InputError
        When the file is none of the three, or does not fit the QUBO.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{name}: is no text") from None
    try:
        tree = json.loads(text)
    except ValueError:
        return _of_csv(text, name, qubo)
    except RecursionError:
        raise InputError(f"{name}: is nested too deeply") from None
    if isinstance(tree, dict) and tree.get("type") == "SampleSet":
        return _of_sampleset(tree, name, qubo)
    if isinstance(tree, dict) and tree:
        return _of_counts(tree, name, qubo)
    raise InputError(
        f"{name}: holds neither a SampleSet, counts of bit strings, nor a table with a column for each bit"
    )


def _of_sampleset(tree: dict[str, Any], name: str, qubo: Qubo) -> Samples:
    try:
        sampleset = extra("dimod", "a SampleSet").SampleSet.from_serializable(tree)
        column = {label: i for i, label in enumerate(sampleset.variables)}
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InputError(f"{name}: is a damaged SampleSet: {error}") from None
    if missing := next((label for label in qubo.labels if label not in column), None):
        raise InputError(f"{name}: has no variable {missing!r} of the QUBO of {qubo.n} bits")
    if not len(sampleset):
        raise InputError(f"{name}: holds no sample")
    counts = sampleset.record.num_occurrences.tolist()
    for row, count in enumerate(counts):
        _require_count(name, f"sample {row}", count)
    values = sampleset.record.sample[:, [column[label] for label in qubo.labels]]
    return Samples(_as_bits(values, name), np.array(counts, dtype=np.int64))


def _of_counts(tree: dict[str, Any], name: str, qubo: Qubo) -> Samples:
    for text, count in tree.items():
        digits = text.replace(" ", "")
        if len(digits) != qubo.n or set(digits) - {"0", "1"}:
            raise InputError(f"{name}: {text!r:.60} is no string of the {qubo.n} bits of the QUBO")
        _require_count(name, repr(text), count)
    bits = [[int(digit) for digit in reversed(text.replace(" ", ""))] for text in tree]
    return Samples(np.array(bits, dtype=np.int8), np.array(list(tree.values()), dtype=np.int64))


def _of_csv(text: str, name: str, qubo: Qubo) -> Samples:
    reader = csv.DictReader(io.StringIO(text))
    try:
        columns, rows = tuple(reader.fieldnames or ()), [(reader.line_num, row) for row in reader]
    except csv.Error as error:
        raise InputError(f"{name}: line {reader.line_num + 1}: {error}") from None
    if missing := next((label for label in qubo.labels if label not in columns), None):
        raise InputError(f"{name}: has no column {missing!r} for a bit of the QUBO of {qubo.n} bits")
    if twice := next((column for column in columns if columns.count(column) > 1), None):
        raise InputError(f"{name}: has the column {twice!r:.60} twice")
    counted = next((column for column in COUNTS if column in columns), None)
    bits, counts = [], []
    for line, row in rows:
        where = f"line {line}"
        if None in row:
            raise InputError(f"{name}: {where}: has more values than the {len(columns)} columns of the header")
        try:
            bits.append([int(row[label]) for label in qubo.labels])
            counts.append(int(row[counted]) if counted else 1)
        except (TypeError, ValueError):
            raise InputError(f"{name}: {where}: holds something that is no whole number") from None
        _require_count(name, where, counts[-1])
    if not bits:
        raise InputError(f"{name}: holds no sample")
    return Samples(_as_bits(np.array(bits), name), np.array(counts, dtype=np.int64))


def _require_count(name: str, where: str, count: object) -> None:
    if type(count) is not int or not 1 <= count <= MOST_COUNTED:
        raise InputError(
            f"{name}: {where}: a count must be a whole number above 0 and at most {MOST_COUNTED}, got {count!r:.40}"
        )


def _as_bits(values: NDArray[Any], name: str) -> NDArray[np.int8]:
    found = set(np.unique(values).tolist())
    if found <= {0, 1}:
        return values.astype(np.int8)
    if found <= {-1, 1}:
        return ((values + 1) // 2).astype(np.int8)
    raise InputError(f"{name}: bits must be 0 and 1, or spins -1 and 1, got {sorted(found - {0, 1})[0]}")
