"""Makes blur-*.ron and blur-*.exr with Blender's Python module: three scenes with motion blur as scene files, and images of them by Cycles.

    python3.11 -m venv v && v/bin/pip install bpy==5.0.1 numpy
    v/bin/python tests/blender/blur.py

Positions are in our axes (y up), and keys are of frames 0 and 2, 24 of them a second. Blender's shutter is open for a whole frame with frame 1 in
its middle. Images have twice the side of those that tests/images/blender.rs compares, and a box as the pixel filter.
"""

import math
import pathlib

import bpy  # first: it brings the other modules
from mathutils import Matrix, Vector

FOLDER = pathlib.Path(__file__).resolve().parent
SIZE = (64, 48)
SAMPLES = 1024
SHUTTER = (0.5 / 24, 1.5 / 24)
FOV = 40.0
SKY = (0.5, 0.6, 0.8)
COLOURS = {"floor": (0.5, 0.5, 0.45), "red": (0.7, 0.1, 0.08), "blue": (0.08, 0.2, 0.6), "lamp": (18.0, 14.0, 9.0)}


def blender(point):
    """A point in Blender's axes (z up)."""
    x, y, z = point
    return Vector((x, -z, y))


def material(name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    shader = nodes.new("ShaderNodeEmission" if name == "lamp" else "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*COLOURS[name], 1.0)
    made.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def mesh(name, corners, faces, of):
    made = bpy.data.meshes.new(name)
    made.from_pydata([blender(corner) for corner in corners], [], faces)
    made.materials.append(material(of))
    placed = bpy.data.objects.new(name, made)
    bpy.context.scene.collection.objects.link(placed)
    return placed


def box(name, low, high, of):
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    text = f'Box(min: {low}, max: {high}, material: "{of}")'
    return mesh(name, corners, faces, of), text


def quad(name, corner, u, v, of):
    add = lambda *points: tuple(sum(parts) for parts in zip(*points))
    corners = [corner, add(corner, u), add(corner, u, v), add(corner, v)]
    text = f'Quad(corner: {corner}, u: {u}, v: {v}, material: "{of}")'
    return mesh(name, corners, [(0, 1, 2, 3)], of), text


def linear(action_of):
    """Makes all keys of an object linear."""
    action = action_of.animation_data.action
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                for curve in bag.fcurves:
                    for point in curve.keyframe_points:
                        point.interpolation = "LINEAR"


def moving(text, first, last):
    keys = ", ".join(f"({frame / 24!r}, [{key}])" for frame, key in ((0, first), (2, last)))
    return f"Moving(keys: [{keys}], object: {text})"


def shifted(placed, text, first, last):
    """Moves an object from one place to another."""
    for frame, at in ((0, first), (2, last)):
        placed.location = blender(at)
        placed.keyframe_insert("location", frame=frame)
    linear(placed)
    return moving(text, f"Translate({first})", f"Translate({last})")


def spun(placed, text, at, degrees):
    """Turns an object around our z axis, at a place."""
    placed.location = blender(at)
    for frame, angle in ((0, 0.0), (2, degrees)):
        # Our z axis is Blender's -y.
        placed.rotation_euler = (0.0, -math.radians(angle), 0.0)
        placed.keyframe_insert("rotation_euler", frame=frame)
    linear(placed)
    placed.cycles.motion_steps = 7
    return moving(text, f"RotateZ(0), Translate({at})", f"RotateZ({degrees}), Translate({at})")


def camera(first, last, target):
    """A camera that looks at a point and may move."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(FOV)
    placed = bpy.data.objects.new("camera", data)
    scene = bpy.context.scene
    scene.collection.objects.link(placed)
    scene.camera = placed
    empty = bpy.data.objects.new("target", None)
    empty.location = blender(target)
    scene.collection.objects.link(empty)
    follow = placed.constraints.new("TRACK_TO")
    follow.target, follow.track_axis, follow.up_axis = empty, "TRACK_NEGATIVE_Z", "UP_Y"
    placed.location = blender(first)
    text = f"look_from: {first}, look_at: {target}"
    if last != first:
        shifted(placed, "", first, last)
        key = lambda at: f"(look_from: {at}, look_at: {target})"
        text += f", moving: [({0 / 24!r}, {key(first)}), ({2 / 24!r}, {key(last)})]"
    return text


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*SKY, 1.0)
    scene.world = world
    scene.render.engine = "CYCLES"
    scene.render.fps = 24
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 1.0
    scene.render.motion_blur_position = "CENTER"
    scene.frame_set(1)
    return scene


def make(name, view, objects):
    """Writes a scene as a scene file, and its image by Cycles."""
    scene = bpy.context.scene
    materials = "".join(
        f'        "{of}": ' + (f"DiffuseLight(emit: Rgb{colour}, two_sided: true)" if of == "lamp" else f"Lambertian(albedo: Rgb{colour})") + ",\n"
        for of, colour in COLOURS.items()
    )
    (FOLDER / name).with_suffix(".ron").write_text(
        "// Written by blur.py, with its image by Cycles.\nScene(\n"
        f"    image: (width: {SIZE[0]}, height: {SIZE[1]}),\n"
        f"    camera: ({view}, vertical_fov: {FOV}, shutter: {SHUTTER}),\n"
        f"    background: Solid({SKY}),\n    materials: {{\n{materials}    }},\n    objects: [\n"
        + "".join(f"        {text},\n" for text in objects)
        + "    ],\n    render: (samples: 64, max_depth: 8),\n)\n"
    )
    cycles, render = scene.cycles, scene.render
    cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", SAMPLES, False, False
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.diffuse_bounces = 8
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    render.resolution_x, render.resolution_y, render.resolution_percentage = 2 * SIZE[0], 2 * SIZE[1], 100
    scene.view_settings.view_transform = "Raw"
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGB", "16", "PIZ"
    render.filepath = str((FOLDER / name).with_suffix(".exr"))
    bpy.ops.render.render(write_still=True)


def floor_and_lamp():
    return [
        quad("floor", (-6, 0, 6), (12, 0, 0), (0, 0, -12), "floor")[1],
        quad("lamp", (-2.5, 3.5, -0.5), (1, 0, 0), (0, 0, 1), "lamp")[1],
        box("still", (1.1, 0, -1.4), (1.9, 0.9, -0.6), "blue")[1],
    ]


VIEW = ((0.5, 2.2, 5.5), (0.5, 2.2, 5.5), (0, 0.7, 0))


def translation():
    empty_scene()
    objects = floor_and_lamp()
    objects.append(shifted(*box("red", (-0.4, 0, -0.4), (0.4, 0.8, 0.4), "red"), (-1.8, 0.1, 0.6), (1.0, 0.7, 0.0)))
    make("blur-translation", camera(*VIEW), objects)


def rotation():
    empty_scene()
    objects = floor_and_lamp()
    objects.append(spun(*box("red", (-1.2, -0.15, -0.3), (1.2, 0.15, 0.3), "red"), (-0.3, 1.3, 0.2), 160))
    make("blur-rotation", camera(*VIEW), objects)


def moving_camera():
    empty_scene()
    objects = floor_and_lamp()
    objects.append(box("red", (-1.2, 0, -0.3), (-0.4, 0.8, 0.5), "red")[1])
    make("blur-camera", camera((-0.4, 2.0, 5.5), (1.4, 2.6, 5.0), (0, 0.7, 0)), objects)


translation()
rotation()
moving_camera()
