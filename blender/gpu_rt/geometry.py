"""The meshes of a scene as a GLB, by Blender's exporter."""

import json

import bpy

from . import blur, materials


def write_glbs(depsgraph, folder, moves):
    """Writes what renders show: each instance that Blender evaluates, after all modifiers. So collections, particles and geometry nodes
    make no difference, and neither do curves, texts and metaballs. Instances of one mesh share it. Returns files by their groups of what
    moves, what of the materials has failed, and the names of instances in the files, by their keys."""
    flat = bpy.data.scenes.new("gpu-rt")
    meshes, groups, names = {}, {None: []}, {}
    for instance in depsgraph.object_instances:
        if not is_mesh(instance):
            continue
        shown, slots = instance.object, slots_of(instance.object)
        key = shown.data.as_pointer(), slots
        if key not in meshes:
            meshes[key] = with_materials(shown.data.copy(), slots)
        placed = bpy.data.objects.new(shown.name, meshes[key])
        placed.matrix_world = instance.matrix_world
        flat.collection.objects.link(placed)
        names[json.dumps(blur.key(instance))] = placed.name
        groups.setdefault(moves.group_of.get(blur.key(instance)), []).append(placed)
    bpy.context.window.scene = flat
    flat.frame_set(depsgraph.scene.frame_current)
    made = materials.Materials(flat)
    files = {}
    for group, members in groups.items():
        for placed in list(flat.collection.objects):
            flat.collection.objects.unlink(placed)
        for placed in members:
            flat.collection.objects.link(placed)
        files[group] = "scene.glb" if group is None else f"moving-{group}.glb"
        bpy.ops.export_scene.gltf(
            filepath=str(folder / files[group]), export_format="GLB", export_yup=True, use_active_scene=True, export_cameras=False,
            export_lights=False, export_apply=False, export_animations=False, export_skins=False, export_morph=False,
        )
        materials.extend(folder / files[group], made.extensions)
    return files, made.notes, names


def is_mesh(instance):
    return instance.object.type == "MESH" and instance.show_self


def slots_of(shown):
    """The materials of a mesh."""
    slots = [slot.material for slot in shown.material_slots] or list(shown.data.materials)
    return tuple(material and material.original for material in slots)


def with_materials(mesh, slots):
    for index, material in enumerate(slots):
        if index < len(mesh.materials):
            mesh.materials[index] = material
        else:
            mesh.materials.append(material)
    return mesh
