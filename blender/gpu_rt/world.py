"""The world as the background of the scene file."""

import os

import bpy

from . import ron

# What the program reads: 8 bits in sRGB, and floats.
CODES, FLOATS = (".png", ".jpg", ".jpeg", ".bmp", ".tga", ".tif", ".tiff", ".webp"), (".hdr", ".exr")
# The width of a baked image: that of the world's own image between these, and without one the least.
LEAST, MOST = 1024, 4096


def background(scene, folder):
    world = scene.world
    if world is None:
        return ron.Solid((0.0, 0.0, 0.0))
    # Since Blender 5.0 it is always true, and it goes with 6.0.
    if not getattr(world, "use_nodes", True) or not world.node_tree:
        return ron.Solid(tuple(world.color))
    output = world.node_tree.get_output_node("CYCLES")
    links = output.inputs["Surface"].links if output else ()
    if not links:
        return ron.Solid((0.0, 0.0, 0.0))
    node = links[0].from_node
    if node.type == "BACKGROUND" and not node.inputs["Strength"].is_linked and not node.mute:
        colour, strength = node.inputs["Color"], max(node.inputs["Strength"].default_value, 0.0)
        if strength == 0 or not colour.is_linked:
            return ron.Solid(tuple(max(channel, 0.0) * strength for channel in colour.default_value[:3]))
        file = own_file(colour.links[0].from_node) if strength == 1 else None
        if file:
            return ron.Image(path=file)
    return ron.Image(path=bake(world, folder).name)


def own_file(node):
    """The file of a plain Environment Texture that the program reads as Blender does."""
    is_plain = node.type == "TEX_ENVIRONMENT" and node.projection == "EQUIRECTANGULAR" and not node.inputs["Vector"].is_linked
    image = node.image if is_plain and not node.mute else None
    if image is None or image.source != "FILE" or image.packed_file:
        return None
    path = os.path.realpath(bpy.path.abspath(image.filepath, library=image.library))
    ending, space = os.path.splitext(path)[1].lower(), image.colorspace_settings.name
    is_same = ending in CODES and space == "sRGB" or ending in FLOATS and space == "Linear Rec.709"
    # Bits of a pixel without alpha. A .hdr never has any.
    is_opaque = ending == ".hdr" or image.depth in (24, 96)
    return path if is_same and is_opaque and os.path.isfile(path) else None


def nodes_of(tree):
    for node in tree.nodes:
        yield node
        if node.type == "GROUP" and node.node_tree:
            yield from nodes_of(node.node_tree)


def bake(world, folder):
    """Renders the world alone by Cycles as a latitude-longitude image, which is the way that Blender's own images of the world have."""
    widths = [node.image.size[0] for node in nodes_of(world.node_tree) if node.type in ("TEX_ENVIRONMENT", "TEX_IMAGE") and node.image]
    has_image = any(widths)
    width = min(max([LEAST, *widths]), MOST)
    scene = bpy.data.scenes.new("gpu-rt world")
    scene.world = world
    scene.frame_set(bpy.context.scene.frame_current)
    world.cycles_visibility.camera = True
    camera = bpy.data.cameras.new("gpu-rt world")
    camera.type = "PANO"
    # Since Blender 5.0 it is a setting of Blender's own.
    (camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type = "EQUIRECTANGULAR"
    scene.camera = bpy.data.objects.new("gpu-rt world", camera)
    scene.collection.objects.link(scene.camera)
    # It looks along +x, with +z up.
    scene.camera.rotation_euler = (1.5707963267948966, 0, -1.5707963267948966)
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, width // 2, 100
    render.use_compositing = render.use_sequencer = False
    if has_image:
        # The middles of an image's texels are those of the pixels, if nothing turns it: one sample there copies them.
        cycles.samples, cycles.pixel_filter_type, cycles.filter_width = 1, "BOX", 0.01
    else:
        # The rim of the sun needs more samples than all the sky.
        cycles.samples, cycles.pixel_filter_type, cycles.filter_width = 1024, "BOX", 1.0
    cycles.use_adaptive_sampling, cycles.adaptive_min_samples, cycles.adaptive_threshold = not has_image, 4, 0.01
    cycles.use_denoising = False
    cycles.sample_clamp_direct = 0
    cycles.seed = 0
    file = render.image_settings
    if hasattr(file, "media_type"):
        file.media_type = "IMAGE"
    file.file_format, file.color_mode, file.color_depth, file.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"
    path = folder / "world.exr"
    render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return path
