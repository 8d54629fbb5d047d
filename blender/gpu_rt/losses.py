"""What the export loses: told in the panel, and as warnings of a render."""

import math
import os

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from .lamps import plain_emission

# Nodes of a material that Blender's exporter of glTF reads.
READ = {
    "TEX_IMAGE", "UVMAP", "TEX_COORD", "MAPPING", "NORMAL_MAP", "SEPARATE_COLOR", "SEPRGB", "VERTEX_COLOR", "RGB", "VALUE", "REROUTE",
    "FRAME", "GROUP", "GROUP_INPUT", "GROUP_OUTPUT", "EMISSION", "ADD_SHADER",
}
# Those that it reads with some operations: a factor, and for an alpha that is cut off a comparison.
OPERATIONS = {"MIX": {"MULTIPLY"}, "MIX_RGB": {"MULTIPLY"}, "MATH": {"MULTIPLY", "GREATER_THAN", "LESS_THAN", "ROUND", "SUBTRACT"}}
SHAPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
NO_SHAPES = {
    "CURVES": "hair", "POINTCLOUD": "a cloud of points", "VOLUME": "a volume", "GREASEPENCIL": "a drawing of Grease Pencil",
    "GPENCIL": "a drawing of Grease Pencil",
}
RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")


def losses(scene, layer):
    """Pairs of a name and of what it loses."""
    found = [(scene.name, words) for words in _of_scene(scene, layer)]
    by_material = {}
    for shown in _rendered(layer):
        words = list(_of_object(shown))
        if shown.type == "LIGHT" and not shown.visible_camera and _is_in_picture(scene, shown):
            words.append("it is not hidden from the camera")
        for material in {slot.material for slot in shown.material_slots if slot.material}:
            if material not in by_material:
                by_material[material] = list(_of_material(material))
            words += [f"{material.name}: {loss}" for loss in by_material[material]]
        found += [(shown.name, loss) for loss in words]
    return found


def _rendered(layer):
    """The objects of a view layer, and of the collections that are placed in it, each once."""
    placed = [inner for each in layer.objects if each.instance_collection for inner in each.instance_collection.all_objects]
    return [shown for shown in dict.fromkeys([*layer.objects, *placed]) if not shown.hide_render]


def _of_scene(scene, layer):
    for library in bpy.data.libraries:
        if not library.packed_file and not os.path.isfile(bpy.path.abspath(library.filepath)):
            yield f"the library {library.name}: there is no such file"
    if scene.render.use_motion_blur:
        yield "motion blur"
    if scene.render.film_transparent:
        yield "the transparent film: the world is in the image"
    if layer.material_override:
        yield "the material override of the view layer"
    output = scene.world and scene.world.node_tree and scene.world.node_tree.get_output_node("CYCLES")
    if output and output.inputs["Volume"].is_linked:
        yield "the volume of the world"
    camera = scene.camera and scene.camera.type == "CAMERA" and scene.camera.data
    if camera and camera.dof.use_dof and camera.dof.aperture_blades >= 3:
        yield "the blades of the camera's aperture: it is round"


def _of_object(shown):
    if shown.type in NO_SHAPES:
        yield NO_SHAPES[shown.type]
    for system in shown.particle_systems:
        if system.settings.render_type not in ("OBJECT", "COLLECTION", "NONE"):
            yield f"{'hair' if system.settings.type == 'HAIR' else 'particles'}: {system.name}"
    if shown.type == "LIGHT":
        yield from _of_lamp(shown.data)
    elif shown.type in SHAPES:
        hidden = [ray for ray in RAYS if not getattr(shown, f"visible_{ray}")]
        if hidden:
            yield f"it is not hidden from rays ({', '.join(hidden)})"
        if shown.is_holdout or shown.is_shadow_catcher:
            yield "holdout or shadow catcher"


def _is_in_picture(scene, lamp):
    """Whether the camera sees a lamp that is a surface: one of its corners, or its middle."""
    light = lamp.data
    if not scene.camera or light.type == "SPOT" or (light.type == "POINT" and light.shadow_soft_size == 0):
        return False
    if light.type == "SUN":
        # As far away as makes no difference.
        points = [scene.camera.matrix_world.translation + 1e6 * lamp.matrix_world.col[2].xyz] if light.angle > 0 else []
    elif light.type == "AREA":
        height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        points = [lamp.matrix_world @ Vector((x * light.size, y * height, 0)) for x in (-0.5, 0, 0.5) for y in (-0.5, 0, 0.5)]
    else:
        turns = scene.camera.matrix_world.to_3x3()
        middle, radius = lamp.matrix_world.translation, light.shadow_soft_size
        points = [middle + radius * (turns @ Vector((x, y, 0))) for x in (-1, 0, 1) for y in (-1, 0, 1)]
    seen = (world_to_camera_view(scene, scene.camera, point) for point in points)
    return any(0 <= at.x <= 1 and 0 <= at.y <= 1 and at.z > 0 for at in seen)


def _of_lamp(light):
    if light.energy < 0:
        yield "its negative light"
    if light.type == "AREA" and light.spread < math.radians(179):
        yield "its spread: it shines in all directions"
    if light.type == "SPOT" and light.shadow_soft_size > 0:
        yield "its radius: its shadows are sharp"
    if not light.use_shadow:
        yield "it casts shadows"
    if light.use_nodes and light.node_tree and not plain_emission(light):
        yield "its nodes"


def _of_material(material):
    tree = material.node_tree if getattr(material, "use_nodes", True) else None
    output = tree.get_output_node("CYCLES") if tree else None
    if not output:
        return
    for socket, words in (("Volume", "its volume"), ("Displacement", "its displacement")):
        if output.inputs[socket].is_linked:
            yield words
    nodes = _before(output.inputs["Surface"])
    shaders = [node for node in nodes if node.type.startswith("BSDF_") or node.type in ("SUBSURFACE_SCATTERING", "EEVEE_SPECULAR")]
    for node in nodes:
        if node.type == "TEX_IMAGE" and node.image:
            yield from _of_image(node.image)
        if node.type == "BSDF_PRINCIPLED":
            for name, words in (("Subsurface Weight", "subsurface"), ("Thin Film Thickness", "its thin film")):
                socket = node.inputs.get(name)
                if socket and (socket.is_linked or socket.default_value > 0):
                    yield words
        elif node in shaders:
            if node.type != "BSDF_TRANSPARENT":
                yield f"{node.bl_label}: only a Principled BSDF is read"
        elif node.type.startswith("TEX_") and node.type not in READ:
            yield f"procedural texture: {node.bl_label}"
        elif node.type not in READ and _operation(node) not in OPERATIONS.get(node.type, ()):
            yield f"node: {node.bl_label}"


def _operation(node):
    return getattr(node, "operation", None) or getattr(node, "blend_type", None)


def _of_image(image):
    if image.source == "FILE" and not image.packed_file and not os.path.isfile(bpy.path.abspath(image.filepath, library=image.library)):
        yield f"its image {image.name}: there is no such file"
    elif image.is_dirty:
        yield f"what is painted on {image.name}: save or pack the image"


def _before(socket):
    """The nodes that a socket depends on, each once, also those in groups."""
    found, waiting = [], [link.from_node for link in socket.links]
    while waiting:
        node = waiting.pop()
        if node in found or node.mute:
            continue
        found.append(node)
        waiting += [link.from_node for inputs in node.inputs for link in inputs.links]
        if node.type == "GROUP" and node.node_tree:
            waiting += [inner for inner in node.node_tree.nodes if inner.type == "GROUP_OUTPUT"]
    return found
