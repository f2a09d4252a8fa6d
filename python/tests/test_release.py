"""A release as a data set: shapes that trainers expect, random access, weights."""

import gc
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import whyroad


def test_every_sample_is_read_once_and_by_position(release: Path) -> None:
    opened = whyroad.open_release(release)
    assert sum(opened.splits.values()) > 0
    for split, count in opened.splits.items():
        dataset = opened.dataset(split)
        assert len(dataset) == count
        ids = [s["sample_id"] for s in dataset]
        assert len(set(ids)) == count
        if count:
            assert dataset[count - 1]["sample_id"] == ids[-1] == dataset[-1]["sample_id"]
            assert pickle.loads(pickle.dumps(dataset))[0]["sample_id"] == ids[0]


def test_arrays_have_the_stated_shapes_and_frame(release: Path) -> None:
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    for s in opened.dataset(split):
        steps = len(s["history_t"])
        assert s["history_xyz"].shape == (steps, 3) and s["history_rot"].shape == (steps, 3, 3)
        assert s["history_xyz"].dtype == np.float32
        # The keyframe is the origin of its own frame.
        assert abs(s["history_t"][-1]) < 1e-6
        assert np.allclose(s["history_xyz"][-1, :2], 0, atol=1e-4)
        assert np.allclose(s["history_rot"][-1], np.eye(3), atol=1e-4)
        assert (s["future_t"] > 0).all()
        label = json.loads(s["label_json"])
        assert label["driving_decision"]["longitudinal"] == s["longitudinal"]
    assert opened.weights(split).shape == (opened.splits[split],)


def test_it_works_as_torch_uses_a_map_style_data_set(release: Path) -> None:
    """What `DataLoader` does: a sampler of positions, batches, arrays of one key stacked, copies in workers."""
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    dataset = opened.dataset(split, columns=["sample_id", "history", "future", "longitudinal"])
    order = list(dataset.shuffled(3))
    assert sorted(order) == list(range(len(dataset)))
    assert order == list(dataset.shuffled(3)) and (len(order) < 4 or order != list(dataset.shuffled(4)))
    worker = pickle.loads(pickle.dumps(dataset))
    batch = [worker[i] for i in order]
    stacked = np.stack([s["future_xyz"] for s in batch])
    assert stacked.shape == (len(order), len(batch[0]["future_t"]), 3) and stacked.dtype == np.float32
    assert "objects" not in batch[0]
    # Changing an item does not change what is read next.
    first = dataset[0]["history_xyz"].copy()
    dataset[0]["history_xyz"][:] = 0
    assert np.array_equal(dataset[0]["history_xyz"], first, equal_nan=True)


def test_values_are_those_of_the_arrow_table(release: Path) -> None:
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    rows = opened.table(split).to_pylist()
    for row, s in zip(rows, opened.dataset(split), strict=True):
        for name in ("sample_id", "trace_zh", "trace_en", "weight", "lineage", "label_json", "rejected"):
            assert s[name] == row[name], name
        for name in ("speed", "accel", "yaw_rate", "heading"):
            expected = np.array([np.nan if v is None else v for v in row["history"][name]], np.float32)
            assert np.array_equal(s[f"history_{name}"], expected, equal_nan=True), name
        assert [o["id"] for o in s["objects"]] == [o["id"] for o in row["objects"]]
        for a, b in zip(s["objects"], row["objects"], strict=True):
            assert np.allclose(a["x"], np.array(b["x"], np.float32))
        assert [i["bytes"] for i in s["images"]] == [i["bytes"] for i in row["images"]]


def equal(a: object, b: object) -> bool:
    """A value of an item, and the same value of the Arrow table as Python gives it."""
    if isinstance(a, np.ndarray):
        return np.array_equal(a, np.array([np.nan if v is None else v for v in b], a.dtype), equal_nan=True)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[k], b[k]) for k in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(equal(x, y) for x, y in zip(a, b, strict=True))
    return a == b


@pytest.mark.parametrize("unpacked", [True, False])
def test_rows_decoded_and_unpacked_are_those_of_pyarrow(
    release: Path, unpacked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Expected values: `to_pylist` of pyarrow. Row groups are forgotten at once, so that each is read again."""
    monkeypatch.setattr(whyroad.release, "KEPT_ROW_GROUPS", 0)
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    rows = opened.table(split).to_pylist()
    dataset = opened.dataset(split, unpacked=unpacked)
    for _ in range(3):
        at = 0
        for group, start in enumerate(dataset._starts):
            end = [*dataset._starts[1:], len(dataset)][group]
            for i in range(end - start):
                assert equal(dataset._read(group)(i), rows[at]), at
                at += 1
        assert at == len(rows)


def test_unpacked_files_are_used_again_and_deleted(
    release: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(whyroad.release, "KEPT_ROW_GROUPS", 0)
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)

    def jump(dataset: "whyroad.release.SampleDataset") -> list[str]:
        return [dataset[i]["sample_id"] for i in [0, 0, len(dataset) - 1, 0, len(dataset) - 1]]

    kept = tmp_path / "unpacked"
    expected = jump(opened.dataset(split, unpacked=kept))
    files = {f: f.stat().st_mtime_ns for f in kept.iterdir()}
    assert files and all(f.suffix == ".arrow" for f in files)
    assert jump(opened.dataset(split, unpacked=kept)) == expected
    assert {f: f.stat().st_mtime_ns for f in kept.iterdir()} == files, "not written again"
    # Other columns are other files.
    assert jump(opened.dataset(split, ["sample_id"], unpacked=kept)) == expected
    assert len(list(kept.iterdir())) > len(files)

    dataset = opened.dataset(split)
    worker = pickle.loads(pickle.dumps(dataset))
    assert jump(worker) == jump(dataset) == expected
    folder = dataset._unpacked._folder
    assert list(folder.iterdir())
    del worker
    assert folder.exists(), "a worker that ends leaves the folder to the others"
    del dataset
    gc.collect()
    assert not folder.exists()


def test_a_folder_that_cannot_be_written_is_said_and_reading_goes_on(
    release: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(whyroad.release, "KEPT_ROW_GROUPS", 0)
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    (tmp_path / "file").write_text("")
    dataset = opened.dataset(split, unpacked=tmp_path / "file" / "below")
    first = dataset[0]["sample_id"]
    with pytest.warns(whyroad.WhyroadWarning, match="cannot unpack to"):
        assert dataset[0]["sample_id"] == first


def test_a_split_and_a_column_that_do_not_exist_are_refused(release: Path) -> None:
    opened = whyroad.open_release(release)
    for call in (opened.dataset, opened.table, opened.weights):
        with pytest.raises(whyroad.WhyroadError, match="no split 'validation'") as e:
            call("validation")
        assert (e.value.code, e.value.hint) == ("dataset.split.unknown", "known: train, val, test")
    for call in (opened.dataset, opened.table):
        with pytest.raises(whyroad.WhyroadError, match="no column 'histroy'") as e:
            call("train", columns=["sample_id", "histroy"])
        assert (e.value.code, e.value.hint) == ("dataset.column.unknown", "did you mean 'history'?")
    assert opened.table("train", ["history.x"]).num_columns == 1, "a part of a column"


def test_a_transform_and_a_folder_that_is_no_release(release: Path, tmp_path: Path) -> None:
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    ids = list(opened.dataset(split, ["sample_id"], transform=lambda s: s["sample_id"].upper()))
    assert ids == [i.upper() for i in opened.table(split, ["sample_id"]).column(0).to_pylist()]
    with pytest.raises(IndexError):
        opened.dataset(split)[len(ids)]
    with pytest.raises(whyroad.WhyroadError) as e:
        whyroad.open_release(tmp_path)
    assert e.value.code == "dataset.release.broken"
