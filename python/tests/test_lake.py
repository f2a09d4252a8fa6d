"""Lakes from Python: signals, mining, Arrow in both directions, errors with codes."""

import pickle
import shutil
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import whyroad


def test_signals_are_one_row_per_frame_or_per_target(demo: Path) -> None:
    lake = whyroad.open_lake(demo / "lake")
    assert lake.drives() == sorted(p.name for p in (demo / "lake/drives").iterdir())
    speed = pa.table(lake.signals(["ego.speed"]))
    frames = sum(pq.read_metadata(p).num_rows for p in (demo / "lake/drives").glob("*/ego.parquet"))
    assert speed.num_rows == frames
    assert speed.schema.field("ego.speed").type == pa.float64()
    gap = pa.table(lake.signals(["target.gap"]))
    assert set(gap.column_names) == {"drive_id", "target_id", "class", "frame", "time", "target.gap"}
    # What is not known is null, never NaN or zero.
    values = gap.column("target.gap").drop_null().to_numpy()
    assert gap.column("target.gap").null_count > 0
    assert (values == values).all()


def test_what_the_binary_stored_is_what_python_reads(demo: Path) -> None:
    lake = whyroad.open_lake(demo / "lake")
    mined = demo / "mined"
    stored = pq.read_table(mined / "episodes.parquet")
    assert pa.table(lake.episodes(mined)).equals(stored)
    again = pa.table(lake.mine())
    assert sorted(again.column("episode_id").to_pylist()) == sorted(stored.column("episode_id").to_pylist())


def test_numbers_are_not_copied_on_the_way_out(demo: Path) -> None:
    table = whyroad.open_lake(demo / "lake").signals(["ego.speed"])
    first, again = pa.table(table), pa.table(table)
    for a, b in zip(first.column("ego.speed").chunks, again.column("ego.speed").chunks, strict=True):
        assert a.buffers()[1].address == b.buffers()[1].address


def test_a_custom_rule_and_its_faults(demo: Path) -> None:
    lake = whyroad.open_lake(demo / "lake")
    found = lake.mine("target.gap < 30 m for 1 s", target="vehicle")
    assert len(found) > 0
    with pytest.raises(whyroad.WhyroadError) as e:
        lake.mine("target.gapp < 30 m")
    assert e.value.code.startswith("rule.") and "gapp" in e.value.message and "target.gap" in e.value.hint
    assert str(e.value).startswith(f"[{e.value.code}] ")


def test_failures_carry_documented_codes(demo: Path) -> None:
    lake = whyroad.open_lake(demo / "lake")
    calls = {
        "lake.": lambda: whyroad.open_lake(demo / "nowhere"),
        "rule.signal.unknown": lambda: lake.signals(["ego.sped"]),
        "taxonomy.class.unknown": lambda: lake.mine(scenario="cutn"),
        "rule.target": lambda: lake.mine("target.gap < 30 m", target="planet"),
        "lake.drive_missing": lambda: lake.signals(["ego.speed"], drives=["nowhere"]),
        "lake.table_broken": lambda: whyroad.read_parquet(demo / "report.html"),
        "dataset.release.broken": lambda: whyroad.open_release(demo),
        "dataset.split.unknown": lambda: whyroad.open_release(demo / "release").table("dev"),
    }
    pages = Path(__file__).resolve().parents[2] / "docs/diagnostics"
    for code, call in calls.items():
        with pytest.raises(whyroad.WhyroadError) as e:
            call()
        assert e.value.code.startswith(code) and e.value.message
        assert (pages / f"{e.value.code}.md").is_file(), e.value.code
        assert pickle.loads(pickle.dumps(e.value)).args == e.value.args


def test_what_could_not_be_read_is_warned_about(demo: Path, tmp_path: Path) -> None:
    shutil.copytree(demo / "lake", tmp_path / "lake")
    lake = whyroad.open_lake(tmp_path / "lake")
    broken = lake.drives()[0]
    folder = tmp_path / "lake/drives" / broken
    (folder / "ego.parquet").write_bytes(b"PAR1")
    # What was stored is read without the drive.
    shutil.rmtree(folder / "signals")
    (folder / "found.json").unlink()
    with pytest.warns(whyroad.WhyroadWarning, match=r"^\[[a-z_.]+\]") as warned:
        found = pa.table(lake.mine())
    assert any(broken in str(w.message) for w in warned)
    assert broken not in found.column("drive_id").to_pylist() and found.num_rows > 0


def test_polars_pandas_and_duckdb_take_a_table_in_two_lines(demo: Path) -> None:
    lake = whyroad.open_lake(demo / "lake")
    rows = len(lake.signals(["ego.speed"]))
    polars = pytest.importorskip("polars")
    t = lake.signals(["ego.speed"])
    assert polars.DataFrame(t).height == rows
    assert t.to_polars().equals(polars.DataFrame(t))
    pandas = pytest.importorskip("pandas")
    assert len(t.to_pandas()) == rows
    assert len(pandas.DataFrame.from_arrow(t)) == rows
    duckdb = pytest.importorskip("duckdb")
    fast = duckdb.sql('SELECT count(*) FROM t WHERE "ego.speed" >= 0').fetchall()[0][0]
    speeds = pa.table(t).column("ego.speed").drop_null().to_numpy()
    assert fast == (speeds >= 0).sum() > 0
