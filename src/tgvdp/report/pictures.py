"""Figures as files: PNG, SVG and PDF, each with the provenance in its metadata."""

import io
import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.errors import InputError
from tgvdp.report.plain import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tgvdp.api import SearchResult

#: Of a search.
PICTURES = ("front", "profile", "speed_time", "effort", "price")
PICTURE_FORMATS = ("png", "svg", "pdf")
#: Effort of zlib: the usual 6 takes 1.5 times as long for files that are 8 % smaller.
_COMPRESSION = 3
#: Letters are embedded as outlines in SVG and as TrueType in PDF (Type 3 fonts are refused by many publishers), and the
#: same figure gives the same file.
_SETTINGS: Any = {"svg.fonttype": "path", "svg.hashsalt": "tgvdp", "pdf.fonttype": 42}


def pictures_of(result: "SearchResult") -> list[str]:
    """Names of the pictures that a result has: only method ``front`` knows prices."""
    return [name for name in PICTURES if name != "price" or result.price_kwh_per_min is not None]


def check_formats(formats: Sequence[str]) -> None:
    """Refuse formats that are not known.

    Raises
    ------
    InputError
        When there is one.
    """
    if unknown := next((word for word in formats if word not in PICTURE_FORMATS), None):
        raise InputError(f"pictures: there is no format {unknown!r:.20}; there are {', '.join(PICTURE_FORMATS)}")


def encode(figure: "Figure", provenance: Mapping[str, Any], format: str = "png") -> bytes:
    """Picture of a figure as a file of a format, with the provenance in its metadata.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    provenance : mapping
        As `make_provenance` returns it.
    format : {"png", "svg", "pdf"}
    """
    import matplotlib

    maker = f"tgvdp {provenance.get('tgvdp', '')}".rstrip()
    about = json.dumps(plain(provenance), ensure_ascii=True)
    metadata: dict[str, dict[str, Any]] = {
        "png": {"Software": maker, "Comment": about},
        "svg": {"Creator": maker, "Description": about, "Date": None},
        "pdf": {"Creator": maker, "Keywords": about, "CreationDate": None},
    }
    options: Any = {"pil_kwargs": {"compress_level": _COMPRESSION}} if format == "png" else {}
    buffer = io.BytesIO()
    with matplotlib.rc_context(_SETTINGS):
        figure.savefig(buffer, format=format, dpi=figure.dpi, metadata=metadata[format], **options)
    return buffer.getvalue()
