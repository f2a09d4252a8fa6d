"""``open_release``: samples of a frozen release, as Arrow tables or as a data set that torch's ``DataLoader`` takes.

Needs pyarrow and NumPy. Positions, headings and velocities are in the ego frame at the keyframe (x forward, y left; m,
rad); times are seconds from the keyframe; unknown is NaN.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from whyroad.errors import WhyroadError

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa

#: Row groups that a data set keeps in memory: neighbors of a sample are likely to be read next.
KEPT_ROW_GROUPS = 8
#: Samples of a row group that are read one by one; from then on the whole group is converted at once.
ONE_BY_ONE = 8


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
        """Parquet files of a split, in order."""
        prefix = f"data/{split}-"
        return [self.path / f["path"] for f in self.manifest["files"] if f["path"].startswith(prefix)]

    def table(self, split: str, columns: Sequence[str] | None = None) -> pa.Table:
        """All samples of a split as one Arrow table."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        files = self.files(split)
        if not files:
            raise WhyroadError("dataset.split.empty", f"the release has no samples in '{split}'", None, str(self.path))
        return pa.concat_tables(pq.read_table(f, columns=list(columns) if columns else None) for f in files)

    def dataset(
        self,
        split: str,
        columns: Sequence[str] | None = None,
        transform: Callable[[dict[str, Any]], Any] | None = None,
    ) -> SampleDataset:
        """A map-style data set: ``torch.utils.data.DataLoader(release.dataset("train"))`` works, torch is not needed here.

        ``columns`` limits what is read (default: all). ``transform`` is applied to each sample.
        """
        return SampleDataset(self, split, columns, transform)

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
    ) -> None:
        import pyarrow.parquet as pq

        self._columns = list(columns) if columns else None
        self._transform = transform
        self._files = release.files(split)
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
        self._kept: OrderedDict[int, _RowGroup] = OrderedDict()

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> Any:
        if index < 0:
            index += self._length
        if not 0 <= index < self._length:
            raise IndexError(index)
        group = bisect_right(self._starts, index) - 1
        item = _sample(self._read(group).row(index - self._starts[group]))
        return self._transform(item) if self._transform else item

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(self._length))

    def __getstate__(self) -> dict[str, Any]:
        # Workers of a DataLoader read for themselves.
        return {**self.__dict__, "_kept": OrderedDict()}

    def shuffled(self, seed: int) -> Iterator[int]:
        """Every position once, in an order of ``seed``, for ``DataLoader(dataset, sampler=list(dataset.shuffled(0)))``.

        Positions come from a few row groups at a time, so that each group is read once: files are shuffled already when
        a release is frozen. A sampler that jumps through the whole split reads a row group for nearly every sample.
        """
        import numpy as np

        rng = np.random.default_rng(seed)
        ends = [*self._starts[1:], self._length]
        order = rng.permutation(len(self._starts))
        for at in range(0, len(order), KEPT_ROW_GROUPS):
            some = order[at : at + KEPT_ROW_GROUPS]
            positions = np.concatenate([np.arange(self._starts[g], ends[g]) for g in some])
            yield from rng.permutation(positions).tolist()

    def _read(self, group: int) -> _RowGroup:
        import pyarrow.parquet as pq

        if group in self._kept:
            self._kept.move_to_end(group)
            return self._kept[group]
        number, of_file = self._groups[group]
        with pq.ParquetFile(self._files[number]) as file:
            table = file.read_row_group(of_file, columns=self._columns)
        rows = _RowGroup(table.to_struct_array().combine_chunks())
        self._kept[group] = rows
        while len(self._kept) > KEPT_ROW_GROUPS:
            self._kept.popitem(last=False)
        return rows


class _RowGroup:
    """Rows of one row group: a few one by one, many by converting all."""

    def __init__(self, rows: pa.Array) -> None:
        self._rows = rows
        self._asked = 0
        self._all: Callable[[int], Any] | None = None

    def row(self, index: int) -> dict[str, Any]:
        self._asked += 1
        if self._all is None and self._asked > ONE_BY_ONE:
            self._all = _reader(self._rows)
        row: dict[str, Any] = self._all(index) if self._all else _reader(self._rows.slice(index, 1))(0)
        return row


def _reader(array: pa.Array) -> Callable[[int], Any]:
    """Gives the value at a position: numbers of lists as NumPy arrays, everything else as Python values."""
    import pyarrow.types as types

    if types.is_struct(array.type):
        fields = [(f.name, _reader(child)) for f, child in zip(array.type, array.flatten(), strict=True)]
        if array.null_count:
            known = array.is_valid().to_numpy(zero_copy_only=False)
            return lambda i: {name: read(i) for name, read in fields} if known[i] else None
        return lambda i: {name: read(i) for name, read in fields}
    if types.is_list(array.type):
        return _list_reader(array)
    if types.is_binary(array.type):
        # Images: only those that are asked for are copied.
        return lambda i: array[i].as_py()
    values = _values(array)
    return lambda i: values[i]


def _values(array: pa.Array) -> list[Any]:
    """All values of an array without children, as Python values; null is None."""
    import pyarrow.types as types

    if array.null_count and not (types.is_string(array.type) or types.is_boolean(array.type)):
        return list(array.to_pylist())
    return list(array.to_numpy(zero_copy_only=False).tolist())


def _list_reader(array: pa.Array) -> Callable[[int], Any]:
    import pyarrow.types as types

    # Of a slice: only its own values, counted from its first.
    positions = array.offsets.to_numpy()
    offsets = (positions - positions[0]).tolist()
    child = array.flatten()
    known = array.is_valid().to_numpy(zero_copy_only=False) if array.null_count else None
    if types.is_floating(array.type.value_type):
        # Null is unknown, and unknown is NaN.
        values = child.to_numpy(zero_copy_only=False)

        def numbers(i: int) -> Any:
            return None if known is not None and not known[i] else values[offsets[i] : offsets[i + 1]].copy()

        return numbers
    if not types.is_nested(array.type.value_type):
        words = _values(child)
        return lambda i: None if known is not None and not known[i] else words[offsets[i] : offsets[i + 1]]
    read = _reader(child)

    def items(i: int) -> Any:
        if known is not None and not known[i]:
            return None
        return [read(j) for j in range(offsets[i], offsets[i + 1])]

    return items


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
