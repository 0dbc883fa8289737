"""Formulations as files of other programs: each format keeps what it can, a sidecar the rest."""

import json

import numpy as np

from tgvdp.errors import InputError
from tgvdp.formulations.circuit.qaoa import energy_scale, qaoa_circuit, qasm3, ramp_angles
from tgvdp.formulations.problem.instances import DemandInstance, Instance
from tgvdp.formulations.program.demand import DemandForm
from tgvdp.formulations.program.files import lp_text, mps_text
from tgvdp.formulations.program.substation import linear_program
from tgvdp.formulations.qubo.couplers import coupler_graph, node_link
from tgvdp.formulations.qubo.encodings import default_encoding, encode
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.formulations.qubo.names import Encoding, PenaltyRule
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.programs.cqm import cqm_of
from tgvdp.solvers.samplers.bqm import bqm_of

#: Angle of a whole layer of the ramp in OpenQASM files, rad.
QASM_TIME_STEP = 0.75


def exported(
    instance: Instance,
    target: str,
    encoding: Encoding | None = None,
    penalty: PenaltyRule | None = None,
    layers: int = 1,
    form: DemandForm | None = None,
) -> dict[str, bytes]:
    """Write an instance in a format.

    Parameters
    ----------
    instance : BinaryInstance, DemandInstance or SubstationInstance
        Demand instances fit into ``cqm`` only.
    target : str
        ``bqm``, ``coo``, ``qs``, ``ising``, ``graph`` and ``qasm3`` hold the QUBO of an encoding, ``lp`` and ``mps``
        the linear program, ``cqm`` the constrained quadratic model.
    encoding, penalty
        As `encode` takes them, by default `default_encoding`. Programs have neither.
    layers : int
        Of the QAOA circuit, whose angles are a ramp.
    form : {"split", "delta", "joint"}, optional
        Of the quadratic program of a demand instance, ``split`` by default.

    Returns
    -------
    dict of str to bytes
        By suffix of the file's name: "" for the file itself, ".json" for the sidecar of COO.

    Raises
    ------
    InputError
        When the format does not hold such instances.
    """
    if target in ("lp", "mps", "cqm") and (encoding is not None or penalty is not None):
        raise InputError(f"{target} holds a program with constraints, so it uses neither an encoding nor a penalty")
    if form is not None and not isinstance(instance, DemandInstance):
        raise InputError(f"{instance.id}: form {form} is one of demand instances, no others")
    if target == "cqm":
        with cqm_of(instance, form or "split").cqm.to_file() as file:
            return {"": bytes(file.read())}
    if isinstance(instance, DemandInstance):
        raise InputError(f"{instance.id}: a demand instance is no QUBO and no linear program: write it --to cqm")
    if target in ("lp", "mps"):
        program = linear_program(instance).program
        return {"": (lp_text if target == "lp" else mps_text)(program).encode()}
    encoded = encode(instance, encoding or default_encoding(instance), penalty)
    if target == "bqm":
        with bqm_of(encoded.qubo).to_file() as file:
            return {"": bytes(file.read())}
    if target == "coo":
        return _coo(encoded.qubo)
    if target == "qs":
        return {"": _qs(encoded.qubo).encode()}
    if target == "ising":
        return {"": json.dumps(_spins(encoded.qubo), ensure_ascii=False).encode()}
    if target == "graph":
        q = encoded.qubo
        graph = coupler_graph(q.labels, q.linear, q.rows, q.cols, q.values, q.offset)
        return {"": json.dumps(node_link(graph)).encode()}
    ising = ising_of(encoded.qubo, -1)
    angles = ramp_angles(layers, QASM_TIME_STEP, energy_scale(ising) or 1.0)
    title = f"{instance.id}: {encoded.encoding}, penalty {encoded.penalty:.6g}, QAOA ramp of depth {layers}"
    return {"": qasm3(qaoa_circuit(ising, angles), [title]).encode()}


def _qs(qubo: Qubo) -> str:
    """QUBO as QOBLIB writes it: half of a symmetric matrix, counted from 1, in which a coupling stands by half."""
    own = np.flatnonzero(qubo.linear)
    entries = [(i, i, value) for i, value in zip(own.tolist(), qubo.linear[own].tolist(), strict=True)]
    triples = zip(qubo.rows.tolist(), qubo.cols.tolist(), qubo.values.tolist(), strict=True)
    entries += [(row, col, 0.5 * value) for row, col, value in triples]
    lines = [f"# ObjectiveOffset {qubo.offset!r}", f"{qubo.n} {len(entries)}"]
    lines += [f"{row + 1} {col + 1} {value!r}" for row, col, value in sorted(entries)]
    return "\n".join([*lines, ""])


def _spins(qubo: Qubo) -> dict[str, object]:
    """Ising form with x = (1 + s)/2, the convention of annealers: fields by label, couplings by two labels."""
    ising = ising_of(qubo, 1)
    pairs = zip(ising.rows.tolist(), ising.cols.tolist(), ising.couplings.tolist(), strict=True)
    return {
        "h": dict(zip(ising.labels, ising.fields.tolist(), strict=True)),
        "J": [[ising.labels[row], ising.labels[col], value] for row, col, value in pairs],
        "offset": ising.offset,
    }


def _coo(qubo: Qubo) -> dict[str, bytes]:
    """Coordinate text as dimod reads it, which has no place for the offset and the labels: they go beside it."""
    own = np.flatnonzero(qubo.linear)
    lines = ["# vartype=BINARY"]
    lines += [f"{i} {i} {_without_exponent(qubo.linear[i])}" for i in own.tolist()]
    triples = zip(qubo.rows.tolist(), qubo.cols.tolist(), qubo.values.tolist(), strict=True)
    lines += [f"{row} {col} {_without_exponent(value)}" for row, col, value in triples]
    sidecar = {"offset": qubo.offset, "labels": list(qubo.labels)}
    return {"": "\n".join([*lines, ""]).encode(), ".json": json.dumps(sidecar, ensure_ascii=False).encode()}


def _without_exponent(value: float) -> str:
    """All digits of a number, with a point and no exponent: dimod passes over a line of COO text that has one."""
    return np.format_float_positional(value, trim="0")
