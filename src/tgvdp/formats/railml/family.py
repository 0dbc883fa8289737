"""Vehicles of railML that say only what sets them apart from another one, their family or template.

Source: the documentation in the schema of 2.4, and the published one of 3.2 and 3.3.
"""

from collections.abc import Mapping
from copy import deepcopy

from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node

#: Attributes that name the family, in 2.x, 3.2 and 3.3.
_REFERENCES = ("vehicleFamilyRef", "belongsToParent", "basedOnTemplate")


def family_of(vehicle: Node) -> str | None:
    """Id of the vehicle that gives what one does not say itself, None without."""
    return next((vehicle.text(name) for name in _REFERENCES if vehicle.has(name)), None)


def whole(vehicle: Node, known: Mapping[str | None, Node]) -> Node:
    """Put a vehicle and its family together: own attributes and elements go before those of the same name.

    Parameters
    ----------
    vehicle : Node
    known : mapping of str to Node
        All vehicles of the file by their ids.

    Raises
    ------
    InputError
        When a family is not in the file, or is its own.
    """
    chain = [vehicle]
    while (name := family_of(chain[-1])) is not None:
        family = known.get(name)
        if family is None or any(family.element is one.element for one in chain):
            attribute = next(one for one in _REFERENCES if chain[-1].has(one))
            lack = "no vehicle" if family is None else "is its own family, by way of others or not:"
            raise chain[-1].bad(f"{lack} {shown(name)}{' in this file' if family is None else ''}", attribute)
        chain.append(family)
    if len(chain) == 1:
        return vehicle
    element = deepcopy(chain[-1].element)
    for one in chain[-2::-1]:
        element.attrib.update(one.element.attrib)
        own = [deepcopy(child) for child in one.element]
        for child in [child for child in element if child.tag in {other.tag for other in own}]:
            element.remove(child)
        element.extend(own)
    return Node(vehicle.path, element, vehicle.seen).read()
