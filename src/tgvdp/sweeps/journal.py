"""What is done: a SQLite file that survives whatever is killed, with one row per thing to solve.

A row is told by its key, so that a sweep that is extended finds again what it has, and one of another engine finds
nothing; scenarios that are the same but in name share one. The write-ahead log is synced with every commit, and the
file is locked as long as somebody writes.
"""

import contextlib
import heapq
import itertools
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from tgvdp.errors import InputError
from tgvdp.sweeps.work import Record

SCHEMA = "tgvdp.sweep-journal/2"
_TABLES = """
CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE scenario (
    id INTEGER PRIMARY KEY,
    key BLOB NOT NULL UNIQUE,
    number INTEGER,
    status TEXT,
    error TEXT,
    fastest_time_s REAL,
    fastest_energy_j REAL,
    points INTEGER,
    part INTEGER,
    elapsed_s REAL,
    cpu_s REAL,
    worker TEXT
);
CREATE UNIQUE INDEX by_number ON scenario (number) WHERE number IS NOT NULL;
CREATE TABLE again (number INTEGER PRIMARY KEY, id INTEGER NOT NULL);
"""
_CHUNK = 10_000
#: What SQLite's errors are called where a disk is full.
_NO_ROOM = ("SQLITE_FULL", "SQLITE_IOERR")


class Finished(NamedTuple):
    """A row of the journal: what came of a scenario, and the part file that holds its points; None where it has none.

    ``status`` is None as long as the scenario is to be done.
    """

    id: int
    key: bytes
    number: int
    status: str | None
    error: str | None
    fastest_time_s: float | None
    fastest_energy_j: float | None
    points: int | None
    part: int | None
    elapsed_s: float | None
    cpu_s: float | None
    worker: str | None


class Journal:
    """The journal of a sweep.

    Parameters
    ----------
    path : Path
        Made when absent.

    Raises
    ------
    InputError
        When somebody else writes it, or it is none.
    sqlite3.Error
        When the disk is full.
    """

    def __init__(self, path: Path) -> None:
        is_new = not path.exists()
        self._database = sqlite3.connect(path, timeout=0.0, isolation_level=None)
        try:
            self._database.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.execute("PRAGMA synchronous = FULL")
            if is_new or not self._database.execute("SELECT name FROM sqlite_master").fetchone():
                self._database.executescript(f"BEGIN IMMEDIATE; {_TABLES} COMMIT;")
                self.note("schema", SCHEMA)
            held = self.noted("schema")
        except sqlite3.DatabaseError as error:
            self.close()
            if error.sqlite_errorname.startswith(_NO_ROOM):
                if is_new:
                    path.unlink(missing_ok=True)
                raise
            busy = "locked" in str(error)
            what = "another sweep is writing here" if busy else f"is no journal of a sweep: {error}"
            raise InputError(f"{path}: {what}") from None
        if held != SCHEMA:
            raise InputError(f"{path}: is of schema {held}, this version knows {SCHEMA}")

    def close(self) -> None:
        """Give the file back."""
        self._database.close()

    def noted(self, name: str) -> str | None:
        """What was noted about the sweep."""
        row = self._database.execute("SELECT value FROM about WHERE name = ?", (name,)).fetchone()
        return None if row is None else str(row[0])

    def note(self, name: str, value: str) -> None:
        """Note something about the sweep."""
        self._database.execute("INSERT OR REPLACE INTO about VALUES (?, ?)", (name, value))

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[None]:
        self._database.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            with contextlib.suppress(sqlite3.Error):  # where the disk is full, it is rolled back already
                self._database.execute("ROLLBACK")
            raise
        self._database.execute("COMMIT")

    def holds(self, plan: str) -> bool:
        """Whether the scenarios of a plan are in."""
        return self.noted("plan") == plan

    def enrol(self, keys: Iterable[bytes], plan: str) -> None:
        """Take in the scenarios of a plan, by their numbers; of equal ones the first is solved for all.

        What was done of them before stays done. A plan that is in already is not taken in again.
        """
        if self.holds(plan):
            return
        with self._transaction():
            self._database.execute("UPDATE scenario SET number = NULL WHERE number IS NOT NULL")
            self._database.execute("DELETE FROM again")
            numbered = enumerate(keys)
            while chunk := [(key, number) for number, key in itertools.islice(numbered, _CHUNK)]:
                self._database.executemany(
                    "INSERT INTO scenario (key, number) VALUES (?, ?) ON CONFLICT (key)"
                    " DO UPDATE SET number = excluded.number WHERE number IS NULL",
                    chunk,
                )
                self._database.executemany(
                    "INSERT INTO again SELECT ?2, id FROM scenario WHERE key = ?1 AND number <> ?2", chunk
                )
            self.note("plan", plan)

    def forget(self, statuses: Sequence[str]) -> None:
        """Have scenarios of some states done again."""
        marks = ", ".join("?" * len(statuses))
        self._database.execute(f"UPDATE scenario SET status = NULL, error = NULL WHERE status IN ({marks})", statuses)

    def pending(self) -> Iterator[tuple[int, int]]:
        """Ids and numbers of what is to be done, by number; rows may be changed meanwhile."""
        yield from self._rows(("id", "number"), "scenario WHERE status IS NULL", "number")

    def finished(self) -> Iterator[Finished]:
        """All scenarios of the plan, by number, done or not; of equal ones each, with what came of the first."""
        first = self._rows(Finished._fields, "scenario WHERE TRUE", "number")
        others = self._rows(Finished._fields, "again JOIN scenario USING (id) WHERE TRUE", "again.number")
        by_number = itemgetter(Finished._fields.index("number"))
        yield from map(Finished._make, heapq.merge(first, others, key=by_number))

    def _rows(self, fields: Sequence[str], source: str, number: str) -> Iterator[tuple[Any, ...]]:
        last, at = -1, fields.index("number")
        columns = ", ".join(number if field == "number" else field for field in fields)
        query = f"SELECT {columns} FROM {source} AND {number} > ? ORDER BY {number} LIMIT {_CHUNK}"
        while rows := self._database.execute(query, (last,)).fetchall():
            yield from rows
            last = rows[-1][at]

    def counts(self) -> dict[str | None, int]:
        """How many scenarios of the plan have each status."""
        query = "SELECT status, count(*) FROM scenario WHERE number IS NOT NULL GROUP BY status"
        return dict(self._database.execute(query).fetchall())

    def is_blank(self) -> bool:
        """Whether no scenario has come to an end yet, of this plan or another one."""
        return self._database.execute("SELECT 1 FROM scenario WHERE status IS NOT NULL").fetchone() is None

    def errors(self, most: int) -> list[tuple[int, str, str]]:
        """Numbers, states and errors of the first scenarios of the plan that have one."""
        query = "SELECT number, status, error FROM scenario WHERE number IS NOT NULL AND error IS NOT NULL"
        return self._database.execute(f"{query} ORDER BY number LIMIT ?", (most,)).fetchall()

    def next_part(self) -> int:
        """Number of a part file that nothing refers to."""
        (last,) = self._database.execute("SELECT coalesce(max(part), -1) FROM scenario").fetchone()
        return int(last) + 1

    def commit(self, records: Sequence[Record], part: int) -> None:
        """Keep what came of tasks whose points are in a part file; on disk when this returns."""
        rows = [
            (
                record.status,
                record.error,
                record.fastest_time_s,
                record.fastest_energy_j,
                None if record.front is None else len(record.front.time_s),
                None if record.front is None else part,
                record.elapsed_s,
                record.cpu_s,
                record.worker,
                record.id,
            )
            for record in records
        ]
        with self._transaction():
            self._database.executemany(
                "UPDATE scenario SET status = ?, error = ?, fastest_time_s = ?, fastest_energy_j = ?, points = ?,"
                " part = ?, elapsed_s = ?, cpu_s = ?, worker = ? WHERE id = ?",
                rows,
            )
