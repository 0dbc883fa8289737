"""A sweep with files: what is done is kept, what is not is solved, and at the end the tables are made."""

import contextlib
import hashlib
import shutil
import sqlite3
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.errors import InputError
from tgvdp.report.files import made_folder, write_files
from tgvdp.report.plain import to_json
from tgvdp.report.provenance import make_provenance
from tgvdp.sweeps.batches import Batches
from tgvdp.sweeps.cluster import Cluster, dashboard_of, started
from tgvdp.sweeps.columns import ROWS
from tgvdp.sweeps.engine import Engine
from tgvdp.sweeps.journal import Journal
from tgvdp.sweeps.parts import write_part
from tgvdp.sweeps.scenario import Task, engine_version, task_of
from tgvdp.sweeps.spec import SweepSpec
from tgvdp.sweeps.tables import load_writers, write_tables
from tgvdp.sweeps.work import Record

if TYPE_CHECKING:
    from distributed import Client

#: Folder, within that of the results, of what a sweep needs to go on.
WORK = "work"
JOURNAL = "journal.sqlite"
SCHEMA = "tgvdp.sweep/1"
_ERRORS = 20
#: What may come out better on another machine or another day.
_UNSATISFYING = ("partial", "failed", "killed")
#: Time between two commits, s: what a killed driver loses at most.
COMMIT_S = 1.0
#: Rows, of profiles mostly, that are not held any longer.
_MOST_ROWS = 500_000


@dataclass
class Progress:
    """How far a sweep is.

    Attributes
    ----------
    total, done, failed : int
        Scenarios; done counts all that are finished, failed ones too.
    started_with : int
        Of these, what an earlier run had done.
    started_s : float
        By `time.perf_counter`.
    dashboard : str
        Address of Dask's dashboard; empty where there is none.
    """

    total: int
    done: int
    failed: int
    started_with: int
    started_s: float
    dashboard: str = ""

    @property
    def per_second(self) -> float:
        """Scenarios of this run per second."""
        return (self.done - self.started_with) / max(time.perf_counter() - self.started_s, 1e-9)

    @property
    def left_s(self) -> float | None:
        """Time that is left at this pace, s."""
        return None if self.done == self.started_with else (self.total - self.done) / self.per_second


class Outcome(NamedTuple):
    """What a sweep came to.

    Attributes
    ----------
    content : dict
        ``schema``; ``scenarios`` of the spec, ``distinct`` ones, and of these those ``done``, ``partial``, ``failed``
        and ``killed``, those done ``earlier``; ``files``.
    errors : list of str
        What went wrong first.
    """

    content: dict[str, Any]
    errors: list[str]


def run_sweep(
    spec: SweepSpec,
    out: Path,
    cluster: Cluster,
    *,
    resume: bool = False,
    retry: bool = False,
    told: Callable[[Progress], object] = bool,
) -> Outcome:
    """Run a sweep, or what is left of it, and write its tables.

    Parameters
    ----------
    spec : SweepSpec
    out : Path
        Folder; made when absent.
    cluster : Cluster
    resume : bool
        Go on with what the folder holds.
    retry : bool
        Solve again what failed, was killed or ended by its budget.
    told : callable
        Told now and then how far it is.

    Returns
    -------
    Outcome

    Raises
    ------
    InputError
        When the folder holds a sweep and `resume` is not asked for, or it cannot be written.
    """
    work = out / WORK
    if (work / JOURNAL).exists() and not resume:
        raise InputError(f"{out}: holds a sweep already: --resume goes on with it")
    if not work.exists() and out.is_dir() and any(out.iterdir()):
        raise InputError(f"{out}: is not empty, and no sweep is in it")
    try:
        with made_folder(work), _opened(work) as journal:
            if retry:
                journal.forget(_UNSATISFYING)
            progress = _solved(spec, journal, work, cluster, told)
            files = write_tables(spec, journal, work, out)
            outcome = _outcome(spec, journal, progress, files, out)
            write_files(out, {"provenance.json": to_json(_provenance(spec, outcome, progress))})
            return outcome
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror or error}") from error
    except sqlite3.Error as error:
        raise InputError(f"{out}: cannot be written: {error}") from error


@contextlib.contextmanager
def _opened(work: Path) -> Iterator[Journal]:
    """The journal of a sweep; one that holds nothing goes again, as where no scheduler answers or the disk is full."""
    journal = Journal(work / JOURNAL)
    try:
        yield journal
    finally:
        is_blank = journal.is_blank()
        journal.close()
        if is_blank:
            _leave(work)


def _leave(work: Path) -> None:
    """Take away what holds nothing yet: the same command begins anew."""
    with contextlib.suppress(OSError):  # there are other files
        for kind in ROWS:
            shutil.rmtree(work / kind, ignore_errors=True)
        (work / JOURNAL).unlink()
        work.rmdir()


def _plan(spec: SweepSpec, engine: str) -> str:
    """What decides which scenarios there are, and their keys."""
    parts = [engine, spec.text, *(part.digest for part in (*spec.trains, *spec.lines)), *spec.tables.settled.values()]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _provenance(spec: SweepSpec, outcome: "Outcome", progress: Progress) -> dict[str, Any]:
    """Where the tables come from: the spec as it was, and the fingerprints of all that it names."""
    parts = {f"train {part.name}": part for part in spec.trains} | {f"line {part.name}": part for part in spec.lines}
    inputs = {role: {"file": part.file, "sha256": part.sha256} for role, part in parts.items()} | spec.tables.provenance
    about = make_provenance({"spec": spec.text}, inputs, time.perf_counter() - progress.started_s)
    return {"schema": "tgvdp.provenance/1", **about, "engine": engine_version(), "sweep": outcome.content}


def _outcome(spec: SweepSpec, journal: Journal, progress: Progress, files: list[Path], out: Path) -> Outcome:
    counts = journal.counts()
    content = {
        "schema": SCHEMA,
        "scenarios": len(spec),
        "distinct": progress.total,
        **{status: counts.get(status, 0) for status in ("done", "partial", "failed", "killed")},
        "earlier": progress.started_with,
        "files": [file.relative_to(out).as_posix() for file in files],
    }
    errors = [f"scenario {number} {status}: {error}" for number, status, error in journal.errors(_ERRORS)]
    return Outcome(content, errors)


def _solved(
    spec: SweepSpec, journal: Journal, work: Path, cluster: Cluster, told: Callable[[Progress], object]
) -> Progress:
    """Enrol the scenarios and load what writes tables while workers come, and solve what is pending."""
    engine = engine_version()
    plan = _plan(spec, engine)
    if journal.holds(plan) and not journal.counts().get(None):
        return _progress(journal)
    with started(cluster) as connect:
        journal.enrol((scenario.key(engine) for scenario in spec), plan)
        load_writers()
        progress = _progress(journal)
        if progress.done < progress.total:
            _solve(spec, journal, work, connect(), progress, told)
    return progress


def _progress(journal: Journal) -> Progress:
    """How far a sweep is as it starts."""
    counts = journal.counts()
    total = sum(counts.values())
    done = total - counts.get(None, 0)
    return Progress(total, done, counts.get("failed", 0) + counts.get("killed", 0), done, time.perf_counter())


def _solve(
    spec: SweepSpec,
    journal: Journal,
    work: Path,
    client: "Client",
    progress: Progress,
    told: Callable[[Progress], object],
) -> None:
    """Solve what is pending, and keep and tell how far it is."""
    pending = progress.total - progress.done
    taken = 0

    def tasks() -> Iterator[Task]:
        nonlocal taken
        for id, number in journal.pending():
            taken += 1
            yield task_of(spec[number], id)

    progress.dashboard = dashboard_of(client)
    progress.started_s = time.perf_counter()
    keeper = _Keeper(journal, work)
    try:
        for records in Engine(client, Batches(tasks(), lambda: pending - taken)).records():
            keeper.keep(records)
            progress.done += len(records)
            progress.failed += sum(record.status in ("failed", "killed") for record in records)
            told(progress)
    finally:
        keeper.commit()


class _Keeper:
    """Keeps records, together those of a moment: one part file, one commit."""

    def __init__(self, journal: Journal, work: Path) -> None:
        self._journal, self._work = journal, work
        self._part = journal.next_part()
        self._held: list[Record] = []
        self._rows = 0
        self._since_s = time.perf_counter()

    def keep(self, records: list[Record]) -> None:
        """Keep records, soon."""
        self._held += records
        self._rows += sum(record.rows for record in records)
        if time.perf_counter() - self._since_s >= COMMIT_S or self._rows >= _MOST_ROWS:
            self.commit()

    def commit(self) -> None:
        """Keep now what is held: the rows first, then that they are there."""
        self._since_s = time.perf_counter()
        if self._held:
            write_part(self._work, self._part, self._held)
            self._journal.commit(self._held, self._part)
            self._held, self._rows = [], 0
            self._part += 1
