"""The fixture of `whyroad ingest pai`, read by the publisher's own package (`physical_ai_av` on PyPI)."""

import os
from pathlib import Path

import pytest

pai = pytest.importorskip("physical_ai_av", reason="the package physical_ai_av is not installed")
ROOT = Path(__file__).resolve().parents[2]
TREE = ROOT / "crates/whyroad-ingest/tests/fixtures/pai/tree"
CLIP = "00000001-0000-4000-8000-000000000001"
REVISION = "0" * 40


@pytest.fixture
def dataset(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The package's interface on the fixture, as a cache that was downloaded before."""
    snapshots = tmp_path / "datasets--made--tree/snapshots"
    snapshots.mkdir(parents=True)
    os.symlink(TREE, snapshots / REVISION)
    import huggingface_hub

    monkeypatch.setattr(huggingface_hub.constants, "HF_HUB_OFFLINE", True)
    return pai.PhysicalAIAVDatasetInterface(
        revision=REVISION, repo_id="made/tree", token=False, cache_dir=tmp_path
    )


def test_the_publishers_package_reads_the_tables(dataset) -> None:
    assert list(dataset.clip_index["chunk"]) == [0, 0, 0, 1]
    assert {"egomotion", "obstacle.offline"} <= dataset.features.ALL
    assert dataset.data_collection.at[CLIP, "country"] == "Germany"
    # Video and obstacles are there for the first clip alone.
    assert list(dataset.feature_presence["obstacle.offline"]) == [True, False, False, False]


def test_the_publishers_package_reads_the_poses(dataset) -> None:
    state = dataset.get_clip_feature(CLIP, "egomotion")(3_000_000)
    # The fixture's closed form: a left-hand circle of 100 m at 10 m/s, 0.3 rad after 3 s.
    assert state.pose.translation == pytest.approx([29.552, 4.4664, 0.0], abs=1e-3)
    assert state.pose.rotation.as_euler("zyx")[0] == pytest.approx(0.3, abs=1e-6)
    assert state.velocity == pytest.approx([9.5534, 2.9552, 0.0], abs=1e-3)


def test_the_publishers_package_reads_dimensions_obstacles_and_video(dataset) -> None:
    assert dataset.get_clip_feature(CLIP, "vehicle_dimensions").rear_axle_to_bbox_center == 1.4
    boxes = dataset.get_clip_feature(CLIP, "obstacle.offline")["obstacle.offline"]
    assert set(boxes["label_class"]) == {"automobile", "heavy_truck", "person", "hovercraft"}
    camera = dataset.get_clip_feature(CLIP, "camera_front_wide_120fov")
    images, times = camera.decode_images_from_timestamps(camera.timestamps[[0, 39]])
    assert images.shape == (2, 32, 32, 3) and list(times) == [-100_000, 3_800_000]
    assert images[1].mean() > images[0].mean() + 50
