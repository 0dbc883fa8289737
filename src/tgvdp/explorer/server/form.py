"""The form of a run: made from the one declaration of options."""

from typing import Any

from tgvdp.explorer.compute.asked import OFFERED
from tgvdp.model import catalog
from tgvdp.options.option import Option


def form() -> dict[str, Any]:
    """Trains, lines and options that a run may have."""
    return {
        "trains": catalog.names("train"),
        "tracks": catalog.names("track"),
        "maps": catalog.names("map"),
        "options": [_field(name, one) for name, one in OFFERED.items()],
    }


def _field(name: str, one: Option) -> dict[str, Any]:
    """One option as a field of a form; its unit is that of people."""
    return {
        "name": name,
        "label": one.name.replace("-", " "),
        "help": one.help,
        "heading": one.heading,
        "unit": "" if one.read else one.unit,
        "kind": "list" if one.repeatable else "text" if one.read else _kind(one),
        "choices": one.choices,
        "is_open": one.open,
        "methods": one.methods,
        "default": one.shown_value,
        "placeholder": one.metavar if one.read else one.shown_default,
        "least": one.at_least if one.above is None else one.above,
        "most": one.at_most,
        "excludes": [other for other in OFFERED if OFFERED[other].argument in one.excludes],
    }


def _kind(one: Option) -> str:
    if one.choices:
        return "choice"
    return {bool: "switch", int: "whole", float: "number"}[one.kind]
