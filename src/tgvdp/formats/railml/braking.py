"""Full braking of railML trains as decelerations: a table over speed, or one number.

Source: the published documentation of the schema.
"""

import math
from itertools import pairwise

from tgvdp.formats.railml.table import ACCELERATION, TABLES, Table, read_table
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.train import BrakingRate

#: Steps that stand for a line between two decelerations are this close to it, as a share of the deceleration.
_STEP = 0.02
_MOST_STEPS = 50


def brakes_of(train: Node) -> list[Node]:
    """Elements that say how a train brakes; those of a vehicle are in boxes."""
    boxes = train.children("trainBrakes", "brakes", "vehicleBrakes")
    return [*boxes, *(one for box in boxes for one in box.children("vehicleBrakes", "vehicleBrake"))]


def braking_rates(train: Node, brakes: list[Node], top_mps: float) -> tuple[tuple[BrakingRate, ...], list[str]]:
    """Deceleration of full braking, and what to say of it.

    That of a table, else the mean one, else the largest; of several numbers the least.

    Parameters
    ----------
    train : Node
    brakes : list of Node
        As `brakes_of` finds them.
    top_mps : float
        Speed up to which the last polynomial of a table counts.

    Raises
    ------
    InputError
        When a deceleration is not above 0, or a table is incomplete.
    """
    holders = [holder for one in (train, *brakes) for holder in one.children("decelerationTable")]
    tables = [table for one in holders for table in one.children(*TABLES)]
    if len(tables) > 1:
        raise tables[1].bad("a second decelerationTable; one is expected")
    if tables:
        table = read_table(tables[0], ACCELERATION, top_mps)
        return _stepped(tables[0], table), ["full braking is decelerationTable, in steps below it", *table.notes]
    for attribute in ("meanDeceleration", "maxDeceleration"):
        rates_mps2 = {one.number(attribute, "m/s²", above=0.0): one.name for one in brakes}
        known_mps2 = sorted(rate_mps2 for rate_mps2 in rates_mps2 if rate_mps2 is not None)
        if known_mps2:
            others = f", the least of {len(known_mps2)}" if len(known_mps2) > 1 else ""
            name = rates_mps2[known_mps2[0]]
            note = f"full braking is {name}@{attribute}, {known_mps2[0]:g} m/s²{others}"
            return (BrakingRate(0.0, known_mps2[0]),), [note]
    return (), []


def _stepped(node: Node, table: Table) -> tuple[BrakingRate, ...]:
    """Steps below the lines between the points of a table, so that no braking is stronger than the train's."""
    least_mps2 = min(rate_mps2 for _, rate_mps2 in table.points)
    if not least_mps2 > 0.0:
        raise node.bad(f"decelerations must be above 0 m/s², got {least_mps2:g} m/s²")
    rates: list[BrakingRate] = []
    for (from_mps, first), (to_mps, last) in pairwise([*table.points, (math.inf, table.points[-1][1])]):
        count = min(max(math.ceil(abs(last - first) / (_STEP * max(first, last))), 1), _MOST_STEPS)
        for index in range(count) if to_mps > from_mps else ():
            share = index / count
            at_mps = from_mps + share * (to_mps - from_mps) if index else from_mps
            rate_mps2 = first + (last - first) * (share if last >= first else share + 1.0 / count)
            rates.append(BrakingRate(at_mps if rates else 0.0, rate_mps2))
    return tuple(rates)
