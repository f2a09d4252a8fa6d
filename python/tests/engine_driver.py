"""A driver of an engine, as a process of its own that tests can kill:

    python engine_driver.py ENGINE LAKE RULE MARKS OUT VICTIM

mines the lake and writes ``OUT/rows`` and ``OUT/report`` (Parquet), whole or not at all. ENGINE is ``ray``,
``ray-nodes`` (two nodes; prints the process ids of the second one) or ``spark`` (two executors)."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from engine_work import Slow


def on_ray(work: Slow) -> tuple[pa.Table, pa.Table]:
    import ray

    size = {"num_cpus": 2, "object_store_memory": 100_000_000}
    ray.init(address="local", include_dashboard=False, log_to_driver=False, **size)
    return mined_on_ray(work)


def on_two_nodes(work: Slow, publish: Any) -> None:
    import ray
    from ray.cluster_utils import Cluster

    size = {"num_cpus": 1, "object_store_memory": 100_000_000}
    cluster = Cluster(initialize_head=True, head_node_args=size)
    try:
        second = cluster.add_node(**size)
        ray.init(address=cluster.address, log_to_driver=False)
        processes = [info.process.pid for infos in second.all_processes.values() for info in infos]
        print("node", *processes, flush=True)
        publish(*mined_on_ray(work))
        ray.shutdown()
    finally:
        try:
            cluster.shutdown()
        except Exception as e:  # noqa: BLE001
            # All is published: that a process of the killed node is gone is an error for Ray.
            print(f"shutdown: {e}", flush=True)
    # The same again for what Ray does at exit.
    os._exit(0)


def mined_on_ray(work: Slow) -> tuple[pa.Table, pa.Table]:
    import ray
    import whyroad.ray

    ray.data.DataContext.get_current().enable_progress_bars = False
    rows, report = whyroad.ray.split(whyroad.ray.run(work, drives_per_task=2).materialize())
    return arrow(rows), arrow(report)


def arrow(dataset: Any) -> pa.Table:
    tables = [pa.table(t) for t in dataset.iter_batches(batch_format="pyarrow", batch_size=None)]
    return pa.concat_tables([t for t in tables if t.num_rows], promote_options="permissive")


def on_spark(work: Slow) -> tuple[pa.Table, pa.Table]:
    import whyroad.spark
    from pyspark.sql import SparkSession

    os.environ["PYSPARK_PYTHON"] = sys.executable
    # Executors in processes of their own, as on a cluster.
    builder = SparkSession.builder.master("local-cluster[2,1,700]").config("spark.ui.enabled", "false")
    builder = builder.config("spark.executor.memory", "700m").config("spark.driver.memory", "700m")
    spark = builder.getOrCreate()
    spark.sparkContext.setLogLevel("ERROR")
    rows, report = whyroad.spark.split(whyroad.spark.run(spark, work, partitions=6).persist())
    return rows.toArrow(), report.toArrow()


def main() -> None:
    engine, lake, rule, marks, out, victim = sys.argv[1:7]
    work = Slow(lake, rule, marks=marks, victim=victim)

    def publish(rows: pa.Table, report: pa.Table) -> None:
        fresh = Path(out + ".new")
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir(parents=True)
        pq.write_table(rows, fresh / "rows")
        pq.write_table(report, fresh / "report")
        os.rename(fresh, out)

    if engine == "ray-nodes":
        on_two_nodes(work, publish)
    elif engine == "ray":
        publish(*on_ray(work))
    else:
        publish(*on_spark(work))


if __name__ == "__main__":
    main()
