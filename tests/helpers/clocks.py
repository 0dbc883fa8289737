"""Budgets whose time is up at a known point of the work, however fast the machine is."""

from tgvdp.certificate.line_maker import LineMaker
from tgvdp.methods.budget import Clock, SearchBudget


class LooksAtTheClock(SearchBudget):
    """A budget that is its own clock, and whose time is up when that has been looked at so often."""

    def __init__(self, looks):
        super().__init__()
        object.__setattr__(self, "looks", looks)

    def start(self, elapsed_s=0.0):
        return self

    @property
    def expired(self):
        object.__setattr__(self, "looks", self.looks - 1)
        return self.looks < 0

    @property
    def elapsed_s(self):
        return 0.0

    @property
    def limit_s(self):
        return self.time_limit_s

    def part(self, share):
        return self

    def left_s(self):
        return 1.0 if self.looks > 0 else 0.0


def expire_after_lines(monkeypatch, count):
    """Have the time of a certificate be up when so many of its lines are made."""
    make, made = LineMaker._line, []

    def counted(maker, *wanted):
        made.append(wanted)
        return make(maker, *wanted)

    monkeypatch.setattr(LineMaker, "_line", counted)
    monkeypatch.setattr(Clock, "expired", property(lambda clock: len(made) >= count))
