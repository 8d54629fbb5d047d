"""Makes still-life.glb with Blender's Python module: what File > Export > glTF 2.0 writes of such a scene.

    python3.11 -m venv v && v/bin/pip install bpy==5.0.1 numpy
    v/bin/python scenes/still-life.py

A plant with cut-out leaves, a glazed bowl with limes, a copper pot and a bottle of green glass, on a table of planks with a
normal map and a texture of roughness, beside a window.
"""

import math
import pathlib
import random

import bpy  # first: it brings the other modules
import bmesh
import numpy as np
from mathutils import Vector

OUT = pathlib.Path(__file__).resolve().parent / "still-life.glb"
RANDOM = random.Random(1888)
PIXELS = np.random.default_rng(1888)


def image(name, pixels, colours=True):
    """An image of floats (height, width, 3 or 4), row 0 at the bottom."""
    height, width, channels = pixels.shape
    if channels == 3:
        pixels = np.concatenate([pixels, np.ones((height, width, 1))], axis=2)
    made = bpy.data.images.new(name, width, height, alpha=channels == 4)
    made.colorspace_settings.name = "sRGB" if colours else "Non-Color"
    made.pixels = pixels.astype(np.float32).ravel()
    made.pack()
    return made


def material(name, colour=(0.8, 0.8, 0.8), roughness=0.5, metallic=0.0, emission=None, base=None, rough=None, normal=None, leaf=False):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic

    def texture(picture):
        node = nodes.new("ShaderNodeTexImage")
        node.image = picture
        return node

    if emission:
        shader.inputs["Emission Color"].default_value = (*emission[0], 1.0)
        shader.inputs["Emission Strength"].default_value = emission[1]
    if base:
        node = texture(base)
        links.new(node.outputs["Color"], shader.inputs["Base Color"])
        if leaf:
            # Alpha above a half: MASK of glTF.
            cut = nodes.new("ShaderNodeMath")
            cut.operation = "GREATER_THAN"
            cut.inputs[1].default_value = 0.5
            links.new(node.outputs["Alpha"], cut.inputs[0])
            links.new(cut.outputs[0], shader.inputs["Alpha"])
    if rough:
        split = nodes.new("ShaderNodeSeparateColor")
        links.new(texture(rough).outputs["Color"], split.inputs["Color"])
        links.new(split.outputs["Green"], shader.inputs["Roughness"])
        links.new(split.outputs["Blue"], shader.inputs["Metallic"])
    if normal:
        bumps = nodes.new("ShaderNodeNormalMap")
        links.new(texture(normal).outputs["Color"], bumps.inputs["Color"])
        links.new(bumps.outputs["Normal"], shader.inputs["Normal"])
    return made


def glass(name, thickness, colour, distance):
    made = material(name, (1.0, 1.0, 1.0), roughness=0.0)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes["Principled BSDF"].inputs["Transmission Weight"].default_value = 1.0
    volume = nodes.new("ShaderNodeVolumeAbsorption")
    volume.inputs["Color"].default_value = (*colour, 1.0)
    volume.inputs["Density"].default_value = 1.0 / distance
    links.new(volume.outputs["Volume"], nodes["Material Output"].inputs["Volume"])
    tree = bpy.data.node_groups.new("glTF Material Output", "ShaderNodeTree")
    tree.interface.new_socket("Thickness", in_out="INPUT", socket_type="NodeSocketFloat")
    group = nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    group.inputs["Thickness"].default_value = thickness
    return made


def place(name, mesh, materials, at=(0, 0, 0), turn=(0, 0, 0), scale=(1, 1, 1)):
    for one in materials:
        mesh.materials.append(one)
    made = bpy.data.objects.new(name, mesh)
    made.location, made.rotation_euler, made.scale = at, turn, scale
    bpy.context.scene.collection.objects.link(made)
    return made


def mesh_of(name, vertices, faces, uvs=None, smooth=False):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    if uvs:
        layer = mesh.uv_layers.new()
        for face in mesh.polygons:
            for corner, vertex in zip(face.loop_indices, face.vertices):
                layer.data[corner].uv = uvs[vertex]
    for face in mesh.polygons:
        face.use_smooth = smooth
    return mesh


def sheet(name, corner, u, v, repeat=(1, 1)):
    corner, u, v = Vector(corner), Vector(u), Vector(v)
    uvs = [(0, 0), (repeat[0], 0), repeat, (0, repeat[1])]
    return mesh_of(name, [corner, corner + u, corner + u + v, corner + v], [(0, 1, 2, 3)], uvs)


def turned(name, profile, columns=64, smooth=True):
    """A surface of revolution around z, of points (radius, height)."""
    vertices, faces = [], []
    for radius, height in profile:
        for column in range(columns):
            angle = math.tau * column / columns
            vertices.append((radius * math.cos(angle), radius * math.sin(angle), height))
    for row in range(len(profile) - 1):
        for column in range(columns):
            a, b = row * columns + column, row * columns + (column + 1) % columns
            faces.append((a, b, b + columns, a + columns))
    mesh = mesh_of(name, vertices, faces, smooth=smooth)
    # Points on the axis become one vertex.
    shape = bmesh.new()
    shape.from_mesh(mesh)
    bmesh.ops.remove_doubles(shape, verts=shape.verts, dist=1e-5)
    bmesh.ops.recalc_face_normals(shape, faces=shape.faces)
    shape.to_mesh(mesh)
    shape.free()
    for face in mesh.polygons:
        face.use_smooth = smooth
    return mesh


def rounded(points, steps=6):
    """A smooth curve through points (Catmull and Rom)."""
    points = [points[0], *points, points[-1]]
    curve = []
    for a, b, c, d in zip(points, points[1:], points[2:], points[3:]):
        for step in range(steps):
            t = step / steps
            curve.append(tuple(
                0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t**2 + (3 * q - p - 3 * r + s) * t**3)
                for p, q, r, s in zip(a, b, c, d)))
    return curve + [points[-1]]


def noise(size, cells):
    """Smooth noise in 0..1 that repeats."""
    grid = PIXELS.random((cells, cells))
    at = np.arange(size) * cells / size
    low = np.floor(at).astype(int)
    part = at - low
    part = part * part * (3 - 2 * part)
    high = (low + 1) % cells
    rows = grid[low] * (1 - part)[:, None] + grid[high] * part[:, None]
    return rows[:, low] * (1 - part) + rows[:, high] * part


def planks(size=256, boards=4):
    """Colour, numbers (roughness in green) and normals of boards along x."""
    y, x = np.mgrid[0:size, 0:size] / size
    board = np.floor(y * boards)
    across = y * boards - board
    grain = noise(size, 8)[:, :, None]
    rings = 0.5 + 0.5 * np.sin(60 * (across + 0.35 * noise(size, 4) + board * 1.7 + 0.04 * np.sin(9 * x)))
    tone = (0.75 + 0.25 * np.sin(board * 2.4))[:, :, None]
    dark, light = np.array([0.46, 0.29, 0.17]), np.array([0.74, 0.54, 0.35])
    colour = (dark + (light - dark) * (0.65 * rings[:, :, None] + 0.35 * grain)) * tone
    gap = np.minimum(across, 1 - across) * size / boards
    colour *= np.clip(gap / 2.0, 0.25, 1.0)[:, :, None]
    # Steps keep the file small.
    steps = lambda pixels, count: np.round(pixels * count) / count
    rough = 0.35 + 0.25 * rings + 0.15 * grain[:, :, 0]
    numbers = np.stack([np.zeros_like(rough), steps(rough, 40), np.zeros_like(rough)], axis=2)
    slope = np.where(gap < 3.0, np.where(across < 0.5, -0.5, 0.5), 0.0)
    normals = np.stack([np.zeros_like(slope), slope, np.ones_like(slope)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return steps(np.clip(colour, 0, 1), 64), numbers, 0.5 + 0.5 * normals


def leaf(size=64):
    """A leaf with veins, cut out by its alpha."""
    y, x = np.mgrid[0:size, 0:size] / (size - 1)
    across, along = 2 * x - 1, y
    width = 0.92 * np.sin(math.pi * along**0.8) ** 0.9
    inside = np.abs(across) < width * (1 + 0.05 * np.sin(40 * along))
    vein = (np.abs(across) < 0.04) | (np.abs((along - 0.35 * np.abs(across)) * 9 % 1 - 0.5) < 0.06)
    colour = np.where(vein[:, :, None], [0.42, 0.60, 0.25], [0.16, 0.38, 0.13])
    return np.concatenate([colour, inside[:, :, None].astype(float)], axis=2)


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    wood, numbers, normals = planks()
    table = material("Planks", base=image("Planks", wood), rough=image("Worn", numbers, False),
                     normal=image("Gaps", normals, False))
    plaster = material("Plaster", (0.66, 0.62, 0.56), roughness=1.0)
    copper = material("Copper", (0.94, 0.55, 0.40), roughness=0.22, metallic=1.0)
    glaze = material("Glaze", (0.06, 0.16, 0.42), roughness=0.12)
    lime = material("Lime", (0.42, 0.60, 0.08), roughness=0.35)
    earth = material("Earth", (0.10, 0.07, 0.05), roughness=1.0)
    clay = material("Clay", (0.62, 0.27, 0.15), roughness=0.8)
    leaves = material("Leaf", roughness=0.4, base=image("Leaf", leaf()), leaf=True)
    bottle = glass("Bottle glass", 0.1, (0.30, 0.75, 0.42), 0.35)
    window = material("Window", (0, 0, 0), emission=((0.80, 0.90, 1.0), 16.0))
    ember = material("Lantern", (0, 0, 0), emission=((1.0, 0.55, 0.22), 10.0))

    place("Table", sheet("Table", (-4, -3, 0), (8, 0, 0), (0, 5.5, 0), (3, 2)), [table])
    place("Wall", sheet("Wall", (-6, 2.5, -2), (12, 0, 0), (0, 0, 8)), [plaster])
    place("Window", sheet("Window", (-4.2, -2.2, 0.9), (0, 3.2, 0), (0, 0, 2.8)), [window])

    pot = rounded([(0.0, 0.02), (0.52, 0.02), (0.60, 0.10), (0.62, 0.60), (0.58, 0.74), (0.64, 0.78)]) \
        + rounded([(0.62, 0.80), (0.56, 0.75), (0.58, 0.60), (0.55, 0.12), (0.0, 0.10)])
    place("Pot", turned("Pot", pot), [copper], at=(1.55, -0.1, 0))
    bowl = rounded([(0.0, 0.0), (0.28, 0.0), (0.30, 0.06), (0.62, 0.30), (0.78, 0.52)]) \
        + rounded([(0.75, 0.53), (0.58, 0.33), (0.25, 0.12), (0.0, 0.11)])
    place("Bowl", turned("Bowl", bowl), [glaze], at=(0.15, -1.0, 0))
    ball = rounded([(0.0, -0.21), (0.12, -0.17), (0.2, 0.0), (0.12, 0.17), (0.0, 0.21)], 5)
    round_one = turned("Lime", ball, 32)
    round_one.materials.append(lime)
    for at, turn in [((0.0, -1.12, 0.36), 0.4), ((0.36, -0.95, 0.40), 1.3), ((0.06, -0.78, 0.38), 2.2), ((0.16, -0.98, 0.66), 0.9)]:
        place("Lime", round_one, [], at=at, turn=(1.2, 0.3, turn))
    outside = [(0.0, 0.0), (0.26, 0.0), (0.30, 0.05), (0.30, 0.95), (0.24, 1.15), (0.10, 1.32), (0.09, 1.62), (0.11, 1.66)]
    inside = [(0.075, 1.66), (0.06, 1.60), (0.065, 1.33), (0.20, 1.12), (0.25, 0.93), (0.25, 0.12), (0.20, 0.06), (0.0, 0.08)]
    place("Bottle", turned("Bottle", rounded(outside) + rounded(inside)), [bottle], at=(0.75, 0.75, 0))

    flower_pot = [(0.0, 0.0), (0.36, 0.0), (0.46, 0.62), (0.52, 0.62), (0.52, 0.76), (0.45, 0.76), (0.43, 0.66), (0.0, 0.66)]
    place("Flower pot", turned("Flower pot", flower_pot, smooth=False), [clay], at=(-1.3, 0.35, 0))
    place("Earth", turned("Earth", [(0.44, 0.0), (0.0, 0.03)], 48), [earth], at=(-1.3, 0.35, 0.65))
    # A leaf is bent along three quads.
    rows = [(0.0, 0.0), (0.4, 0.16), (0.8, 0.20), (1.2, 0.08)]
    vertices = [(side * 0.27, y, z) for y, z in rows for side in (-1, 1)]
    uvs = [((side + 1) / 2, row / 3) for row in range(4) for side in (-1, 1)]
    blade = mesh_of("Leaf", vertices, [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(3)], uvs, smooth=True)
    blade.materials.append(leaves)
    for number in range(26):
        turn, rise = number * 2.399963, math.radians(78 - 62 * (number / 25) ** 0.8 + RANDOM.uniform(-6, 6))
        size = RANDOM.uniform(0.75, 1.1)
        place("Leaf", blade, [], at=(-1.3, 0.35, 0.70 + 0.25 * RANDOM.random()), turn=(rise, 0.0, turn), scale=(size, size, size))
    place("Lantern", turned("Lantern", ball, 24), [ember], at=(2.05, 1.5, 2.2), scale=(1.1, 1.1, 1.1))

    camera = bpy.data.cameras.new("Camera")
    camera.angle = math.radians(40)
    seen = bpy.data.objects.new("Camera", camera)
    seen.location = (0.35, -6.6, 2.15)
    seen.rotation_euler = (Vector((0.1, 0.0, 0.95)) - seen.location).to_track_quat("-Z", "Y").to_euler()
    scene = bpy.context.scene
    scene.collection.objects.link(seen)
    scene.camera = seen
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    bpy.ops.export_scene.gltf(filepath=str(OUT), export_format="GLB", export_cameras=True, export_yup=True, export_apply=True)


if __name__ == "__main__":
    main()
