"""What strangers may take of the machine that serves the page."""

from dataclasses import dataclass

from tgvdp.formats.syntax.reading import LARGEST_BYTES


@dataclass(frozen=True)
class Limits:
    """Limits of the server; a test may make them small.

    Attributes
    ----------
    upload_b, request_b : int
        Size of an uploaded file, that of the readers, and of any other request, B.
    uploads : int
        Files that are kept; the oldest ones go.
    reading_s : float
        Time for reading an uploaded file, s.
    running_s : float
        Time for a run, its proof included, s; a run has its own time limit, which may not be above it.
    memory_b : float
        Address space of a child process, B; libraries and kernels take 0.5 GB of that.
    runs_at_once, runs_queued, runs_kept : int
        Runs that are computed at a time, that wait, and whose results are kept; the oldest ones that were run from the
        page go.
    """

    upload_b: int = LARGEST_BYTES
    request_b: int = 100_000
    uploads: int = 20
    reading_s: float = 30.0
    running_s: float = 600.0
    memory_b: float = 4e9
    runs_at_once: int = 2
    runs_queued: int = 20
    runs_kept: int = 30
