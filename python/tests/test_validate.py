"""Findings of labels: one document, or a column of an Arrow table of another library."""

import json
from pathlib import Path

import pyarrow as pa
import whyroad

ROOT = Path(__file__).resolve().parents[2]
GOOD = (ROOT / "examples/cutin_urgent_example.json").read_text(encoding="utf-8")


def test_a_valid_label_has_no_findings() -> None:
    assert [f for f in whyroad.validate(GOOD) if f.severity == "error"] == []


def test_findings_have_code_and_position() -> None:
    bad = json.loads(GOOD)
    label = bad.get("coc_label", bad)
    label["driving_decision"]["longitudinal"] = "brake"
    found = whyroad.validate(bad)
    assert any(f.code == "label.enum.longitudinal" and f.pointer for f in found)
    zh = whyroad.validate(bad, lang="zh")
    assert [f.code for f in zh] == [f.code for f in found]
    assert [f.message for f in zh] != [f.message for f in found]


def test_a_table_of_labels_in_either_text_type() -> None:
    for kind in (pa.string(), pa.large_string(), pa.string_view()):
        table = pa.table({"label": pa.array([GOOD, "{", None, GOOD], kind)})
        found = pa.table(whyroad.validate(table))
        assert set(found.filter(pa.compute.equal(found["severity"], "error")).column("row").to_pylist()) == {1}
