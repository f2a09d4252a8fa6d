"""A release as a data set: shapes that trainers expect, random access, weights."""

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


def test_one_by_one_and_all_at_once_give_the_same(release: Path) -> None:
    opened = whyroad.open_release(release)
    split = max(opened.splits, key=opened.splits.get)
    at_once = opened.dataset(split)
    for _ in range(3):
        all_rows = list(at_once)  # more than ONE_BY_ONE reads: the group is converted
    for i, expected in enumerate(all_rows):
        alone = opened.dataset(split)[i]
        assert alone.keys() == expected.keys()
        for name, value in expected.items():
            if isinstance(value, np.ndarray):
                assert np.array_equal(alone[name], value, equal_nan=True), name
            elif name in ("objects", "map", "components"):
                assert [str(o) for o in alone[name]] == [str(o) for o in value], name
            elif name != "groups":
                assert alone[name] == value, name


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
