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

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa

#: Row groups that a data set keeps in memory: neighbours of a sample are likely to be read next.
KEPT_ROW_GROUPS = 4


def open_release(path: str | Path) -> Release:
    """Opens a release, as ``whyroad dataset build --out DIR`` froze it."""
    return Release(Path(path))


class Release:
    """A frozen release: its manifest and its samples."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.manifest: dict[str, Any] = json.loads((path / "manifest.json").read_text(encoding="utf-8"))
        if self.manifest.get("format") != "whyroad-release":
            from whyroad._whyroad import WhyroadError

            raise WhyroadError("dataset.release.broken", f"{path} is not a Whyroad release", None, str(path))

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

        return pa.concat_tables(pq.read_table(f, columns=list(columns) if columns else None) for f in self.files(split))

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
        return self.table(split, ["weight"]).column("weight").to_numpy()

    def __repr__(self) -> str:
        return f"whyroad.Release({self.manifest['name']!r}, {self.splits})"


class SampleDataset:
    """Samples of one split by position. An item is a dictionary; see ``sample``."""

    def __init__(
        self,
        release: Release,
        split: str,
        columns: Sequence[str] | None,
        transform: Callable[[dict[str, Any]], Any] | None,
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
        self._kept: OrderedDict[int, pa.Table] = OrderedDict()

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, index: int) -> Any:
        if index < 0:
            index += self._length
        if not 0 <= index < self._length:
            raise IndexError(index)
        group = bisect_right(self._starts, index) - 1
        row = self._read(group).slice(index - self._starts[group], 1).to_pylist()[0]
        item = sample(row)
        return self._transform(item) if self._transform else item

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(self._length))

    def __getstate__(self) -> dict[str, Any]:
        # Workers of a DataLoader read for themselves.
        return {**self.__dict__, "_kept": OrderedDict()}

    def _read(self, group: int) -> pa.Table:
        import pyarrow.parquet as pq

        if group in self._kept:
            self._kept.move_to_end(group)
            return self._kept[group]
        number, of_file = self._groups[group]
        with pq.ParquetFile(self._files[number]) as file:
            table = file.read_row_group(of_file, columns=self._columns)
        self._kept[group] = table
        while len(self._kept) > KEPT_ROW_GROUPS:
            self._kept.popitem(last=False)
        return table


def sample(row: dict[str, Any]) -> dict[str, Any]:
    """A row of a release as NumPy arrays where it has numbers.

    ``history`` and ``future`` become ``<name>_t`` (T,), ``<name>_xyz`` (T, 3) and ``<name>_rot`` (T, 3, 3), float32, and one
    array per further quantity (``history_speed``, ...). Everything else keeps its name; images keep their encoded bytes.
    """
    import numpy as np

    out: dict[str, Any] = {}
    for name, value in row.items():
        if name not in ("history", "future") or value is None:
            out[name] = value
            continue

        def numbers(column: str, of: dict[str, Any] = value) -> np.ndarray:
            return np.array([np.nan if v is None else v for v in of[column]], dtype=np.float32)

        out[f"{name}_t"] = numbers("t_s")
        out[f"{name}_xyz"] = np.stack([numbers("x"), numbers("y"), numbers("z")], axis=-1)
        heading = numbers("heading")
        rotation = np.zeros((len(heading), 3, 3), dtype=np.float32)
        rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(heading)
        rotation[:, 1, 0] = np.sin(heading)
        rotation[:, 0, 1] = -np.sin(heading)
        rotation[:, 2, 2] = 1
        out[f"{name}_rot"] = rotation
        for column in ("heading", "speed", "accel", "yaw_rate"):
            out[f"{name}_{column}"] = numbers(column)
        out[f"{name}_meta_longitudinal"] = value["meta_longitudinal"]
        out[f"{name}_meta_lateral"] = value["meta_lateral"]
        out[f"{name}_complete"] = value["complete"]
    return out
