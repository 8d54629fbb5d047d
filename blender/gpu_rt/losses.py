"""What the export loses: told in the panel, and as warnings of a render."""

import math
import os

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from .lamps import plain_emission
from .materials import is_plain
from .shaders import Reader

BENDING = {"ARMATURE", "CLOTH", "SOFT_BODY", "WAVE", "MESH_DEFORM", "LATTICE", "HOOK", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "OCEAN", "FLUID"}
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
        is_lamp, animated = shown.type == "LIGHT", getattr(shown.data, "animation_data", None)
        bends = getattr(shown.data, "shape_keys", None) or (is_lamp and animated) or any(each.type in BENDING for each in shown.modifiers)
        moves = is_lamp and (shown.animation_data or shown.parent or shown.constraints)
        if scene.render.use_motion_blur:
            words += [f"the blur of its {of}" for of, is_blurred in (("motion", moves), ("shape", bends)) if is_blurred]
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
    # It is not there if the add-on is off.
    if hasattr(scene, "cycles"):
        yield from _of_cycles(scene.cycles, scene.render.use_motion_blur)
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


def _of_cycles(cycles, has_blur):
    if has_blur and cycles.rolling_shutter_type != "NONE":
        yield "the rolling shutter"
    _, found, wished = pixel_filter(cycles)
    if abs(found - wished) > 0.15:
        yield f"the pixel filter: its standard deviation is {found:.2f} pixels, and not {wished:.2f}"
    for kind, default in (("diffuse", 4), ("glossy", 4), ("transmission", 12)):
        if getattr(cycles, f"{kind}_bounces") < min(default, cycles.max_bounces):
            yield f"the limit of {kind} bounces: all kinds have that of Total"


def pixel_filter(cycles):
    """The program's filter that blurs as much as Cycles', with its standard deviation and that of Cycles."""
    width = cycles.filter_width
    wished = {"BOX": width / math.sqrt(12), "GAUSSIAN": width / 12, "BLACKMAN_HARRIS": 0.14 * width}[cycles.pixel_filter_type]
    name, found = min((("box", 0.29), ("tent", 0.41), ("gauss", 0.49)), key=lambda each: abs(each[1] - wished))
    return name, found, wished


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
    reader = Reader()
    surface = reader.of_material(material)
    if not is_plain(material):
        reader.parameters(surface)
    yield from reader.notes
    for node in _before(output.inputs["Surface"]):
        if node.type == "TEX_IMAGE" and node.image:
            yield from _of_image(node.image)
        if node.type == "BSDF_PRINCIPLED":
            for name, words in (("Subsurface Weight", "subsurface"), ("Thin Film Thickness", "its thin film")):
                socket = node.inputs.get(name)
                if socket and (socket.is_linked or socket.default_value > 0):
                    yield words


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
