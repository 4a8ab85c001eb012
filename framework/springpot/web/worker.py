"""A worker process: one line of JSON in, some lines out.

What reads files and fits models, and can be ended.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from typing import Any


def main() -> None:
    """Answer until the other end of standard input is closed."""
    # Ctrl-C is for the server, which ends its workers itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # A descriptor of its own for answers, since the usual one is given away below.
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # What foreign code prints is no answer.
    os.dup2(2, 1)

    from springpot.hooks import KINDS
    from springpot.limits import own_process
    from springpot.registry import plugins
    from springpot.report.text import to_json

    from .tasks import perform

    def say(line: dict[str, Any]) -> None:
        out.write(to_json(line, None) + "\n")
        # Line by line: a stage that waits in a buffer is told too late.
        out.flush()

    # Before the first task comes: what it needs is imported while nobody waits.
    for word in KINDS:
        plugins().shelf(word)
    say({"ready": True})

    def told(stage: str | dict[str, Any]) -> None:
        say({"stage": stage} if isinstance(stage, str) else stage)

    with own_process():
        for line in sys.stdin:
            asked = json.loads(line)
            say(perform(asked["task"], asked["arguments"], told))


if __name__ == "__main__":
    main()
