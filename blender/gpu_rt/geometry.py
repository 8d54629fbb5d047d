"""The meshes of a scene as a GLB, by Blender's exporter."""

import bpy


def write_glb(depsgraph, path):
    """Writes what renders show: each instance that Blender evaluates, after all modifiers. So collections, particles and geometry nodes
    make no difference, and neither do curves, texts and metaballs. Instances of one mesh share it."""
    flat = bpy.data.scenes.new("gpu-rt")
    meshes = {}
    for instance in depsgraph.object_instances:
        shown = instance.object
        if shown.type != "MESH" or not instance.show_self:
            continue
        materials = [slot.material for slot in shown.material_slots] or list(shown.data.materials)
        materials = tuple(material and material.original for material in materials)
        key = shown.data.as_pointer(), materials
        if key not in meshes:
            meshes[key] = with_materials(shown.data.copy(), materials)
        placed = bpy.data.objects.new(shown.name, meshes[key])
        placed.matrix_world = instance.matrix_world
        flat.collection.objects.link(placed)
    bpy.context.window.scene = flat
    bpy.ops.export_scene.gltf(
        filepath=str(path), export_format="GLB", export_yup=True, use_active_scene=True, export_cameras=False, export_lights=False,
        export_apply=False, export_animations=False, export_skins=False, export_morph=False,
    )


def with_materials(mesh, materials):
    for index, material in enumerate(materials):
        if index < len(mesh.materials):
            mesh.materials[index] = material
        else:
            mesh.materials.append(material)
    return mesh
