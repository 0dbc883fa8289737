"""The data set of a sweep: Parquet and CSV in the order of the spec, the same bytes whoever solved what and when."""

import itertools
import os
import shutil
from collections.abc import Callable, Iterator
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
    try:
        tables = [_Table(drafts, "scenarios", scenario_columns(spec), many=False, csv=spec.csv)]
        tables.append(_Table(drafts, "timings", timing_columns, many=False, csv=False))
        tables += [_Table(drafts, kind, row_columns(parts, kind), csv=spec.csv) for kind in ROWS]
        for block in _blocks(spec, journal):
            for table in tables:
                table.add(block)
        for table in tables:
            table.close()
        return _moved(drafts, out)
    finally:
        shutil.rmtree(drafts, ignore_errors=True)


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


class _Table:
    """A table that is written a block at a time, as Parquet, one file or many in a folder, and as CSV."""

    def __init__(
        self,
        folder: Path,
        name: str,
        columns_of: Callable[[Block], Any],
        *,
        many: bool = True,
        csv: bool,
    ) -> None:
        self._folder, self._name, self._columns_of, self._many = folder, name, columns_of, many
        self._parquet: Any = None
        self._csv: Any = None
        self._wants_csv = csv
        self._groups = 0

    def add(self, block: Block) -> None:
        """Write the rows of a block as one group."""
        table = self._columns_of(block)
        if table is None:
            return
        table = table.replace_schema_metadata({"schema": SCHEMAS[self._name]})
        if self._parquet is None or (self._many and self._groups % _GROUPS == 0):
            self._next_file(table.schema)
        self._parquet.write_table(table, row_group_size=max(table.num_rows, 1))
        self._groups += 1
        if self._wants_csv:
            self._write_csv(table)

    def _next_file(self, schema: Any) -> None:
        parquet = import_module("pyarrow.parquet")
        if self._parquet is not None:
            self._parquet.close()
        path = self._folder / f"{self._name}.parquet"
        if self._many:
            path = self._folder / self._name / f"{self._groups // _GROUPS:04d}.parquet"
            path.parent.mkdir(exist_ok=True)
        self._parquet = parquet.ParquetWriter(path, schema)

    def _write_csv(self, table: Any) -> None:
        csv = import_module("pyarrow.csv")
        arrow = import_module("pyarrow")
        plain = arrow.table(
            {
                name: column.cast(arrow.string()) if arrow.types.is_dictionary(column.type) else column
                for name, column in zip(table.column_names, table.columns, strict=True)
            }
        )
        if self._csv is None:
            self._csv = csv.CSVWriter(
                self._folder / f"{self._name}.csv", plain.schema, write_options=csv.WriteOptions(quoting_style="needed")
            )
        self._csv.write_table(plain)

    def close(self) -> None:
        """Finish the files."""
        for writer in (self._parquet, self._csv):
            if writer is not None:
                writer.close()
