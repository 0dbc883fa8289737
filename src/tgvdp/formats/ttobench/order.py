"""Checks of the rows of a track as its file names them: in its units, where those of the model name SI."""

from itertools import pairwise
from pathlib import Path
from typing import Any

from tgvdp.formats.syntax.reading import bad
from tgvdp.formats.ttobench.fields import Quantity
from tgvdp.model.checks import SUM_RTOL
from tgvdp.model.track import VERTICAL_PERMIL
from tgvdp.units import to_si


def require_steps(path: Path, place: str, table: Any, end: Quantity) -> None:
    """Refuse rows that do not hold one after the other from 0 to the end of a track.

    Parameters
    ----------
    path : Path
    place : str
        Name of the table in the file.
    table : Struct
        With ``units``, which are known, and ``values``, whose first column is a position.
    end : Quantity
        The last stop.

    Raises
    ------
    InputError
        When positions do not start at 0, do not increase, or reach the end.
    """
    unit, end_m = table.units.position, to_si(end.value, end.unit, "length")
    positions = [row[0] for row in table.values]
    if positions and positions[0] != 0.0:
        raise bad(path, f"{place}.values[0]: position must be 0 {unit}, got {positions[0]:.12g} {unit}")
    for index, (before, position) in enumerate(pairwise(positions), start=1):
        where, got = f"{place}.values[{index}]: position", f"got {position:.12g} {unit}"
        if not position > before:
            raise bad(path, f"{where} must increase, {got} after {before:.12g} {unit}")
        if to_si(position, unit, "length") >= end_m:
            raise bad(path, f"{where} must lie before the last stop at {end.value:.12g} {end.unit}, {got}")


def require_slopes(path: Path, table: Any) -> None:
    """Refuse gradients that are none of a railway."""
    unit = table.units.slope
    for index, (_, slope) in enumerate(table.values):
        if abs(to_si(slope, unit, "gradient")) >= VERTICAL_PERMIL:
            most = VERTICAL_PERMIL / to_si(1.0, unit, "gradient")
            where = f"gradients.values[{index}]: slope"
            raise bad(path, f"{where} must be within ±{most:g} {unit}, got {slope:.12g} {unit}")


def require_stretches(path: Path, table: Any, end: Quantity) -> None:
    """Refuse tunnels of no length or cross section, and those that overlap or do not lie on the track."""
    units, end_m = table.units, to_si(end.value, end.unit, "length")
    slack_m, before_m, before = SUM_RTOL * end_m, 0.0, f"0 {units.position}"
    for index, (position, length, area) in enumerate(table.values):
        where = f"tunnels.values[{index}]"
        if length < 0.0:
            raise bad(path, f"{where}: length must be at least 0 {units.length}, got {length:.12g} {units.length}")
        if not area > 0.0:
            unit = units.cross_section
            raise bad(path, f"{where}: cross section must be above 0 {unit}, got {area:.12g} {unit}")
        from_m = to_si(position, units.position, "length")
        here = f"{position:.12g} {units.position}"
        if from_m < before_m - slack_m:
            raise bad(path, f"{where}: position must not lie before {before}, where the one before it ends, got {here}")
        before_m = from_m + to_si(length, units.length, "length")
        before = f"{before_m / to_si(1.0, units.position, 'length'):.12g} {units.position}"
        if before_m > end_m + slack_m:
            last = f"{end.value:.12g} {end.unit}"
            raise bad(path, f"{where}: must end before the last stop at {last}, ends at {before}")
