"""``validate``: what is wrong with labels and other messages."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from whyroad._whyroad import Table, validate_table, validate_text

if TYPE_CHECKING:
    from whyroad._whyroad import ArrowArray, ArrowStream


@dataclass(frozen=True)
class Finding:
    """One finding: a stable code, a severity, a message, and where it is."""

    code: str
    severity: str
    message: str
    hint: str | None
    line: int | None
    column: int | None
    pointer: str | None


@overload
def validate(document: str | bytes | Mapping[str, Any], *, lang: str = "en") -> list[Finding]: ...
@overload
def validate(document: ArrowStream | ArrowArray, *, column: str = "label", lang: str = "en") -> Table: ...
def validate(document: Any, *, column: str = "label", lang: str = "en") -> list[Finding] | Table:
    """Checks one document, or every document in a text column of an Arrow table.

    ``document`` is JSON text, a dictionary, or a table of any library with the Arrow PyCapsule interface. A document
    gives a list of findings (empty: valid). A table gives a table with the columns row, code, severity, message, hint,
    location.
    """
    if hasattr(document, "__arrow_c_stream__") or hasattr(document, "__arrow_c_array__"):
        return validate_table(document, column, lang)
    if isinstance(document, bytes):
        document = document.decode("utf-8")
    elif not isinstance(document, str):
        document = json.dumps(document, ensure_ascii=False)
    return [_finding(json.loads(row)) for row in validate_text(document, lang)]


def _finding(row: dict[str, Any]) -> Finding:
    place = row.get("place") or row.get("location") or {}
    return Finding(
        code=row["code"],
        severity=row["severity"],
        message=row["message"],
        hint=row.get("hint"),
        line=place.get("line"),
        column=place.get("column"),
        pointer=place.get("pointer"),
    )
