"""Makes moving.glb and moving.json with Blender's Python module: an animated scene by its exporter, and the positions of its vertices in Blender.

    python3.11 -m venv v && v/bin/pip install bpy==5.0.1 numpy
    v/bin/python tests/blender/moving.py

tests/host/gltf_animation.rs loads frames of moving.glb and compares their meshes with moving.json: by frame and object the vertices after all
modifiers, in glTF's axes (y up). The exporter writes a key for each of the frames 1 to 24.
"""

import json
import math
import pathlib

import bpy  # first: it brings the other modules
import bmesh
from mathutils import Vector

FOLDER = pathlib.Path(__file__).resolve().parent
FRAMES = [1, 8, 17, 24]


def mesh_object(name, make):
    """An object with the mesh that a function of bmesh makes."""
    made = bmesh.new()
    make(made)
    mesh = bpy.data.meshes.new(name)
    made.to_mesh(mesh)
    made.free()
    placed = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(placed)
    return placed


def key(what, path, frames):
    """Keys of a property: its values by frame."""
    for frame, value in frames.items():
        setattr(what, path, value)
        what.keyframe_insert(path, frame=frame)


def tube():
    """A tube along z from 0 to 3 that bends with three bones, and follows an empty that moves, turns and scales."""
    placed = mesh_object("tube", lambda made: bmesh.ops.create_cone(
        made, segments=8, radius1=0.4, radius2=0.4, depth=3.0))
    for vertex in placed.data.vertices:
        vertex.co.z += 1.5
    made = bmesh.new()
    made.from_mesh(placed.data)
    along = [edge for edge in made.edges if abs(edge.verts[0].co.z - edge.verts[1].co.z) > 1]
    bmesh.ops.subdivide_edges(made, edges=along, cuts=5)
    made.to_mesh(placed.data)
    made.free()

    armature = bpy.data.armatures.new("bones")
    rig = bpy.data.objects.new("rig", armature)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    above = None
    for number in range(3):
        bone = armature.edit_bones.new(f"bone{number}")
        bone.head, bone.tail = Vector((0, 0, number)), Vector((0, 0, number + 1))
        bone.parent, above = above, bone
    bpy.ops.object.mode_set(mode="OBJECT")
    for number in range(3):
        group = placed.vertex_groups.new(name=f"bone{number}")
        for vertex in placed.data.vertices:
            # All three have a weight nearly everywhere.
            weight = math.exp(-((vertex.co.z - number - 0.5) ** 2))
            group.add([vertex.index], weight, "REPLACE")
    placed.parent = rig
    placed.modifiers.new("bones", "ARMATURE").object = rig
    for number, angle in enumerate([0.2, 0.9, -1.3]):
        bone = rig.pose.bones[f"bone{number}"]
        bone.rotation_mode = "QUATERNION"
        key(bone, "rotation_quaternion", {
            1: (1, 0, 0, 0),
            24: (math.cos(angle), math.sin(angle) * 0.6, math.sin(angle) * 0.64, math.sin(angle) * 0.48),
        })
    key(rig.pose.bones["bone2"], "scale", {1: (1, 1, 1), 24: (1.4, 0.8, 1.1)})
    empty = bpy.data.objects.new("empty", None)
    bpy.context.scene.collection.objects.link(empty)
    rig.parent = empty
    key(empty, "location", {1: (0, 0, 0), 12: (1, -2, 0.5), 24: (-1, 0, 0)})
    key(empty, "rotation_euler", {1: (0, 0, 0), 24: (0.4, 0.3, 2.5)})
    key(empty, "scale", {1: (1, 1, 1), 24: (1.5, 0.7, 1.2)})
    return placed


def ball():
    """A ball with two shape keys, on a node that mirrors and scales unevenly."""
    placed = mesh_object("ball", lambda made: bmesh.ops.create_icosphere(made, subdivisions=1, radius=0.5))
    placed.shape_key_add(name="Basis")
    for name, by in [("long", Vector((0, 0, 1.0))), ("wide", Vector((1.0, 0.5, 0)))]:
        shape = placed.shape_key_add(name=name)
        for vertex, point in zip(placed.data.vertices, shape.data):
            # The upper half alone, so that most of the deltas are 0: the exporter writes sparse accessors.
            if vertex.co.z > 0.4:
                point.co = vertex.co + by
    blocks = placed.data.shape_keys.key_blocks
    key(blocks["long"], "value", {1: 0.0, 24: 1.0})
    key(blocks["wide"], "value", {1: 0.75, 12: 0.0, 24: 0.25})
    placed.location = (3, 0, 0)
    placed.scale = (-1, 1.5, 1)
    key(placed, "rotation_euler", {1: (0, 0, 0), 24: (1, 2, 0)})
    return placed


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 24, 1, 24
    objects = [tube(), ball()]
    positions = {}
    for frame in FRAMES:
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        positions[str(frame)] = {}
        for placed in objects:
            evaluated = placed.evaluated_get(graph)
            mesh = evaluated.to_mesh()
            world = [evaluated.matrix_world @ vertex.co for vertex in mesh.vertices]
            positions[str(frame)][placed.name] = [[round(x, 6) for x in (p.x, p.z, -p.y)] for p in world]
            evaluated.to_mesh_clear()
    scene.frame_set(1)
    bpy.ops.export_scene.gltf(filepath=str(FOLDER / "moving.glb"), export_influence_nb=8, export_animations=True)
    text = json.dumps(positions, separators=(",", ":"))
    (FOLDER / "moving.json").write_text(text.replace("]],", "]],\n") + "\n")


main()
