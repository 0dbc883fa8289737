"""The line: stops, speed limits, gradients, curves and tunnels along one direction of running."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.model.checks import SUM_RTOL, require_increasing, require_notes, require_number, require_rows, require_text

#: Above this a "gradient" is a unit slip, not a railway.
VERTICAL_PERMIL = 1000.0

#: Current on a stretch: traction and all; neither traction nor dynamic brake; no auxiliaries either.
POWERED, NEUTRAL, LOWERED = range(3)


class SpeedLimit(NamedTuple):
    """A speed limit that holds from a position to the next one."""

    position_m: float
    speed_mps: float


class Gradient(NamedTuple):
    """A gradient in permille, positive uphill, that holds from a position to the next one."""

    position_m: float
    gradient_permil: float


class Curve(NamedTuple):
    """A curve from a position to the next one; curvature is linear between the two radii, infinite = straight."""

    position_m: float
    radius_start_m: float
    radius_end_m: float


class Tunnel(NamedTuple):
    """A tunnel of one cross section."""

    position_m: float
    length_m: float
    cross_section_m2: float


class NeutralSection(NamedTuple):
    """A stretch without traction current: no traction, no regeneration, while the train's head is in it.

    With the pantograph lowered the auxiliaries are without power as well.
    """

    position_m: float
    length_m: float
    lowered_pantograph: bool = False


class Place(NamedTuple):
    """A place that has a name, such as a station."""

    position_m: float
    name: str


class SpeedRestriction(NamedTuple):
    """A speed that is not exceeded from one position to another, whatever the limit there."""

    from_m: float
    to_m: float
    speed_mps: float


@dataclass(frozen=True, kw_only=True)
class Track:
    """A line in SI units, checked when it is made.

    Parameters
    ----------
    length_m : float
        Length of the line.
    speed_limits : tuple of SpeedLimit
        Must start at 0 m; each holds until the next.
    gradients : tuple of Gradient
        Empty means level. Must start at 0 m; each holds until the next.
    stops_m : tuple of float
        Positions of stops, increasing, within the line; empty means its two ends.
    curves : tuple of Curve
        Empty means straight.
    tunnels : tuple of Tunnel
        Empty means none; they may not overlap.
    neutral_sections : tuple of NeutralSection
        Empty means none; they may not overlap.
    places : tuple of Place
        Named places, in order: for people, and for timetables that give names alone.
    altitude_m : float
        Altitude at 0 m, for plots only.
    name : str
        For people.
    notes : tuple of str
        Sources and doubts.

    Raises
    ------
    InputError
        When positions are negative or unordered, a limit is 0, or a value is not finite.
    """

    length_m: float
    speed_limits: tuple[SpeedLimit, ...]
    gradients: tuple[Gradient, ...] = ()
    stops_m: tuple[float, ...] = ()
    curves: tuple[Curve, ...] = ()
    tunnels: tuple[Tunnel, ...] = ()
    neutral_sections: tuple[NeutralSection, ...] = ()
    places: tuple[Place, ...] = ()
    altitude_m: float = 0.0
    name: str = "track"
    notes: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        owner = f"track {require_text('track', 'name', self.name)}"
        store = partial(object.__setattr__, self)
        store("notes", require_notes(owner, self.notes))
        store("length_m", require_number(owner, "length_m", self.length_m, "m", above=0.0))
        store("altitude_m", require_number(owner, "altitude_m", self.altitude_m, "m"))
        store("speed_limits", self._speed_limits(owner))
        store("gradients", self._gradients(owner))
        store("curves", self._curves(owner))
        store("tunnels", self._tunnels(owner))
        store("neutral_sections", self._neutral_sections(owner))
        store("stops_m", self._stops(owner))
        store("places", self._places(owner))

    def name_at(self, position_m: float) -> str:
        """Name of the place at a position, m; empty where there is none."""
        slack_m = SUM_RTOL * self.length_m
        return next((place.name for place in self.places if abs(place.position_m - position_m) <= slack_m), "")

    def _speed_limits(self, owner: str) -> tuple[SpeedLimit, ...]:
        rows = require_rows(owner, "speed_limits", self.speed_limits, SpeedLimit)
        if not rows:
            raise InputError(f"{owner}: speed_limits must not be empty")
        require_increasing(owner, "speed_limits", [row.position_m for row in rows], self.length_m)
        return tuple(
            SpeedLimit(
                float(row.position_m),
                require_number(owner, f"speed_limits[{index}].speed", row.speed_mps, "m/s", above=0.0),
            )
            for index, row in enumerate(rows)
        )

    def _gradients(self, owner: str) -> tuple[Gradient, ...]:
        rows = require_rows(owner, "gradients", self.gradients, Gradient)
        require_increasing(owner, "gradients", [row.position_m for row in rows], self.length_m)
        made = []
        for index, row in enumerate(rows):
            permil = require_number(owner, f"gradients[{index}].gradient", row.gradient_permil, "‰")
            if abs(permil) >= VERTICAL_PERMIL:
                raise InputError(
                    f"{owner}: gradients[{index}].gradient must be within ±{VERTICAL_PERMIL:g} ‰, got {permil:.12g} ‰"
                )
            made.append(Gradient(float(row.position_m), permil))
        return tuple(made)

    def _curves(self, owner: str) -> tuple[Curve, ...]:
        rows = require_rows(owner, "curves", self.curves, Curve)
        require_increasing(owner, "curves", [row.position_m for row in rows], self.length_m)
        made = []
        for index, row in enumerate(rows):
            radii_m = [
                require_number(owner, f"curves[{index}].radius", radius_m, "m", infinite_ok=True)
                for radius_m in row[1:]
            ]
            if 0.0 in radii_m:
                raise InputError(f"{owner}: curves[{index}].radius must not be 0 m")
            made.append(Curve(float(row.position_m), *radii_m))
        return tuple(made)

    def _tunnels(self, owner: str) -> tuple[Tunnel, ...]:
        made: list[Tunnel] = []
        for index, row in enumerate(require_rows(owner, "tunnels", self.tunnels, Tunnel)):
            label = f"tunnels[{index}]"
            area_m2 = require_number(owner, f"{label}.cross_section", row.cross_section_m2, "m²", above=0.0)
            made.append(Tunnel(*self._stretch(owner, label, row.position_m, row.length_m, made), area_m2))
        return tuple(made)

    def _neutral_sections(self, owner: str) -> tuple[NeutralSection, ...]:
        made: list[NeutralSection] = []
        for index, row in enumerate(require_rows(owner, "neutral_sections", self.neutral_sections, NeutralSection)):
            label = f"neutral_sections[{index}]"
            if not isinstance(row.lowered_pantograph, bool):
                raise InputError(
                    f"{owner}: {label}.lowered_pantograph must be true or false, got {row.lowered_pantograph!r:.60}"
                )
            stretch = self._stretch(owner, label, row.position_m, row.length_m, made)
            made.append(NeutralSection(*stretch, row.lowered_pantograph))
        return tuple(made)

    def _stretch(
        self, owner: str, label: str, position_m: float, length_m: float, before: Sequence[Tunnel | NeutralSection]
    ) -> tuple[float, float]:
        """Check a stretch that lies within the line and after the one before it."""
        position_m = require_number(owner, f"{label}.position", position_m, "m", at_least=0.0)
        length_m = require_number(owner, f"{label}.length", length_m, "m", at_least=0.0)
        slack_m = SUM_RTOL * self.length_m
        end_m = before[-1].position_m + before[-1].length_m if before else 0.0
        if position_m < end_m - slack_m:
            raise InputError(
                f"{owner}: {label}.position must not lie before the end of the one before it, {end_m:.12g} m, "
                f"got {position_m:.12g} m"
            )
        if position_m + length_m > self.length_m + slack_m:
            raise InputError(
                f"{owner}: {label} must end within the line's {self.length_m:.12g} m, "
                f"ends at {position_m + length_m:.12g} m"
            )
        return position_m, length_m

    def _stops(self, owner: str) -> tuple[float, ...]:
        given: object = self.stops_m
        if isinstance(given, str) or not isinstance(given, Iterable):
            raise InputError(f"{owner}: stops must be a list of positions in m, got {given!r:.60}")
        stops_m: list[float] = []
        for index, position_m in enumerate(given):
            stop_m = require_number(owner, f"stops[{index}]", position_m, "m", at_least=0.0)
            if stops_m and not stop_m > stops_m[-1]:
                raise InputError(
                    f"{owner}: stops[{index}] must increase, got {stop_m:.12g} m after {stops_m[-1]:.12g} m"
                )
            if stop_m > self.length_m:
                raise InputError(
                    f"{owner}: stops[{index}] must be within the line's {self.length_m:.12g} m, got {stop_m:.12g} m"
                )
            stops_m.append(stop_m)
        return tuple(stops_m) or (0.0, self.length_m)

    def _places(self, owner: str) -> tuple[Place, ...]:
        made: list[Place] = []
        for index, row in enumerate(require_rows(owner, "places", self.places, Place)):
            label = f"places[{index}]"
            position_m = require_number(owner, f"{label}.position", row.position_m, "m", at_least=0.0)
            got = f"got {position_m:.12g} m"
            if made and not position_m > made[-1].position_m:
                raise InputError(f"{owner}: {label}.position must increase, {got} after {made[-1].position_m:.12g} m")
            if position_m > self.length_m * (1.0 + SUM_RTOL):
                raise InputError(f"{owner}: {label}.position must be within the line's {self.length_m:.12g} m, {got}")
            made.append(Place(position_m, require_text(owner, f"{label}.name", row.name)))
        return tuple(made)
