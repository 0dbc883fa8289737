"""Neutral sections of railML 3.2 and 3.3 under a run: insulated sections that are passed without drawing current.

Source: the published documentation of the schema.
"""

from tgvdp.formats.railml.path import NetPath
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import NeutralSection

ELECTRIFIED = ("infrastructure", "functionalInfrastructure", "electrifications", "electrificationSection")
_SEPARATIONS = ("phaseSeparationSection", "systemSeparationSection")


def neutral_sections(path: NetPath, root: Node) -> list[tuple[NeutralSection, int]]:
    """Stretches of the run on which the main breaker is switched off, or pantographs are lowered."""
    found = path.ground([node for node in root.below(*ELECTRIFIED) if is_neutral(node)])
    return [
        (NeutralSection(one.from_m, one.to_m - one.from_m, _orders(one.node, "lowerPantograph")), one.node.line)
        for one in found
    ]


def is_neutral(section: Node) -> bool:
    """Whether all of a section is neutral; a separation somewhere in a section that is not insulated has no place."""
    ordered = _orders(section, "switchOffBreaker") or _orders(section, "lowerPantograph")
    return section.flag("isInsulatedSection") is True and ordered


def _orders(section: Node, name: str) -> bool:
    return any(one.flag(name) is True for one in section.children(*_SEPARATIONS))
