"""``validate``: what is wrong with labels and other messages."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from whyroad._whyroad import Table, validate_table, validate_text


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


def validate(document: str | bytes | dict[str, Any] | Any, *, column: str = "label", lang: str = "en") -> list[Finding] | Table:
    """Checks one document, or every document in a text column of an Arrow table.

    ``document`` is JSON text, a dictionary, or any object with ``__arrow_c_stream__``. A document gives a list of
    findings (empty: valid). A table gives a table with the columns row, code, severity, message, hint, location.
    """
    if hasattr(document, "__arrow_c_stream__"):
        return validate_table(document, column, lang)
    if isinstance(document, bytes):
        document = document.decode("utf-8")
    elif not isinstance(document, str):
        document = json.dumps(document, ensure_ascii=False)
    return [_finding(json.loads(row)) for row in validate_text(document, lang)]


def _finding(row: dict[str, Any]) -> Finding:
    place = row.get("location") or row.get("place") or {}
    return Finding(
        code=row["code"],
        severity=row["severity"],
        message=row["message"],
        hint=row.get("hint"),
        line=place.get("line"),
        column=place.get("column"),
        pointer=place.get("pointer"),
    )
