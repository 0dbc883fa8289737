"""The data set of a sweep: Parquet and CSV in the order of the spec, the same bytes whoever solved what and when."""

import contextlib
import itertools
import os
import shutil
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import Any

from tgvdp.sweeps.columns import ROWS, Block, row_columns, scenario_columns, timing_columns
from tgvdp.sweeps.journal import Journal
from tgvdp.sweeps.spec import SweepSpec

#: Versioned schema of each table, in the metadata of its files.
SCHEMAS = {"scenarios": "tgvdp.sweep-scenarios/2"} | {name: f"tgvdp.sweep-{name}/1" for name in (*ROWS, "timings")}
#: Scenarios of a group of rows, which is all that is in memory, and groups of a file.
_GROUP, _GROUP_WITH_PROFILES, _GROUPS = 1000, 10, 100


def write_tables(spec: SweepSpec, journal: Journal, parts: Path, out: Path) -> list[Path]:
    """Write all tables of a sweep from its journal and part files.

    Returns
    -------
    list of Path
        The files.
    """
    drafts = out / ".tables.tmp"
    shutil.rmtree(drafts, ignore_errors=True)
    drafts.mkdir(parents=True)
    columns_of = {"scenarios": scenario_columns(spec), "timings": timing_columns}
    columns_of |= {kind: row_columns(parts, kind) for kind in ROWS}
    files: dict[str, list[_Parquet | _Csv]] = {name: [_Parquet(drafts, name)] for name in columns_of}
    if spec.csv:
        for name in ("scenarios", *ROWS):
            files[name].append(_Csv(drafts / f"{name}.csv"))
    try:
        with ThreadPoolExecutor() as threads:
            writing: list[Future[None]] = []
            for block in _blocks(spec, journal):
                made = {name: columns(block) for name, columns in columns_of.items()}
                _wait(writing)
                writing = [
                    threads.submit(file.write, table.replace_schema_metadata({"schema": SCHEMAS[name]}))
                    for name, table in made.items()
                    if table is not None
                    for file in files[name]
                ]
            _wait(writing)
        for file in itertools.chain(*files.values()):
            file.close()
        return _moved(drafts, out)
    finally:
        for file in itertools.chain(*files.values()):
            with contextlib.suppress(OSError):  # where the disk is full, which the error under way says
                file.close()
        shutil.rmtree(drafts, ignore_errors=True)


def load_writers() -> None:
    """Load what writes tables, so that nobody waits for it at the end."""
    for name in ("parquet", "csv", "compute"):
        import_module(f"pyarrow.{name}")


def _wait(writing: Iterable[Future[None]]) -> None:
    """Have a block written: the files side by side, and while the next one is made; raises what went wrong."""
    for one in writing:
        one.result()


def _blocks(spec: SweepSpec, journal: Journal) -> Iterator[Block]:
    finished = journal.finished()
    size = _GROUP if spec.profiles_every_m is None else _GROUP_WITH_PROFILES
    while chunk := list(itertools.islice(finished, size)):
        yield Block([spec[one.number] for one in chunk], chunk)


def _moved(drafts: Path, out: Path) -> list[Path]:
    """Put finished tables in the place of earlier ones."""
    for name in (f"{table}{suffix}" for table in SCHEMAS for suffix in ("", ".parquet", ".csv")):
        target = out / name
        if target.is_dir():
            shutil.rmtree(target)
        else:
            target.unlink(missing_ok=True)
        if (drafts / name).exists():
            os.replace(drafts / name, target)
    found = [out / f"{table}{suffix}" for table in SCHEMAS for suffix in (".parquet", ".csv")]
    found += [file for table in SCHEMAS for file in sorted((out / table).glob("*.parquet"))]
    return [file for file in found if file.exists()]


class _Parquet:
    """A table that is written a block at a time, a group of rows each: one file, or of rows many in a folder."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder, self._name = folder, name
        self._writer: Any = None
        self._groups = 0

    def write(self, table: Any) -> None:
        """Write the rows of a block."""
        if self._writer is None or (self._name in ROWS and self._groups % _GROUPS == 0):
            self._next_file(table.schema)
        self._writer.write_table(table, row_group_size=max(table.num_rows, 1))
        self._groups += 1

    def _next_file(self, schema: Any) -> None:
        self.close()
        path = self._folder / f"{self._name}.parquet"
        if self._name in ROWS:
            path = self._folder / self._name / f"{self._groups // _GROUPS:04d}.parquet"
            path.parent.mkdir(exist_ok=True)
        self._writer = import_module("pyarrow.parquet").ParquetWriter(path, schema, use_dictionary=_texts(schema))

    def close(self) -> None:
        """Finish the file."""
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.close()


def _texts(schema: Any) -> list[str]:
    """Columns whose values come again: looking for equal ones among figures takes twice as long as writing them."""
    types = import_module("pyarrow").types
    return [one.name for one in schema if types.is_dictionary(one.type) or types.is_string(one.type)]


class _Csv:
    """The same as CSV."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer: Any = None

    def write(self, table: Any) -> None:
        """Write the rows of a block."""
        arrow, csv = import_module("pyarrow"), import_module("pyarrow.csv")
        plain = arrow.table(
            {
                name: column.cast(arrow.string()) if arrow.types.is_dictionary(column.type) else column
                for name, column in zip(table.column_names, table.columns, strict=True)
            }
        )
        if self._writer is None:
            self._writer = csv.CSVWriter(
                self._path, plain.schema, write_options=csv.WriteOptions(quoting_style="needed")
            )
        self._writer.write_table(plain)

    def close(self) -> None:
        """Finish the file."""
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.close()
