"""Materials as Blender's exporter of glTF reads them: one Principled BSDF, and images. It works on a copy of the file."""

import json
import struct

import bpy
import numpy as np

from .shaders import GREY, ONE, Reader, before, is_number, mean_of_rays, mul, source

NORMALS = {"Normal", "Coat Normal", "Tangent"}
# What the exporter reads from an image.
TEXTURED = {
    "Base Color", "Metallic", "Roughness", "Alpha", "Specular IOR Level", "Specular Tint", "Transmission Weight", "Coat Weight", "Coat Roughness",
    "Sheen Tint", "Sheen Roughness", "Emission Color", *NORMALS,
}
# Nodes that mean the same on all meshes.
ANYWHERE = {
    "MATH", "MIX", "MIX_RGB", "VALTORGB", "HUE_SAT", "BRIGHTCONTRAST", "GAMMA", "INVERT", "CURVE_RGB", "CURVE_VEC", "CURVE_FLOAT", "CLAMP",
    "SEPARATE_COLOR", "COMBINE_COLOR", "SEPXYZ", "COMBXYZ", "SEPRGB", "COMBRGB", "RGB", "VALUE", "RGBTOBW", "MAP_RANGE", "VECT_MATH",
    "BLACKBODY", "WAVELENGTH", "TEX_IMAGE",
}
MULTISCATTER = "GPU_RT_materials_multiscatter"
# Of baked images: the texture coordinates, the side of one on a mesh, and the most pixels along one.
OWN, SIDE, MOST = "gpu-rt", 1024, 4096


def is_colour(name):
    return "Color" in name or "Tint" in name


def repeats(node, path):
    """Whether an Image Texture repeats by texture coordinates of the mesh, moved by a Mapping at most."""
    socket = node.inputs["Vector"]
    out, path = source(socket, path)
    if out is not None and out.is_output and out.node.type == "MAPPING":
        vector, *others = out.node.inputs
        if any(each.is_linked for each in others) or any(out.node.inputs["Rotation"].default_value[:2]):
            return False
        out, path = source(vector, path)
        socket = None
    is_uv = out is socket or (out is not None and out.is_output and (out.node.type == "UVMAP" or out.identifier == "UV"))
    return is_uv and (node.projection, node.extension) == ("FLAT", "REPEAT")


def is_read(value, name):
    """Whether the exporter reads a value as Cycles does."""
    if is_number(value) or name not in TEXTURED or name in NORMALS:
        return is_number(value) or name in NORMALS
    if value[0] != "from":
        return value[0] in ("mul", "grey") and is_number(value[-2] if value[0] == "mul" else ONE) and is_read(value[-1], name)
    _, out, path = value
    node, image = out.node, getattr(out.node, "image", None)
    if node.type in ("SEPARATE_COLOR", "SEPRGB"):
        inner, path = source(node.inputs[0], path)
        return inner is not None and inner.is_output and inner.node.type == "TEX_IMAGE" and is_read(("from", inner, path), name)
    if name == "Alpha" and node.type == "MATH" and node.operation in ("ROUND", "SUBTRACT", "GREATER_THAN"):
        return {inner.node.type for inner, _ in before(value)} <= {"MATH", "VALUE", "TEX_IMAGE"}
    if node.type != "TEX_IMAGE" or not image or not image.size[0] or image.source not in ("FILE", "GENERATED"):
        return node.type == "VERTEX_COLOR" and name in ("Base Color", "Alpha")
    has_space = image.colorspace_settings.name == ("sRGB" if is_colour(name) else "Non-Color")
    return repeats(node, path) and (has_space or out.identifier == "Alpha")


def is_plain(material):
    """Whether the exporter reads a material as it is."""
    output = material.node_tree and material.node_tree.get_output_node("CYCLES")
    out, path = source(output.inputs["Surface"], ()) if output else (None, ())
    if out is None or path or not out.is_output or out.node.type != "BSDF_PRINCIPLED":
        return False
    return all(is_read(Reader().value(each, ()), each.name) for each in out.node.inputs if each.is_linked)


class Materials:
    """Replaces materials of the meshes of a scene. `extensions` has what the exporter does not write, by material, and `notes` what failed."""

    def __init__(self, scene):
        self.extensions, self.notes, self._scene, self._made = {}, [], scene, {}
        for mesh, placed in {placed.data: placed for placed in scene.objects}.items():
            for index, material in enumerate(mesh.materials):
                if material and not is_plain(material):
                    self._placed, self._on_mesh = placed, False
                    made = self._made.get((material, None)) or self._made.get((material, mesh)) or self._replaced(material)
                    self._made[material, mesh if self._on_mesh else None] = mesh.materials[index] = made

    def _replaced(self, material):
        made, reader, name = material.copy(), Reader(), material.name
        if not material.library:
            # Messages of the program have the name.
            material.name, made.name = OWN, name
        self._tree = tree = made.node_tree
        if tree:
            own_groups(tree)
        values = reader.parameters(reader.of_material(made))
        for out, path in dict.fromkeys(found for value in values.values() if isinstance(value, tuple) for found in before(value)):
            number = mean_of_rays(out)
            if number:
                constant = out.id_data.nodes.new("ShaderNodeValue").outputs[0]
                constant.default_value = number[0]
                for link in list(out.links):
                    out.id_data.links.new(constant, link.to_socket)
        if not tree:
            made.use_nodes = True
            self._tree = tree = made.node_tree
        self._output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
        for node in [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL" and node != self._output]:
            tree.nodes.remove(node)
        self._output.target = "ALL"
        shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
        for name, value in values.items():
            if name in shader.inputs:
                self._set(made, shader, name, value)
        tree.links.new(shader.outputs[0], self._output.inputs["Surface"])
        self.extensions[made.name] = {name: value for name, value in values.items() if name not in shader.inputs}
        return made

    def _set(self, material, shader, name, value):
        socket = shader.inputs[name]
        value = value if is_read(value, name) else self._baked(material, value, name)
        if name == "Emission Color":
            strength = max(*(value if is_number(value) else value[1] if value[0] == "mul" else ONE), 1e-30)
            value, shader.inputs["Emission Strength"].default_value = mul((1 / strength,) * 3, value), strength
        if is_number(value):
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" else value[0]
        else:
            self._tree.links.new(self._output_of(value, socket.type), socket)

    def _output_of(self, value, kind="VECTOR"):
        """An output that has a value. `kind` is that of the socket that it is for: the exporter looks for a factor by it."""
        if value[0] == "from":
            return lifted(*value[1:])
        node = self._tree.nodes.new("ShaderNode" + {"grey": "RGBToBW"}.get(value[0], {"RGBA": "Mix", "VALUE": "Math"}.get(kind, "VectorMath")))
        inputs, output = node.inputs, node.outputs[0]
        if node.type == "MIX":
            node.data_type, node.blend_type, node.inputs[0].default_value = "RGBA", "MULTIPLY", 1.0
            inputs, output = node.inputs[6:8], node.outputs[2]
        elif node.type != "RGBTOBW":
            node.operation = {"mul": "MULTIPLY", "add": "ADD", "sub": "SUBTRACT", "div": "DIVIDE"}[value[0]]
        for socket, part in zip(inputs, value[1:]):
            if is_number(part):
                socket.default_value = part[0] if socket.type == "VALUE" else (*part, 1.0)[:len(socket.default_value)]
            else:
                self._tree.links.new(self._output_of(part, kind), socket)
        return output

    def _baked(self, material, value, name):
        """A value as an image, or as numbers where it is the same everywhere. What depends on images alone is baked in their axes, and all
        else on the mesh, with texture coordinates of its own."""
        nodes, links, outputs = self._tree.nodes, self._tree.links, before(value)
        images = {(out.node, path) for out, path in outputs if out.node.type == "TEX_IMAGE"}
        vectors = {source(node.inputs["Vector"], path) for node, path in images}
        places = [vector for vector in vectors if vector[0].is_output] if all(out for out, _ in vectors) else []
        of_places = {found for place in places for found in before(("from", *place))}
        is_anywhere = all(out.node.type in ANYWHERE for out, path in outputs if (out, path) not in of_places)
        in_axes = is_anywhere and (len(vectors) == 1 or not places) and all(repeats(*each) for each in images)
        sizes = [length for node, _ in images if node.image for length in node.image.size]
        light = nodes.new("ShaderNodeEmission")
        links.new(self._output_of(value), light.inputs["Color"])
        links.new(light.outputs[0], self._output.inputs["Surface"])
        cut = [(node.id_data.links, node.inputs["Vector"].links[0].from_socket, node.inputs["Vector"])
               for node, _ in images if in_axes and node.inputs["Vector"].is_linked]
        for of_tree, _, vector in cut:
            of_tree.remove(vector.links[0])
        try:
            pixels = self._pixels(material, min(max([4, *sizes]), MOST) if in_axes else SIDE, in_axes)
        except RuntimeError as error:
            self.notes.append(f"{material.name}: grey 0.8 stands for its {name}, which cannot be baked: {error}")
            return GREY
        finally:
            nodes.remove(light)
            for of_tree, out, vector in cut:
                of_tree.new(out, vector)
        if name not in TEXTURED or np.ptp(pixels, axis=(0, 1)).max() < 1e-6:
            return tuple(map(float, pixels.mean((0, 1))))
        self._on_mesh = self._on_mesh or not in_axes
        most = max(float(pixels.max()), 1.0) if name == "Emission Color" else 1.0
        pixels = np.clip(pixels / most, 0, 1)
        node, side = nodes.new("ShaderNodeTexImage"), len(pixels)
        node.image = image = bpy.data.images.new(f"{material.name} {name}", side, side)
        if is_colour(name):
            pixels = np.where(pixels <= 0.0031308, 12.92 * pixels, 1.055 * pixels ** (1 / 2.4) - 0.055)
        else:
            image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(np.dstack([pixels, np.ones((side, side))]).astype(np.float32).ravel())
        image.pack()
        if not in_axes:
            coordinates = nodes.new("ShaderNodeUVMap")
            coordinates.uv_map = OWN
            links.new(coordinates.outputs[0], node.inputs["Vector"])
        elif places:
            links.new(lifted(*places[0]), node.inputs["Vector"])
        return mul((most,) * 3, ("from", node.outputs["Color"], ()))

    def _pixels(self, material, side, in_axes):
        """What a material emits, by Cycles: on the unit square of texture coordinates, or on the mesh."""
        scene, mesh = bpy.data.scenes.new(OWN), self._placed.data
        scene.render.engine, scene.cycles.samples = "CYCLES", 1
        bpy.context.window.scene = scene
        scene.frame_set(self._scene.frame_current)
        if in_axes:
            mesh = bpy.data.meshes.new(OWN)
            mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [range(4)])
            mesh.uv_layers.new(name=OWN).uv.foreach_set("vector", (0, 0, 1, 0, 1, 1, 0, 1))
        elif OWN not in mesh.uv_layers:
            shown = mesh.uv_layers.active_index
            mesh.uv_layers.active = mesh.uv_layers.new(name=OWN)
            select(scene, mesh)
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.uv.smart_project(island_margin=0.01)
            bpy.ops.object.mode_set(mode="OBJECT")
            mesh.uv_layers.active_index = max(shown, 0)
        mesh = mesh.copy()
        mesh.uv_layers.active = mesh.uv_layers[OWN]
        mesh.materials.clear()
        mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", [0] * len(mesh.polygons))
        select(scene, mesh).matrix_world = self._placed.matrix_world
        target = material.node_tree.nodes.new("ShaderNodeTexImage")
        target.image = image = bpy.data.images.new(OWN, side, side, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        material.node_tree.nodes.active = target
        try:
            bpy.ops.object.bake(type="EMIT", margin=8)
            pixels = np.empty(4 * side * side, np.float32)
            image.pixels.foreach_get(pixels)
            return pixels.reshape(side, side, 4)[..., :3]
        finally:
            material.node_tree.nodes.remove(target)
            bpy.data.images.remove(image)
            bpy.context.window.scene = self._scene
            bpy.data.scenes.remove(scene)


def select(scene, mesh):
    """The active object of a scene, alone and new, with a mesh."""
    for other in list(scene.collection.objects):
        scene.collection.objects.unlink(other)
    made = bpy.data.objects.new(OWN, mesh)
    scene.collection.objects.link(made)
    scene.view_layers[0].objects.active = made
    made.select_set(True)
    return made


def own_groups(tree):
    """Gives a tree groups of its own, without links in circles, in which the exporter would get lost."""
    for link in [link for link in tree.links if not link.is_valid]:
        tree.links.remove(link)
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree:
            node.node_tree = node.node_tree.copy()
            own_groups(node.node_tree)


def lifted(out, path):
    """An output in groups as one of the tree around them."""
    for group in reversed(path):
        kind = {"RGBA": "NodeSocketColor", "VECTOR": "NodeSocketVector"}.get(out.type, "NodeSocketFloat")
        name = f"{OWN} {len(group.outputs)}"
        made = group.node_tree.interface.new_socket(name, in_out="OUTPUT", socket_type=kind).identifier
        end = next(node for node in group.node_tree.nodes if node.type == "GROUP_OUTPUT" and node.is_active_output)
        group.node_tree.links.new(out, next(socket for socket in end.inputs if socket.identifier == made))
        out = next(socket for socket in group.outputs if socket.identifier == made)
    return out


def extend(path, extensions):
    """Writes into a GLB what the exporter does not."""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    gltf, rest = json.loads(data[20:20 + length]), data[20 + length:]
    used = set(gltf.get("extensionsUsed", ()))
    for material in gltf.get("materials", ()):
        more, own = extensions.get(material.get("name"), {}), material.setdefault("extensions", {})
        if "transmitted" in more:
            # Without gloss Specular Tint is free, and has the colour of the far side.
            layer = own.get("KHR_materials_specular", {})
            colour = own.pop("KHR_materials_specular") if layer.get("specularFactor") == 0 else {}
            own["KHR_materials_diffuse_transmission"] = {"diffuseTransmissionFactor": more["transmitted"]} | {
                name.replace("specularColor", "diffuseTransmissionColor"): each for name, each in colour.items() if "Color" in name}
            own.setdefault("KHR_materials_specular", {"specularFactor": 0})
        if "body" in more or "pane" in more:
            own["KHR_materials_volume"] = {"thicknessFactor": int("body" in more)}
            own.pop("KHR_materials_specular", None)
        if "multiscatter" in more:
            own[MULTISCATTER] = {}
        used.update(own)
    gltf["extensionsUsed"] = sorted(used)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)
