"""Tasks of batches: as many as take about as long as is worth a message, by the processor time that their like took."""

from collections.abc import Callable, Iterator

from tgvdp.sweeps.scenario import Task

#: What a batch should take at least, s: long against a message, short against a lost worker.
BATCH_S = 1.0
#: What a batch costs the driver, s (docs/sweeps.md), and the share of its time that may be: many workers get long ones.
_MESSAGE_S, _MESSAGES = 0.008, 0.25
#: Batches that each worker should still get, so that all of them end together, and what the last ones take, s.
_LAST, _LAST_S = 2, 0.05
_MOST = 2000
#: Weight of the newest figure.
_NEWEST = 0.3


class Pace:
    """Measured cost of tasks, by their lines."""

    def __init__(self) -> None:
        self._by_line: dict[int, float] = {}
        self._mean_s: float | None = None

    def observe(self, task: Task, elapsed_s: float) -> None:
        """Take note of what a task took, s."""
        line = id(task.track)
        self._by_line[line] = _blended(self._by_line.get(line), elapsed_s)
        self._mean_s = _blended(self._mean_s, elapsed_s)

    def cost_s(self, task: Task) -> float:
        """What a task may take, s: as those of its line, or as all; a batch of its own as long as nothing is known."""
        return self._by_line.get(id(task.track), BATCH_S if self._mean_s is None else self._mean_s)

    @property
    def mean_s(self) -> float | None:
        """What a task takes of late, s."""
        return self._mean_s


def _blended(known_s: float | None, newest_s: float) -> float:
    return newest_s if known_s is None else (1.0 - _NEWEST) * known_s + _NEWEST * newest_s


class Batches:
    """Takes tasks from an iterator, a batch at a time.

    Parameters
    ----------
    tasks : iterator of Task
    left : callable
        Number of tasks that are still to be taken, or None where nobody knows.
    """

    def __init__(self, tasks: Iterator[Task], left: Callable[[], int | None]) -> None:
        self.pace = Pace()
        self._tasks = tasks
        self._left = left

    def take(self, workers: int) -> list[Task]:
        """Next batch for one of so many workers; empty at the end."""
        most_s = max(BATCH_S, workers * _MESSAGE_S / _MESSAGES)
        left, mean_s = self._left(), self.pace.mean_s
        if left is not None and mean_s is not None:
            most_s = min(most_s, max(left * mean_s / (_LAST * max(workers, 1)), _LAST_S))
        batch: list[Task] = []
        total_s = 0.0
        for task in self._tasks:
            batch.append(task)
            total_s += self.pace.cost_s(task)
            if total_s >= most_s or len(batch) >= _MOST:
                break
        return batch
