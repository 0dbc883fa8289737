"""All solvers by name, and one function that runs any of them. Modules are imported when a solver is used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.names import Encoding, PenaltyRule
from tgvdp.solvers.allowance import Allowance

if TYPE_CHECKING:
    from tgvdp.formulations.problem.instances import Instance
    from tgvdp.formulations.problem.schedule import Solution


_SINGLE = ("binary",)
_BOTH = ("binary", "demand")
_SHARED = ("binary", "substation")
_ALL = (*_BOTH, "substation")


class Solver(NamedTuple):
    """Where a solver lives and what it takes.

    Attributes
    ----------
    module, function : str
        Module below `tgvdp.solvers`, and in it ``function(instance, allowance)``, or ``function(encoded, allowance)``
        where it solves a QUBO; returns a `Solution`.
    kinds : tuple of str
        Of the instances it solves: ``binary``, ``demand``, ``substation``.
    qubo : bool
        Whether it solves the instance as a QUBO.
    uses : tuple of str
        Fields of `Allowance` that change what it does.
    """

    module: str
    function: str
    kinds: tuple[str, ...] = _SINGLE
    qubo: bool = False
    uses: tuple[str, ...] = ()


_PROGRAM = ("form", "time_limit_s")
_SAMPLER = ("reads", "seed")
_QAOA = ("layers", "mixer", "angles", "step", "starts", "backend", *_SAMPLER)
_DWAVE = ("backend", "chain_strength", "anneal_us", *_SAMPLER)

SOLVERS: dict[str, Solver] = {
    "dp": Solver("exact.solve", "solve_dp", _ALL),
    "brute": Solver("exact.solve", "solve_brute", _BOTH),
    "closed": Solver("exact.solve", "solve_closed"),
    "greedy": Solver("greedy", "solve_greedy", _SHARED, uses=("time_limit_s",)),
    "milp": Solver("programs.milp", "solve_milp", _SHARED, uses=("time_limit_s",)),
    "scip": Solver("programs.scip", "solve_scip", _ALL, uses=_PROGRAM),
    "cqm": Solver("programs.cqm", "solve_cqm", _BOTH, uses=_PROGRAM),
    "leap": Solver("programs.cqm", "solve_leap", _ALL, uses=_PROGRAM),
    "sa": Solver("samplers.annealing", "solve_sa", _SHARED, qubo=True, uses=("sweeps", "beta", *_SAMPLER)),
    "pt": Solver("tempering.solve", "solve_pt", _SHARED, qubo=True, uses=("sweeps", "beta", "replicas", *_SAMPLER)),
    "tabu": Solver("samplers.annealing", "solve_tabu", _SHARED, qubo=True, uses=("sweeps", "tenure", *_SAMPLER)),
    "multiplier": Solver("samplers.multiplier", "solve_multiplier", uses=("sweeps", "beta", *_SAMPLER)),
    "descent": Solver("samplers.annealing", "solve_descent", _SHARED, qubo=True, uses=_SAMPLER),
    "random": Solver("samplers.coin_tosses", "solve_random", _SHARED, qubo=True, uses=_SAMPLER),
    "tree": Solver("samplers.annealing", "solve_tree", qubo=True),
    "exact-qubo": Solver("samplers.annealing", "solve_exact_qubo", qubo=True),
    "qaoa": Solver("circuit.angles", "solve_qaoa", qubo=True, uses=_QAOA),
    "dwave": Solver("samplers.cloud", "solve_dwave", _SHARED, qubo=True, uses=_DWAVE),
}


def solve(
    instance: "Instance",
    solver: str,
    encoding: Encoding | None = None,
    penalty: PenaltyRule | None = None,
    allowance: Allowance | None = None,
) -> "Solution":
    """Solve an instance.

    Parameters
    ----------
    instance : BinaryInstance or DemandInstance
    solver : str
        One of `SOLVERS`.
    encoding : str, optional
        For solvers of a QUBO; by default `tgvdp.formulations.qubo.encodings.default_encoding`.
    penalty : "sufficient", "tenfold", float or tuple of float, optional
        For solvers of a QUBO; see `tgvdp.formulations.qubo.encodings.encode`.
    allowance : Allowance, optional

    Raises
    ------
    InputError
        When the solver does not solve such instances, or was given what it does not use.
    InfeasibleError
        When it proves that nothing satisfies all constraints.
    """
    from tgvdp.formulations.problem.binary import warn_of_oddities
    from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance, kind_of
    from tgvdp.formulations.qubo.encodings import default_encoding, encode

    entry, kind = SOLVERS[solver], kind_of(instance)
    if kind not in entry.kinds:
        can = ", ".join(name for name, other in SOLVERS.items() if kind in other.kinds)
        raise InputError(f"{instance.id}: solver {solver} takes no {kind} instances; {can} do")
    function: Any = getattr(import_module(f"tgvdp.solvers.{entry.module}"), entry.function)
    allowance = allowance or Allowance()
    if not entry.qubo:
        if encoding is not None or penalty is not None:
            raise InputError(f"solver {solver} makes no QUBO, so it uses neither an encoding nor a penalty")
        if isinstance(instance, BinaryInstance):
            if allowance.form is not None:
                raise InputError(f"{instance.id}: form {allowance.form} is one of demand instances, not of binary ones")
            warn_of_oddities(instance)
        solution: Solution = function(instance, allowance)
        return solution
    assert not isinstance(instance, DemandInstance)
    solution = function(encode(instance, encoding or default_encoding(instance), penalty), allowance)
    return solution
