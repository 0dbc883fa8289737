"""One published instance, and what families of them are made with."""

import hashlib
import json
import random
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tgvdp.formulations.problem.instances import Instance
from tgvdp.formulations.problem.reading import parse_instance


class Entry(NamedTuple):
    """One published instance."""

    family: str
    name: str
    params: dict[str, Any]

    @property
    def content(self) -> bytes:
        """The file."""
        return (json.dumps({"id": self.name, "params": self.params}, indent=1) + "\n").encode()

    @property
    def sha256(self) -> str:
        """Digest of the file."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def instance(self) -> Instance:
        """The instance as a reader of the file gets it."""
        return parse_instance(Path(f"{self.name}.json"), json.loads(self.content))


class Draw:
    """Whole numbers from a seed, by the one function of `random` that is promised to stay the same."""

    def __init__(self, seed: str) -> None:
        self._random = random.Random(seed).random

    def whole(self, low: int, high: int) -> int:
        """One of low..high, each as likely."""
        return low + int(self._random() * (high - low + 1))


def farthest(steps: int, caps: list[float]) -> int:
    """Longest distance from stop to stop in unit steps within caps."""
    reach = np.array([0, *(int(cap) for cap in caps[:-1]), 0])
    for k in range(1, steps + 1):
        reach[k] = min(reach[k], reach[k - 1] + 1)
    for k in range(steps - 1, -1, -1):
        reach[k] = min(reach[k], reach[k + 1] + 1)
    return int(reach.sum())
