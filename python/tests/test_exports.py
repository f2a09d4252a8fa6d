"""Every export read back by its consumer's own library, or by a check that does what its loader does."""

import io
import json
import subprocess
import zipfile
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from conftest import binary


def export(release: Path, kind: str, out: Path, *more: str) -> dict:
    done = subprocess.run(
        [binary(), "dataset", "export", kind, str(release), "--out", str(out), *more],
        capture_output=True, text=True, check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads((out / "export.json").read_text(encoding="utf-8"))


def lines(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def test_ms_swift_has_as_many_tags_as_images(release: Path, tmp_path: Path) -> None:
    summary = export(release, "ms-swift", tmp_path / "e")
    files = sorted((tmp_path / "e").glob("sft.*.jsonl"))
    assert files and summary["records"] > 0
    for record in (r for f in files for r in lines(f)):
        user, assistant = record["messages"]
        assert (user["role"], assistant["role"]) == ("user", "assistant")
        assert user["content"].count("<image>") == len(record.get("images", []))
        assert all((tmp_path / "e" / p).is_file() for p in record.get("images", []))
        assert assistant["content"].strip()
    for record in (r for f in (tmp_path / "e").glob("grpo.*.jsonl") for r in lines(f)):
        assert [m["role"] for m in record["messages"]] == ["user"] and record["solution"]


def test_llama_factory_names_every_file(release: Path, tmp_path: Path) -> None:
    export(release, "llama-factory", tmp_path / "e")
    info = json.loads((tmp_path / "e/dataset_info.json").read_text())
    assert info
    for entry in info.values():
        assert entry["formatting"] == "sharegpt"
        for record in lines(tmp_path / "e" / entry["file_name"]):
            assert set(record) == set(entry["columns"].values())
            assert record["messages"][0]["content"].count("<image>") == len(record.get("images", []))


def test_qwen_conversations(release: Path, tmp_path: Path) -> None:
    export(release, "qwen", tmp_path / "e")
    records = [r for f in (tmp_path / "e").glob("*.jsonl") for r in lines(f)]
    assert records
    for r in records:
        assert [c["from"] for c in r["conversations"]] == ["human", "gpt"]
        assert r["conversations"][0]["value"].count("<image>") == len(r.get("image", []))


def test_hugging_face_datasets_decodes_images(release: Path, tmp_path: Path) -> None:
    datasets = pytest.importorskip("datasets")
    export(release, "huggingface", tmp_path / "e")
    loaded = datasets.load_dataset(str(tmp_path / "e"), cache_dir=str(tmp_path / "cache"))
    manifest = json.loads((release / "manifest.json").read_text())
    names = {"train": "train", "val": "validation", "test": "test"}
    for split, count in manifest["counts"]["by_split"].items():
        if count:
            assert loaded[names[split]].num_rows == count
    first = next(iter(loaded.values()))[0]
    assert first["scenario_id"] and isinstance(first["history"]["x"], list)
    for image in first["images"]:
        assert image.size[0] > 0  # a PIL image, decoded


def test_croissant_is_valid(release: Path, tmp_path: Path) -> None:
    mlcroissant = pytest.importorskip("mlcroissant")
    export(release, "huggingface", tmp_path / "e")
    for folder in (tmp_path / "e", release):
        dataset = mlcroissant.Dataset(str(folder / "croissant.json"))
        assert not dataset.metadata.ctx.issues.errors
        assert dataset.metadata.record_sets


def test_webdataset_groups_the_files_of_a_sample(release: Path, tmp_path: Path) -> None:
    webdataset = pytest.importorskip("webdataset")
    summary = export(release, "webdataset", tmp_path / "e")
    shards = sorted(str(p) for p in (tmp_path / "e").glob("*.tar"))
    samples = [s for shard in shards for s in webdataset.WebDataset(shard, shardshuffle=False)]
    assert len(samples) == summary["samples"]
    for s in samples:
        assert json.loads(s["json"])["sample_id"] == s["__key__"].split("/")[-1]


def test_lerobot_v3_structure(release: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    export(release, "lerobot", tmp_path / "e")
    root = tmp_path / "e"
    info = json.loads((root / "meta/info.json").read_text())
    assert info["codebase_version"] == "v3.0"
    tasks = pandas.read_parquet(root / "meta/tasks.parquet")
    assert tasks.index.name == "task" and list(tasks.columns) == ["task_index"]
    episodes = pq.read_table(root / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert len(episodes) == info["total_episodes"]
    rows = 0
    for e in episodes:
        path = info["data_path"].format(chunk_index=e["data/chunk_index"], file_index=e["data/file_index"])
        table = pq.read_table(root / path).to_pylist()
        own = [r for r in table if r["episode_index"] == e["episode_index"]]
        assert [r["index"] for r in own] == list(range(e["dataset_from_index"], e["dataset_to_index"]))
        assert [r["frame_index"] for r in own] == list(range(e["length"]))
        rows += len(own)
        for r in own:
            for name, feature in info["features"].items():
                if feature["dtype"] == "float32" and feature["shape"] != [1]:
                    assert len(r[name]) == feature["shape"][0]
            styles = {row["style"] for row in r["language_persistent"]}
            assert "plan" in styles and styles <= {"plan", "motion"}
            assert all(row["camera"] is None for row in r["language_persistent"])
    assert rows == info["total_frames"]


def test_alpamayo_tree_as_its_loader_filters_it(release: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    yaml = pytest.importorskip("yaml")
    export(release, "alpamayo", tmp_path / "e")
    root = tmp_path / "e"
    features = pandas.read_csv(root / "features.csv", index_col="feature")
    files = features["clip_files_in_zip"].map(json.loads)
    index = pandas.read_parquet(root / "clip_index.parquet")
    presence = pandas.read_parquet(root / "metadata/feature_presence.parquet")
    reasoning = pandas.read_parquet(root / "reasoning/ood_reasoning.parquet")
    assert index.index.name == "clip_id" and len(index) > 0
    assert list(presence.index) == list(index.index) == list(reasoning.index)
    assert presence.select_dtypes(include=bool).shape[1] == presence.shape[1]
    for clip, row in index.iterrows():
        # What `_read_reasoning_data` and `filter_clips_by_event_t0s` do: 1.6 s before and 6.4 s after within 20 s.
        events = json.loads(reasoning.at[clip, "events"])
        assert len(events) == 1 and events[0]["cot"] and events[0]["coc"] == events[0]["cot"]
        t0 = events[0]["event_start_timestamp"]
        assert 1_600_000 < t0 and t0 + 6_400_000 <= 20_000_000
        chunk = features.at["egomotion", "chunk_path"].format(chunk_id=row["chunk"])
        with zipfile.ZipFile(root / chunk) as archive:
            name = files["egomotion"]["egomotion"].format(clip_id=clip)
            motion = pandas.read_parquet(io.BytesIO(archive.read(name)))
        at_t0 = motion[motion["timestamp"] == t0].iloc[0]
        assert abs(at_t0["x"]) < 1e-3 and abs(at_t0["qw"] - 1) < 1e-6
    preflight = json.loads((root / "preflight.json").read_text())
    assert preflight["clips"] == len(index)
    # The loader chooses by chunk: none may mix splits, and each data set of the configuration reads its own split.
    assert index.groupby("chunk")["split"].nunique().max() == 1
    config = yaml.safe_load((root / "training.yaml").read_text())["data"]
    for key, split in (("train_dataset", "train"), ("val_dataset", "val")):
        if key not in config:
            assert split not in set(index["split"])
            continue
        first, end = map(int, config[key]["chunk_ids"].split("-"))
        assert set(index.loc[index["chunk"].isin(range(first, end)), "split"]) == {split}
        assert config[key]["use_default_keyframe"] is False
        assert "cot" in config[key]["vla_preprocess_args"]["label_components"]


def test_alpamayo_egomotion_is_read_by_physical_ai_av(release: Path, tmp_path: Path) -> None:
    egomotion = pytest.importorskip("physical_ai_av.egomotion")
    pandas = pytest.importorskip("pandas")
    export(release, "alpamayo", tmp_path / "e")
    archive = zipfile.ZipFile(next((tmp_path / "e/labels/egomotion").glob("*.zip")))
    frame = pandas.read_parquet(io.BytesIO(archive.read(archive.namelist()[0])))
    at = egomotion.EgomotionState.from_egomotion_df(frame).create_interpolator(frame["timestamp"].to_numpy())
    assert abs(at(5_100_000).pose.translation).max() < 1e-3


def test_openlabel_documents(release: Path, tmp_path: Path) -> None:
    export(release, "openlabel", tmp_path / "e")
    documents = list((tmp_path / "e").glob("*/*.json"))
    assert documents
    for path in documents:
        document = json.loads(path.read_text(encoding="utf-8"))["openlabel"]
        assert document["metadata"]["schema_version"] == "1.0.0"
        last = document["frame_intervals"][0]["frame_end"]
        assert set(map(int, document["frames"])) == set(range(last + 1))
        for frame in document["frames"].values():
            for uid, data in frame["objects"].items():
                assert uid in document["objects"]
                assert all(len(c["val"]) == 10 for c in data["object_data"]["cuboid"])


def test_openlabel_documents_fit_the_schema_of_the_standard(release: Path, tmp_path: Path) -> None:
    schema = pytest.importorskip("vcd.schema").openlabel_schema
    validator = pytest.importorskip("jsonschema").Draft7Validator(schema)
    export(release, "openlabel", tmp_path / "e")
    for path in (tmp_path / "e").glob("*/*.json"):
        document = json.loads(path.read_text(encoding="utf-8"))
        assert [e.message for e in validator.iter_errors(document)] == [], path
        inside = document["openlabel"]
        for relation in inside.get("relations", {}).values():
            assert all(s["uid"] in inside["contexts"] for s in relation["rdf_subjects"])
            assert all(o["uid"] in inside["actions"] for o in relation["rdf_objects"])


def test_jsonl_holds_every_sample(release: Path, tmp_path: Path) -> None:
    summary = export(release, "jsonl", tmp_path / "e")
    records = [r for f in (tmp_path / "e").glob("*.jsonl") for r in lines(f)]
    assert len(records) == summary["samples"]
    assert all(r["label"]["clip_id"] for r in records)
    # Numbers of 32 bits are written as such: 0.1, not 0.10000000149011612.
    assert all(len(str(t)) <= 5 for r in records for t in r["future"]["t_s"])
