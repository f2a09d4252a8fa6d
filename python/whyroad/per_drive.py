"""Work on single drives, for engines that spread drives over workers: ``whyroad.ray`` and ``whyroad.spark``.

A drive is worked on in a process of its own beside the worker, so that one on which the program dies is set aside and
named, and takes neither the worker nor its other drives with it. Results are Arrow tables in types that every engine
has: category columns are texts, times are nanoseconds in 64 bits, counts are 64 bits wide.

Every drive ends with one row whose ``whyroad_status`` is ``done`` or ``failed``; rows of its result have ``row``. So a
run reports every drive, also where nothing was found.
"""

from __future__ import annotations

import os
import pickle
import struct
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from typing import IO, Any, Protocol

import pyarrow as pa

import whyroad

STATUS = "whyroad_status"
FAILURE = "whyroad_failure"
ROWS = "whyroad_rows"
#: Columns of the report: one row per drive.
REPORT = ["drive_id", STATUS, ROWS, FAILURE]


@lru_cache(maxsize=2)
def _opened(path: str) -> whyroad.Lake:
    """The lake, opened once per process: a catalog of many drives is read once, and again when it is replaced."""
    return whyroad.open_lake(path)


class Work(Protocol):
    """What is done with a drive; it is sent to other processes and so must be picklable."""

    @property
    def lake(self) -> str: ...
    def run(self, drives: list[str]) -> whyroad.Table:
        """The result for these drives; of none it has the same columns."""
        ...


@dataclass(frozen=True)
class Signals:
    """``Lake.signals`` of one drive."""

    lake: str
    names: tuple[str, ...]

    def run(self, drives: list[str]) -> whyroad.Table:
        return _opened(self.lake).signals(self.names, drives=drives)


@dataclass(frozen=True)
class Mine:
    """``Lake.mine`` of one drive."""

    lake: str
    rule: str | None = None
    target: str | None = None
    scenario: str | None = None

    def run(self, drives: list[str]) -> whyroad.Table:
        lake = _opened(self.lake)
        return lake.mine(self.rule, target=self.target, scenario=self.scenario, drives=drives, jobs=1)


def lake_path(lake: str | PathLike[str] | whyroad.Lake) -> str:
    """The lake's full path, which every worker must have."""
    return os.path.abspath(lake.path if isinstance(lake, whyroad.Lake) else lake)


def portable(table: pa.Table) -> pa.Table:
    """The table in types that every engine has."""
    names, columns = [], []
    for field, column in zip(table.schema, table.columns, strict=True):
        name, kind = field.name, field.type
        if pa.types.is_dictionary(kind):
            column = column.cast(pa.string())
        elif pa.types.is_timestamp(kind):
            name, column = f"{name}_ns", column.cast(pa.timestamp("ns")).cast(pa.int64())
        elif pa.types.is_integer(kind):
            column = column.cast(pa.int64())
        names.append(name)
        columns.append(column)
    return pa.table(columns, names=names)


def schema(work: Work) -> pa.Schema:
    """Columns of :func:`results`."""
    own = portable(pa.table(work.run([])))
    fields = [field.with_nullable(True) for field in own.schema]
    return pa.schema([*fields, (STATUS, pa.string()), (ROWS, pa.int64()), (FAILURE, pa.string())])


def results(work: Work, drives: Iterable[str], attempts: int = 2) -> Iterator[pa.Table]:
    """One table per drive: its rows, then its status. A drive on which the process dies is tried ``attempts`` times."""
    columns = schema(work)
    with _Isolated(work) as isolated:
        for drive in drives:
            table, failure = isolated.run(drive, attempts)
            yield _table(columns, drive, table, failure)


def _table(columns: pa.Schema, drive: str, table: pa.Table | None, failure: str | None) -> pa.Table:
    last = {"drive_id": drive, STATUS: "failed" if failure else "done", FAILURE: failure}
    last[ROWS] = table.num_rows if table is not None else None
    end = pa.Table.from_pylist([last], schema=columns)
    if table is None:
        return end
    table = table.append_column(STATUS, pa.array(["row"] * table.num_rows, pa.string()))
    for name in (ROWS, FAILURE):
        table = table.append_column(name, pa.nulls(table.num_rows, columns.field(name).type))
    return pa.concat_tables([table.cast(columns), end])


class _Isolated:
    """The process beside the worker."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self.process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> _Isolated:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def run(self, drive: str, attempts: int) -> tuple[pa.Table | None, str | None]:
        """The result, or why it has no draft."""
        died = ""
        for _ in range(max(attempts, 1)):
            process = self.process or self._start()
            try:
                _send(process.stdin, (self.work, drive))
                answer = _receive(process.stdout)
            except (EOFError, OSError):
                code = process.wait()
                how = f"signal {-code}" if code < 0 else f"exit code {code}"
                died = f"mine.drive.kills_worker: the process died of {how}, {attempts} times"
                self._stop()
                continue
            if isinstance(answer, str):
                return None, answer
            with pa.ipc.open_stream(answer) as reader:
                return reader.read_all(), None
        return None, died

    def _start(self) -> subprocess.Popen[bytes]:
        path = os.pathsep.join(p for p in sys.path if p)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "whyroad.per_drive"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": path},
        )
        return self.process

    def _stop(self) -> None:
        process, self.process = self.process, None
        if process is None:
            return
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                try:
                    pipe.close()
                except OSError:
                    pass
        process.kill()
        process.wait()


def _send(pipe: IO[bytes] | None, value: object) -> None:
    assert pipe is not None
    data = pickle.dumps(value)
    pipe.write(struct.pack("<Q", len(data)) + data)
    pipe.flush()


def _receive(pipe: IO[bytes] | None) -> Any:
    assert pipe is not None
    head = pipe.read(8)
    if len(head) < 8:
        raise EOFError
    (size,) = struct.unpack("<Q", head)
    data = pipe.read(size)
    if len(data) < size:
        raise EOFError
    return pickle.loads(data)


def _answer(work: Work, drive: str) -> bytes | str:
    """The result as an Arrow stream, or the failure in words. A warning says that a drive was left out."""
    import warnings

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", whyroad.WhyroadWarning)
            # This is about the lake, not about the drive.
            warnings.filterwarnings("ignore", r"\[mine\.store\.unwritable\]", whyroad.WhyroadWarning)
            table = portable(pa.table(work.run([drive])))
    except whyroad.WhyroadError as e:
        return f"{e.code}: {e.message}"
    except whyroad.WhyroadWarning as e:
        return str(e)
    out = pa.BufferOutputStream()
    with pa.ipc.new_stream(out, table.schema) as writer:
        writer.write_table(table)
    return bytes(out.getvalue())


def _serve() -> None:
    # What the program prints must not get among the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    while True:
        try:
            work, drive = _receive(sys.stdin.buffer)
        except EOFError:
            return
        _send(answers, _answer(work, drive))


if __name__ == "__main__":
    _serve()
