"""Makes of the program's EXR one whose passes RenderResult.load_from_file finds."""

import struct

MULTIPART = 1 << 12
LONG_NAMES = 1 << 10
# Attributes that only files of several parts have.
OF_PARTS = (b"name", b"type", b"chunkCount")


def _text(stream):
    return b"".join(iter(lambda: stream.read(1), b"\0"))


def _header(stream):
    """The attributes of a part by their names, each a type and bytes. Empty after the last part."""
    attributes = {}
    while name := _text(stream):
        kind = _text(stream)
        (size,) = struct.unpack("<i", stream.read(4))
        attributes[name] = (kind, stream.read(size))
    return attributes


def attributes(path):
    """The header of the picture."""
    with open(path, "rb") as stream:
        stream.seek(8)
        return _header(stream)


def held_samples(path):
    """One past the last sample index that the image holds; 0 if the file is no image of a render."""
    try:
        return struct.unpack("<i", attributes(path)[b"gpu-rt:end_sample"][1])[0]
    except (OSError, KeyError, struct.error):
        return 0


def write_for_layer(source, target, layer):
    """Copies the picture of a render: one part, without the state, and channels such as `ViewLayer.Depth.Z`, which begin with the
    name of the view layer. Blender finds no channels in files of several parts."""
    with open(source, "rb") as stream, open(target, "wb") as out:
        magic, version = struct.unpack("<ii", stream.read(8))
        parts = [_header(stream)]
        while version & MULTIPART and (header := _header(stream)):
            parts.append(header)
        header = {name: value for name, value in parts[0].items() if name not in OF_PARTS}
        _, top, _, bottom = struct.unpack("<4i", header[b"dataWindow"][1])
        offsets = struct.unpack(f"<{bottom - top + 1}Q", stream.read(8 * (bottom - top + 1)))
        kind, channels = header[b"channels"]
        header[b"channels"] = kind, _renamed(channels, layer.encode() + b".")
        head = struct.pack("<ii", magic, version & ~MULTIPART | LONG_NAMES)
        head += b"".join(name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data for name, (kind, data) in header.items()) + b"\0"
        out.write(head + bytes(8 * len(offsets)))
        new_offsets = []
        for offset in offsets:
            # In a file of several parts, a chunk begins with the number of its part.
            stream.seek(offset + (4 if version & MULTIPART else 0))
            row = stream.read(8)
            new_offsets.append(out.tell())
            out.write(row + stream.read(struct.unpack("<ii", row)[1]))
        out.seek(len(head))
        out.write(struct.pack(f"<{len(new_offsets)}Q", *new_offsets))


def _renamed(channels, prefix):
    """The list of channels with a prefix before all their names, which keeps their order: that of the pixels in the file."""
    renamed, at = b"", 0
    while channels[at]:
        end = channels.index(0, at)
        renamed += prefix + channels[at:end + 17]
        at = end + 17
    return renamed + b"\0"
