"""The notebook in docs/tutorial runs as it is, in a folder where `whyroad demo` has run.

`WHYROAD_WRITE=1 pytest python/tests/test_tutorial.py` writes the outputs into the notebook again.
"""

import ast
import contextlib
import io
import json
import os
from pathlib import Path
from typing import Any

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs/tutorial/python.ipynb"


def execute(source: str, names: dict[str, Any]) -> list[dict[str, Any]]:
    """Runs a cell as Jupyter does: what it prints, then the value of a last line that is an expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    value = None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": printed.getvalue().splitlines(True)})
    if value is not None:
        text = {"text/plain": repr(value).splitlines(True)}
        outputs.append({"data": text, "execution_count": 0, "metadata": {}, "output_type": "execute_result"})
    return outputs


def test_the_tutorial_runs(demo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("pandas", "polars", "duckdb"):
        pytest.importorskip(package)
    (tmp_path / "whyroad-demo").symlink_to(demo)
    monkeypatch.chdir(tmp_path)
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    names: dict[str, Any] = {}
    ran = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        ran += 1
        outputs = execute("".join(cell["source"]), names)
        for output in outputs:
            if "execution_count" in output:
                output["execution_count"] = ran
        if os.environ.get("WHYROAD_WRITE"):
            cell["outputs"], cell["execution_count"] = outputs, ran
        # Numbers may move with the rules; what kind of output a cell has may not.
        kinds = [o["output_type"] for o in cell["outputs"]]
        assert [o["output_type"] for o in outputs] == kinds, "".join(cell["source"])
        assert cell["execution_count"] == ran
    assert ran >= 8
    if os.environ.get("WHYROAD_WRITE"):
        NOTEBOOK.write_text(json.dumps(notebook, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
