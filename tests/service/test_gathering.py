"""What is written to a connection in one turn of the loop, and how it goes out."""

from __future__ import annotations

import asyncio

from service.gathering import MOST_BYTES, Gathering


class Transport:
    """What a transport was told, in order."""

    def __init__(self):
        self.told = []

    def write(self, data):
        self.told.append(bytes(data))

    def write_eof(self):
        self.told.append("eof")

    def close(self):
        self.told.append("close")

    def abort(self):
        self.told.append("abort")

    def get_write_buffer_size(self):
        return 7


def told(scenario):
    """What the transport was told by a coroutine function that has it gathered."""

    async def whole():
        transport = Transport()
        await scenario(Gathering(transport, asyncio.get_running_loop()), transport)
        return transport.told

    return asyncio.run(whole())


def test_head_and_content_of_a_small_answer_go_out_together():
    async def scenario(gathering, transport):
        gathering.write(b"head,")
        gathering.write(b"content")
        assert transport.told == []
        assert gathering.get_write_buffer_size() == 7 + 12
        await asyncio.sleep(0)
        assert gathering.get_write_buffer_size() == 7
        gathering.write(b"next")
        await asyncio.sleep(0)

    assert told(scenario) == [b"head,content", b"next"]


def test_large_pieces_are_neither_held_nor_copied_and_come_after_what_was_held():
    piece = b"x" * MOST_BYTES

    async def scenario(gathering, transport):
        gathering.write(b"head")
        gathering.write(piece)
        assert transport.told == [b"head", piece]
        gathering.write(b"end")
        await asyncio.sleep(0)

    assert told(scenario) == [b"head", piece, b"end"]


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
