"""A release as a data set: shapes that trainers expect, random access, weights."""

import json
import pickle
from pathlib import Path

import numpy as np
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
