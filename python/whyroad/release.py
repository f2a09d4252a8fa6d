"""``open_release``: samples of a frozen release, as Arrow tables or as a data set that torch's ``DataLoader`` takes.

Needs pyarrow and NumPy. Positions, headings and velocities are in the ego frame at the keyframe (x forward, y left; m,
rad); times are seconds from the keyframe; unknown is NaN.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import os
import warnings
from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from whyroad.errors import WhyroadError, WhyroadWarning

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa

#: The splits of every release; any may be empty.
SPLITS = ("train", "val", "test")
#: Row groups that a data set keeps decoded in memory: neighbors of a sample are likely to be read next.
KEPT_ROW_GROUPS = 8
#: Row groups that stay open in the unpacked copy; each is a memory-mapped file.
OPEN_ROW_GROUPS = 1024


def open_release(path: str | Path) -> Release:
    """Opens a release, as ``whyroad dataset build --out DIR`` froze it."""
    return Release(Path(path))


class Release:
    """A frozen release: its manifest and its samples."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.manifest: dict[str, Any] = json.loads((path / "manifest.json").read_text(encoding="utf-8"))
        except (OSError, ValueError) as e:
            raise WhyroadError("dataset.release.broken", f"not a Whyroad release: {e}", None, str(path)) from e
        if self.manifest.get("format") != "whyroad-release":
            raise WhyroadError("dataset.release.broken", "not a Whyroad release", None, str(path))

    @property
    def splits(self) -> dict[str, int]:
        """Number of samples per split."""
        return dict(self.manifest["counts"]["by_split"])

    def files(self, split: str) -> list[Path]:
        """Parquet files of a split, in order; none where it is empty."""
        if split not in SPLITS:
            message = f"the release has no split '{split}'"
            raise WhyroadError("dataset.split.unknown", message, _nearest(split, SPLITS), str(self.path))
        prefix = f"data/{split}-"
        return [self.path / f["path"] for f in self.manifest["files"] if f["path"].startswith(prefix)]

    def table(self, split: str, columns: Sequence[str] | None = None) -> pa.Table:
        """All samples of a split as one Arrow table."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        files = self.files(split)
        if not files:
            raise WhyroadError("dataset.split.empty", f"the release has no samples in '{split}'", None, str(self.path))
        self._check_columns(files[0], columns)
        return pa.concat_tables(pq.read_table(f, columns=list(columns) if columns else None) for f in files)

    def _check_columns(self, file: Path, columns: Sequence[str] | None) -> None:
        """Raises for a column that samples do not have: Parquet readers leave it out without a word."""
        import pyarrow.parquet as pq

        known = pq.read_schema(file).names
        # `history.x` is a part of the column `history`.
        for column in columns or []:
            if column.split(".")[0] not in known:
                message = f"samples have no column '{column}'"
                raise WhyroadError("dataset.column.unknown", message, _nearest(column, known), str(self.path))

    def dataset(
        self,
        split: str,
        columns: Sequence[str] | None = None,
        transform: Callable[[dict[str, Any]], Any] | None = None,
        unpacked: str | Path | bool = True,
    ) -> SampleDataset:
        """A map-style data set: ``torch.utils.data.DataLoader(release.dataset("train"))`` works, torch is not needed here.

        ``columns`` limits what is read (default: all). ``transform`` is applied to each sample.

        A row group that is read again, by a sampler that jumps (``shuffle=True``) or in a second epoch, is unpacked once
        into a file that is mapped into memory: some 25 kB per sample without images, shared by all workers. The files are
        in a temporary folder, deleted with the data set, or in ``unpacked``, where the next run finds them; ``False``
        writes none and decodes again.
        """
        return SampleDataset(self, split, columns, transform, unpacked)

    def weights(self, split: str = "train") -> np.ndarray:
        """Sampling weights of a split, for ``torch.utils.data.WeightedRandomSampler``."""
        weights: np.ndarray = self.table(split, ["weight"]).column("weight").to_numpy()
        return weights

    def __repr__(self) -> str:
        return f"whyroad.Release({self.manifest['name']!r}, {self.splits})"


class SampleDataset:
    """Samples of one split by position. An item is a dictionary of NumPy arrays and values.

    ``history`` and ``future`` become ``<name>_t`` (T,), ``<name>_xyz`` (T, 3) and ``<name>_rot`` (T, 3, 3), float32, and
    one array per further quantity (``history_speed``, ...). Lists of numbers are arrays, lists of records (``objects``,
    ``map``, ``images``) lists of dictionaries; images keep their encoded bytes.
    """

    def __init__(
        self,
        release: Release,
        split: str,
        columns: Sequence[str] | None = None,
        transform: Callable[[dict[str, Any]], Any] | None = None,
        unpacked: str | Path | bool = True,
    ) -> None:
        import pyarrow.parquet as pq

        self._columns = list(columns) if columns else None
        self._transform = transform
        self._files = release.files(split)
        if self._files:
            release._check_columns(self._files[0], columns)
        folder = None if unpacked is True else unpacked
        self._unpacked = None if folder is False else _Unpacked(release, self._files, self._columns, folder)
        self._groups: list[tuple[int, int]] = []
        self._starts: list[int] = []
        total = 0
        for number, file in enumerate(self._files):
            metadata = pq.read_metadata(file)
            for group in range(metadata.num_row_groups):
                self._groups.append((number, group))
                self._starts.append(total)
                total += metadata.row_group(group).num_rows
        self._length = total
        self._kept: OrderedDict[int, Callable[[int], Any]] = OrderedDict()
        self._open: OrderedDict[int, Callable[[int], Any]] = OrderedDict()
        self._seen: set[int] = set()

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> Any:
        if index < 0:
            index += self._length
        if not 0 <= index < self._length:
            raise IndexError(index)
        group = bisect_right(self._starts, index) - 1
        item = _sample(self._read(group)(index - self._starts[group]))
        return self._transform(item) if self._transform else item

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(self._length))

    def __getstate__(self) -> dict[str, Any]:
        # Workers of a DataLoader read for themselves.
        return {**self.__dict__, "_kept": OrderedDict(), "_open": OrderedDict(), "_seen": set()}

    def shuffled(self, seed: int) -> Iterator[int]:
        """Every position once, in an order of ``seed``, for ``DataLoader(dataset, sampler=list(dataset.shuffled(0)))``.

        Positions come from a few row groups at a time, so that each group is read once in an epoch: files are shuffled
        already when a release is frozen.
        """
        import numpy as np

        rng = np.random.default_rng(seed)
        ends = [*self._starts[1:], self._length]
        order = rng.permutation(len(self._starts))
        for at in range(0, len(order), KEPT_ROW_GROUPS):
            some = order[at : at + KEPT_ROW_GROUPS]
            positions = np.concatenate([np.arange(self._starts[g], ends[g]) for g in some])
            yield from rng.permutation(positions).tolist()

    def _read(self, group: int) -> Callable[[int], Any]:
        """Gives the rows of a row group."""
        for held in (self._kept, self._open):
            if group in held:
                held.move_to_end(group)
                return held[group]
        number, of_file = self._groups[group]
        mapped = self._unpacked.table(number, of_file) if self._unpacked and group in self._seen else None
        self._seen.add(group)
        held, most = (self._open, OPEN_ROW_GROUPS) if mapped else (self._kept, KEPT_ROW_GROUPS)
        read = _reader(_rows(mapped or _decoded(self._files[number], of_file, self._columns)))
        held[group] = read
        while len(held) > most:
            held.popitem(last=False)
        return read


def _nearest(name: str, known: Sequence[str]) -> str:
    """The hint for an unknown name: the nearest known one, or all of them."""
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f"did you mean '{near[0]}'?" if near else f"known: {', '.join(known)}"


class _Unpacked:
    """Row groups as uncompressed Arrow files. The name of a file has the hash of what it was made from, so that a folder
    may serve several releases and a changed one is never mixed up."""

    def __init__(
        self, release: Release, files: Sequence[Path], columns: Sequence[str] | None, folder: str | Path | None
    ) -> None:
        import tempfile

        hashes = {release.path / f["path"]: f["sha256"] for f in release.manifest["files"]}
        self._files = list(files)
        self._hashes = [hashes[f] for f in files]
        self._columns = list(columns) if columns else None
        # Of a copy in a worker, the folder belongs to the process that made the data set.
        self._owned = tempfile.TemporaryDirectory(prefix="whyroad-", ignore_cleanup_errors=True) if folder is None else None
        self._folder = Path(self._owned.name if self._owned else folder or "")

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_owned": None}

    def table(self, number: int, group: int) -> pa.Table | None:
        """A row group of a file, mapped into memory; None, with a warning, where it cannot be written."""
        import pyarrow as pa

        of = hashlib.sha256("\n".join([self._hashes[number], str(group), *(self._columns or ["*"])]).encode()).hexdigest()
        path = self._folder / f"{of}.arrow"
        try:
            if not path.exists():
                self._write(path, _decoded(self._files[number], group, self._columns))
            return pa.ipc.open_file(pa.memory_map(str(path))).read_all()
        except (OSError, pa.ArrowInvalid) as e:
            text = f"cannot unpack to {self._folder}; row groups are decoded each time they are read: {e}"
            warnings.warn(text, WhyroadWarning, stacklevel=2)
            return None

    def _write(self, path: Path, table: pa.Table) -> None:
        import pyarrow as pa

        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f"{path.stem}.{os.getpid()}")
        try:
            with pa.ipc.new_file(str(aside), table.schema) as out:
                out.write_table(table.combine_chunks())
            aside.replace(path)
        finally:
            aside.unlink(missing_ok=True)


def _decoded(file: Path, group: int, columns: Sequence[str] | None) -> pa.Table:
    import pyarrow.parquet as pq

    with pq.ParquetFile(file) as parquet:
        return parquet.read_row_group(group, columns=columns)


def _rows(table: pa.Table) -> pa.Array:
    rows = table.to_struct_array()
    return rows.chunk(0) if rows.num_chunks == 1 else rows.combine_chunks()


def _reader(array: pa.Array) -> Callable[[int], Any]:
    """Gives the value at a position: numbers of lists as NumPy arrays, everything else as Python values. What is not
    asked for is not converted."""
    import pyarrow.types as types

    if array.null_count:
        known = array.is_valid().to_numpy(zero_copy_only=False).item
        read = _reader_of_known(array)
        return lambda i: read(i) if known(i) else None
    if types.is_null(array.type):
        return lambda i: None
    return _reader_of_known(array)


def _reader_of_known(array: pa.Array) -> Callable[[int], Any]:
    """As [`_reader`], of positions whose value is not null."""
    import numpy as np
    import pyarrow.types as types

    if types.is_struct(array.type):
        fields = [(array.type.field(n).name, _reader(array.field(n))) for n in range(array.type.num_fields)]
        return lambda i: {name: read(i) for name, read in fields}
    if types.is_list(array.type):
        return _list_reader(array)
    if types.is_string(array.type):
        _, positions, data = array.buffers()
        if data is None:
            return lambda i: ""
        at = np.frombuffer(positions, np.int32)[array.offset :].item
        text = memoryview(data)
        return lambda i: str(text[at(i) : at(i + 1)], "utf-8")
    if types.is_integer(array.type) or types.is_floating(array.type):
        number: Callable[[int], Any] = array.fill_null(0).to_numpy().item
        return number
    return lambda i: array[i].as_py()


def _list_reader(array: pa.Array) -> Callable[[int], Any]:
    """Lists of positions that are not null."""
    import pyarrow.types as types

    at = array.offsets.to_numpy().item
    child = array.values
    if types.is_floating(array.type.value_type):
        # Null is unknown, and unknown is NaN.
        values = child.to_numpy(zero_copy_only=False)
        return lambda i: values[at(i) : at(i + 1)].copy()
    read = _reader(child)
    return lambda i: [read(j) for j in range(at(i), at(i + 1))]


def _sample(row: dict[str, Any]) -> dict[str, Any]:
    """``history`` and ``future`` as arrays of their own."""
    import numpy as np

    out: dict[str, Any] = {}
    for name, value in row.items():
        if name not in ("history", "future") or value is None:
            out[name] = value
            continue
        out[f"{name}_t"] = value["t_s"]
        out[f"{name}_xyz"] = np.stack([value["x"], value["y"], value["z"]], axis=-1)
        heading = value["heading"]
        rotation = np.zeros((len(heading), 3, 3), dtype=np.float32)
        rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(heading)
        rotation[:, 1, 0] = np.sin(heading)
        rotation[:, 0, 1] = -rotation[:, 1, 0]
        rotation[:, 2, 2] = 1
        out[f"{name}_rot"] = rotation
        for column in ("heading", "speed", "accel", "yaw_rate"):
            out[f"{name}_{column}"] = value[column]
        for column in ("meta_longitudinal", "meta_lateral", "complete"):
            out[f"{name}_{column}"] = value[column]
    return out
