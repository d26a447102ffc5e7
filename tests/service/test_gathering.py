"""What is written to a connection in one turn of the loop, and how it goes out."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from service.gathering import MOST_BYTES, SLICE, Gathering


class Transport:
    """What a transport was told, in order; its socket has room for so many bytes until some are `taken`."""

    def __init__(self, room=10**9):
        self.told, self.room, self.left = [], room, 0

    def set_write_buffer_limits(self, high):
        assert high == 0

    def write(self, data):
        assert self.left == 0
        self.told.append(bytes(data))
        self.left = max(0, len(data) - self.room)
        self.room = max(0, self.room - len(data))

    def taken(self, room):
        self.room, self.left = max(0, room - self.left), max(0, self.left - room)

    def write_eof(self):
        self.told.append("eof")

    def close(self):
        self.told.append("close")

    def abort(self):
        self.told.append("abort")

    def get_write_buffer_size(self):
        return self.left

    def is_closing(self):
        return "close" in self.told


def told(scenario, room=10**9):
    """What the transport was told by a coroutine function that has it gathered."""

    async def whole():
        transport = Transport(room)
        await scenario(Gathering(transport, asyncio.get_running_loop()), transport)
        return transport.told

    return asyncio.run(whole())


def test_head_and_content_of_a_small_answer_go_out_together():
    async def scenario(gathering, transport):
        gathering.write(b"head,")
        gathering.write(b"content")
        assert transport.told == []
        assert gathering.get_write_buffer_size() == 12
        await asyncio.sleep(0)
        assert gathering.get_write_buffer_size() == 0
        gathering.write(b"next")
        await asyncio.sleep(0)

    assert told(scenario) == [b"head,content", b"next"]


def test_pieces_of_one_event_go_out_as_if_they_were_joined():
    numbers = memoryview(np.arange(4.0))

    async def scenario(gathering, transport):
        gathering.write([b"20\r\n", numbers, b"\r\n"])
        gathering.write([])
        assert gathering.get_write_buffer_size() == 4 + 32 + 2
        await asyncio.sleep(0)

    assert told(scenario) == [b"20\r\n" + bytes(numbers) + b"\r\n"]


def test_large_pieces_are_not_held_and_come_after_what_was():
    piece = b"x" * MOST_BYTES

    async def scenario(gathering, transport):
        gathering.write(b"head")
        gathering.write(piece)
        assert transport.told == [b"head", piece]
        gathering.write(b"end")
        await asyncio.sleep(0)

    assert told(scenario) == [b"head", piece, b"end"]


def test_large_piece_waits_in_slices_for_a_client_that_takes_its_time():
    piece = bytes(range(256)) * (SLICE // 64)  # four slices

    async def scenario(gathering, transport):
        gathering.write(piece)
        assert [len(part) for part in transport.told] == [SLICE, SLICE]
        assert gathering.is_holding
        assert gathering.get_write_buffer_size() == len(piece) - SLICE - 10
        gathering.write(b"end")
        await asyncio.sleep(0)
        transport.taken(SLICE)  # not all that it has
        gathering.push()
        assert len(transport.told) == 3
        transport.taken(10**9)
        gathering.push()
        assert not gathering.is_holding

    parts = told(scenario, room=SLICE + 10)
    assert b"".join(parts) == piece + b"end"
    assert max(map(len, parts)) == SLICE


@pytest.mark.parametrize("size", [3 * SLICE, 10])
def test_connection_is_closed_when_all_is_on_its_way(size):
    async def scenario(gathering, transport):
        gathering.write(b"x" * size)
        gathering.close()
        assert gathering.is_closing()
        while gathering.is_holding:
            assert "close" not in transport.told
            transport.taken(SLICE)
            gathering.push()

    *parts, last = told(scenario, room=10)
    assert last == "close"
    assert b"".join(parts) == b"x" * size


def test_what_is_left_for_a_client_that_has_gone_is_dropped():
    async def scenario(gathering, transport):
        gathering.write(b"x" * (3 * SLICE))
        gathering.drop()
        transport.taken(10**9)
        gathering.push()

    assert [len(part) for part in told(scenario, room=10)] == [SLICE]


def test_what_ends_a_connection_comes_after_what_was_written():
    async def closed(gathering, transport):
        gathering.write(b"last")
        gathering.close()

    async def ended(gathering, transport):
        gathering.write(b"last")
        gathering.write_eof()

    assert told(closed) == [b"last", "close"]
    assert told(ended) == [b"last", "eof"]


def test_all_else_is_the_transports_own():
    async def scenario(gathering, transport):
        gathering.abort()

    assert told(scenario) == ["abort"]
