"""The extension blender/gpu_rt in Blender's Python module: F12, what it exports, and its picture against Cycles. `make test-blender` runs
it, with the program on PATH."""

import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
from unittest import mock

import bpy  # first: it brings the other modules
import numpy as np
import OpenEXR
from mathutils import Vector

FOLDER = pathlib.Path(__file__).resolve().parent
# The extension, and not the module of PyPI that has the same name.
sys.path.insert(0, str(FOLDER.parents[1] / "blender"))
import gpu_rt
from gpu_rt import engine, exr, lamps, losses, panel, preferences, process, ron

SIZE = (64, 48)
# Of Cycles and of the program, samples of a pixel.
CYCLES_SPP, SPP = 256, 64


def setUpModule():
    gpu_rt.register()
    # Again, as when Blender loads its scripts anew.
    gpu_rt.unregister()
    gpu_rt.register()


def software_device():
    """The index of a software driver: tests choose it, or what GPU_RT_TEST_DEVICE names."""
    listed = json.loads(subprocess.run([preferences.program(), "devices", "--json"], capture_output=True, check=True).stdout)
    return os.environ.get("GPU_RT_TEST_DEVICE") or next(str(each["index"]) for each in listed["devices"] if each["software"])


def read(path):
    """An EXR by a reader that is not ours: channels by name, row 0 on top."""
    return {name: channel.pixels for name, channel in OpenEXR.File(str(path), separate_channels=True).parts[0].channels.items()}


def matt(name, colour=(0.8, 0.8, 0.8)):
    """A material on the active object that is one model in Cycles and in glTF."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*colour, 1)
    inputs["Roughness"].default_value, inputs["Specular IOR Level"].default_value = 1, 0
    bpy.context.object.data.materials.clear()
    bpy.context.object.data.materials.append(made)
    return made


def add_lamp(kind, energy, at, turn=(0, 0, 0), **more):
    bpy.ops.object.light_add(type=kind, location=at, rotation=[math.radians(angle) for angle in turn])
    light = bpy.context.object.data
    light.energy = energy
    for name, value in more.items():
        setattr(light, name, value)
    return bpy.context.object


def background():
    return bpy.context.scene.world.node_tree.nodes["Background"].inputs


def add_sky(turn=None):
    """An image of the world without symmetries: the ground, a sky, a sun. Angles are in degrees."""
    tree = bpy.context.scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    sky.image = bpy.data.images.load(str(FOLDER / "world-in-blender.hdr"))
    tree.links.new(sky.outputs["Color"], background()["Color"])
    background()["Strength"].default_value = 1
    if turn:
        mapping, coordinates = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
        mapping.inputs["Rotation"].default_value = [math.radians(angle) for angle in turn]
        tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], sky.inputs["Vector"])
    return sky


class InBlender(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="with spaces ä ")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        self.scene = bpy.context.scene
        self.choose_engine(self.scene)

    def choose_engine(self, scene):
        scene.render.engine = "GPU_RT"
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.gpu_rt.samples, scene.gpu_rt.device = SPP, software_device()

    def stage(self):
        """The cube on a plane, both matt, in the dark."""
        bpy.data.objects.remove(bpy.data.objects["Light"])
        bpy.context.view_layer.objects.active = bpy.data.objects["Cube"]
        matt("Cube", (0.7, 0.4, 0.3))
        bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1))
        matt("Floor")
        background()["Strength"].default_value = 0

    def files(self, scene=None, layer=None):
        scene = scene or self.scene
        return engine.folder_of(scene, layer or scene.view_layers[0].name)

    def f12(self, **options):
        """Renders, and returns the passes of the last view layer by their names: height x width x channels, row 0 on top."""
        passes = {}
        hand_over = engine.hand_over

        def keep(image, combined, filled):
            hand_over(image, combined, filled)
            height = exr.read(image)["R"].shape[0]
            for each in filled:
                values = np.empty(len(each.rect) * each.channels, np.float32)
                each.rect.foreach_get(values)
                passes[each.name] = values.reshape(height, -1, each.channels)[::-1]

        with mock.patch.object(engine, "hand_over", keep):
            bpy.ops.render.render(**options)
        return passes

    def export(self, **options):
        """F12 without the program. Returns the scene file, and the JSON of the GLB."""
        with mock.patch.object(engine.GPU_RT_engine, "_run", side_effect=engine.Cancelled):
            bpy.ops.render.render(**options)
        files = self.files(bpy.data.scenes[options["scene"]] if "scene" in options else None)
        data = (files / "scene.glb").read_bytes()
        size = int.from_bytes(data[12:16], "little")
        return (files / "scene.ron").read_text(encoding="utf-8"), json.loads(data[20:20 + size])

    def fails(self, words, **options):
        with self.assertRaisesRegex(RuntimeError, words) as raised:
            bpy.ops.render.render(**options)
        self.assertNotIn("Traceback", str(raised.exception))

    def save(self, name):
        """The picture of the last render."""
        settings = self.scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
        path = self.folder / name
        bpy.data.images["Render Result"].save_render(str(path))
        return path

    def cycles(self):
        """The picture by Cycles, without what is a setting of Cycles alone."""
        self.scene.render.engine = "CYCLES"
        settings = self.scene.cycles
        for name, value in {
            "samples": CYCLES_SPP, "seed": 1, "use_adaptive_sampling": False, "use_denoising": False, "pixel_filter_type": "BOX",
            "filter_width": 1.0, "light_sampling_threshold": 0.0, "sample_clamp_indirect": 0.0, "diffuse_bounces": 64, "max_bounces": 64,
        }.items():
            setattr(settings, name, value)
        bpy.ops.render.render()
        self.scene.render.engine = "GPU_RT"
        return self.save("cycles.exr")

    def distance(self, image, reference):
        """The relative difference of the means, and FLIP."""
        ran = subprocess.run([preferences.program(), "compare", image, reference, "--json"], capture_output=True, check=True)
        report = json.loads(ran.stdout)
        means = [np.mean([read(path)[colour] for colour in "RGB"]) for path in (image, reference)]
        return means[0] / means[1] - 1, report["flip"]


class Result(InBlender):
    def test_result_is_the_program_s_own_image_of_the_exported_file(self):
        self.stage()
        add_lamp("AREA", 300, (1.5, -1.5, 4), (20, 20, 0), size=2)
        add_lamp("POINT", 100, (-2, -2, 2), shadow_soft_size=0.3)
        add_lamp("SUN", 1, (0, 0, 5), (40, 10, 30))
        passes = self.f12()
        own = self.folder / "own.exr"
        options = ["--spp", str(SPP), "--aov", "albedo,normal,depth,position", "--device", self.scene.gpu_rt.device, "--quiet"]
        subprocess.run([preferences.program(), "render", "scene.ron", "-o", own, *options], cwd=self.files(), check=True)
        own = read(own)
        for colour, each in zip("RGB", np.moveaxis(passes["Combined"], 2, 0)):
            np.testing.assert_array_equal(each, own[colour])
        for colour, each in zip("RGB", np.moveaxis(passes["Denoising Albedo"], 2, 0)):
            np.testing.assert_array_equal(each, own[f"albedo.{colour}"])
        np.testing.assert_array_equal(passes["Combined"][..., 3], 1)
        is_sky = own["Z"] > 1e30
        self.assertTrue(is_sky.any() and not is_sky.all())
        np.testing.assert_array_equal(passes["Depth"][..., 0], np.where(is_sky, np.float32(1e10), own["Z"]))
        # What Blender shows and saves has the same values, beside the alpha.
        saved = read(self.save("saved.exr"))
        for colour in "RGB":
            np.testing.assert_array_equal(saved[colour], own[colour])
        # In Blender's axes the floor is at z = -1 and looks up, and the cube's upper side is at z = 1.
        floor = passes["Denoising Normal"][-1, 32]
        np.testing.assert_allclose(floor, (0, 0, 1), atol=1e-6)
        self.assertAlmostEqual(float(passes["Position"][-1, 32, 2]), -1, places=5)
        camera, middle = self.scene.camera, passes["Position"][24, 32]
        seen = camera.matrix_world.inverted() @ Vector(middle.tolist())
        # Half a pixel from the camera's axis, and at its depth.
        self.assertLess(max(abs(seen.x), abs(seen.y)), 0.02 * abs(seen.z))
        self.assertAlmostEqual(-seen.z, float(passes["Depth"][24, 32, 0]), places=3)

    def test_region_percentage_and_layers(self):
        self.stage()
        background()["Strength"].default_value = 1
        whole = self.f12()["Combined"]
        render = self.scene.render
        render.use_border = True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.25, 0.5
        # From the upper left: columns 16 to 47, and rows 24 to 35.
        for render.use_crop_to_border in (True, False):
            np.testing.assert_array_equal(self.f12()["Combined"], whole[24:36, 16:48])
            saved = read(self.save("part.exr"))["R"]
            if not render.use_crop_to_border:
                self.assertEqual(saved[:24].max(), 0)
                saved = saved[24:36, 16:48]
            np.testing.assert_array_equal(saved, whole[24:36, 16:48, 0])
        render.use_border = False
        render.resolution_percentage = 33
        self.assertEqual(self.f12()["Combined"].shape, (15, 21, 4))
        # Each view layer has its objects. Names may be long, and hold what separates others.
        second = self.scene.view_layers.new("Zweite „Ebene“ / 2." + "x" * 40)
        second.layer_collection.children[0].exclude = True
        without = self.f12()["Depth"]
        self.assertEqual(without.min(), np.float32(1e10))

    def test_shifted_lens(self):
        self.stage()
        background()["Strength"].default_value = 1
        whole = self.f12()["Combined"]
        # Blender's unit is the longer side: the picture moves 8 columns to the left, and 4 rows up.
        self.scene.camera.data.shift_x, self.scene.camera.data.shift_y = 8 / 64, -4 / 64
        shifted = self.f12()["Combined"]
        text = (self.files() / "scene.ron").read_text()
        self.assertIn("image: (width: 80, height: 56)", text)
        # Other pixels have other random numbers: only the sky is the same to the byte, and the means agree within their noise, which is
        # below 1 % of 64 samples of 1600 pixels that see a white sky.
        self.assertLess(abs(shifted[:-4, :-8].mean() / whole[4:, 8:].mean() - 1), 0.01)
        self.assertGreater(np.abs(whole[:-4, :-8] - whole[4:, 8:]).mean(), 4 * np.abs(shifted[:-4, :-8] - whole[4:, 8:]).mean())

    def test_denoised(self):
        self.stage()
        background()["Strength"].default_value = 1
        self.scene.gpu_rt.samples = 8
        noisy = self.f12()["Combined"]
        self.scene.gpu_rt.denoise = True
        clean = self.f12()["Combined"]
        floor = np.s_[40:, 8:56, 0]
        # Neighbours on the floor are alike without their noise.
        self.assertLess(np.diff(clean[floor]).std(), 0.5 * np.diff(noisy[floor]).std())
        self.assertLess(abs(clean[..., :3].mean() / noisy[..., :3].mean() - 1), 0.02)

    def test_frames_move(self):
        self.stage()
        cube = bpy.data.objects["Cube"]
        for frame, height in ((1, 0), (3, 1)):
            cube.location.z = height
            cube.keyframe_insert("location", frame=frame)
        self.scene.frame_start, self.scene.frame_end = 2, 3
        self.scene.render.filepath = str(self.folder / "frame.####")
        heights = []
        with mock.patch.object(engine.GPU_RT_engine, "_run", side_effect=lambda *_: self.heights(heights)):
            bpy.ops.render.render(animation=True)
        np.testing.assert_allclose(heights, [0.5, 1])

    def heights(self, heights):
        data = (self.files() / "scene.glb").read_bytes()
        nodes = json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])["nodes"]
        heights.append(next(node for node in nodes if "Cube" in node["name"])["translation"][1])
        raise engine.Cancelled


class BesideCycles(InBlender):
    """The same .blend by Cycles. The scenes are matt, so that both have one model (docs/gltf.md: a plastic box differs by 9 %).

    A mean has a noise of 0.25 % here, if a sample's standard deviation is its mean: 1 / sqrt(64 · 64 · 48), and half of that by Cycles.
    So 1 % is four standard deviations. FLIP has the bound of docs/gltf.md, 0.06, most of which is noise.
    """

    def is_near(self, found):
        return abs(found[0]) < 0.01 and found[1] < 0.06

    def beside(self, plant, *controls):
        """Compares the picture, and checks that each control is found: a function that changes the scene after Cycles has rendered it."""
        plant()
        reference = self.cycles()
        bpy.ops.render.render()
        found = self.distance(self.save("image.exr"), reference)
        print(self.id().split(".")[-1], "mean %+.2f %%, FLIP %.3f" % (100 * found[0], found[1]))
        self.assertTrue(self.is_near(found), found)
        for control in controls:
            control()
            bpy.ops.render.render()
            wrong = self.distance(self.save("wrong.exr"), reference)
            self.assertFalse(self.is_near(wrong), wrong)

    def test_area_lamps(self):
        self.stage()

        def plant():
            add_lamp("AREA", 200, (1.5, -1.5, 4), (20, 20, 40), shape="RECTANGLE", size=3, size_y=0.5).name = "Panel"
            add_lamp("AREA", 100, (-2, -2, 3), (35, -30, 0), shape="ELLIPSE", size=1.5, size_y=0.5).scale = (-1, 1.5, 1)

        def brighter():
            bpy.data.objects["Panel"].data.energy *= 1.04

        self.beside(plant, brighter)

    def test_lamps_with_a_size(self):
        self.stage()

        def plant():
            add_lamp("POINT", 300, (0.5, -3.5, 4), shadow_soft_size=0.4)
            add_lamp("SUN", 2, (0, 0, 5), (40, 10, 30), angle=math.radians(12)).name = "Sun"
            add_lamp("SPOT", 600, (-3, -2, 4), (35, -25, 0), shadow_soft_size=0, spot_blend=0.3).name = "Spot"

        def sharper():
            bpy.data.objects["Sun"].data.energy *= 1.04

        self.beside(plant, sharper)

    def test_world_of_an_image(self):
        self.stage()
        # It looks at the horizon, so that the picture shows the sky, too.
        self.scene.camera.location, self.scene.camera.data.lens = (3, -4, 1.5), 16
        self.scene.camera.rotation_euler = [math.radians(angle) for angle in (95, 0, 40)]

        def turned():
            # The file itself is in use until then.
            file = ron.text(str(FOLDER / "world-in-blender.hdr"))
            self.assertIn(f"background: Image(path: {file})", (self.files() / "scene.ron").read_text())
            add_sky((0, 0, 90))

        self.beside(add_sky, turned)

    def test_world_that_is_baked(self):
        self.stage()
        self.scene.camera.location, self.scene.camera.data.lens = (3, -4, 1.5), 16
        self.scene.camera.rotation_euler = [math.radians(angle) for angle in (95, 0, 40)]

        def plant():
            add_sky((20, 30, 70))
            background()["Strength"].default_value = 0.7

        def brighter():
            background()["Strength"].default_value *= 1.04

        self.beside(plant, brighter)
        self.assertIn('background: Image(path: "world.exr")', (self.files() / "scene.ron").read_text())

    def test_startup_file_as_it_is(self):
        """With its plastic, by the bounds of docs/gltf.md: 4 %."""
        reference = self.cycles()
        bpy.ops.render.render()
        found = self.distance(self.save("image.exr"), reference)
        print("startup mean %+.2f %%, FLIP %.3f" % (100 * found[0], found[1]))
        self.assertTrue(abs(found[0]) < 0.04 and found[1] < 0.06, found)


class Export(InBlender):
    def test_names_libraries_instances_and_what_is_hidden(self):
        cube = bpy.data.objects["Cube"]
        cube.modifiers.new("Finer", "SUBSURF").levels = 0
        library = self.folder / "library ü.blend"
        bpy.data.libraries.write(str(library), {bpy.data.collections["Collection"]})
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        self.scene = bpy.context.scene
        self.choose_engine(self.scene)
        cube = bpy.data.objects["Cube"]
        cube.name, cube.data.materials[0].name = 'Wür"fel \\ 1', 'Grün "\\'
        cube.hide_viewport = True
        for name, hide in (("Gone", "hide_render"), ("Seen", "hide_select")):
            copy = cube.copy()
            copy.name, copy.location.x, copy.hide_viewport = name, 3, False
            setattr(copy, hide, True)
            self.scene.collection.objects.link(copy)
        bpy.data.objects["Seen"].hide_set(True)
        bpy.data.objects["Light"].name = 'L"ämp\\ 日本'
        with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
            wanted.collections = ["Collection"]
        for index in range(2):
            instance = bpy.data.objects.new("Instance", None)
            instance.instance_type, instance.instance_collection = "COLLECTION", wanted.collections[0]
            instance.location.y = 4 * index
            self.scene.collection.objects.link(instance)
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "user ä.blend"))
        text, gltf = self.export()
        # The cube and the copy that is seen, of one mesh; and twice that of the library, whose finer mesh is that of renders.
        positions = [gltf["meshes"][node["mesh"]]["primitives"][0]["attributes"]["POSITION"] for node in gltf["nodes"]]
        counts = [gltf["accessors"][position]["count"] for position in positions]
        self.assertEqual(len(gltf["meshes"]), 2)
        self.assertEqual(sorted(counts)[:2], [24, 24])
        self.assertEqual(len(counts), 4)
        self.assertGreater(min(sorted(counts)[2:]), 24 * 4)
        # A lamp of its own, and two of the library.
        self.assertEqual(text.count("DiffuseLight("), 3)
        self.assertIn('"L\\"ämp\\\\ 日本', text)
        self.assertEqual(self.f12()["Combined"].shape[:2], SIZE[::-1])

    def test_what_is_no_mesh(self):
        bpy.data.objects.remove(bpy.data.objects["Cube"])
        bpy.ops.object.text_add()
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
        bpy.ops.object.metaball_add()
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
        names = [node["name"].split(".")[0] for node in self.export()[1]["nodes"]]
        # Each once.
        self.assertEqual(sorted(names), ["BézierCircle", "Mball", "SurfSphere", "Text"])

    def test_materials_of_objects_and_packed_images(self):
        cube = bpy.data.objects["Cube"]
        image = bpy.data.images.new("Packed", 4, 4)
        image.pack()
        made = cube.data.materials[0]
        texture = made.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        made.node_tree.links.new(texture.outputs["Color"], made.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
        cube.data.materials.append(bpy.data.materials.new("Second"))
        cube.data.polygons[0].material_index = 1
        copy = cube.copy()
        self.scene.collection.objects.link(copy)
        copy.material_slots[0].link, copy.material_slots[0].material = "OBJECT", bpy.data.materials.new("Own")
        _, gltf = self.export()
        parts = [gltf["meshes"][node["mesh"]]["primitives"] for node in gltf["nodes"]]
        used = [[gltf["materials"][part["material"]]["name"] for part in each] for each in parts]
        self.assertEqual(sorted(used), [["Material", "Second"], ["Own", "Second"]])
        self.assertEqual(len(gltf["images"]), 1)

    def test_worlds(self):
        for plant, expected in (
            (lambda: setattr(self.scene, "world", None), "Solid((0.0, 0.0, 0.0))"),
            (lambda: setattr(background()["Strength"], "default_value", 2), "Solid((0.1"),
            (lambda: self.scene.world.node_tree.nodes.clear(), "Solid((0.0, 0.0, 0.0))"),
        ):
            self.setUp()
            plant()
            self.assertIn(f"background: {expected}", self.export()[0])

    def test_second_scene(self):
        second = bpy.data.scenes.new("Zwei")
        self.choose_engine(second)
        second.camera = self.scene.camera
        second.collection.objects.link(bpy.data.objects["Cube"])
        text, gltf = self.export(scene="Zwei")
        self.assertEqual((len(gltf["nodes"]), text.count("DiffuseLight")), (1, 0))

    def test_lens(self):
        lens = self.scene.camera.data
        lens.lens, lens.dof.use_dof, lens.dof.aperture_fstop, lens.dof.focus_distance = 50, True, 2, 7
        # 50 mm over 2: the diameter is 25 mm.
        self.assertIn("aperture: 0.025, focus_distance: 7.0", self.export()[0])
        lens.dof.focus_object = bpy.data.objects["Cube"]
        distance = (self.scene.camera.matrix_world.inverted() @ Vector()).z
        self.assertAlmostEqual(float(self.export()[0].split("focus_distance: ")[1].split(")")[0]), -distance, places=4)

    def test_lamps_without_size_or_light(self):
        light = bpy.data.objects["Light"]
        for plant in (
            lambda: setattr(light.data, "energy", -5),
            lambda: setattr(light.data, "energy", 0),
            lambda: (setattr(light.data, "type", "AREA"), setattr(light, "scale", (0, 1, 1))),
        ):
            plant()
            self.assertNotIn("Light(", self.export()[0])
        # A beam has the light of Blender's: the mean of a smoothstep is a half.
        spot = bpy.data.lights.new("Spot", "SPOT")
        spot.spot_size, spot.spot_blend = math.radians(90), 0.4
        inner, outer = (math.cos(math.radians(angle)) for angle in lamps.beam(spot))
        width = 0.4 * (1 - outer)
        self.assertAlmostEqual((inner - outer) / 3 + (outer + width - inner), width / 2)


class Stop(InBlender):
    def run_until(self, is_over):
        """`process.run`, which Esc stops as soon as the program runs and this is true."""
        run = process.run

        def stopped(command, folder, is_cancelled, *more):
            begin = time.monotonic()
            return run(command, folder, lambda: is_cancelled() or is_over(command[1] == "render", time.monotonic() - begin), *more)

        return mock.patch.object(engine, "run", stopped)

    def test_esc_keeps_the_samples_and_f12_goes_on(self):
        self.stage()
        background()["Strength"].default_value = 1
        self.scene.gpu_rt.samples = 1 << 20
        shown, fill = [], engine.fill

        def seen(render_pass, *channels):
            shown.append((render_pass.name, float(channels[0].mean())))
            fill(render_pass, *channels)

        def has_shown(is_program, seconds):
            self.assertLess(seconds, 200)
            return is_program and len(shown) > 2

        with self.run_until(has_shown), mock.patch.object(engine, "fill", seen):
            passes = self.f12()
        # The whole picture was shown while it converged: soon the mean of its red is about that of the end. The first one may lack pixels.
        self.assertEqual({name for name, _ in shown[:3]}, {"Combined"})
        self.assertLess(abs(shown[2][1] / passes["Combined"][..., 0].mean() - 1), 0.1)
        image, = self.files().glob("*.exr")
        held = exr.held_samples(image)
        self.assertTrue(0 < held < 1 << 20)
        # The same scene goes on: with 8 samples more it is there at once, and has the values of one render.
        self.scene.gpu_rt.samples = held + 8
        passes = self.f12()
        self.assertEqual(exr.held_samples(image), held + 8)
        log = read(image)
        np.testing.assert_array_equal(passes["Combined"][..., 0], log["R"])
        self.assertEqual({int(log["samples.Y"].min()), int(log["samples.Y"].max())}, {held + 8})
        # Fewer samples, another scene and other settings begin anew.
        self.scene.gpu_rt.samples = 8
        self.f12()
        self.assertEqual(exr.held_samples(image), 8)
        bpy.data.objects["Cube"].location.x += 1
        self.f12()
        self.assertFalse(image.exists())

    def test_samples_of_another_image_of_the_world_are_dropped(self):
        self.stage()
        sky = add_sky()
        file = self.folder / "sky.hdr"
        file.write_bytes(data := pathlib.Path(sky.image.filepath).read_bytes())
        sky.image.filepath = str(file)
        before = self.f12()["Combined"]
        # Twice the light: its exponents are one more. The exported files are the same.
        header = data.index(b"+X 32\n") + 6
        codes = np.frombuffer(data[header:], np.uint8).reshape(-1, 4) + np.uint8([0, 0, 0, 1])
        file.write_bytes(data[:header] + codes.tobytes())
        np.testing.assert_allclose(self.f12()["Combined"][..., :3], 2 * before[..., :3], rtol=1e-5)

    def test_esc_while_exporting(self):
        with self.run_until(lambda is_program, seconds: not is_program and seconds > 0.2):
            bpy.ops.render.render()
        self.assertEqual(list(self.files().glob("scene.*")), [])


class Errors(InBlender):
    def program(self, script):
        """PATH with another program, or without one."""
        folder = self.folder / "bin"
        folder.mkdir(exist_ok=True)
        if script is not None:
            (folder / "gpu-rt").write_text(script)
            (folder / "gpu-rt").chmod(0o755)
        return mock.patch.dict(os.environ, PATH=f"{folder}:/usr/bin:/bin", HOME=str(self.folder))

    def test_program(self):
        for script, words in (
            (None, "The program gpu-rt is not on PATH: install it, or set Preferences > Add-ons"),
            ("#!/bin/sh\necho \"error: unexpected argument '--aov' found\" >&2; exit 2\n", "gpu-rt has failed: unexpected argument"),
            ("#!/bin/sh\nkill -9 $$\n", "gpu-rt has failed: it ended with status -9"),
            ("#!/bin/sh\necho hello\n", "gpu-rt has written no image: is it gpu-rt?"),
            ("no program", "gpu-rt cannot be started: "),
        ):
            with self.subTest(words), self.program(script):
                self.fails(words)
        # A preference is taken before PATH.
        addon = mock.MagicMock()
        addon.preferences.program = "/nowhere/gpu-rt"
        with mock.patch.object(preferences.bpy, "context", mock.MagicMock()) as context:
            context.preferences.addons.get.return_value = addon
            with self.assertRaisesRegex(process.Failure, "/nowhere/gpu-rt is not a program: set Preferences"):
                preferences.program()

    def test_scene(self):
        bpy.data.lights["Light"].energy = 1e38
        self.fails(r'has failed: scene.ron:.*materials\["Light"\].*expected a radiance')
        self.scene.camera.data.type = "ORTHO"
        self.fails("The camera Camera is not perspective, which gpu-rt needs: change its Lens > Type")
        self.scene.camera.data.type = "PERSP"
        self.scene.render.pixel_aspect_x = 2
        self.fails("gpu-rt has square pixels: set Output > Format > Aspect to 1")
        self.scene.camera = None
        self.fails("no camera")

    def test_second_blender(self):
        with mock.patch.object(engine.sys, "executable", "/bin/false"):
            self.fails("The second Blender that exports the scene ended with status 1")

    def test_disk_that_is_full(self):
        with mock.patch.object(engine.pathlib.Path, "write_text", side_effect=OSError(28, "No space left on device")):
            self.fails("gpu-rt: .*No space left on device")


class Losses(InBlender):
    def told(self):
        return {words for _, words in losses.losses(self.scene, bpy.context.view_layer)}

    def test_nothing_is_lost_of_the_startup_file(self):
        self.assertEqual(self.told(), set())

    def test_each_is_told_with_its_object(self):
        made = bpy.data.materials["Material"]
        tree, shader = made.node_tree, made.node_tree.nodes["Principled BSDF"]
        output = tree.get_output_node("CYCLES")
        shader.inputs["Subsurface Weight"].default_value = 0.5
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], shader.inputs["Base Color"])
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.new("Lost", 1, 1)
        texture.image.source, texture.image.filepath = "FILE", "//nowhere.png"
        tree.links.new(texture.outputs["Color"], shader.inputs["Emission Color"])
        tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs["Volume"], output.inputs["Volume"])
        mix = tree.nodes.new("ShaderNodeMix")
        mix.data_type = "RGBA"
        tree.links.new(mix.outputs["Result"], noise.inputs["Vector"])
        cube = bpy.data.objects["Cube"]
        cube.modifiers.new("Hair", "PARTICLE_SYSTEM")
        cube.particle_systems[0].settings.type = "HAIR"
        cube.visible_shadow = False
        bpy.ops.object.volume_add()
        add_lamp("AREA", 10, (0, 0, 5), spread=math.radians(60))
        add_lamp("SPOT", 10, (0, 0, 5), shadow_soft_size=0.1)
        self.scene.render.use_motion_blur = self.scene.render.film_transparent = True
        library = self.folder / "gone.blend"
        bpy.data.libraries.write(str(library), {bpy.data.lights["Light"]})
        with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
            wanted.lights = ["Light"]
        library.unlink()
        told = losses.losses(self.scene, bpy.context.view_layer)
        for expected in (
            ("Cube", "Material: subsurface"), ("Cube", "Material: procedural texture: Noise Texture"), ("Cube", "Material: its volume"),
            ("Cube", "Material: node: Mix"),
            ("Cube", "Material: its image Lost: there is no such file"), ("Cube", "hair: Hair"),
            ("Cube", "it is not hidden from rays (shadow)"), ("Volume", "a volume"),
            ("Area", "its spread: it shines in all directions"), ("Spot", "its radius: its shadows are sharp"),
            ("Scene", "motion blur"), ("Scene", "the library gone.blend: there is no such file"),
            ("Scene", "the transparent film: the world is in the image"),
        ):
            self.assertIn(expected, told)

    def test_lamps_that_the_camera_sees(self):
        words = "it is not hidden from the camera"
        lamp = bpy.data.objects["Light"]
        self.assertNotIn(words, self.told())
        lamp.location = (0, 0, 0)
        bpy.context.view_layer.update()
        self.assertIn(words, self.told())
        lamp.data.shadow_soft_size = 0
        self.assertNotIn(words, self.told())

    def test_panel_lists_them(self):
        self.scene.render.use_motion_blur = True
        shown = mock.MagicMock()
        panel.GPU_RT_PT_losses.draw(shown, bpy.context)
        labels = [call.kwargs["text"] for call in shown.layout.column().label.call_args_list]
        self.assertEqual(labels, ["Scene", "motion blur"])
        panel.GPU_RT_PT_sampling.draw(shown, bpy.context)
        drawn = [call.args[1] for call in shown.layout.prop.call_args_list]
        self.assertEqual(drawn, ["samples", "noise", "time", "denoise", "light_paths", "device"])
        # Panels of materials and lamps are shown, those of EEVEE's settings are not.
        shared = {each.__name__ for each in panel.shared()}
        self.assertLessEqual({"EEVEE_MATERIAL_PT_surface", "DATA_PT_EEVEE_light", "RENDER_PT_color_management"}, shared)
        # DATA_PT_light is that of engines without EEVEE's.
        self.assertFalse([name for name in shared if name.startswith("RENDER_PT_eevee") or name == "DATA_PT_light"])


class Files(InBlender):
    def test_manifest_has_the_version_of_the_program(self):
        said = subprocess.run([preferences.program(), "--version"], capture_output=True, text=True, check=True).stdout
        manifest = tomllib.loads((FOLDER.parents[1] / "blender/gpu_rt/blender_manifest.toml").read_text())
        self.assertEqual((manifest["id"], f"gpu-rt {manifest['version']}"), (gpu_rt.__name__, said.strip()))

    def test_reader_has_the_values_of_another(self):
        self.stage()
        self.f12()
        image, = self.files().glob("*.exr")
        other = read(image)
        for name, values in exr.read(image).items():
            if values.dtype == other[name].dtype:
                np.testing.assert_array_equal(values[::-1], other[name], name)
        self.assertEqual(exr.held_samples(image), SPP)
        self.assertEqual(exr.held_samples(self.folder / "nothing.exr"), 0)


if __name__ == "__main__":
    unittest.main()
