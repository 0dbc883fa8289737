"""The results folder of a search: result.json, two CSV tables, four pictures and provenance.json."""

import hashlib
import io
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tgvdp.report.courses import PROFILE_FILES
from tgvdp.report.files import write_files
from tgvdp.report.plain import plain
from tgvdp.report.tables import front_csv, result_object

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tgvdp.api import SearchResult
    from tgvdp.certificate.front import Certificate
    from tgvdp.referee.replay import Verdict

#: Effort of zlib: the usual 6 takes 1.5 times as long for files that are 8 % smaller.
_COMPRESSION = 3


def write_results(
    result: "SearchResult",
    out_dir: str | os.PathLike[str],
    provenance: Mapping[str, Any],
    verdicts: Sequence["Verdict"] | None = None,
    certificate: "Certificate | None" = None,
    profiles: str = "csv",
) -> list[Path]:
    """Write all files of a result into a folder, all or none.

    JSON and pictures carry the provenance themselves. The CSV tables stay plain for the scripts that read them;
    ``provenance.json`` ties every file to its origin by its SHA-256.

    Parameters
    ----------
    result : SearchResult
    out_dir : path
        Made when absent; files of an earlier run are replaced.
    provenance : mapping
        As `make_provenance` returns it.
    verdicts : sequence of Verdict, optional
        Of ``result.verify()``, when the caller has them already.
    certificate : Certificate, optional
        Of ``result.certify()``; without it files and pictures hold no bounds.
    profiles : {"csv", "parquet", "railtoolkit"}
        Format of the speed profiles.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        When the folder cannot be written.
    """
    content = result_object(result, result.verify() if verdicts is None else verdicts, provenance, certificate)
    profiles_name, profiles_of = PROFILE_FILES[profiles]
    files = {
        "result.json": _json(content),
        "front.csv": front_csv(content).encode(),
        profiles_name: profiles_of(result),
        **_pictures(result, provenance, certificate),
    }
    ledger = {
        "schema": "tgvdp.provenance/1",
        **plain(provenance),
        "files": {name: hashlib.sha256(data).hexdigest() for name, data in files.items()},
    }
    return write_files(out_dir, {**files, "provenance.json": _json(ledger)})


def _json(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _pictures(
    result: "SearchResult", provenance: Mapping[str, Any], certificate: "Certificate | None"
) -> dict[str, bytes]:
    # Here, so that whoever wants no picture does not wait for matplotlib.
    from tgvdp.report import front_plots, profile_plots

    figures = {
        "front.png": front_plots.plot_front(result, None if certificate is None else certificate.lower_bound_j),
        "profile.png": profile_plots.plot_profile(result),
        "speed_curve.png": profile_plots.plot_speed_curve(result),
        "metric.png": front_plots.plot_metric(result),
    }
    return {name: png(figure, provenance) for name, figure in figures.items()}


def png(figure: "Figure", provenance: Mapping[str, Any]) -> bytes:
    """Picture of a figure as PNG, with the provenance in its metadata."""
    buffer = io.BytesIO()
    about = json.dumps(plain(provenance), ensure_ascii=True)
    figure.savefig(
        buffer,
        format="png",
        dpi=figure.dpi,
        metadata={"Software": f"tgvdp {provenance['tgvdp']}", "Comment": about},
        pil_kwargs={"compress_level": _COMPRESSION},
    )
    return buffer.getvalue()
