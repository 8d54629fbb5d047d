#!/usr/bin/env python3
"""Writes the OpenVDB files of this folder: make bpy && target/bpy/bin/python tests/corpus/vdb/make.py

blosc, levels, several and half are Blender's. Blender writes no other compression, so zip, mask and plain are from here, and OpenVDB
reads what is expected of them. The formulas of the values stand in src/scene/grid_files/tests.rs too.
"""

import gzip
import os
import struct
import sys
import zlib

import bpy

sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python/lib/python3.11/site-packages"))
import openvdb  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))


def formula(x, y, z):
    """Exact in half floats where it is used."""
    return 0.125 * x + y * y - z


def ball(grid, radius):
    """Active voxels within a radius of (-12, 12, 12), and inactive ones of two other values around it."""
    accessor = grid.getAccessor()
    reach = range(-radius - 2, radius + 3)
    for x, y, z in ((x, y, z) for x in reach for y in reach for z in reach):
        far = abs(x) + abs(y) + abs(z) - radius
        voxel = x - 12, y + 12, z + 12
        if far <= 0:
            accessor.setValueOn(voxel, formula(x, y, z))
        elif far <= 2:
            accessor.setValueOff(voxel, [-3.0, 7.0][far - 1])
    return grid


def grid_of(name, background=0.0, voxel=1.0, half=False):
    grid = openvdb.FloatGrid(background)
    grid.name, grid.saveFloatAsHalf = name, half
    grid.transform = openvdb.createLinearTransform(voxel)
    return grid


def write(name, grids):
    path = os.path.join(HERE, name)
    openvdb.write(path, grids=grids, metadata={"author": "make.py", "year": 2024, "place": (1.0, 2.0, 3.0)})
    with open(path, "r+b") as file:
        file.seek(21)  # The UUID would be another each time.
        file.write(b"0" * 36)


def blenders():
    density = ball(grid_of("density", voxel=0.5), 9)
    shared = density.copy()
    shared.name, shared.transform = "shared", openvdb.createLinearTransform(2.0)
    shared.transform.postTranslate((1.0, 2.0, 3.0))
    write("blosc.vdb", [density, shared])

    levels = grid_of("levels", 2.5)
    levels.fill((4096, 0, 0), (8191, 4095, 4095), 5.0)
    levels.fill((0, 0, 0), (127, 127, 127), 0.5)
    levels.fill((128, 0, 0), (135, 7, 7), 0.25)
    levels.fill((136, 0, 0), (143, 7, 7), 9.0, False)
    levels.fill((144, 0, 0), (151, 7, 7), 2.5)
    levels.transform.postTranslate((-1.0, 0.5, 0.0))
    write("levels.vdb", [levels])

    several = [grid_of("density", voxel=voxel) for voxel in (1.0, 3.0)]
    for number, grid in enumerate(several):
        grid.getAccessor().setValueOn((number, 2, 3), 4.0 + number)
    write("several.vdb", several)

    half = ball(grid_of("tilted", 0.5, half=True), 5)
    matrix = [(0.5, 0.125, 0, 0), (0, 0.25, 0, 0), (0, 0.125, 1, 0), (3, -4, 5, 1)]
    half.transform = openvdb.createLinearTransform(matrix)
    write("half.vdb", [half])


def text(string):
    return struct.pack("<I", len(string)) + string.encode()


def mask(bits, count):
    return sum(1 << bit for bit in bits).to_bytes(count // 8, "little")


def packed(values, flags):
    data = struct.pack(f"<{len(values)}f", *values)
    small = zlib.compress(data, 9)
    if not flags & 1:
        return data
    return struct.pack("<q", len(small)) + small if len(small) < len(data) else struct.pack("<q", -len(data)) + data


def leaf(kind, flags, background):
    """The mask of a leaf, its 512 values, and their bytes. Every third voxel is active."""
    active = [i for i in range(512) if i % 3 == 0]
    plus, other = {0: (background, 0), 1: (-background, 0), 2: (7.0, 0), 3: (-background, background),
                   4: (7.0, background), 5: (7.0, -3.0), 6: (7.0, -3.0)}[kind]  # fmt: skip
    chosen = {i for i in range(512) if i % 5 == 0} if kind >= 3 else set()
    values = [0.125 * i + kind if i % 3 == 0 else other if i in chosen else plus for i in range(512)]
    data = bytes([kind]) + struct.pack("<2f", 7.0, -3.0)[: {2: 4, 4: 4, 5: 8}.get(kind, 0)]
    data += mask(chosen, 512) if 3 <= kind <= 5 else b""
    stored = values if kind == 6 or not flags & 2 else [values[i] for i in active]
    return mask(active, 512), values, data + packed(stored, flags)


def by_hand(name, version, flags, background, corner, kinds, tiles=()):
    """A file with a node at `corner`, in which a leaf of each of these kinds follows another along z, and with tiles of the root."""
    leaves = [leaf(kind, flags, background) for kind in kinds]

    def node(count, children):
        stored = [] if flags & 2 else [background] * count
        return mask(children, count) + mask([], count) + b"\0" + packed(stored, flags)

    tree = struct.pack("<ifII", 1, background, len(tiles), 1)
    for tile in tiles:
        tree += struct.pack("<iiifB", *tile)
    tree += struct.pack("<iii", *corner) + node(32768, [0]) + node(4096, range(len(leaves)))
    tree += b"".join(active for active, _, _ in leaves)
    tree += b"".join(active + data for active, _, data in leaves)
    scale = struct.pack("<15d", *[0.5] * 6, *[2.0] * 3, *[4.0] * 3, *[1.0] * 3)
    grid = struct.pack("<II", flags, 0) + text("ScaleMap") + scale + tree
    head = b" BDV\0\0\0\0" + struct.pack("<IIIB", version, 12, 0, 1) + b"0" * 36 + struct.pack("<II", 0, 1)
    head += text("density") + text("Tree_float_5_4_3") + text("")
    start = len(head) + 24
    data = head + struct.pack("<3q", start, start + 1, start + len(grid)) + grid
    path = os.path.join(HERE, name)
    with open(path, "wb") as file:
        file.write(data)
    read = openvdb.read(path, "density").getConstAccessor()
    x, y, z = corner
    for k, (_, values, _) in enumerate(leaves):
        for i in range(512):
            found = read.getValue((x + (i >> 6), y + (i >> 3 & 7), z + 8 * k + (i & 7)))
            assert found == values[i], (name, k, i, found, values[i])
    return data


blenders()
by_hand("zip.vdb", 223, 3, 1.5, (0, 0, 0), range(7))
least, most = -(1 << 31), (1 << 31) - 4096
by_hand("mask.vdb", 222, 2, 0.0, (least, least, least), [0, 2, 5], [(most, most, most, 0.75, 1), (0, 0, 0, 0.5, 0)])
plain = by_hand("plain.vdb", 224, 0, 1.5, (-4096, 0, 4096), [6])
with open(os.path.join(HERE, "plain.vdb.gz"), "wb") as file:
    file.write(gzip.compress(plain, 9, mtime=0))
os.remove(os.path.join(HERE, "plain.vdb"))
