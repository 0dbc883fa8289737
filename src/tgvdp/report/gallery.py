"""All pictures of a result, by name: what the results folder holds and ``result.plot`` draws."""

import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.errors import InputError
from tgvdp.report.front_plots import plot_front, plot_price
from tgvdp.report.pictures import PICTURES, encode, pictures_of
from tgvdp.report.profile_plots import plot_effort, plot_profile, plot_speed_time
from tgvdp.report.style import Picture

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.certificate.front import Certificate


def draw(
    result: "SearchResult",
    picture: str,
    certificate: "Certificate | None" = None,
    price_per_kwh: float | None = None,
) -> Picture:
    """Draw one picture of a result.

    Parameters
    ----------
    result : SearchResult
    picture : str
        One of `PICTURES`.
    certificate : Certificate, optional
        Adds the proven bound to ``front``.
    price_per_kwh : float, optional
        €/kWh; adds money to ``price``.

    Raises
    ------
    InputError
        When there is no such picture.
    """
    plots = {"profile": plot_profile, "speed_time": plot_speed_time, "effort": plot_effort}
    if picture not in PICTURES:
        raise InputError(f"plot: there is no picture {picture!r:.40}; there are {', '.join(PICTURES)}")
    if picture == "front":
        return plot_front(result, None if certificate is None else certificate.lower_bound_j)
    if picture == "price":
        return plot_price(result, price_per_kwh)
    return plots[picture](result)


def front_files(
    formats: Sequence[str],
    time_s: float,
    result: "SearchResult",
    provenance: Mapping[str, Any],
    certificate: "Certificate | None",
) -> dict[str, bytes]:
    """Files of the one picture that waits for the certificate, by name; none is begun after so many seconds."""
    return _files(formats, time_s, result, provenance, ["front"], certificate=certificate)


def run_files(
    formats: Sequence[str],
    time_s: float,
    result: "SearchResult",
    provenance: Mapping[str, Any],
    price_per_kwh: float | None,
) -> dict[str, bytes]:
    """Files of all other pictures, by name; none is begun after so many seconds."""
    names = [name for name in pictures_of(result) if name != "front"]
    return _files(formats, time_s, result, provenance, names, price_per_kwh=price_per_kwh)


def _files(
    formats: Sequence[str],
    time_s: float,
    result: "SearchResult",
    provenance: Mapping[str, Any],
    names: Sequence[str],
    **shown: Any,
) -> dict[str, bytes]:
    files: dict[str, bytes] = {}
    started_s = time.perf_counter()
    for name in names:
        if time.perf_counter() - started_s > time_s:
            break
        figure = draw(result, name, **shown)
        files |= {f"{name}.{format}": encode(figure, provenance, format) for format in formats}
    return files
