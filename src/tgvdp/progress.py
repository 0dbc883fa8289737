"""How far a long computation is: whoever computes tells, and whoever wants to know listens."""

import contextlib
from collections.abc import Iterator
from contextvars import ContextVar
from typing import Protocol


class Listener(Protocol):
    """Hears how far a computation is; it may raise an error to end it."""

    def __call__(self, stage: str, done: float | None = None, total: float | None = None, **counters: int) -> None:
        """Take what is being done, how much of how much of it is, where that is known, and what was counted."""


_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextlib.contextmanager
def heard_by(listener: Listener | None) -> Iterator[None]:
    """Have a listener, or nobody, hear what is computed meanwhile."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def tell(stage: str, done: float | None = None, total: float | None = None, **counters: int) -> None:
    """Tell how far a computation is, a few times per second; without a listener it costs nothing."""
    listener = _listener.get()
    if listener is not None:
        listener(stage, done, total, **counters)
