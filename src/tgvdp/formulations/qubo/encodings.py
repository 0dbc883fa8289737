"""One door to the encodings as a QUBO, by their names and by the rule for the penalty."""

import warnings
from dataclasses import replace

from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import FormulationWarning, level_counts, warn_of_oddities
from tgvdp.formulations.problem.instances import BinaryInstance, SubstationInstance
from tgvdp.formulations.qubo.bits import encode_bits
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.names import MULTIPLIER, UNARY, Encoding, PenaltyRule, Weights, bits_form, kinds_of
from tgvdp.formulations.qubo.parts import joined, si_weights
from tgvdp.formulations.qubo.penalties import (
    best_multiplier,
    spread_penalty,
    sufficient_for_substation,
    sufficient_penalty,
    tenfold_penalty,
)
from tgvdp.formulations.qubo.substation import encode_substation
from tgvdp.formulations.qubo.unary import encode_unary

#: Most couplers of a QUBO: 20 million take two minutes and 4 GB to make.
MOST_COUPLERS = 20_000_000


def default_encoding(instance: BinaryInstance | SubstationInstance) -> Encoding:
    """Encoding that holds all constraints: ``unary`` where the steps are equal, else ``bits+slack``."""
    equal = isinstance(instance, SubstationInstance) or instance.acc_units == instance.dec_units
    return "unary" if equal else "bits+slack"


def encode(
    instance: BinaryInstance | SubstationInstance, encoding: Encoding, penalty: PenaltyRule | None = None
) -> Encoded:
    """Write an instance as a QUBO.

    Parameters
    ----------
    instance : BinaryInstance or SubstationInstance
        The trains of a substation are ``unary`` only.
    encoding : str
        ``bits`` (2N bits; nothing holds the speed within its limits), ``bits+slack`` (with a register per step that
        does), ``unary`` (equal steps only; holds all constraints), ``unary+multiplier`` (the distance as a linear term,
        of the multiplier whose lower bound is best), or a printed form (`tgvdp.formulations.qubo.names.bits_form`).
    penalty : "sufficient", "tenfold", float or tuple of float, optional
        A tuple has a weight for each kind of violation. By default the instance's own ``lambda_uniform``, else
        ``sufficient``.

    Warns
    -----
    FormulationWarning
        When the weight is not proved to be large enough, or the instance is not what it looks like.

    Raises
    ------
    InputError
        When the encoding does not fit the instance, or would have more than `MOST_COUPLERS` couplers.
    """
    if isinstance(instance, BinaryInstance):
        _require_size(instance, encoding)
        warn_of_oddities(instance)
    own = instance.lambda_uniform if isinstance(instance, BinaryInstance) else None
    rule: PenaltyRule = own or "sufficient" if penalty is None else penalty
    weights = Weights()
    if isinstance(rule, tuple):
        weights = _own_weights(instance, encoding, rule)
    elif rule == "tenfold" and isinstance(instance, BinaryInstance):
        weights = si_weights(instance, encoding)
    draft = _with_weights(instance, encoding, weights)
    enough = _sufficient(draft)
    if rule == "tenfold":
        weight = tenfold_penalty(draft.objective)
    else:
        weight = 1.0 if isinstance(rule, tuple) else enough if rule == "sufficient" else float(rule)
    least = weight * min(getattr(weights, kind) for kind in _kinds(instance, encoding))
    if least < enough / 1.05:
        warnings.warn(
            f"{instance.id}: a penalty of {least:.4g} {instance.objective_unit} per unit of violation may be too "
            f"small: the minimum can break constraints; {enough:.4g} is sufficient",
            FormulationWarning,
            stacklevel=2,
        )
    return replace(draft, qubo=joined(draft.objective, draft.violation, weight), penalty=weight)


def _kinds(instance: BinaryInstance | SubstationInstance, encoding: Encoding) -> tuple[str, ...]:
    return kinds_of(encoding, shared=isinstance(instance, SubstationInstance))


def _own_weights(
    instance: BinaryInstance | SubstationInstance, encoding: Encoding, given: tuple[float, ...]
) -> Weights:
    kinds = _kinds(instance, encoding)
    if len(given) != len(kinds):
        raise InputError(
            f"penalty: {encoding} has {len(kinds)} kinds of violations ({', '.join(kinds)}), got {len(given)} weights"
        )
    return Weights(**dict(zip(kinds, given, strict=True)))


def _sufficient(draft: Encoded) -> float:
    if isinstance(draft.instance, SubstationInstance):
        return sufficient_for_substation(draft.instance)
    if draft.encoding == MULTIPLIER or (draft.encoding != UNARY and bits_form(draft.encoding).cubic):
        return spread_penalty(draft.objective)
    return sufficient_penalty(draft.instance, draft.encoding)


def _require_size(instance: BinaryInstance, encoding: Encoding) -> None:
    """The square of the distance couples all bits that move the train."""
    if encoding == MULTIPLIER:
        return  # a strip of few couplers
    bits = sum(level_counts(instance)) if encoding == UNARY else 2 * instance.steps
    if bits * (bits - 1) // 2 > MOST_COUPLERS:
        raise InputError(
            f"{instance.id}: {encoding} couples {bits} bits with each other, {bits * (bits - 1) // 2} couplers "
            f"(at most {MOST_COUPLERS})"
        )


def _with_weights(instance: BinaryInstance | SubstationInstance, encoding: Encoding, weights: Weights) -> Encoded:
    if isinstance(instance, SubstationInstance):
        if encoding != UNARY:
            raise InputError(f"{instance.id}: the trains of a substation are written as unary, not as {encoding}")
        return encode_substation(instance, 1.0, weights)
    if encoding == UNARY:
        return encode_unary(instance, 1.0, weights)
    if encoding == MULTIPLIER:
        return encode_unary(instance, 1.0, weights, best_multiplier(instance))
    form = bits_form(encoding)
    if form.cubic and instance.model != "efficiency":
        raise InputError(f"{instance.id}: {encoding}: cubic is the efficiency model's, got the {instance.model} model")
    return encode_bits(instance, 1.0, form, weights)
