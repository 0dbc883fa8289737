"""The train: mass, running resistance, effort and comfort limits."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.model.adhesion import Adhesion
from tgvdp.model.checks import require_notes, require_number, require_rows, require_text
from tgvdp.model.effort import EffortCurve

_NO_BRAKE = EffortCurve.from_caps(0.0)


class TunnelDrag(NamedTuple):
    """Additional drag in tunnels of one cross section: it adds ``coefficient · v²`` to the resistance."""

    cross_section_m2: float
    davis_c_n_per_mps2: float


class BrakingRate(NamedTuple):
    """A deceleration of full braking that holds from a speed up to the next row's."""

    from_mps: float
    deceleration_mps2: float


@dataclass(frozen=True, kw_only=True)
class Train:
    """A train in SI units, checked when it is made.

    Parameters
    ----------
    mass_kg : float
        Static mass, which gravity acts on.
    traction : EffortCurve
        Largest traction effort of the drive, at the wheel.
    braking : EffortCurve
        Largest effort of the dynamic (electric) brake, positive.
    adhesion : Adhesion, optional
        What the driven wheels can put on the rail at most, of traction and of the dynamic brake; None means enough.
    friction_brake_n : float
        Effort of the friction brake, on top of the dynamic brake.
    braking_rates : tuple of BrakingRate
        Full braking as decelerations by speed, whatever gradient and resistance (OSRD, railtoolkit); empty means that
        full braking is the effort of both brakes. The dynamic brake's share of it is then what ``braking`` allows.
    rotating_mass_factor : float
        Inertia over mass, at least 1: ``m_eff = mass_kg · rotating_mass_factor``.
    length_m : float
        Length of the train.
    davis_a_n, davis_b_n_per_mps, davis_c_n_per_mps2 : float
        Davis resistance ``A + B·v + C·v²`` on straight level track in the open.
    tunnel_drag : tuple of TunnelDrag
        Additional drag by cross section of the tunnel.
    max_acceleration_mps2, max_deceleration_mps2 : float
        Comfort limits on dv/dt, both positive; infinite means none.
    max_speed_mps : float
        Top speed; infinite means none.
    traction_efficiency, regeneration_efficiency : float
        Pantograph to wheel and wheel to pantograph, 0..1.
    auxiliary_power_w : float
        Power of everything but traction, drawn as long as the run takes.
    name : str
        For people.
    notes : tuple of str
        Sources and doubts, shown by the catalog and on validation.

    Raises
    ------
    InputError
        When a value is not finite or out of range, when an effort is negative below the top speed, or when the
        train has no traction at standstill. Whether it can climb or stop on a given line shows in the search.
    """

    mass_kg: float
    traction: EffortCurve
    braking: EffortCurve = _NO_BRAKE
    adhesion: Adhesion | None = None
    friction_brake_n: float = 0.0
    braking_rates: tuple[BrakingRate, ...] = ()
    rotating_mass_factor: float = 1.0
    length_m: float = 0.0
    davis_a_n: float = 0.0
    davis_b_n_per_mps: float = 0.0
    davis_c_n_per_mps2: float = 0.0
    tunnel_drag: tuple[TunnelDrag, ...] = ()
    max_acceleration_mps2: float = math.inf
    max_deceleration_mps2: float = math.inf
    max_speed_mps: float = math.inf
    traction_efficiency: float = 1.0
    regeneration_efficiency: float = 0.0
    auxiliary_power_w: float = 0.0
    name: str = "train"
    notes: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        owner = f"train {require_text('train', 'name', self.name)}"
        object.__setattr__(self, "notes", require_notes(owner, self.notes))
        self._set_numbers(owner, "kg", "mass_kg", above=0.0)
        self._set_numbers(owner, "-", "rotating_mass_factor", at_least=1.0)
        self._set_numbers(owner, "m", "length_m", at_least=0.0)
        self._set_numbers(owner, "N", "friction_brake_n", "davis_a_n", at_least=0.0)
        self._set_numbers(owner, "N/(m/s)", "davis_b_n_per_mps", at_least=0.0)
        self._set_numbers(owner, "N/(m/s)²", "davis_c_n_per_mps2", at_least=0.0)
        self._set_numbers(owner, "m/s²", "max_acceleration_mps2", "max_deceleration_mps2", above=0.0, infinite_ok=True)
        self._set_numbers(owner, "m/s", "max_speed_mps", above=0.0, infinite_ok=True)
        self._set_numbers(owner, "-", "traction_efficiency", above=0.0)
        self._set_numbers(owner, "-", "regeneration_efficiency", at_least=0.0)
        self._set_numbers(owner, "W", "auxiliary_power_w", at_least=0.0)
        object.__setattr__(self, "tunnel_drag", self._tunnel_drag(owner))
        object.__setattr__(self, "braking_rates", self._braking_rates(owner))
        object.__setattr__(self, "adhesion", self._adhesion(owner))
        for name in ("traction_efficiency", "regeneration_efficiency"):
            if getattr(self, name) > 1.0:
                raise InputError(f"{owner}: {name} must be at most 1, got {getattr(self, name):g}")
        for name in ("traction", "braking"):
            curve = getattr(self, name)
            if not isinstance(curve, EffortCurve):
                raise InputError(f"{owner}: {name} must be an EffortCurve, got {curve!r:.60}")
            if math.isfinite(self.max_speed_mps):
                curve.require_not_negative(f"{owner}: {name}", self.max_speed_mps)
        if self.traction.effort_n(0.0) <= 0.0:
            raise InputError(f"{owner}: traction must be above 0 N at standstill")

    def __hash__(self) -> int:
        """Of a few of its numbers: what is kept per train is looked up at each run, and curves may be long."""
        davis = (self.davis_a_n, self.davis_b_n_per_mps, self.davis_c_n_per_mps2)
        return hash((self.mass_kg, self.rotating_mass_factor, *davis, self.name))

    def _tunnel_drag(self, owner: str) -> tuple[TunnelDrag, ...]:
        made: dict[float, TunnelDrag] = {}
        for index, row in enumerate(require_rows(owner, "tunnel_drag", self.tunnel_drag, TunnelDrag)):
            label = f"tunnel_drag[{index}]"
            drag = TunnelDrag(
                require_number(owner, f"{label}.cross_section", row.cross_section_m2, "m²", above=0.0),
                require_number(owner, f"{label}.davis_c", row.davis_c_n_per_mps2, "N/(m/s)²", at_least=0.0),
            )
            if drag.cross_section_m2 in made:
                raise InputError(f"{owner}: {label} repeats the cross section {drag.cross_section_m2:.12g} m²")
            made[drag.cross_section_m2] = drag
        return tuple(made.values())

    def _adhesion(self, owner: str) -> Adhesion | None:
        if self.adhesion is None:
            return None
        (row,) = require_rows(owner, "adhesion", (self.adhesion,), Adhesion)
        if row.coefficient is not None:
            require_number(owner, "adhesion.coefficient", row.coefficient, "-", above=0.0)
            if row.coefficient > 1.0:
                raise InputError(f"{owner}: adhesion.coefficient must be at most 1, got {row.coefficient:g}")
        mass_kg = require_number(owner, "adhesion.adhesive_mass", row.adhesive_mass_kg, "kg", above=0.0)
        if mass_kg > self.mass_kg:
            raise InputError(
                f"{owner}: adhesion.adhesive_mass must be at most the mass of {self.mass_kg:.12g} kg, "
                f"got {mass_kg:.12g} kg"
            )
        return Adhesion(mass_kg, row.coefficient)

    def _braking_rates(self, owner: str) -> tuple[BrakingRate, ...]:
        made: list[BrakingRate] = []
        for index, row in enumerate(require_rows(owner, "braking_rates", self.braking_rates, BrakingRate)):
            label = f"braking_rates[{index}]"
            rate = BrakingRate(
                require_number(owner, f"{label}.from", row.from_mps, "m/s", at_least=0.0),
                require_number(owner, f"{label}.deceleration", row.deceleration_mps2, "m/s²", above=0.0),
            )
            if rate.from_mps != 0.0 if not made else not rate.from_mps > made[-1].from_mps:
                raise InputError(
                    f"{owner}: {label}.from must start at 0 m/s and increase, got {rate.from_mps:.12g} m/s"
                )
            made.append(rate)
        return tuple(made)

    def _set_numbers(
        self,
        owner: str,
        unit: str,
        *names: str,
        above: float | None = None,
        at_least: float | None = None,
        infinite_ok: bool = False,
    ) -> None:
        """Check numbers and store them as floats, whatever kind of number they were given as."""
        for name in names:
            value = require_number(
                owner, name, getattr(self, name), unit, above=above, at_least=at_least, infinite_ok=infinite_ok
            )
            object.__setattr__(self, name, value)

    @cached_property
    def traction_limit(self) -> EffortCurve:
        """Largest traction effort that reaches the rail."""
        return self.traction if self.adhesion is None else self.traction.within(self.adhesion.limit())

    @cached_property
    def dynamic_brake_limit(self) -> EffortCurve:
        """Largest effort of the dynamic brake that reaches the rail."""
        return self.braking if self.adhesion is None else self.braking.within(self.adhesion.limit())

    @property
    def inertia_kg(self) -> float:
        """Mass that accelerates: static mass times the rotating mass factor."""
        return self.mass_kg * self.rotating_mass_factor

    def resistance_n(self, speed_mps: float) -> float:
        """Davis resistance at a speed, N."""
        return self.davis_a_n + speed_mps * (self.davis_b_n_per_mps + speed_mps * self.davis_c_n_per_mps2)
