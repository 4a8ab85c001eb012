"""A connection of the server that ends when the head of a request is not whole in time.

uvicorn closes a connection that is idle behind an answer, and the guard one whose body does not
come; a client that sends half a head would stay for ever, and enough of them would take every file
that the process may open.
"""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

HEAD_PATIENCE = 10.0
"""Seconds from the first byte of a head, or from the connection, to its end.

At loopback a millisecond is enough.
"""
MOST = 128
"""Connections at once.

A page holds six, and a process may open 256 files where the least is allowed.
"""


class Punctual(H11Protocol):
    """uvicorn's connection with a deadline for the head of each request."""

    _late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a head.

        Where there are too many connections, end the one that waits longest.
        """
        super().connection_made(transport)
        self._await_head()
        if len(self.connections) > MOST:
            _end_oldest(self.connections)

    def data_received(self, data: bytes) -> None:
        """Take what came; half a head starts the clock, a whole one stops it."""
        super().data_received(data)
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the clock."""
        self._stop()
        super().connection_lost(exc)

    def _await_head(self) -> None:
        if self.conn.their_state is not h11.IDLE:
            self._stop()
        elif self._late is None and not self.transport.is_closing():
            self._late = self.loop.call_later(HEAD_PATIENCE, self.transport.close)

    def _stop(self) -> None:
        if self._late is not None:
            self._late.cancel()
            self._late = None


def _end_oldest(connections: set[Any]) -> None:
    """Close the connection that has waited longest for a head, but none that is being answered."""
    waiting = [
        (each._late.when(), each.transport) for each in connections if each._late is not None
    ]
    if waiting:
        _, transport = min(waiting, key=lambda pair: pair[0])
        transport.abort()
