"""What people and scripts get to read: tables, pictures, and the provenance that each file carries.

Nothing is imported until it is used, so that a program that only writes JSON never loads matplotlib.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tgvdp.report.files import check_writable as check_writable
    from tgvdp.report.front_plots import plot_front as plot_front
    from tgvdp.report.front_plots import plot_price as plot_price
    from tgvdp.report.profile_plots import plot_effort as plot_effort
    from tgvdp.report.profile_plots import plot_profile as plot_profile
    from tgvdp.report.profile_plots import plot_speed_time as plot_speed_time
    from tgvdp.report.provenance import make_provenance as make_provenance
    from tgvdp.report.results import write_results as write_results
    from tgvdp.report.tables import make_tariff as make_tariff
    from tgvdp.report.tables import result_object as result_object

_HOME = {
    "check_writable": "files",
    "make_provenance": "provenance",
    "make_tariff": "tables",
    "plot_effort": "profile_plots",
    "plot_front": "front_plots",
    "plot_price": "front_plots",
    "plot_profile": "profile_plots",
    "plot_speed_time": "profile_plots",
    "result_object": "tables",
    "write_results": "results",
}

__all__ = [
    "check_writable",
    "make_provenance",
    "make_tariff",
    "plot_effort",
    "plot_front",
    "plot_price",
    "plot_profile",
    "plot_speed_time",
    "result_object",
    "write_results",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
