"""tgvdp: the whole Pareto front of delay against energy for a train on a line.

>>> import tgvdp
>>> result = tgvdp.search(tgvdp.load_train("tgv"), tgvdp.load_track("lgv-100km"))  # doctest: +SKIP

Public names are loaded when they are first used, so that ``import tgvdp`` stays cheap.
"""

import importlib
from typing import TYPE_CHECKING, Any

from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError, MissingExtraError, TgvdpError

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult, Score, SearchResult, journey, score_run, search
    from tgvdp.formats import RecordedRun, load_energy_map, load_run, load_scenario, load_track, load_train
    from tgvdp.model.effort import EffortCurve
    from tgvdp.model.energy import EnergyMap
    from tgvdp.model.track import Curve, Gradient, SpeedLimit, Track, Tunnel
    from tgvdp.model.train import Train
    from tgvdp.model.trip import Trip
    from tgvdp.pareto import ParetoFront
    from tgvdp.referee.replay import Verdict, replay
    from tgvdp.runs.profile import Profile
    from tgvdp.sweeps.iterate import SweepResult, sweep

__version__ = "0.1.0"

__all__ = [
    "BudgetExceededError",
    "Curve",
    "EffortCurve",
    "EnergyMap",
    "Gradient",
    "InfeasibleError",
    "InputError",
    "JourneyResult",
    "MissingExtraError",
    "ParetoFront",
    "Profile",
    "RecordedRun",
    "Score",
    "SearchResult",
    "SpeedLimit",
    "SweepResult",
    "TgvdpError",
    "Track",
    "Train",
    "Trip",
    "Tunnel",
    "Verdict",
    "__version__",
    "journey",
    "load_energy_map",
    "load_run",
    "load_scenario",
    "load_track",
    "load_train",
    "replay",
    "score_run",
    "search",
    "sweep",
]

_HOMES = {
    "Curve": "tgvdp.model.track",
    "EffortCurve": "tgvdp.model.effort",
    "EnergyMap": "tgvdp.model.energy",
    "Gradient": "tgvdp.model.track",
    "JourneyResult": "tgvdp.api",
    "ParetoFront": "tgvdp.pareto",
    "Profile": "tgvdp.runs.profile",
    "RecordedRun": "tgvdp.formats",
    "Score": "tgvdp.api",
    "SearchResult": "tgvdp.api",
    "SpeedLimit": "tgvdp.model.track",
    "SweepResult": "tgvdp.sweeps.iterate",
    "Track": "tgvdp.model.track",
    "Train": "tgvdp.model.train",
    "Trip": "tgvdp.model.trip",
    "Tunnel": "tgvdp.model.track",
    "Verdict": "tgvdp.referee.replay",
    "journey": "tgvdp.api",
    "load_energy_map": "tgvdp.formats",
    "load_run": "tgvdp.formats",
    "load_scenario": "tgvdp.formats",
    "load_track": "tgvdp.formats",
    "load_train": "tgvdp.formats",
    "replay": "tgvdp.referee.replay",
    "score_run": "tgvdp.api",
    "search": "tgvdp.api",
    "sweep": "tgvdp.sweeps.iterate",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
