"""Makes the scenes of this folder with Blender's Python module: NAME.glb by its exporter, NAME.exr by Cycles.

    python3.11 -m venv v && v/bin/pip install bpy==5.0.1 numpy
    v/bin/python tests/blender/make.py                 # all of them, a quarter of an hour on one core
    v/bin/python tests/blender/make.py room --spp 64   # one of them, noisy

tests/images/blender.rs renders each .glb and compares it with the .exr: linear Rec. 709. docs/gltf.md has the differences that remain.

Of the scenes of SCENES, Cycles is set so that it renders what the .glb says: 160 by 120 pixels, GGX without multiple scattering, no
clamping, no blur of caustics, all bounces, a box as the pixel filter, no offset at the shadow terminator.

Those of USERS are Blender's startup file with a few changes, as users make them, and exported with the boxes that the README names. Cycles
renders the .blend with Blender's settings, except for its samples, without adaptive sampling and denoising, and with a box as the pixel
filter: 80 by 60 pixels.
"""

import argparse
import math
import pathlib

import bpy  # first: it brings the other modules
import bmesh
import numpy as np
from mathutils import Vector

FOLDER = pathlib.Path(__file__).resolve().parent
SIZE = (160, 120)
SMALL_SIZE = (80, 60)


def material(name, colour=(0.8, 0.8, 0.8), roughness=1.0, metallic=0.0, specular=0.5, transmission=0.0, ior=1.5,
             emission=(0.0, 0.0, 0.0), strength=0.0, thickness=0.0):
    """A Principled BSDF. `specular` is 0.5 for the reflectance that its `ior` has, and 0 for none: KHR_materials_specular."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    principled = made.node_tree.nodes["Principled BSDF"]
    principled.distribution = "GGX"
    for socket, value in {
        "Base Color": (*colour, 1.0), "Roughness": roughness, "Metallic": metallic, "Specular IOR Level": specular,
        "Transmission Weight": transmission, "IOR": ior, "Emission Color": (*emission, 1.0), "Emission Strength": strength,
    }.items():
        principled.inputs[socket].default_value = value
    if thickness > 0.0:
        group = made.node_tree.nodes.new("ShaderNodeGroup")
        group.node_tree = gltf_output()
        group.inputs["Thickness"].default_value = thickness
    return made


def gltf_output():
    """The node group by whose name the exporter finds the thickness of KHR_materials_volume."""
    name = "glTF Material Output"
    if name not in bpy.data.node_groups:
        group = bpy.data.node_groups.new(name, "ShaderNodeTree")
        group.interface.new_socket("Thickness", in_out="INPUT", socket_type="NodeSocketFloat")
    return bpy.data.node_groups[name]


def matt(name, colour):
    return material(name, colour, specular=0.0)


def lamp(name, strength, colour=(1.0, 1.0, 1.0)):
    return material(name, (0.0, 0.0, 0.0), specular=0.0, emission=colour, strength=strength)


def node(made, kind, **inputs):
    """A new node; an input is a value, or the socket that it is linked with."""
    new = made.node_tree.nodes.new(kind)
    for name, value in inputs.items():
        link(made, value, new.inputs[name]) if isinstance(value, bpy.types.NodeSocket) else \
            setattr(new.inputs[name], "default_value", value)
    return new


def link(made, output, to):
    made.node_tree.links.new(output, to)


def principled(made):
    return made.node_tree.nodes["Principled BSDF"].inputs


def image(name, pixels, linear=False):
    """An image of 8 bits from codes / 255, row 0 on top, of three or four channels."""
    height, width, channels = pixels.shape
    made = bpy.data.images.new(name, width, height, alpha=channels == 4)
    made.colorspace_settings.name = "Non-Color" if linear else "sRGB"
    made.alpha_mode = "CHANNEL_PACKED" if channels == 4 else "NONE"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels[::-1]
    made.pixels.foreach_set(rgba.ravel())
    made.update()
    made.pack()
    return made


def textured(made, picture):
    new = made.node_tree.nodes.new("ShaderNodeTexImage")
    new.image = picture
    return new.outputs


def thing(name, mesh, made, at=(0, 0, 0), turn=(0, 0, 0), scale=(1, 1, 1), smooth=False, parent=None):
    """An object with a mesh and a material. Angles are in degrees."""
    mesh = mesh.copy()
    mesh.materials.append(made)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    new = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(new)
    new.location, new.scale, new.parent = at, scale, parent
    new.rotation_euler = [math.radians(angle) for angle in turn]
    # Cycles lifts the origin of shadow rays on smooth meshes by a tenth of their edges.
    new.shadow_terminator_geometry_offset = 0.0
    new.shadow_terminator_shading_offset = 0.0
    return new


def built(build):
    shape, mesh = bmesh.new(), bpy.data.meshes.new("mesh")
    build(shape)
    shape.to_mesh(mesh)
    shape.free()
    return mesh


def square():
    """From (-1, -1, 0) to (1, 1, 0), with the texture once."""
    mesh = built(lambda shape: bmesh.ops.create_grid(shape, x_segments=1, y_segments=1, size=1.0))
    uvs = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        x, y, _ = mesh.vertices[loop.vertex_index].co
        uvs.data[loop.index].uv = (0.5 * x + 0.5, 0.5 * y + 0.5)
    return mesh


def box():
    return built(lambda shape: bmesh.ops.create_cube(shape, size=2.0))


def ball(subdivisions=4):
    return built(lambda shape: bmesh.ops.create_icosphere(shape, subdivisions=subdivisions, radius=1.0))


def globe():
    """A sphere with texture coordinates."""
    return built(lambda shape: bmesh.ops.create_uvsphere(shape, u_segments=48, v_segments=24, radius=1.0, calc_uvs=bool(
        shape.loops.layers.uv.new("UVMap"))))


def monkey():
    """With faces so small that it hardly matters how a renderer treats normals that are not those of the face."""
    coarse = bpy.data.objects.new("Coarse", built(bmesh.ops.create_monkey))
    bpy.context.collection.objects.link(coarse)
    coarse.modifiers.new("Finer", "SUBSURF").levels = 1
    fine = bpy.data.meshes.new_from_object(coarse.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(coarse)
    return fine


def light(kind, name, strength, at, to, colour=(1.0, 1.0, 1.0), **more):
    """A light without size that looks at a point. `strength` is in watts, and for a sun in watts per square metre."""
    data = bpy.data.lights.new(name, kind)
    data.energy, data.color = strength, colour
    if kind == "SUN":
        data.angle = 0.0
    else:
        data.shadow_soft_size = 0.0
    for field, value in more.items():
        setattr(data, field, value)
    new = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(new)
    look(new, at, to)
    return new


def look(new, at, to):
    new.location = at
    new.rotation_euler = (Vector(to) - Vector(at)).to_track_quat("-Z", "Y").to_euler()


def camera(at, to, angle):
    """`angle` is the horizontal one, in degrees."""
    data = bpy.data.cameras.new("Camera")
    data.angle = math.radians(angle)
    new = bpy.data.objects.new("Camera", data)
    bpy.context.collection.objects.link(new)
    look(new, at, to)
    bpy.context.scene.camera = new


def room():
    """Daylight through a window: all light is from a panel outside and from a sun without size."""
    white, red, green = (matt("White", (0.75, 0.73, 0.7)), matt("Red", (0.6, 0.12, 0.1)), matt("Green", (0.15, 0.45, 0.15)))
    thing("Floor", square(), matt("Parquet", (0.35, 0.22, 0.12)), scale=(2, 2, 1))
    thing("Ceiling", square(), white, (0, 0, 2.5), (180, 0, 0), (2, 2, 1))
    thing("Back", square(), white, (0, 2, 1.25), (90, 0, 0), (2, 1.25, 1))
    thing("Front", square(), white, (0, -2, 1.25), (-90, 0, 0), (2, 1.25, 1))
    thing("Right", square(), green, (2, 0, 1.25), (0, -90, 0), (1.25, 2, 1))
    # The left wall around the window, which is 2.6 by 1.6.
    for name, at, scale in (
        ("Below", (-2, 0, 0.3), (0.3, 2)), ("Above", (-2, 0, 2.35), (0.15, 2)),
        ("Before", (-2, -1.65, 1.4), (0.8, 0.35)), ("Behind", (-2, 1.65, 1.4), (0.8, 0.35)),
    ):
        thing(name, square(), red, at, (0, 90, 0), (*scale, 1))
    # The sun passes between them.
    thing("Horizon", square(), lamp("Haze", 1.2, (0.8, 0.9, 1.0)), (-6, 0, 0.2), (0, 90, 0), (2.2, 6, 1))
    thing("Sky", square(), lamp("Daylight", 9.0, (0.7, 0.85, 1.0)), (-2.8, 0, 2.9), (0, 30, 0), (0.7, 1.5, 1))
    light("SUN", "Sun", 9.0, (-4, -1, 2), (0, 0, 0), (1.0, 0.9, 0.75))
    thing("Table", box(), material("Lacquer", (0.15, 0.25, 0.5), roughness=0.6), (0.6, 0.6, 0.35), (0, 0, 25), (0.6, 0.4, 0.35))
    thing("Monkey", monkey(), material("Clay", (0.7, 0.4, 0.25), roughness=0.7), (0.6, 0.6, 1.05), (0, 0, -30), (0.4, 0.4, 0.4),
          smooth=True)
    camera((0.3, -1.9, 1.4), (0.05, 1, 1.05), 75)


def metals():
    """Spheres of five roughnesses and three colours."""
    thing("Floor", square(), matt("Grey", (0.4, 0.4, 0.42)), scale=(5, 5, 1))
    thing("Wall", square(), matt("Blue", (0.2, 0.3, 0.5)), (0, 3, 2), (90, 0, 0), (5, 2, 1))
    thing("Panel", square(), lamp("Panel", 5.0), (-1, -1.5, 3.5), (160, 0, 0), (1.6, 0.8, 1))
    thing("Side", square(), lamp("Warm", 3.0, (1.0, 0.7, 0.4)), (4, 0, 1.5), (0, -90, 0), (1, 1.5, 1))
    steel, gold, copper = (0.8, 0.8, 0.8), (0.95, 0.75, 0.35), (0.85, 0.5, 0.4)
    sphere = ball()
    for index, (roughness, colour) in enumerate(zip((0.0, 0.15, 0.3, 0.6, 1.0), (steel, gold, steel, copper, steel))):
        made = material(f"Metal {roughness}", colour, roughness, metallic=1.0)
        thing(made.name, sphere, made, (1.05 * (index - 2), 0.4 * (index % 2), 0.5), scale=(0.5, 0.5, 0.5), smooth=True)
    camera((0, -6, 2.2), (0, 0, 0.75), 50)


def glass():
    """Panes and a block with a thickness: clear, frosted by little and by much, before stripes."""
    for index in range(-6, 7):
        colour = ((0.75, 0.75, 0.7), (0.15, 0.3, 0.6), (0.7, 0.2, 0.15))[index % 3]
        thing(f"Stripe {index}", square(), matt(f"Stripe {index}", colour), (0.5 * index, 1.6, 1.5), (90, 0, 0), (0.25, 1.5, 1))
    thing("Floor", square(), matt("Floor", (0.5, 0.5, 0.5)), scale=(4, 4, 1))
    thing("Panel", square(), lamp("Panel", 4.0), (0, -1, 4), (180, 0, 0), (2.5, 1.5, 1))
    for index, roughness in enumerate((0.0, 0.25, 0.5)):
        made = material(f"Glass {roughness}", (1.0, 1.0, 1.0), roughness, transmission=1.0, ior=1.45, thickness=0.2)
        thing(f"Pane {roughness}", box(), made, (1.3 * (index - 1), 0.3, 0.8), (0, 0, 10 * (index - 1)), (0.55, 0.06, 0.75))
    made = material("Ball", (1.0, 1.0, 1.0), 0.15, transmission=1.0, ior=1.5, thickness=0.6)
    thing("Ball", ball(3), made, (0.7, -0.9, 0.36), scale=(0.35, 0.35, 0.35), smooth=True)
    camera((0, -5, 1.7), (0, 0, 0.85), 42)


def pattern(size=64):
    """A smooth pattern without symmetries, of three channels from 0 to 1."""
    y, x = np.mgrid[0:size, 0:size] / size
    return np.stack([0.5 + 0.5 * np.sin(2 * np.pi * (a * x + b * y) + c) for a, b, c in ((1, 2, 0.3), (3, -1, 1.0), (-2, 2, 2.0))], -1)


def bumps(size=128):
    """The normals of a field of bumps, as a normal map: y up, as glTF has it."""
    y, x = np.mgrid[0:size, 0:size] / size
    slope = 0.9
    across = slope * np.cos(2 * np.pi * 4 * x) * np.sin(2 * np.pi * 3 * y)
    down = slope * np.sin(2 * np.pi * 4 * x) * np.cos(2 * np.pi * 3 * y)
    normal = np.stack([-across, down, np.ones_like(x)], -1)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def with_normal_map(made, strength=1.0):
    colour = textured(made, image(f"Bumps of {made.name}", bumps(), linear=True))["Color"]
    mapped = node(made, "ShaderNodeNormalMap", Color=colour, Strength=strength)
    link(made, mapped.outputs["Normal"], principled(made)["Normal"])
    # Cycles bends normals that would mirror light into the surface.
    made.cycles.use_bump_map_correction = False


def textures():
    """Images of the base colour, of roughness and metal, and of normals."""
    thing("Floor", square(), matt("Floor", (0.5, 0.5, 0.5)), scale=(4, 4, 1))
    thing("Wall", square(), matt("Wall", (0.4, 0.45, 0.5)), (0, 2, 2), (90, 0, 0), (4, 2, 1))
    thing("Panel", square(), lamp("Panel", 5.0), (-1.5, -1.5, 3.5), (150, -20, 0), (1.2, 0.8, 1))
    light("SUN", "Sun", 1.5, (3, -4, 4), (0, 0, 0))
    picture = matt("Picture", (1, 1, 1))
    link(picture, textured(picture, image("Colours", 0.25 + 0.65 * pattern()))["Color"], principled(picture)["Base Color"])
    thing("Picture", square(), picture, (-1.3, 1.2, 1.0), (90, 0, 15), (0.9, 0.9, 1))
    worn = material("Worn", (0.9, 0.7, 0.4), metallic=1.0)
    split = node(worn, "ShaderNodeSeparateColor", Color=textured(worn, image("Wear", 0.1 + 0.8 * pattern(), linear=True))["Color"])
    link(worn, split.outputs["Green"], principled(worn)["Roughness"])
    link(worn, split.outputs["Blue"], principled(worn)["Metallic"])
    thing("Worn", globe(), worn, (-0.9, -0.8, 0.6), (0, 0, 40), (0.6, 0.6, 0.6), smooth=True)
    bumpy = matt("Bumpy", (0.7, 0.65, 0.6))
    with_normal_map(bumpy)
    thing("Bumpy", square(), bumpy, (1.3, 1.2, 1.0), (90, 0, -20), (0.9, 0.9, 1))
    dented = material("Dented", (0.8, 0.8, 0.85), roughness=0.35, metallic=1.0)
    with_normal_map(dented, 0.6)
    thing("Dented", globe(), dented, (0.9, -0.8, 0.6), (0, 0, 0), (0.6, 0.6, 0.6), smooth=True)
    camera((0, -5.5, 2.0), (0, 0, 0.85), 42)


def nodes():
    """Nodes that mirror, that scale unevenly, and that shear."""
    thing("Floor", square(), matt("Floor", (0.5, 0.5, 0.5)), scale=(5, 5, 1))
    thing("Wall", square(), matt("Wall", (0.45, 0.5, 0.6)), (0, 2.5, 2), (90, 0, 0), (5, 2, 1))
    thing("Panel", square(), lamp("Panel", 5.0), (-2, -2, 4), (150, -20, 0), (-1.4, 0.9, 1))
    light("SUN", "Sun", 1.0, (4, -3, 3), (0, 0, 0), (1.0, 0.85, 0.7))
    head = monkey()
    clay = material("Clay", (0.7, 0.4, 0.25), roughness=0.6)
    metal = material("Steel", (0.75, 0.75, 0.75), roughness=0.35, metallic=1.0)
    thing("Mirrored", head, clay, (-1.9, 0, 0.75), (0, 0, 25), (-0.7, 0.7, 0.7), smooth=True)
    thing("Uneven", head, metal, (-0.3, 0.3, 0.75), (0, 0, -20), (0.5, 1.1, 0.75), smooth=True)
    thing("Inside out", ball(3), clay, (0.35, -1.3, 0.35), (20, 30, 0), (-0.35, -0.2, -0.35), smooth=True)
    parent = bpy.data.objects.new("Stretched", None)
    bpy.context.collection.objects.link(parent)
    parent.location, parent.scale = (1.6, 0, 0.8), (1.3, 0.6, 0.8)
    thing("Sheared", head, clay, (0, 0, 0), (10, 30, -40), (0.7, 0.7, -0.7), smooth=True, parent=parent)
    thing("Sheared box", box(), metal, (0.2, -2.2, -0.6), (0, 0, 40), (0.3, 0.3, 0.3), parent=parent)
    camera((0, -6, 2.2), (0.2, 0, 0.7), 50)


def leaf(size=64):
    """A leaf that is opaque within, and green also where it is not."""
    y, x = np.mgrid[0:size, 0:size] / (size - 1) * 2 - 1
    along, across = (x + y) / math.sqrt(2), (x - y) / math.sqrt(2)
    inside = 1.2 * (1 - along**2) * (0.45 + 0.1 * along) - np.abs(across) + 0.04 * np.cos(20 * along)
    veins = 0.5 + 0.5 * np.cos(14 * (along + np.abs(across)))
    green = np.stack([0.25 + 0.25 * veins, 0.45 + 0.25 * veins, 0.12 + 0.08 * veins], -1)
    return np.concatenate([green, np.clip(0.5 + 4 * inside, 0, 1)[..., None]], -1)


def leaves():
    """Leaves that are cut out by their alpha, and a veil."""
    thing("Floor", square(), matt("Floor", (0.55, 0.5, 0.45)), scale=(4, 4, 1))
    thing("Wall", square(), matt("Wall", (0.5, 0.5, 0.55)), (0, 2, 2), (90, 0, 0), (4, 2, 1))
    thing("Panel", square(), lamp("Panel", 4.0), (1.5, -2, 3.5), (150, 20, 0), (1.2, 0.8, 1))
    light("SUN", "Sun", 2.0, (-3, -3, 5), (0, 0, 0), (1.0, 0.9, 0.8))
    made = matt("Leaf", (1, 1, 1))
    outputs = textured(made, image("Leaf", leaf()))
    link(made, outputs["Color"], principled(made)["Base Color"])
    is_inside = node(made, "ShaderNodeMath")
    is_inside.operation = "GREATER_THAN"
    is_inside.inputs[1].default_value = 0.5
    link(made, outputs["Alpha"], is_inside.inputs[0])
    link(made, is_inside.outputs[0], principled(made)["Alpha"])
    turns = np.random.default_rng(1)
    flat = square()
    for index in range(24):
        at = turns.uniform((-1.9, -0.8, 0.3), (1.0, 0.9, 2.3))
        thing(f"Leaf {index}", flat, made, at, turns.uniform(-60, 60, 3) + (60, 0, 0), (0.35, 0.35, 1))
    veil = matt("Veil", (0.85, 0.7, 0.75))
    outputs = textured(veil, image("Veil", np.concatenate([0.6 + 0.3 * pattern(), 0.1 + 0.8 * pattern()[..., :1]], -1)))
    link(veil, outputs["Color"], principled(veil)["Base Color"])
    link(veil, outputs["Alpha"], principled(veil)["Alpha"])
    thing("Veil", flat, veil, (1.5, 0.2, 1.0), (90, 0, 30), (0.7, 1.0, 1))
    camera((0, -5.5, 1.8), (0, 0, 1.0), 42)


def lights():
    """A point, two spots and a sun, all without size; the second spot has a soft edge."""
    thing("Floor", square(), matt("Floor", (0.6, 0.6, 0.6)), scale=(4, 4, 1))
    thing("Wall", square(), matt("Wall", (0.55, 0.6, 0.65)), (0, 2, 2), (90, 0, 0), (4, 2, 1))
    thing("Box", box(), material("Plastic", (0.7, 0.2, 0.15), roughness=0.4), (-1.1, 0.3, 0.5), (0, 0, 30), (0.4, 0.4, 0.5))
    thing("Ball", ball(), material("Brass", (0.9, 0.75, 0.4), roughness=0.6, metallic=1.0), (0.9, 0.2, 0.5), scale=(0.5, 0.5, 0.5),
          smooth=True)
    light("POINT", "Point", 60.0, (0.2, -0.9, 1.6), (0, 0, 0), (1.0, 0.8, 0.6))
    light("SPOT", "Hard", 500.0, (-2.5, -1.5, 2.5), (-1.0, 0.3, 0.4), (0.5, 0.8, 1.0), spot_size=math.radians(34), spot_blend=0.0)
    soft = light("SPOT", "Soft", 700.0, (2.0, -2.0, 3.0), (1.0, 0.8, 0.4), (0.8, 1.0, 0.7), spot_size=math.radians(50), spot_blend=0.6)
    light("SUN", "Sun", 0.5, (3, -2, 4), (0, 0, 0))
    camera((0, -5.5, 2.2), (0, 0, 0.8), 42)
    return lambda: falls_as_in_gltf(soft)


def falls_as_in_gltf(spot):
    """Has Cycles fall from the inner to the outer angle as KHR_lights_punctual does, by nodes: Blender's own edge is a smoothstep from
    another inner angle, which no file of glTF can say."""
    outer = 0.5 * spot.data.spot_size
    inner = outer - outer * spot.data.spot_blend
    spot.data.spot_blend = 0.0
    spot.data.use_nodes = True
    emission = spot.data.node_tree.nodes["Emission"]
    cosine = node(spot.data, "ShaderNodeVectorMath")
    cosine.operation = "DOT_PRODUCT"
    link(spot.data, node(spot.data, "ShaderNodeNewGeometry").outputs["Incoming"], cosine.inputs[0])
    cosine.inputs[1].default_value = spot.rotation_euler.to_matrix() @ Vector((0, 0, -1))
    share = node(spot.data, "ShaderNodeMapRange")
    share.inputs["From Min"].default_value, share.inputs["From Max"].default_value = math.cos(outer), math.cos(inner)
    link(spot.data, cosine.outputs["Value"], share.inputs["Value"])
    squared = node(spot.data, "ShaderNodeMath")
    squared.operation = "MULTIPLY"
    for index in (0, 1):
        link(spot.data, share.outputs["Result"], squared.inputs[index])
    link(spot.data, squared.outputs[0], emission.inputs["Strength"])


def emission():
    """Things that emit: a ball, a picture, and a surface that scatters too."""
    thing("Floor", square(), matt("Floor", (0.5, 0.5, 0.5)), scale=(4, 4, 1))
    thing("Wall", square(), matt("Wall", (0.55, 0.5, 0.5)), (0, 2, 2), (90, 0, 0), (4, 2, 1))
    thing("Ball", ball(3), lamp("Ball", 6.0, (1.0, 0.75, 0.5)), (-1.4, 0, 0.4), scale=(0.4, 0.4, 0.4), smooth=True)
    made = lamp("Screen", 2.0)
    link(made, textured(made, image("Screen", 0.15 + 0.8 * pattern()))["Color"], principled(made)["Emission Color"])
    thing("Screen", square(), made, (0.3, 1.0, 1.1), (75, 0, 10), (0.8, 0.6, 1))
    made = material("Glowing", (0.6, 0.55, 0.5), roughness=0.5, emission=(0.1, 0.3, 0.5), strength=0.5)
    thing("Glowing", box(), made, (1.6, -0.2, 0.5), (0, 0, 30), (0.4, 0.4, 0.5))
    made = material("Signs", (0.5, 0.5, 0.5), roughness=0.8, strength=0.8)
    signs = np.where(pattern() > 0.75, 0.9, 0.0)
    link(made, textured(made, image("Signs", signs))["Color"], principled(made)["Emission Color"])
    thing("Signs", square(), made, (0.1, -1.3, 0.3), (50, 0, -5), (0.5, 0.4, 1))
    camera((0, -5.5, 2.2), (0, 0, 0.8), 42)


# Scenes as users make them: Blender's startup file, in which they add and change a few things.


def new_material(name, **inputs):
    """A new material on the active object, with some inputs of its Principled BSDF changed."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    for name, value in inputs.items():
        principled(made)[name.replace("_", " ")].default_value = value
    bpy.context.object.data.materials.append(made)


def add(kind, smooth=False, **where):
    """Add → Mesh, and Shade Smooth."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(**where)
    if smooth:
        bpy.ops.object.shade_smooth()


def remove(name):
    bpy.data.objects.remove(bpy.data.objects[name])


def startup():
    """Blender's startup file: a cube, a lamp, a grey world."""


def suzanne():
    """The monkey with a Subdivision Surface on a plane, both without a material."""
    remove("Cube")
    add("plane", size=12, location=(0, 0, -0.8))
    add("monkey", smooth=True, rotation=(-0.4, 0, 0.9))
    bpy.context.object.modifiers.new("Subdivision", "SUBSURF")


def glass_ball():
    """A ball of glass, on a plane."""
    remove("Cube")
    add("plane", size=12, location=(0, 0, -1.2))
    new_material("Floor", Base_Color=(0.5, 0.3, 0.2, 1))
    add("uv_sphere", smooth=True)
    new_material("Glass", Transmission_Weight=1.0, Roughness=0.0)


def gold():
    """A ball of gold, on a plane."""
    remove("Cube")
    add("plane", size=12, location=(0, 0, -1))
    new_material("Floor")
    add("uv_sphere", smooth=True)
    new_material("Gold", Base_Color=(1.0, 0.77, 0.34, 1), Metallic=1.0, Roughness=0.25)


def lamp_in_place(kind, energy, at, turn=(0, 0, 0)):
    """The cube on a plane, with another lamp than that of the startup file."""
    remove("Light")
    add("plane", size=12, location=(0, 0, -1))
    new_material("Floor")
    bpy.ops.object.light_add(type=kind, location=at, rotation=[math.radians(angle) for angle in turn])
    bpy.context.object.data.energy = energy


def area():
    lamp_in_place("AREA", 300.0, (1.5, -1.5, 4), (20, 20, 0))
    bpy.context.object.data.size = 2.0


def point():
    lamp_in_place("POINT", 800.0, (2, -3, 4))
    bpy.context.object.data.shadow_soft_size = 0.1


def sun():
    lamp_in_place("SUN", 3.0, (0, 0, 5), (40, 10, 30))


def world():
    """An image around the cube, and no lamp."""
    skies()
    remove("Light")
    add("plane", size=12, location=(0, 0, -1))
    new_material("Floor")
    nodes = bpy.context.scene.world.node_tree
    environment = nodes.nodes.new("ShaderNodeTexEnvironment")
    environment.image = bpy.data.images.load(str(FOLDER / "world-in-blender.hdr"))
    nodes.links.new(environment.outputs["Color"], nodes.nodes["Background"].inputs["Color"])


def skies():
    """An image for the world, and the same for --sky: Blender has its middle towards +x, and glTF's and our -z is Blender's +y."""
    height, width = 16, 32
    y, x = (np.mgrid[0:height, 0:width] + 0.5) / height
    up = np.clip(1 - y, 0, 1)[..., None]
    picture = np.where(up > 0.5, 0.2 + up * np.array([0.3, 0.5, 0.9]), np.array([0.15, 0.13, 0.1]))
    picture += np.exp(-((x - 1.4) ** 2 + (y - 0.3) ** 2) / 0.02)[..., None] * np.array([9.0, 7.0, 5.0])
    # As Radiance HDR, without run lengths.
    mantissa, exponent = np.frexp(picture.max(-1, keepdims=True))
    codes = np.concatenate([picture * (mantissa / picture.max(-1, keepdims=True) * 256), exponent + 128.0], -1).astype(np.uint8)
    for name, shift in (("world-in-blender", 0), ("world-sky", width // 4)):
        header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
        (FOLDER / f"{name}.hdr").write_bytes(header.encode() + np.roll(codes, shift, axis=1).tobytes())


# Scenes as users make them.
USERS = {"startup": startup, "suzanne": suzanne, "glass-ball": glass_ball, "gold": gold, "area": area, "point": point, "sun": sun,
         "world": world}
SCENES = {"room": room, "metals": metals, "glass": glass, "textures": textures, "nodes": nodes, "leaves": leaves, "lights": lights,
          "emission": emission}
# Samples per pixel.
SPP = {"room": 2048, **dict.fromkeys(USERS, 4096)}
OTHER_SPP = 512


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("Dark")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100


def export(path):
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", export_cameras=True, export_lights=True, export_yup=True,
                              export_animations=False, export_image_format="AUTO")


def export_as_user(path):
    """With the boxes ticked that the README names."""
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", use_renderable=True, export_cameras=True, export_lights=True,
                              export_apply=True)


# What a .glb says, for Cycles.
AS_IN_THE_FILE = {
    "light_sampling_threshold": 0.0, "blur_glossy": 0.0, "sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0,
    "caustics_reflective": True, "caustics_refractive": True, "max_bounces": 64, "diffuse_bounces": 64, "glossy_bounces": 64,
    "transmission_bounces": 64, "transparent_max_bounces": 256,
}


def render(path, spp, threads, settings=AS_IN_THE_FILE, seed=1):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    cycles = scene.cycles
    for setting, value in {
        "device": "CPU", "samples": spp, "seed": seed, "use_adaptive_sampling": False, "use_denoising": False,
        "pixel_filter_type": "BOX", "filter_width": 1.0, **settings,
    }.items():
        setattr(cycles, setting, value)
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGB", "16", "PIZ"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scenes", nargs="*", choices=[*SCENES, *USERS, []], metavar="scene", help=", ".join([*SCENES, *USERS]))
    arguments.add_argument("--spp", type=int, help="samples per pixel")
    arguments.add_argument("--threads", type=int, default=1)
    arguments.add_argument("--to", type=pathlib.Path, default=FOLDER, help="another folder")
    arguments.add_argument("--no-render", action="store_true", help="only the .glb")
    options = arguments.parse_args()
    for name in options.scenes or [*SCENES, *USERS]:
        glb, exr = (options.to / f"{name}.{ending}" for ending in ("glb", "exr"))
        spp = options.spp or SPP.get(name, OTHER_SPP)
        if name in USERS:
            bpy.ops.wm.read_homefile(use_factory_startup=True)
            bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = SMALL_SIZE
            USERS[name]()
            export_as_user(glb)
            if not options.no_render:
                render(exr, spp, options.threads, settings={})
            continue
        empty()
        what_no_file_says = SCENES[name]()
        export(glb)
        if what_no_file_says:
            what_no_file_says()
        if not options.no_render:
            render(exr, spp, options.threads)


if __name__ == "__main__":
    main()
