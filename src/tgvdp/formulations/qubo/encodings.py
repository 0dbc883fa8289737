"""One door to the encodings of the binary model, by their names and by the rule for the penalty."""

import warnings
from dataclasses import replace

from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import FormulationWarning, warn_of_oddities
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.qubo.bits import BitsForm, encode_bits
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.names import Encoding, PenaltyRule
from tgvdp.formulations.qubo.parts import Weights, joined, si_weights
from tgvdp.formulations.qubo.penalties import sufficient_penalty, tenfold_penalty
from tgvdp.formulations.qubo.unary import encode_unary

#: Most couplers of a QUBO: 20 million take two minutes and 4 GB to make.
MOST_COUPLERS = 20_000_000


def encode(instance: BinaryInstance, encoding: Encoding, penalty: PenaltyRule | None = None) -> Encoded:
    """Write an instance as a QUBO.

    Parameters
    ----------
    instance : BinaryInstance
    encoding : str
        ``bits`` (2N bits; nothing holds the speed within its limits), ``bits+slack`` (with a register per step that
        does) or ``unary`` (equal steps only; holds all constraints).
    penalty : "sufficient", "tenfold" or float, optional
        By default the instance's own ``lambda_uniform``, else ``sufficient``.

    Warns
    -----
    FormulationWarning
        When the weight is not proved to be large enough, or the instance is not what it looks like.

    Raises
    ------
    InputError
        When the encoding does not fit the instance, or would have more than `MOST_COUPLERS` couplers.
    """
    _require_size(instance, encoding)
    warn_of_oddities(instance)
    rule: PenaltyRule = instance.lambda_uniform or "sufficient" if penalty is None else penalty
    weights = si_weights(instance, encoding) if rule == "tenfold" else Weights()
    draft = _with_weights(instance, encoding, weights)
    enough = sufficient_penalty(instance, encoding)
    weight = tenfold_penalty(draft.objective) if rule == "tenfold" else enough if rule == "sufficient" else float(rule)
    if weight * min(weights) < enough / 1.05:
        warnings.warn(
            f"{instance.id}: a penalty of {weight * min(weights):.4g} (m/s)² per unit of violation may be too small: "
            f"the minimum can break constraints; {enough:.4g} is sufficient",
            FormulationWarning,
            stacklevel=2,
        )
    return replace(draft, qubo=joined(draft.objective, draft.violation, weight), penalty=weight)


def _require_size(instance: BinaryInstance, encoding: Encoding) -> None:
    """The square of the distance couples all bits that move the train."""
    steps, unit = instance.steps, instance.acc_units
    if encoding == "unary":
        bits = sum(min(k, steps - k, cap // unit) for k, cap in enumerate(instance.cap_units[:-1], start=1))
    else:
        bits = 2 * steps
    if bits * (bits - 1) // 2 > MOST_COUPLERS:
        raise InputError(
            f"{instance.id}: {encoding} couples {bits} bits with each other, {bits * (bits - 1) // 2} couplers "
            f"(at most {MOST_COUPLERS})"
        )


def _with_weights(instance: BinaryInstance, encoding: Encoding, weights: Weights) -> Encoded:
    if encoding == "unary":
        return encode_unary(instance, 1.0, weights)
    return encode_bits(instance, 1.0, BitsForm("none" if encoding == "bits" else "per-step"), weights)
