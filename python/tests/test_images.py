"""Camera images (JPEG) from files beside a log to what trainers decode: `media add`, a build with cameras, exports."""

import io
import json
import shutil
import tarfile
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import whyroad
from conftest import run

Image = pytest.importorskip("PIL.Image")
RATE_HZ = 10


def picture(number: int) -> bytes:
    """A JPEG whose brightness says its number; neighbors differ by more than what compression changes."""
    out = io.BytesIO()
    Image.new("RGB", (32, 24), (number % 16 * 16 + 8, number // 16 % 16 * 16 + 8, 128)).save(out, "JPEG", quality=95)
    return out.getvalue()


def number(image: "Image.Image") -> int:
    """The number modulo 256."""
    red, green, _ = image.convert("RGB").getpixel((16, 12))
    return red // 16 + green // 16 * 16


@pytest.fixture(scope="module")
def with_cameras(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A release of the demo's drafts with images of two cameras."""
    at = tmp_path_factory.mktemp("cameras")
    shutil.copytree(demo / "lake", at / "lake")
    (at / "pictures").mkdir()
    for n in range(1000):
        (at / f"pictures/{n}.jpg").write_bytes(picture(n))
    drives = whyroad.open_lake(at / "lake").drives()
    for drive in drives:
        for camera in ("front", "left"):
            # 3: images after the end of the drive are left out and named.
            command = ["media", "add", "--lake", at / "lake", "--drive", drive, "--camera", camera, "--copy"]
            run(*command, "--pictures", at / "pictures", "--rate", str(RATE_HZ), codes=(0, 3))
    run("dataset", "init", at / "spec.yaml")
    text = (at / "spec.yaml").read_text(encoding="utf-8").replace("images: none", "images: cameras")
    (at / "spec.yaml").write_text(text, encoding="utf-8")
    command = ["dataset", "build", "--spec", at / "spec.yaml", "--labels", demo / "mined", "--drafts"]
    run(*command, "--lake", at / "lake", "--out", at / "release", codes=(0,))
    return at


def expected(lake: Path, sample: dict, t_s: float) -> int:
    """The number of the picture that was taken last at that moment."""
    start = pq.read_table(lake / "drives" / sample["lineage"]["drive_id"] / "ego.parquet").column("time_ns")[0].as_py()
    return int(((sample["lineage"]["keyframe_time_ns"] - start) / 1e9 + t_s) * RATE_HZ + 1e-3) % 256


def test_samples_have_the_pictures_of_their_moments(with_cameras: Path) -> None:
    release = whyroad.open_release(with_cameras / "release")
    seen = 0
    for split in release.splits:
        for s in release.dataset(split):
            assert [i["camera"] for i in s["images"]] == ["front"] * 4 + ["left"] * 4
            for i in s["images"]:
                assert i["format"] == "jpg"
                shown = number(Image.open(io.BytesIO(i["bytes"])))
                assert shown == expected(with_cameras / "lake", s, i["t_s"])
                seen += 1
    assert seen >= 40


def test_hugging_face_and_webdataset_decode_them(with_cameras: Path, tmp_path: Path) -> None:
    release = with_cameras / "release"
    run("dataset", "export", "huggingface", release, "--out", tmp_path / "hf", codes=(0,))
    datasets = pytest.importorskip("datasets")
    loaded = datasets.load_dataset(str(tmp_path / "hf"), cache_dir=str(tmp_path / "cache"))
    for row in (r for split in loaded.values() for r in split):
        for image, t_s in zip(row["images"], row["image_t_s"], strict=True):
            assert number(image) == expected(with_cameras / "lake", row, t_s)


def test_webdataset_has_them_beside_the_sample(with_cameras: Path, tmp_path: Path) -> None:
    run("dataset", "export", "webdataset", with_cameras / "release", "--out", tmp_path / "wds", codes=(0,))
    samples = 0
    for shard in (tmp_path / "wds").glob("*.tar"):
        with tarfile.open(shard) as tar:
            files = {m.name: tar.extractfile(m).read() for m in tar.getmembers()}
        for name in (n for n in files if n.endswith(".json")):
            sample = json.loads(files[name])
            times = [i["t_s"] for i in sample["images"] if i["camera"] == "left"]
            for n, t_s in enumerate(times):
                image = Image.open(io.BytesIO(files[name.removesuffix("json") + f"left_{n}.jpg"]))
                assert number(image) == expected(with_cameras / "lake", sample, t_s)
            samples += 1
    assert samples == sum(whyroad.open_release(with_cameras / "release").splits.values())


def test_alpamayo_videos_are_read_by_the_publishers_package(with_cameras: Path, tmp_path: Path) -> None:
    """Under the loader's camera names, encoded by ffmpeg; the frame at t0 is the last one."""
    video = pytest.importorskip("physical_ai_av.video")
    if shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed")
    import zipfile

    import pandas

    spec = (with_cameras / "spec.yaml").read_text(encoding="utf-8")
    lake = tmp_path / "lake"
    shutil.copytree(with_cameras / "lake", lake)
    name = "camera_front_wide_120fov"
    for drive in whyroad.open_lake(lake).drives():
        command = ["media", "add", "--lake", lake, "--drive", drive, "--camera", name, "--copy"]
        run(*command, "--pictures", with_cameras / "pictures", "--rate", str(RATE_HZ), codes=(0, 3))
    (tmp_path / "spec.yaml").write_text(spec.replace("cameras: []", f"cameras: [{name}]"), encoding="utf-8")
    labels = tmp_path / "labels.jsonl"
    release = whyroad.open_release(with_cameras / "release")
    rows = [s["label_json"] for split in release.splits for s in release.dataset(split, ["label_json"])]
    labels.write_text("\n".join(rows) + "\n", encoding="utf-8")
    command = ["dataset", "build", "--spec", tmp_path / "spec.yaml", "--labels", labels, "--drafts", "--lake", lake]
    run(*command, "--out", tmp_path / "release", codes=(0,))
    run("dataset", "export", "alpamayo", tmp_path / "release", "--out", tmp_path / "tree", codes=(0,))
    archive = zipfile.ZipFile(next((tmp_path / "tree/camera" / name).glob("*.zip")))
    clip = next(n for n in archive.namelist() if n.endswith(".mp4"))
    times = pandas.read_parquet(io.BytesIO(archive.read(clip.replace(".mp4", ".timestamps.parquet"))))["timestamp"]
    assert list(times) == [4_800_000, 4_900_000, 5_000_000, 5_100_000]
    reader = video.SeekVideoReader(video_data=io.BytesIO(archive.read(clip)), timestamps=times.to_numpy())
    frames, read = reader.decode_images_from_timestamps(times.to_numpy())
    assert len(frames) == 4 and list(read) == list(times)
