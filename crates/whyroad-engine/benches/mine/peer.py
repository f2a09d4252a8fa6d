"""Answers the questions of the bench `mine` by DuckDB or Polars: argument 1 says which, argument 2 is the folder of the
stored signals. Reads lines `condition<TAB>least_ns`, writes `seconds cpu_seconds episodes`: unbroken runs of the condition, target by
target, that last at least so long (gaps and islands: the filter comes first, so that only rows that hold are numbered)."""

import sys
import time

engine, folder = sys.argv[1:3]
TARGETS, FRAMES = f"{folder}/*/targets.parquet", f"{folder}/*/frames.parquet"

if engine == "duckdb":
    import duckdb

    connection = duckdb.connect()

    def ask(condition, least):
        join = f"JOIN read_parquet('{FRAMES}') f USING (drive_id, frame)" if "ego." in condition else ""
        return connection.execute(f"""
            WITH held AS (
              SELECT drive_id, target_id, frame, t.time_ns,
                     frame - row_number() OVER (PARTITION BY drive_id, target_id ORDER BY frame) AS island
              FROM read_parquet('{TARGETS}') t {join} WHERE {condition}),
            runs AS (SELECT drive_id, target_id, island, min(time_ns) AS first, max(time_ns) AS last
                     FROM held GROUP BY ALL)
            SELECT count(*) FROM runs WHERE last - first + 100000000 >= {least}""").fetchone()[0]

elif engine == "polars":
    import polars as pl

    def ask(condition, least):
        rows = pl.scan_parquet(TARGETS)
        if "ego." in condition:
            ego = pl.scan_parquet(FRAMES).select("drive_id", "frame", "ego.speed")
            rows = rows.join(ego, on=["drive_id", "frame"])
        held = rows.filter(pl.sql_expr(condition)).select("drive_id", "target_id", "frame", "time_ns")
        # The files are in the order of target and frame; only a join may change it.
        if "ego." in condition:
            held = held.sort("drive_id", "target_id", "frame")
        # A run ends where the next row is not the next frame.
        new = (
            (pl.col("frame").cast(pl.Int64).diff() != 1)
            | (pl.col("target_id") != pl.col("target_id").shift())
            | (pl.col("drive_id") != pl.col("drive_id").shift())
        ).fill_null(True)
        runs = held.with_columns(new.cum_sum().alias("run")).group_by("run").agg(
            pl.col("time_ns").min().alias("first"), pl.col("time_ns").max().alias("last")
        )
        long = runs.filter(pl.col("last") - pl.col("first") + 100_000_000 >= least)
        return long.select(pl.len()).collect(engine="streaming").item()


print("ready", flush=True)
for line in sys.stdin:
    condition, least = line.rstrip("\n").split("\t")
    start, cpu = time.perf_counter(), time.process_time()
    count = ask(condition, int(least))
    print(f"{time.perf_counter() - start} {time.process_time() - cpu} {count}", flush=True)
