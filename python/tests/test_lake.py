"""Lakes from Python: signals, mining, Arrow in both directions, errors with codes."""

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


def test_a_custom_rule_and_its_faults(demo: Path) -> None:
    lake = whyroad.open_lake(demo / "lake")
    found = lake.mine("target.gap < 30 m for 1 s", target="vehicle")
    assert len(found) > 0
    with pytest.raises(whyroad.WhyroadError) as e:
        lake.mine("target.gapp < 30 m")
    code, message, hint, _ = e.value.args
    assert code.startswith("rule.") and "gapp" in message and hint
    with pytest.raises(whyroad.WhyroadError) as e:
        whyroad.open_lake(demo / "nowhere")
    assert e.value.args[0].startswith("lake.")


def test_polars_pandas_and_duckdb_take_a_table(demo: Path) -> None:
    table = whyroad.open_lake(demo / "lake").signals(["ego.speed"])
    rows = len(table)
    polars = pytest.importorskip("polars")
    assert polars.DataFrame(table).height == rows
    pytest.importorskip("pandas")
    assert len(table.to_pandas()) == rows
    duckdb = pytest.importorskip("duckdb")
    arrow = table.to_arrow()
    assert duckdb.sql('SELECT count(*) FROM arrow WHERE "ego.speed" >= 0').fetchone()[0] > 0
    assert arrow.num_rows == rows
