"""Reads the program's EXRs. RenderResult.load_from_file does not: it finds no channels in files of several parts, such as those with a
state to go on from, nor for view layers with long names, and Blender's passes have z up."""

import struct
import zlib

import numpy as np

from .process import Failure

MULTIPART = 1 << 12
# Rows by themselves, each compressed by zlib.
ZIP1 = 2


def _text(stream):
    return b"".join(iter(lambda: stream.read(1), b"\0"))


def _header(stream):
    """The attributes of a part by their names, as bytes. Empty after the last part."""
    attributes = {}
    while name := _text(stream):
        _text(stream)  # its type
        (size,) = struct.unpack("<i", stream.read(4))
        attributes[name] = stream.read(size)
    return attributes


def held_samples(path):
    """One past the last sample index that the image holds; 0 if there is no such image."""
    try:
        with open(path, "rb") as stream:
            stream.seek(8)
            return struct.unpack("<i", _header(stream)[b"gpu-rt:end_sample"])[0]
    except (OSError, KeyError, struct.error):
        return 0


def read(path):
    """The channels of the picture by their names: f32, height x width, row 0 at the bottom as Blender has it."""
    with open(path, "rb") as stream:
        _, version = struct.unpack("<ii", stream.read(8))
        header = _header(stream)
        while version & MULTIPART and _header(stream):
            pass
        if header[b"compression"][0] != ZIP1:
            raise Failure(f"{path} is of another version of gpu-rt: its compression is {header[b'compression'][0]}")
        left, top, right, bottom = struct.unpack("<4i", header[b"dataWindow"])
        names = _names(header[b"channels"])
        width, height = right - left + 1, bottom - top + 1
        pixels = np.empty((height, len(names), width), "<f4")
        for offset in struct.unpack(f"<{height}Q", stream.read(8 * height)):
            # In a file of several parts, a row begins with the number of its part.
            stream.seek(offset + (4 if version & MULTIPART else 0))
            y, size = struct.unpack("<ii", stream.read(8))
            pixels[height - 1 - (y - top)] = _row(stream.read(size), pixels[0].nbytes).view("<f4").reshape(len(names), width)
    return {name: pixels[:, index] for index, name in enumerate(names)}


def _names(channels):
    """The names of channels, whose pixels stand in this order. All are of 32 bits."""
    names, at = [], 0
    while channels[at]:
        end = channels.index(0, at)
        names.append(channels[at:end].decode())
        at = end + 17
    return names


def _row(data, size):
    """The bytes of a row. Compressed, they are differences of neighbours around 128: those at even places, then those at odd ones."""
    if len(data) == size:
        return np.frombuffer(data, np.uint8)
    differences = np.frombuffer(zlib.decompress(data), np.uint8) - np.uint8(128)
    differences[:1] += np.uint8(128)
    halves = np.cumsum(differences, dtype=np.uint8)
    row = np.empty(size, np.uint8)
    row[0::2], row[1::2] = halves[:(size + 1) // 2], halves[(size + 1) // 2:]
    return row
