"""What a 3D view tells the program without another export: its camera, where things are, and numbers of materials and lamps."""

import json
import math

import bpy
import numpy as np

from . import blur, geometry, lamps, ron
from .axes import placed
from .shaders import ZERO, Reader, is_number

# The image and the camera of the scene file. Each request has its own camera; the numbers of a calibrated one are in pixels of this image.
WIDTH, HEIGHT = 1024, 1024
FIELDS = {
    "image": {"width": WIDTH, "height": HEIGHT},
    "camera": {"look_from": (0.0, 0.0, 1.0), "look_at": (0.0, 0.0, 0.0), "vertical_fov": 40.0},
}
# The axes of glTF, and those of the scene file (axes.placed), by Blender's.
OF_GLTF = np.array([(1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)], float)
OF_FILE = np.array([(0, -1, 0, 0), (0, 0, 1, 0), (-1, 0, 0, 0), (0, 0, 0, 1)], float)
# The field that has an input of a Principled BSDF, by the material of the scene file.
FORMS = {
    "Pbr": {"Base Color": "base_color", "Roughness": "roughness", "Metallic": "metallic", "Emission Color": "emission"},
    "Conductor": {"Base Color": "albedo", "Roughness": "roughness"},
    "Lambertian": {"Base Color": "albedo", "Roughness": None, "Emission Color": "emission"},
}
# Data of which `state` and the camera have all that shows; and other data without geometry.
WATCHED = bpy.types.Armature, bpy.types.Camera, bpy.types.Light, bpy.types.Scene
SHADING = bpy.types.Image, bpy.types.Texture, bpy.types.World


def camera(view, window, lens):
    """The fields of the camera of a 3D view, by its two matrices. `lens` says how it blurs."""
    window, place = np.array(window), np.linalg.inv(np.array(view))
    right, up, back, at = place[:3].T
    scale, shift = window.diagonal()[:2], window[:2, 2]
    if window[3, 3] == 1:
        # Its middle is beside the axis, and it sees what is between its near plane and the axis' beginning.
        near = (-1 - window[2, 3]) / window[2, 2]
        at = at - right * window[0, 3] / scale[0] - up * window[1, 3] / scale[1] + back * max(near, 0.0)
        form = {"projection": ron.Orthographic(height=2 / scale[1])}
    elif abs(shift).max() < 1e-5:
        form = {"vertical_fov": 2 * math.degrees(math.atan(1 / scale[1]))}
    else:
        middle = {"cx": WIDTH / 2 * (1 - shift[0]), "cy": HEIGHT / 2 * (1 + shift[1])}
        form = {"projection": ron.Calibrated(fx=WIDTH / 2 * scale[0], fy=HEIGHT / 2 * scale[1], **middle)}
    towards = at - back * lens.get("focus_distance", 1.0)
    return {"look_from": placed(at), "look_at": placed(towards), "up": placed(up)} | form | lens


def state(depsgraph, lights, materials):
    """What requests can change, as JSON has it: the places of instances and of lamps behind what they are, fields of lamps, and numbers of
    these materials."""
    objects = {
        json.dumps(blur.key(instance)): ([material and material.name for material in geometry.slots_of(instance.object)], list(map(tuple, instance.matrix_world)))
        for instance in depsgraph.object_instances if geometry.is_mesh(instance)
    }
    made = {
        "objects": objects, "lamps": {key: (shape, list(map(tuple, matrix))) for key, (shape, matrix) in lights.places.items()},
        "values": {name: ron._text(fields) for name, fields in lights.values.items()},
        "materials": {f"scene.glb#{material.name}": numbers(material) for material in materials},
        "ball": (tuple(lights.ball[0]), lights.ball[1]),
    }
    return json.loads(json.dumps(made))


def numbers(material):
    """The inputs of the Principled BSDF that stands for a material, if they are numbers alone. None if not."""
    reader = Reader()
    values = reader.parameters(reader.of_material(material))
    return values if all(isinstance(value, tuple) and is_number(value) for value in values.values()) else None


def difference(then, now, names):
    """The `objects` and the `materials` of a request that make a scene as it is now of the one that was exported then. None if another
    export has to. `names` has those of objects in the scene file."""
    kinds = lambda state: [{key: kind for key, (kind, _) in state[name].items()} for name in ("objects", "lamps")] + [state["values"].keys()]
    if kinds(then) != kinds(now):
        return None
    # The meshes are the first object of the scene file, and lamps follow.
    of_lamps = {key: f"objects[{1 + index}]" for index, key in enumerate(then["lamps"])}
    objects = {}
    for kind, axes, own in (("objects", OF_GLTF, names), ("lamps", OF_FILE, of_lamps)):
        for key, (_, before) in then[kind].items():
            if before != now[kind][key][1]:
                objects[own[key]] = moved(before, now[kind][key][1], axes)
    materials = {name: fields for name, fields in now["values"].items() if fields != then["values"][name]}
    for name, values in now["materials"].items():
        if name in then["materials"] and values != then["materials"][name]:
            materials[name] = changed(then["materials"][name], values)
    return None if None in objects.values() or None in materials.values() else (objects, materials)


def moved(before, after, axes):
    """The matrix that moves from one place to another: a rotation, a shift and one positive scale. None if no such matrix does."""
    try:
        by = axes @ np.array(after) @ np.linalg.inv(np.array(before)) @ axes.T
        left, scales, right = np.linalg.svd(by[:3, :3])
    except np.linalg.LinAlgError:
        return None
    # Blender's matrices have seven digits.
    if not np.linalg.det(by[:3, :3]) > 0 or scales.max() > (1 + 1e-4) * scales.min():
        return None
    by[:3, :3] = scales.mean() * left @ right
    return by.tolist()


def changed(then, now):
    """The fields of a material whose numbers have changed. None if it becomes another material, or if it is not of numbers alone."""
    if then is None or now is None or then.keys() != now.keys() or form(then) is None or form(then) != form(now):
        return None
    names, fields = FORMS[form(now)[0]], {}
    for name, value in now.items():
        if list(value) == list(then[name]):
            continue
        if name not in names:
            return None
        if names[name]:
            fields[names[name]] = ron.Rgb(*value) if "Color" in name else min(max(value[0], 0.0), 1.0)
    return ron._text(fields)


def form(values):
    """Which material the program reads, and whether it emits. None for glass, and for light alone."""
    if any(values.get("Transmission Weight", ZERO)) or not any(values["Base Color"]):
        return None
    metallic, emits = values.get("Metallic", ZERO)[0], any(values["Emission Color"])
    is_matt = not any(values["Specular IOR Level"]) and metallic <= 0
    return "Conductor" if metallic >= 1 else "Lambertian" if is_matt else "Pbr", emits


def needs_export(updates):
    """Whether updates of Blender's are of more than `state` has."""
    for update in updates:
        changed = update.id.original
        if isinstance(changed, bpy.types.Object):
            if update.is_updated_geometry and changed.type not in ("LIGHT", "CAMERA", "EMPTY", "ARMATURE", "SPEAKER"):
                return True
        elif isinstance(changed, bpy.types.Material):
            if numbers(changed) is None:
                return True
        elif isinstance(changed, SHADING) or (update.is_updated_geometry and not isinstance(changed, WATCHED)):
            return True
    return False
