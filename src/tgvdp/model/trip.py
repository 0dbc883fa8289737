"""One run to be planned: a train, a line, where it starts and ends, and at which speeds."""

from dataclasses import dataclass

from tgvdp.errors import ArgumentError, InputError
from tgvdp.model.checks import require_number
from tgvdp.model.convention import TTOBENCH, Convention
from tgvdp.model.energy import WHEEL, EnergyModel
from tgvdp.model.track import Track
from tgvdp.model.train import Train

_UNITS = {"origin_m": "m", "destination_m": "m", "start_speed_mps": "m/s", "end_speed_mps": "m/s"}
_KINDS = {"train": Train, "track": Track, "energy": EnergyModel, "convention": Convention}


@dataclass(frozen=True, kw_only=True)
class Trip:
    """A run from one position to another without intermediate stop.

    Parameters
    ----------
    train : Train
    track : Track
    origin_m, destination_m : float
        Positions on the track; the destination lies after the origin.
    start_speed_mps, end_speed_mps : float
        Speeds at the two ends, 0 for a stop.
    energy : EnergyModel
        What the run is charged for.
    convention : Convention
        How line resistance and speed limits are understood.
    credits : tuple of (float, float)
        Positions on the track, m, and by how much each second before them is cheaper, J/s, for journeys with timing
        points (`journeys.whole`). Searches and bounds count them as saved energy, profiles and replays do not.

    Raises
    ------
    InputError
        When train or track are none (`tgvdp.load_train` reads one), positions lie outside the track or are out of
        order, or a speed is negative.
    """

    train: Train
    track: Track
    origin_m: float
    destination_m: float
    start_speed_mps: float = 0.0
    end_speed_mps: float = 0.0
    energy: EnergyModel = WHEEL
    convention: Convention = TTOBENCH
    credits: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        for name, kind in _KINDS.items():
            if not isinstance(getattr(self, name), kind):
                raise ArgumentError("trip", name, f"must be of class {kind.__name__}, got {getattr(self, name)!r:.60}")
        for name, unit in _UNITS.items():
            value = require_number("trip", name, getattr(self, name), unit, at_least=0.0)
            object.__setattr__(self, name, value)
        if self.destination_m > self.track.length_m:
            raise InputError(
                f"trip: destination must lie within the line's {self.track.length_m:.12g} m, "
                f"got {self.destination_m:.12g} m"
            )
        if not self.destination_m > self.origin_m:
            raise InputError(
                f"trip: destination must lie after the origin, "
                f"got {self.destination_m:.12g} m after {self.origin_m:.12g} m"
            )

    def __hash__(self) -> int:
        """Of a few of its numbers: what is kept per trip is looked up at each run, and lines may have thousands."""
        train, track = self.train, self.track
        ends = (self.origin_m, self.destination_m, self.start_speed_mps, self.end_speed_mps)
        davis = (train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2)  # wind changes the first two
        return hash((*ends, train.mass_kg, *davis, track.length_m, track.name))

    @property
    def distance_m(self) -> float:
        """Distance from origin to destination, m."""
        return self.destination_m - self.origin_m
