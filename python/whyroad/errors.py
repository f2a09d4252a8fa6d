"""What calls raise and warn with: the code, message, hint and location of a diagnostic.

Every code has a page in docs/reference/diagnostics.md.
"""

from __future__ import annotations


class WhyroadError(Exception):
    """A failure. ``code`` is stable and documented; ``message`` and ``hint`` are for people."""

    def __init__(self, code: str, message: str, hint: str | None = None, location: str | None = None) -> None:
        super().__init__(code, message, hint, location)
        self.code = code
        self.message = message
        self.hint = hint
        self.location = location

    def __str__(self) -> str:
        where = f"{self.location}: " if self.location else ""
        hint = f" ({self.hint})" if self.hint else ""
        return f"[{self.code}] {where}{self.message}{hint}"


class WhyroadWarning(UserWarning):
    """Something was left out of a result; the message begins with the code of its diagnostic."""
