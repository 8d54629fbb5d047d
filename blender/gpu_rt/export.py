"""Exports a scene for the program: a script for a second Blender in the background.

    blender --background --factory-startup --python export.py -- JOB.json

Operators such as Blender's exporter of glTF must not run in a render. The second Blender has a copy of the file, which it may change.
"""

import importlib.util
import json
import pathlib
import sys
import traceback

import bpy


def package():
    """This folder as a package, whatever else is called gpu_rt or beside it."""
    folder = pathlib.Path(__file__).resolve().parent
    spec = importlib.util.spec_from_file_location("gpu_rt", folder / "__init__.py", submodule_search_locations=[str(folder)])
    module = importlib.util.module_from_spec(spec)
    sys.modules["gpu_rt"] = module
    spec.loader.exec_module(module)


def export(job, folder):
    """Writes scene.ron and what it names. Returns what the engine has to know of it."""
    from gpu_rt import blur, camera, geometry, lamps, live, ron, world
    from gpu_rt.losses import pixel_filter

    bpy.ops.wm.open_mainfile(filepath=job["blend"], load_ui=False, use_scripts=job["scripts"])
    scene = bpy.data.scenes[job["scene"]]
    window = bpy.context.window
    window.scene = scene
    window.view_layer = scene.view_layers[job["layer"]]
    of_view = job.get("view", False)
    if of_view:
        # A 3D view has its own camera, no motion blur, and shows what the view does.
        scene.render.use_motion_blur = False
    else:
        show_as_rendered(scene)
    scene.frame_set(job["frame"], subframe=job["subframe"])
    depsgraph = bpy.context.evaluated_depsgraph_get()
    moves = blur.Blur(scene, depsgraph, job["frame"] + job["subframe"])
    fields, begin = live.FIELDS, (0, 0)
    if not of_view:
        fields, begin = camera.fields(scene, depsgraph, job["size"], moves)
    lights = lamps.Lamps(depsgraph, folder)
    background = world.background(scene, folder)
    state = live.state(depsgraph, lights, bpy.data.materials) if of_view else {}
    # Last: it changes the scene of the window, and with it what Blender has evaluated.
    files, notes, names = geometry.write_glbs(depsgraph, folder, moves)
    # Blender's exporter has Blender's +x along +x, and the image of the world has it along -z (axes.placed).
    meshes = {group: ron.Transformed(by=[ron.RotateY(90)], object=ron.Gltf(path=file)) for group, file in files.items()}
    meshes = [made if group is None else moves.moving(group, made) for group, made in meshes.items()]
    # Cycles' bounces are those after the first event.
    depth = scene.cycles.max_bounces + 1
    fields = fields | {
        "background": background, "materials": lights.materials, "objects": [*meshes, *lights.objects], "render": {"max_depth": depth},
    }
    (folder / "scene.ron").write_text(ron.dumps(fields), encoding="utf-8")
    return {
        "begin": begin, "notes": [*moves.notes, *notes], "exposure": scene.cycles.film_exposure, "filter": pixel_filter(scene.cycles)[0],
        "state": state, "names": names,
    }


def show_as_rendered(scene):
    """Has the viewport, whose objects and modifiers the exporter takes, show what renders show."""
    for shown in [*bpy.data.objects, *bpy.data.collections]:
        shown.hide_viewport = shown.hide_render
    for shown in bpy.context.view_layer.objects:
        shown.hide_set(False)
    for shown in bpy.data.objects:
        for modifier in shown.modifiers:
            modifier.show_viewport = modifier.show_render
            if modifier.type in ("SUBSURF", "MULTIRES"):
                modifier.levels = modifier.render_levels
    for curve in bpy.data.curves:
        for direction in ("u", "v"):
            finer = getattr(curve, f"render_resolution_{direction}")
            if finer:
                setattr(curve, f"resolution_{direction}", finer)
    for ball in bpy.data.metaballs:
        ball.resolution = ball.render_resolution
    scene.render.simplify_subdivision = scene.render.simplify_subdivision_render


def main():
    path = pathlib.Path(sys.argv[-1])
    job = json.loads(path.read_text(encoding="utf-8"))
    package()
    from gpu_rt.process import Failure

    try:
        answer = export(job, path.parent)
    except Failure as failure:
        answer = {"error": str(failure)}
    except Exception as error:
        # Blender's own errors begin with their kind, and an exporter's end with its traceback.
        traceback.print_exc()
        answer = {"error": "The scene cannot be exported: " + str(error).removeprefix("Error: ").strip().splitlines()[-1]}
    path.with_name("answer.json").write_text(json.dumps(answer), encoding="utf-8")


if __name__ == "__main__":
    main()
