"""The 3D view in a window of Blender, for `window.sh`: a script of Blender, with the program on PATH.

Blender goes on only between the steps of a test, so a test is a generator, which yields what it waits for.
"""

import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import time
import traceback

import bpy
import numpy as np
from mathutils import Euler

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "blender"))
import gpu_rt
from gpu_rt import engine, process, viewport

SPP = 16
# Seconds that a step may take.
PATIENCE = 120

views, programs = [], []


def watch():
    """Notes the views with their exports and their last request, and the processes that are started."""
    begin, start, export, send = viewport.Viewport.__init__, process.start, viewport.Viewport._export, viewport.Session.send

    def begun(view):
        begin(view)
        view.exports, view.request = 0, None
        views.append(view)

    def exported(view):
        view.exports += 1
        export(view)

    def sent(session, request):
        for view in views:
            if session is view._session and "interrupt" not in request:
                view.request = request
        send(session, request)

    def started(*arguments):
        programs.append(start(*arguments))
        return programs[-1]

    viewport.Viewport.__init__, process.start, viewport.Viewport._export, viewport.Session.send = begun, started, exported, sent


def area():
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def stage():
    """The cube on a plane with a lamp of each kind, from the camera, whose frame is all of the view."""
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1))
    for kind, energy, at, size in (("AREA", 200, (2, -2, 4), "size"), ("SPOT", 300, (-3, 0, 4), "shadow_soft_size"), ("SUN", 1, (0, 0, 5), "angle")):
        bpy.ops.object.light_add(type=kind, location=at, rotation=(0.3, 0.2, 0))
        light = bpy.context.object.data
        light.energy = energy
        setattr(light, size, 0.0 if kind == "SPOT" else 0.5)
    scene, region = bpy.context.scene, next(region for region in area().regions if region.type == "WINDOW")
    scene.render.engine, scene.gpu_rt.samples = "GPU_RT", SPP
    scene.render.resolution_x, scene.render.resolution_y = region.width, region.height
    space = area().spaces.active
    space.region_3d.view_perspective, space.region_3d.view_camera_zoom = "CAMERA", 50 * (2 - math.sqrt(2))
    space.region_3d.view_camera_offset = 0, 0
    return region.width, region.height


def choose(mode, area=None):
    (area or globals()["area"]()).spaces.active.shading.type = mode


def is_whole(view):
    """Whether the view shows all of the image at rest."""
    def found():
        is_complete = view._whole is not None and view._whole == view._key and not view._changed and not view._next
        return is_complete and view.image is not None and view.image.shape[1::-1] == view._key["size"]

    return found


def changes(view):
    """Whether the view shows something else than now, as a whole."""
    key = view._key
    return lambda: view._key != key and is_whole(view)()


def image_of(view):
    return view._session._folder / view.request["output"]


def f12():
    """The program's image of F12, and one of the same export with other random numbers."""
    bpy.ops.render.render()
    folder = engine.folder_of(bpy.context.scene, bpy.context.view_layer.name)
    image, other = next(file for file in folder.glob("*.exr") if file.name != "world.exr"), folder.parent / "other.exr"
    line = ["gpu-rt", "render", "scene.ron", "-o", other, "--seed=1", f"--spp={SPP}", "--quiet", "--force"]
    subprocess.run(line, cwd=folder, check=True)
    return image, other


def differs(image, reference):
    """Whether two images differ by more than noise, and in which words."""
    ran = subprocess.run(["gpu-rt", "compare", image, reference, "--json"], capture_output=True, check=True)
    found = json.loads(ran.stdout)
    return found["p"] < found["level"], found["verdict"]


def is_gone(pid):
    return not os.path.exists(f"/proc/{pid}")


def test_picture_is_that_of_f12():
    width, height = stage()
    choose("RENDERED")
    yield lambda: views and is_whole(views[0])()
    view, (image, other) = views[0], f12()
    assert view.image.shape == (height, width, 3), view.image.shape
    own = engine.exr.read(image_of(view))
    yield lambda: (view.image[::-1] == np.dstack([own[colour] for colour in "RGB"])).all()
    # Its random numbers are those of F12: but for roundings it is the same image.
    of_f12 = engine.exr.read(image)
    is_near = np.all([np.isclose(own[colour], of_f12[colour], rtol=1e-3, atol=1e-5) for colour in "RGB"], axis=0)
    assert is_near.mean() > 0.98, is_near.mean()
    is_other, verdict = differs(image_of(view), other)
    assert not is_other, verdict
    # With a lamp elsewhere, that is found.
    bpy.data.objects["Light"].location.x += 0.3
    yield changes(view)
    is_other, verdict = differs(image_of(view), other)
    assert is_other, verdict


def test_changes_are_requests():
    """A turn of the view, a moved object, and numbers: none is exported, and the picture is that of the scene as it is then."""
    view, exports = views[0], views[0].exports
    rotation = area().spaces.active.region_3d.view_rotation
    area().spaces.active.region_3d.view_perspective = "PERSP"
    yield changes(view)
    before, begin = view.request, time.monotonic()
    rotation.rotate(Euler((0, 0, 0.3)))
    width, height = before["size"].split("x")
    yield lambda: view.image.shape[:2] == (int(height) // 4, int(width) // 4)
    print(f"a turn shows after {time.monotonic() - begin:.2f} s")
    assert view.request["camera"] != before["camera"] and view.request["objects"] == before["objects"], view.request
    yield is_whole(view)
    area().spaces.active.region_3d.view_perspective = "CAMERA"
    yield changes(view)
    camera, begin = view.request["camera"], time.monotonic()

    cube = bpy.data.objects["Cube"]
    cube.location, cube.rotation_euler, cube.scale = (0.5, 1, 0.5), (0.1, 0.2, 0.3), (1.2, 1.2, 1.2)
    yield lambda: "Cube.001" in view.request["objects"]
    yield lambda: view.image.shape[:2] == (int(height) // 4, int(width) // 4)
    print(f"a moved object shows after {time.monotonic() - begin:.2f} s")
    inputs = bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Roughness"].default_value = (0.7, 0.2, 0.1, 1), 0.3
    for name, energy, turn in (("Light", 500, (0, 0, 0)), ("Area", 300, (0.5, 0.1, 0)), ("Spot", 500, (0.1, 0.3, 0)), ("Sun", 2, (0.6, -0.3, 0))):
        bpy.data.objects[name].rotation_euler, bpy.data.lights[name].energy = turn, energy
    bpy.data.objects["Area"].location.x += 0.5
    yield changes(view)
    assert view.exports == exports, "it was exported"
    assert view.request["camera"] == camera, view.request
    assert view.request["materials"]["scene.glb#Material"] == "(base_color: Rgb(0.699999988079071, 0.20000000298023224, 0.10000000149011612), roughness: 0.30000001192092896)"
    assert {"Light", "Area", "Spot", "Sun"} <= set(view.request["materials"]), view.request
    is_other, verdict = differs(image_of(view), f12()[1])
    assert not is_other, verdict


def test_other_changes_are_exported():
    view, exports = views[0], views[0].exports
    bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs["Coat Weight"].default_value = 1
    bpy.data.meshes["Cube"].vertices[0].co.x += 0.5
    bpy.data.meshes["Cube"].update()
    os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"
    said = set()
    yield lambda: said.add(view._shown) or view.exports > exports and is_whole(view)()
    del os.environ["MESA_SHADER_CACHE_DISABLE"]
    assert "exporting the scene" in said and any(words.startswith("compiling ") for words in said if words), said
    is_other, verdict = differs(image_of(view), f12()[1])
    assert not is_other, verdict


def test_an_edited_mesh_is_exported_once():
    view, exports = views[0], views[0].exports
    bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
    for mode in ("EDIT", "OBJECT"):
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area()):
            bpy.ops.object.mode_set(mode=mode)
        yield lambda: view.exports > exports and is_whole(view)()
        until = time.monotonic() + 1
        yield lambda: time.monotonic() > until
        # Blender may tell of it twice.
        assert view.exports <= exports + 2, view.exports - exports
        exports = view.exports


def test_views_that_move_the_frustum():
    """A camera view that is shifted, and a parallel one: all of F12's image is in them, elsewhere."""
    view, three = views[0], area().spaces.active.region_3d
    three.view_camera_offset = 0.1, 0.05
    yield changes(view)
    assert "Calibrated(" in view.request["camera"] and not view._failure, view.request
    three.view_camera_offset = 0, 0
    three.view_perspective = "ORTHO"
    yield changes(view)
    assert "Orthographic(" in view.request["camera"] and not view._failure, view.request
    three.view_perspective = "CAMERA"
    yield changes(view)


def test_a_killed_program_is_said():
    view = views[0]
    yield is_whole(view)
    exports = view.exports
    os.kill(view._session._program.pid, signal.SIGKILL)
    yield lambda: view._shown and "ended with status -9" in view._shown
    until = time.monotonic() + 2
    yield lambda: time.monotonic() > until
    assert view.exports == exports, "it is started again and again"
    # The next change of the scene starts it.
    bpy.data.objects["Cube"].location.x += 0.1
    yield lambda: view.exports > exports and is_whole(view)()


def test_leaving_the_mode_ends_the_programs():
    """At rest, while it exports, and while it renders; with two views at once."""
    views.clear()
    running = [program.pid for program in programs if program.poll() is None]
    assert running
    choose("SOLID")
    yield lambda: all(map(is_gone, running))
    for moment in ("_next", "_session"):
        choose("RENDERED")
        yield lambda: views and getattr(views[0], moment)
        views.clear()
        choose("SOLID")
        yield lambda: all(is_gone(program.pid) for program in programs)
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area()):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    areas = [area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D"]
    for each in areas:
        choose("RENDERED", each)
    yield lambda: len(views) == 2 and all(is_whole(view)() for view in views)
    views.clear()
    for each in areas:
        choose("SOLID", each)
    yield lambda: all(is_gone(program.pid) for program in programs)
    left = [name for name in os.listdir(bpy.app.tempdir) if name.startswith("gpu-rt-view")]
    assert not left, left


def run():
    """All tests, step by step. Ends Blender."""
    watch()
    gpu_rt.register()
    bpy.context.preferences.view.show_splash = False
    tests = [(name, test) for name, test in globals().items() if name.startswith("test_")]
    failed = 0
    for name, test in tests:
        begin = time.monotonic()
        try:
            for condition in test():
                until = time.monotonic() + PATIENCE
                while not condition():
                    if time.monotonic() > until:
                        raise AssertionError(f"it waits in vain: {[(view._shown, view.request) for view in views]}")
                    yield
        except Exception:
            failed += 1
            traceback.print_exc()
        print(f"{name}: {time.monotonic() - begin:.1f} s", flush=True)
    print(f"{len(tests) - failed} of {len(tests)} passed", flush=True)
    os._exit(1 if failed else 0)


running = run()
bpy.app.timers.register(lambda: next(running) or 0.02, first_interval=1)
