"""Recordings and logs as LCM's own event files, read without this project's code."""

import struct


def read_events(path):
    """Returns the complete events of an LCM log, and True if bytes are left behind them."""
    data, at, events = path.read_bytes(), 0, []
    while len(data) - at >= 28:
        sync, number, _, channel, length = struct.unpack_from(">IqqII", data, at)
        assert sync == 0xEDA1DA01 and number == len(events), f"{path}: byte {at} of {len(data)}"
        if at + 28 + channel + length > len(data):
            break
        events.append((data[at + 28:at + 28 + channel].decode(), data[at + 28 + channel:at + 28 + channel + length]))
        at += 28 + channel + length
    return events, at < len(data)


def read_ticks(path):
    """Returns the ticks of the complete tick records."""
    events, _ = read_events(path)
    return [struct.unpack_from(">q", data)[0] for channel, data in events if channel == "UNLATCH_LOG_TICK"]
