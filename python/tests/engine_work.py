"""Work of the tests of faults: mining that takes a while, and leaves a mark of each drive when it begins."""

from __future__ import annotations

import os
import time
import uuid
from dataclasses import dataclass
from pathlib import Path

import whyroad
from whyroad.per_drive import Mine


@dataclass(frozen=True)
class Slow(Mine):
    """Mining that can be killed in the middle."""

    marks: str = ""
    seconds: float = 0.4
    #: A drive that kills its process whenever it is worked on.
    victim: str = ""

    def run(self, drives: list[str]) -> whyroad.Table:
        for drive in drives:
            # Process of the drive, and the worker that started it.
            mark = Path(self.marks) / f"{drive} {uuid.uuid4().hex}"
            mark.write_text(f"{os.getpid()} {os.getppid()}", encoding="utf-8")
            if drive == self.victim:
                os.kill(os.getpid(), 9)
            time.sleep(self.seconds)
        return super().run(drives)
