"""Arrow across the border in both directions: the same buffers, by address."""

import numpy as np
import pyarrow as pa
import pytest
import whyroad


def addresses(table: pa.Table) -> list[list[int | None]]:
    """The addresses of all buffers of a table, column by column."""
    return [
        [None if b is None else b.address for chunk in table.column(name).chunks for b in chunk.buffers()]
        for name in table.column_names
    ]


def made() -> pa.Table:
    number = pa.array(np.arange(1000.0))
    text = pa.array([None if i % 7 == 0 else f"row {i}" for i in range(1000)])
    nested = pa.array([[i, i + 1] for i in range(1000)], pa.list_(pa.int64()))
    return pa.table({"number": number, "text": text, "nested": nested})


def test_in_and_out_again_are_the_same_buffers() -> None:
    source = made()
    table = whyroad.Table.from_arrow(source)
    assert len(table) == 1000 and table.column_names == ["number", "text", "nested"]
    back = pa.table(table)
    assert back.equals(source)
    assert addresses(back) == addresses(source)


def test_a_table_can_be_read_many_times_without_copies() -> None:
    table = whyroad.Table.from_arrow(made())
    assert addresses(pa.table(table)) == addresses(pa.table(table))
    assert pa.schema(table) == made().schema


def test_slices_keep_their_offsets() -> None:
    source = made().slice(10, 5)
    table = whyroad.Table.from_arrow(source)
    assert pa.table(table).equals(source)
    assert pa.table(table).column("number").to_pylist() == [10.0, 11.0, 12.0, 13.0, 14.0]


def test_a_record_batch_and_tables_of_other_libraries_come_in() -> None:
    batch = made().to_batches()[0]
    assert addresses(pa.table(whyroad.Table.from_arrow(batch)))[0] == addresses(made_of(batch))[0]
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame({"number": [1.0, 2.0, None]})
    assert pa.table(whyroad.Table.from_arrow(frame)).column("number").to_pylist() == [1.0, 2.0, None]
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"number": [1.0, 2.0]})
    assert pa.table(whyroad.Table.from_arrow(frame)).column("number").to_pylist() == [1.0, 2.0]


def made_of(batch: pa.RecordBatch) -> pa.Table:
    return pa.Table.from_batches([batch])


def test_the_table_outlives_what_it_came_from() -> None:
    table = whyroad.Table.from_arrow(pa.table({"x": pa.array(np.arange(100_000.0))}))
    out = pa.table(table)
    del table
    assert out.column("x").chunk(0).to_numpy(zero_copy_only=True).sum() == 99_999 * 50_000


def test_what_is_no_table_is_refused() -> None:
    with pytest.raises(TypeError, match="__arrow_c_stream__"):
        whyroad.Table.from_arrow([1, 2, 3])
    with pytest.raises(TypeError, match="nulls"):
        whyroad.Table.from_arrow(pa.array([{"a": 1}, None]))
