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
from types import SimpleNamespace
from unittest import mock

import bpy  # first: it brings the other modules
import numpy as np
import OpenEXR
from mathutils import Vector

FOLDER = pathlib.Path(__file__).resolve().parent
# The extension, and not the module of PyPI that has the same name.
sys.path.insert(0, str(FOLDER.parents[1] / "blender"))
import gpu_rt
from gpu_rt import camera as camera_of
from gpu_rt import engine, exr, lamps, live, losses, panel, preferences, process, ron, viewport
from gpu_rt.job import job_of

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

        def keep(image, combined, filled, exposure):
            hand_over(image, combined, filled, exposure)
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

    def inside(self, mask, path, view=np.s_[:]):
        """An image, or a view of its pixels, that is black outside of a mask."""
        pixels = read(path)
        made = path.with_name(f"inside-{path.name}")
        OpenEXR.File({}, {colour: np.ascontiguousarray(pixels[colour][view] * mask) for colour in "RGB"}).write(str(made))
        return made


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

    def test_cameras(self):
        """Each camera sees the sky and the cube where Cycles does: outside of a fisheye's circle, which is black in Cycles alone, nothing is compared."""
        self.stage()
        add_sky()
        lens = self.scene.camera.data
        own = lens if hasattr(lens, "panorama_type") else lens.cycles
        self.scene.render.resolution_y = 64
        lens.ortho_scale = 9
        for kind, panorama, word in (
            ("ORTHO", "EQUIRECTANGULAR", "Orthographic(height: 9.0)"), ("PANO", "EQUIRECTANGULAR", "Equirectangular("),
            ("PANO", "FISHEYE_EQUIDISTANT", "Fisheye(model: Equidistant"), ("PANO", "FISHEYE_EQUISOLID", "Fisheye(model: Equisolid"),
        ):
            lens.type, own.panorama_type, own.fisheye_fov, own.fisheye_lens = kind, panorama, math.pi, 10.5
            with self.subTest(kind=kind, panorama=panorama):
                self.f12()
                self.assertIn(word, (self.files() / "scene.ron").read_text())
                circle = np.linalg.norm(np.indices((64, 64)) - 31.5, axis=0) < (25 if panorama.startswith("FISHEYE") else 64)
                ours, theirs = self.save("ours.exr"), self.cycles()
                theirs = self.inside(circle, theirs)
                mean, flip = self.distance(self.inside(circle, ours), theirs)
                _, of_mirror_image = self.distance(self.inside(circle, ours, np.s_[:, ::-1]), theirs)
                # Noise of 64 and 256 samples: twice what was found.
                self.assertLess(abs(mean), 0.005)
                self.assertLess(flip, 0.035 if kind == "ORTHO" else 0.016)
                self.assertGreater(of_mirror_image, 2 * flip)
        # Other images have other stretches.
        self.scene.render.resolution_y, own.panorama_type = 48, "FISHEYE_EQUIDISTANT"
        self.assertIn("Calibrated(fx: 20.37", self.export()[0])
        own.panorama_type = "MIRRORBALL"
        with self.assertRaisesRegex(RuntimeError, "mirrorball"):
            self.export()

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
            self.assertIn(f'background: Image(path: "{FOLDER / "world-in-blender.hdr"}")', (self.files() / "scene.ron").read_text())
            add_sky((0, 0, 90))

        self.beside(add_sky, turned)

    def test_world_of_a_studio_light(self):
        """One that Blender ships: a room with lamps, whose file has an alpha and numbers below 0."""
        self.stage()
        self.scene.camera.location, self.scene.camera.data.lens = (3, -4, 1.5), 16
        self.scene.camera.rotation_euler = [math.radians(angle) for angle in (95, 0, 40)]

        def plant():
            lights = pathlib.Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world"))
            add_sky().image = bpy.data.images.load(str(lights / "interior.exr"))

        def turned():
            add_sky((0, 0, 90)).image = bpy.data.images["interior.exr"]

        self.beside(plant, turned)

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

    def test_motion_blur(self):
        """A parent that turns and shifts unevenly scaled boxes, and the camera moves."""
        self.stage()
        cube, parent = bpy.data.objects["Cube"], bpy.data.objects.new("Parent", None)
        second = cube.copy()
        second.location, cube.scale = (0, 0, 1.4), (0.5, 0.3, 1)
        self.scene.collection.objects.link(parent)
        self.scene.collection.objects.link(second)
        second.scale, cube.parent, second.parent, cube.location.x = (2, 0.2, 0.2), parent, parent, 1.5
        background()["Strength"].default_value = 1
        for frame, turn in ((0, -0.8), (2, 1)):
            parent.rotation_euler.z, parent.location.x, self.scene.camera.location.x = turn, turn, 7.3 + 0.2 * turn
            for each, path in ((parent, "rotation_euler"), (parent, "location"), (self.scene.camera, "location")):
                each.keyframe_insert(path, frame=frame)
        self.scene.render.use_motion_blur, self.scene.render.motion_blur_shutter = True, 1
        cube.cycles.motion_steps = second.cycles.motion_steps = self.scene.camera.cycles.motion_steps = 3
        self.scene.frame_set(1)
        add_lamp("SUN", 3, (0, 0, 5), (40, 10, 30), angle=0.05)
        # The noise has a FLIP of 0.005 here.
        with mock.patch.object(self, "is_near", lambda found: abs(found[0]) < 0.01 and found[1] < 0.02):
            self.beside(lambda: None, lambda: setattr(self.scene.render, "use_motion_blur", False))

    def test_vectors(self):
        """--aov motion has the signs and the order of Cycles' vectors, for a plane across the axis that shifts unevenly: inside of it they are constant."""
        bpy.data.objects.remove(bpy.data.objects["Light"])
        bpy.data.objects.remove(bpy.data.objects["Cube"])
        bpy.ops.mesh.primitive_plane_add(size=4)
        plane, camera = bpy.context.object, self.scene.camera
        matt("Plane")
        camera.location, camera.rotation_euler = (0, 0, 8), (0, 0, 0)
        places = {1: (0, 0, 0), 2: (0.3, 0.1, 0), 3: (0.45, -0.2, 0)}
        for frame, place in places.items():
            plane.location = place
            plane.keyframe_insert("location", frame=frame)
        self.scene.frame_set(2)
        layer = self.scene.view_layers[0]
        layer.use_pass_vector, self.scene.render.engine = True, "CYCLES"
        settings = self.scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE"
        settings.file_format, settings.color_depth, self.scene.cycles.samples = "OPEN_EXR_MULTILAYER", "32", 4
        self.scene.render.filepath = str(self.folder / "cycles.exr")
        bpy.ops.render.render(write_still=True)
        parts = OpenEXR.File(str(self.folder / "cycles.exr"), separate_channels=True).parts
        theirs = {name: channel.pixels for part in parts for name, channel in part.channels.items()}
        keys = ", ".join(f"({(frame - 2) / 24}, [Translate({place})])" for frame, place in places.items())
        fov = 2 * math.atan(math.tan(camera.data.angle_x / 2) * SIZE[1] / SIZE[0])
        scene = f"""Scene(image: (width: {SIZE[0]}, height: {SIZE[1]}), background: Solid((1, 1, 1)),
            camera: (look_from: (0, 0, 8), look_at: (0, 0, 0), vertical_fov: {math.degrees(fov)}),
            materials: {{"grey": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
            objects: [Moving(keys: [{keys}], object: Quad(corner: (-2, -2, 0), u: (4, 0, 0), v: (0, 4, 0), material: "grey"))])"""
        (self.folder / "scene.ron").write_text(scene)
        line = ["render", "scene.ron", "--spp=8", "--frame=0", "--fps=24", "--aov=motion", "--aov-names=blender", "--no-state", "--quiet"]
        subprocess.run([preferences.program(), *line, f"--device={software_device()}", "-o", "ours.exr"], cwd=self.folder, check=True)
        ours = read(self.folder / "ours.exr")
        inside = np.s_[SIZE[1] // 2 - 6:SIZE[1] // 2 + 6, SIZE[0] // 2 - 6:SIZE[0] // 2 + 6]
        found = {axis: [image[f"ViewLayer.Vector.{axis}"][inside] for image in (ours, theirs)] for axis in "XYZW"}
        for axis, (mine, cycles) in found.items():
            # Cycles rounds positions to f32 and keeps vectors in them.
            np.testing.assert_allclose(mine, cycles, atol=2e-3, err_msg=axis)
        # The control: all four are different, and none is 0.
        means = [np.mean(mine) for mine, _ in found.values()]
        self.assertGreater(min(abs(a - b) for a, b in zip(means, means[1:])), 0.1)
        self.assertGreater(np.abs(means).min(), 0.1)

    def test_startup_file_as_it_is(self):
        """With its plastic, by the bounds of docs/gltf.md: 4 %."""
        reference = self.cycles()
        bpy.ops.render.render()
        found = self.distance(self.save("image.exr"), reference)
        print("startup mean %+.2f %%, FLIP %.3f" % (100 * found[0], found[1]))
        self.assertTrue(abs(found[0]) < 0.04 and found[1] < 0.06, found)


def node(tree, kind, **values):
    """A new shader node, with its inputs by their names."""
    made = tree.nodes.new("ShaderNode" + kind)
    for name, value in values.items():
        socket = made.inputs[name.replace("_", " ")]
        socket.default_value = (*value, 1) if isinstance(value, tuple) else value
    return made


def mixed(tree, first, second, share=0.5):
    """A Mix Shader, whose share may be an output of a node. None is an input without a shader."""
    made = tree.nodes.new("ShaderNodeMixShader")
    if isinstance(share, float):
        made.inputs[0].default_value = share
    else:
        tree.links.new(share, made.inputs[0])
    for socket, shader in zip(made.inputs[1:], (first, second)):
        if shader:
            tree.links.new(shader.outputs[0], socket)
    return made


def added(tree, *shaders):
    made = tree.nodes.new("ShaderNodeAddShader")
    for socket, shader in zip(made.inputs, shaders):
        tree.links.new(shader.outputs[0], socket)
    return made


def fed(tree, made, name, output):
    tree.links.new(output, made.inputs[name])
    return made


def picture(tree):
    """An Image Texture of floats without symmetries."""
    made, image = tree.nodes.new("ShaderNodeTexImage"), bpy.data.images.new("Picture", 64, 32)
    y, x = np.mgrid[:32, :64]
    image.pixels.foreach_set(np.stack([0.2 + 0.6 * (x / 63), 0.7 - 0.4 * (y / 31), 0.3 + 0 * x, 1 + 0 * x], -1).astype(np.float32).ravel())
    image.pack()
    made.image = image
    return made


def ramp(tree, output):
    made = tree.nodes.new("ShaderNodeValToRGB")
    for element, colour in zip(made.color_ramp.elements, ((0.9, 0.1, 0.1, 1), (0.1, 0.3, 0.9, 1))):
        element.color = colour
    return fed(tree, made, 0, output).outputs[0]


def in_group(tree):
    """A group whose shader has a texture of its own, and a share from outside."""
    made, group = tree.nodes.new("ShaderNodeGroup"), bpy.data.node_groups.new("Group", "ShaderNodeTree")
    group.interface.new_socket("Share", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
    begin, end, dot = (group.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "NodeReroute"))
    shader = fed(group, node(group, "BsdfDiffuse"), "Color", node(group, "TexNoise", Scale=3.0).outputs["Color"])
    group.links.new(begin.outputs[0], dot.inputs[0])
    group.links.new(mixed(group, shader, node(group, "BsdfTransparent"), dot.outputs[0]).outputs[0], end.inputs[0])
    made.node_tree, made.inputs[0].default_value = group, 0.3
    return made


RED, WHITE, GREEN = (0.8, 0.3, 0.2), (1.0, 1.0, 1.0), (0.2, 0.7, 0.3)
diffuse = lambda tree, colour=RED: node(tree, "BsdfDiffuse", Color=colour)
glossy = lambda tree, colour=(0.8, 0.8, 0.8), roughness=0.3: node(tree, "BsdfAnisotropic", Color=colour, Roughness=roughness)
glass = lambda tree, roughness=0.0: node(tree, "BsdfGlass", Color=WHITE, Roughness=roughness, IOR=1.45)
emission = lambda tree, colour=GREEN, strength=1.0: node(tree, "Emission", Color=colour, Strength=strength)
clear = lambda tree, colour=WHITE: node(tree, "BsdfTransparent", Color=colour)
noise = lambda tree: node(tree, "TexNoise", Scale=2.0).outputs["Color"]
# By names of shaders: what makes them, and the most that a ball's mean may be off, in shares of the mean of Cycles.
SHADERS = {
    "Diffuse": (diffuse, 0.03),
    "Glossy": (lambda tree: glossy(tree, RED), 0.03),
    "rough Glossy": (lambda tree: glossy(tree, RED, 0.7), 0.06),
    "Glass": (glass, 0.03),
    "Translucent": (lambda tree: node(tree, "BsdfTranslucent", Color=GREEN), 0.03),
    "Transparent": (lambda tree: clear(tree, GREEN), 0.03),
    "Emission": (lambda tree: emission(tree, strength=3.0), 0.03),
    "Metallic": (lambda tree: node(tree, "BsdfMetallic", Base_Color=RED, Roughness=0.3), 0.03),
    "Diffuse and Glossy": (lambda tree: mixed(tree, diffuse(tree), glossy(tree), 0.4), 0.03),
    "Diffuse and Glossy by Fresnel": (lambda tree: mixed(tree, diffuse(tree), glossy(tree), node(tree, "Fresnel", IOR=1.5).outputs[0]), 0.06),
    "Diffuse and Transparent": (lambda tree: mixed(tree, diffuse(tree), clear(tree), 0.4), 0.03),
    "Diffuse and Translucent": (lambda tree: mixed(tree, diffuse(tree), node(tree, "BsdfTranslucent", Color=GREEN), 0.4), 0.03),
    "Emission and Transparent": (lambda tree: mixed(tree, emission(tree), clear(tree), 0.4), 0.03),
    "Diffuse + Emission": (lambda tree: added(tree, diffuse(tree), emission(tree)), 0.03),
    "Glass and Transparent": (lambda tree: mixed(tree, glass(tree), clear(tree), 0.5), 0.05),
    "Principled and Transparent by noise": (lambda tree: mixed(
        tree, node(tree, "BsdfPrincipled", Base_Color=RED, Roughness=1.0, Specular_IOR_Level=0.0), clear(tree), noise(tree)), 0.03),
    "Diffuse and nothing": (lambda tree: mixed(tree, diffuse(tree), None), 0.03),
    "nothing": (lambda tree: None, 0.03),
    "a ramp of an image": (lambda tree: fed(tree, diffuse(tree), "Color", ramp(tree, picture(tree).outputs[0])), 0.03),
    "noise": (lambda tree: fed(tree, diffuse(tree), "Color", noise(tree)), 0.03),
    "noise that emits": (lambda tree: fed(tree, emission(tree, strength=5.0), "Color", noise(tree)), 0.03),
    "Blackbody": (lambda tree: fed(tree, emission(tree), "Color", node(tree, "Blackbody", Temperature=3000.0).outputs[0]), 0.03),
    "a group": (in_group, 0.03),
    "a colour": (lambda tree: fed(tree, tree.nodes.new("NodeReroute"), 0, node(tree, "RGB").outputs[0]), 0.03),
}


if not hasattr(bpy.types, "ShaderNodeBsdfMetallic"):
    # Blender has it since 4.3.
    del SHADERS["Metallic"]


class Shaders(InBlender):
    """Balls side by side, each with its shader, by Cycles and by the program: means of their pixels, 13 by 13 around the middle of each.

    A mean has a noise of 0.7 % here, if a sample's standard deviation is two thirds of its mean (a sky of one colour and a large light):
    2 / 3 / sqrt(64 · 169), and half of that by Cycles, which is 0.8 % for both. So 3 % is four standard deviations, for each of three
    channels. What is given more differs by its model, as docs/blender.md has it: gloss by Schlick, and by how it makes up for lost light.
    """

    ROWS, COLUMNS, STEP = 4, 6, 20

    def test_each_is_as_in_cycles(self):
        for placed in list(bpy.data.objects):
            bpy.data.objects.remove(placed)
        self.scene.render.resolution_x, self.scene.render.resolution_y = self.COLUMNS * self.STEP, self.ROWS * self.STEP
        background()["Color"].default_value, background()["Strength"].default_value = (0.5, 0.55, 0.6, 1), 1
        # Far away, so that all balls are seen from the front, and each has a square of the picture.
        bpy.ops.object.camera_add(location=(0, -200, 0), rotation=(math.pi / 2, 0, 0))
        self.scene.camera = bpy.context.object
        self.scene.camera.data.angle = 2 * math.atan(self.COLUMNS * 3 / 2 / 200)
        # Large, so that no caustics are noise.
        bpy.ops.mesh.primitive_plane_add(size=40, location=(-8, -8, 15))
        light = matt("Light").node_tree.nodes["Principled BSDF"].inputs
        light["Emission Color"].default_value, light["Emission Strength"].default_value = (1, 0.9, 0.7, 1), 2
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1.2)
        bpy.ops.object.shade_smooth()
        first = bpy.context.object
        for index, (name, (make, _)) in enumerate(SHADERS.items()):
            material = bpy.data.materials.new(name)
            material.use_nodes = True
            tree = material.node_tree
            output = tree.nodes["Material Output"]
            tree.nodes.remove(tree.nodes["Principled BSDF"])
            shader = make(tree)
            if shader:
                tree.links.new(shader.outputs[0], output.inputs["Surface"])
            ball = first.copy()
            ball.data = first.data.copy()
            ball.data.materials.append(material)
            row, column = divmod(index, self.COLUMNS)
            ball.location = (3 * (column - (self.COLUMNS - 1) / 2), 0, 3 * ((self.ROWS - 1) / 2 - row))
            self.scene.collection.objects.link(ball)
        bpy.data.objects.remove(first)
        # It would blur what gloss casts on others.
        self.scene.cycles.blur_glossy = 0
        reference = self.means(self.cycles())
        bpy.ops.render.render()
        found = self.means(self.save("image.exr"))
        for name, (_, most) in SHADERS.items():
            off = self.off(found[name], reference[name])
            print(f"{name}: {100 * off:+.2f} %")
            with self.subTest(name):
                self.assertLess(abs(off), most)
        # A share of the mix that is 0.1 off is found, and so is nearly every ball that is taken for another.
        tree = bpy.data.materials["Diffuse and Transparent"].node_tree
        tree.nodes["Mix Shader"].inputs[0].default_value = 0.5
        tree = bpy.data.materials["noise"].node_tree
        tree.nodes["Noise Texture"].inputs["Scale"].default_value = 1
        bpy.ops.render.render()
        wrong = self.means(self.save("wrong.exr"))
        for name in ("Diffuse and Transparent", "noise"):
            self.assertGreater(abs(self.off(wrong[name], reference[name])), SHADERS[name][1])
        near = [(a, b) for a in SHADERS for b in SHADERS if a < b and abs(self.off(found[a], reference[b])) < SHADERS[b][1]]
        self.assertLess(len(near), 6, near)

    def means(self, path):
        channels, step = read(path), self.STEP
        image = np.stack([channels[colour] for colour in "RGB"], -1)
        found = {}
        for index, name in enumerate(SHADERS):
            row, column = divmod(index, self.COLUMNS)
            found[name] = image[row * step + 3:row * step + 16, column * step + 3:column * step + 16].mean((0, 1))
        return found

    def off(self, found, reference):
        """The largest difference of a channel, in shares of the mean of all; at least of a hundredth, as what is black has none."""
        differences = (found - reference) / max(reference.mean(), 0.01)
        return differences[np.abs(differences).argmax()]


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

    def test_material_without_nodes(self):
        made = bpy.data.materials["Material"]
        made.use_nodes, made.diffuse_color = False, (0.25, 0.5, 0.75, 1)
        found, = self.export()[1]["materials"]
        # Since Blender 5.0 all materials have nodes.
        expected = (0.8, 0.8, 0.8, 1) if made.use_nodes else (0.25, 0.5, 0.75, 1)
        np.testing.assert_allclose(found["pbrMetallicRoughness"]["baseColorFactor"], expected, atol=1e-6)

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

    def test_settings_of_cycles(self):
        cycles, cube = self.scene.cycles, bpy.data.objects["Cube"]
        cycles.max_bounces = 7
        self.assertIn("render: (max_depth: 8)", self.export()[0])
        # By standard deviations: 0.29, 0.41 and 0.49 pixels.
        for kind, width, expected in (("BLACKMAN_HARRIS", 1.5, "box"), ("BOX", 1.0, "box"), ("BLACKMAN_HARRIS", 3.0, "tent"), ("GAUSSIAN", 6.0, "gauss")):
            cycles.pixel_filter_type, cycles.filter_width = kind, width
            self.assertEqual(losses.pixel_filter(cycles)[0], expected)
        with mock.patch.object(engine, "run", wraps=process.run) as ran:
            dark = self.f12()["Combined"]
            self.assertIn("--filter=gauss", ran.call_args.args[0])
        cycles.film_exposure = 3
        np.testing.assert_allclose(self.f12()["Combined"][..., :3], 3 * dark[..., :3], rtol=1e-6)
        # The shutter is open for half a frame with frame 2 in its middle; what does not move is no Moving, and two that move alike are one.
        for frame, x in ((1, 0), (3, 2)):
            cube.location.x = x
            cube.keyframe_insert("location", frame=frame)
        other = bpy.data.objects.new("Other", cube.data)
        other.parent = cube
        self.scene.collection.objects.link(other)
        self.scene.render.use_motion_blur = True
        self.scene.frame_set(2)
        text, _ = self.export()
        self.assertEqual((text.count("Moving("), text.count("Gltf(")), (1, 2))
        self.assertIn("shutter: (-0.25, 0.25)", text)
        self.scene.render.motion_blur_position = "START"
        self.assertIn("shutter: (0.0, 0.5)", self.export()[0])
        cube.cycles.use_motion_blur = other.cycles.use_motion_blur = False
        self.assertNotIn("Moving(", self.export()[0])
        # A camera that moves is upright at all times, and one that turns around its own axis is told.
        camera = self.scene.camera
        for turns, expected in ((False, []), (True, ["the blur of the camera's roll"])):
            for frame in (1, 3):
                camera.location.x = frame
                camera.keyframe_insert("location", frame=frame)
                if turns:
                    camera.rotation_mode, camera.rotation_axis_angle = "AXIS_ANGLE", (0.1 * frame, *camera.matrix_world.col[2].xyz)
                    camera.keyframe_insert("rotation_axis_angle", frame=frame)
            self.scene.frame_set(2)
            self.export()
            self.assertEqual(json.loads((self.files() / "answer.json").read_text())["notes"], expected)

    def test_materials_by_name(self):
        """What becomes of nodes that the balls of `Shaders` do not show."""
        cube = bpy.data.objects["Cube"]

        def exported(make):
            made = bpy.data.materials.new("Made")
            made.use_nodes = True
            tree = made.node_tree
            tree.nodes.remove(tree.nodes["Principled BSDF"])
            tree.links.new(make(tree).outputs[0], tree.nodes["Material Output"].inputs[0])
            cube.data.materials.clear()
            cube.data.materials.append(made)
            told = [words for name, words in losses.losses(self.scene, bpy.context.view_layer) if name == "Cube"]
            found, = self.export()[1]["materials"]
            self.assertEqual(found["name"], made.name)
            bpy.data.materials.remove(made)
            return found, [words.split(": ", 1)[1] for words in told]

        def eevee_s(tree):
            other = tree.nodes.new("ShaderNodeOutputMaterial")
            other.target, tree.nodes["Material Output"].target = "CYCLES", "EEVEE"
            tree.links.new(emission(tree).outputs[0], other.inputs[0])
            return diffuse(tree)

        def muted(tree):
            made = mixed(tree, diffuse(tree), emission(tree))
            made.mute = True
            return made

        colour = lambda found: [round(x, 3) for x in found["pbrMetallicRoughness"].get("baseColorFactor", (1, 1, 1))[:3]]
        found, told = exported(lambda tree: fed(tree, diffuse(tree), "Color", node(tree, "Attribute").outputs["Color"]))
        self.assertEqual((colour(found), told), ([0, 0, 0], []))
        self.assertIn("emissiveFactor", exported(eevee_s)[0])
        self.assertEqual(colour(exported(muted)[0]), [0.8, 0.3, 0.2])
        found, told = exported(lambda tree: node(tree, "BsdfRefraction", Color=WHITE, IOR=1.2))
        self.assertEqual(told, ["Refraction BSDF: it reflects, too"])
        self.assertEqual(found["extensions"]["KHR_materials_volume"], {"thicknessFactor": 1})
        found, told = exported(lambda tree: node(tree, "BsdfToon", Color=RED))
        self.assertEqual((colour(found), told), ([0.8, 0.3, 0.2], ["Toon BSDF: a Diffuse BSDF of its colour stands for it"]))
        _, told = exported(lambda tree: fed(tree, diffuse(tree), "Color", tree.nodes.new("ShaderNodeCameraData").outputs["View Vector"]))
        self.assertEqual(told, ["Camera Data: grey 0.8 stands for what depends on the view"])
        found, told = exported(lambda tree: fed(tree, diffuse(tree), "Color", ramp(tree, node(tree, "LayerWeight").outputs["Facing"])))
        self.assertEqual(told, ["Layer Weight: the same for all rays"])
        # A third of the way from red to blue.
        self.assertEqual(colour(found), [0.633, 0.167, 0.367])
        _, told = exported(lambda tree: mixed(tree, glass(tree), diffuse(tree)))
        self.assertEqual(told, ["Mix of Diffuse BSDF and Glass BSDF: their values are mixed"])
        found, told = exported(lambda tree: mixed(tree, node(tree, "BsdfPrincipled", Roughness=0.2), node(tree, "BsdfPrincipled", Roughness=0.6), 0.25))
        self.assertEqual(told, ["Mix of Principled BSDF: their values are mixed"])
        self.assertAlmostEqual(found["pbrMetallicRoughness"]["roughnessFactor"], 0.3, places=6)
        found, told = exported(lambda tree: mixed(tree, clear(tree), glossy(tree), node(tree, "Fresnel", IOR=1.5).outputs[0]))
        self.assertEqual(told, ["Fresnel: from behind, it reflects as from the front"])
        self.assertEqual(found["extensions"]["KHR_materials_volume"], {"thicknessFactor": 0})
        words = "Transparent BSDF: where it emits, it lets 31/32 pass at most"
        for share, expected in ((0.9, []), (0.99, [words])):
            self.assertEqual(exported(lambda tree: mixed(tree, emission(tree), clear(tree), share))[1], expected)
        self.assertEqual(exported(lambda tree: added(tree, emission(tree), clear(tree)))[1], [words])

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

    def test_program_that_writes_nothing(self):
        self.stage()
        background()["Strength"].default_value = 1
        self.scene.gpu_rt.samples = 8
        self.f12()
        # Where the image of the render before is.
        with self.program("#!/bin/sh\nexit 0\n"):
            self.fails("gpu-rt has written no image: is it gpu-rt?")

    def test_scene(self):
        self.scene.camera.scale.y = 0
        self.fails("The camera Camera has a scale of 0")
        self.scene.camera.scale.y = 1
        bpy.data.lights["Light"].energy = 1e38
        self.fails(r'has failed: scene.ron:.*materials\["Light"\].*expected a radiance')
        self.scene.render.pixel_aspect_x = 2
        self.fails("gpu-rt has square pixels: set Output > Format > Aspect to 1")
        self.scene.camera = None
        self.fails("no camera")

    def test_second_blender(self):
        with mock.patch.object(sys, "executable", "/bin/false"):
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
        tree.links.new(tree.nodes.new("ShaderNodeBump").outputs[0], shader.inputs["Normal"])
        cube = bpy.data.objects["Cube"]
        cube.modifiers.new("Hair", "PARTICLE_SYSTEM")
        cube.particle_systems[0].settings.type = "HAIR"
        cube.visible_shadow = False
        bpy.ops.object.volume_add()
        add_lamp("AREA", 10, (0, 0, 5), spread=math.radians(60))
        add_lamp("SPOT", 10, (0, 0, 5), shadow_soft_size=0.1)
        self.scene.render.use_motion_blur = self.scene.render.film_transparent = True
        self.scene.cycles.rolling_shutter_type, self.scene.cycles.diffuse_bounces = "TOP", 2
        self.scene.cycles.pixel_filter_type, self.scene.cycles.filter_width = "BOX", 4
        bpy.data.objects["Light"].keyframe_insert("location", frame=1)
        bpy.data.lights["Light"].keyframe_insert("shadow_soft_size", frame=1)
        library = self.folder / "gone.blend"
        bpy.data.libraries.write(str(library), {bpy.data.lights["Light"]})
        with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
            wanted.lights = ["Light"]
        library.unlink()
        told = losses.losses(self.scene, bpy.context.view_layer)
        for expected in (
            ("Cube", "Material: subsurface"), ("Cube", "Material: its volume"), ("Cube", "Material: its bumps: only a Normal Map is read"),
            ("Cube", "Material: its image Lost: there is no such file"), ("Cube", "hair: Hair"),
            ("Cube", "it is not hidden from rays (shadow)"), ("Volume", "a volume"),
            ("Area", "its spread: it shines in all directions"), ("Spot", "its radius: its shadows are sharp"),
            ("Scene", "the rolling shutter"), ("Light", "the blur of its motion"), ("Light", "the blur of its shape"),
            ("Scene", "the pixel filter: its standard deviation is 0.49 pixels, and not 1.15"),
            ("Scene", "the limit of diffuse bounces: all kinds have that of Total"), ("Scene", "the library gone.blend: there is no such file"),
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
        self.scene.render.film_transparent = True
        shown = mock.MagicMock()
        panel.GPU_RT_PT_losses.draw(shown, bpy.context)
        labels = [call.kwargs["text"] for call in shown.layout.column().label.call_args_list]
        self.assertEqual(labels, ["Scene", "the transparent film: the world is in the image"])
        panel.GPU_RT_PT_sampling.draw(shown, bpy.context)
        drawn = [call.args[1] for call in shown.layout.prop.call_args_list]
        self.assertEqual(drawn, ["samples", "noise", "time", "denoise", "light_paths", "device"])
        # Panels of materials and lamps are shown, those of EEVEE's settings are not.
        shared = {each.__name__ for each in panel.shared()}
        self.assertLessEqual({"EEVEE_MATERIAL_PT_surface", "DATA_PT_EEVEE_light", "RENDER_PT_color_management"}, shared)
        # DATA_PT_light is that of engines without EEVEE's.
        self.assertFalse([name for name in shared if name.startswith("RENDER_PT_eevee") or name == "DATA_PT_light"])


class Compositor(InBlender):
    def matte(self, image, layer, name):
        """The matte that the compositor's node Cryptomatte has of a name in an image."""
        tree = bpy.data.node_groups.new("Mattes", "CompositorNodeTree")
        node, out = tree.nodes.new("CompositorNodeCryptomatteV2"), tree.nodes.new("NodeGroupOutput")
        node.source, node.image = "IMAGE", bpy.data.images.load(str(image))
        node.layer_name, node.matte_id = layer, name
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        tree.links.new(node.outputs["Matte"], out.inputs[0])
        self.scene.compositing_node_group = tree
        self.scene.render.engine, self.scene.cycles.samples = "CYCLES", 1
        bpy.ops.render.render()
        return read(self.save("matte.exr"))["R"]

    def test_mattes_of_objects_and_materials(self):
        """Blender picks what a file of the program has, to the bit, with a state and without one."""
        self.stage()
        self.export()
        scene, image = self.files() / "scene.ron", self.folder / "mattes.exr"
        line = [preferences.program(), "render", scene, "--spp", "16", "--device", software_device(), "--aov", "cryptomatte", "--quiet", "--force"]
        for state in ([], ["--no-state"]):
            subprocess.run([*line, *state, "--aov-names", "blender", "-o", image], check=True)
            part = OpenEXR.File(str(image), separate_channels=True).parts[0]
            for layer, key in (("ViewLayer.CryptoObject", "542cafa"), ("ViewLayer.CryptoMaterial", "c7dbf5e")):
                ranks = [[part.channels[f"{layer}0{number}.{letter}"].pixels for letter in letters]
                         for number in range(3) for letters in ("rg", "ba")]
                names = json.loads(part.header[f"cryptomatte/{key}/manifest"])
                self.assertEqual(len(names), 2)
                for name, hashed in names.items():
                    expected = sum(np.where(ids.view(np.uint32) == int(hashed, 16), share, 0) for ids, share in ranks)
                    found = self.matte(image, layer, name)
                    np.testing.assert_array_equal(found, expected)
                    self.assertGreater(((found > 0) & (found < 1)).sum(), 10)
            # The control: a name that no pixel has.
            self.assertEqual(self.matte(image, "ViewLayer.CryptoObject", "Cone").max(), 0)


class View(InBlender):
    """What a 3D view sends, without a window; window.py has one."""

    def state(self, materials=()):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return live.state(depsgraph, lamps.Lamps(depsgraph), materials)

    def update(self, changed, geometry=False):
        return SimpleNamespace(id=changed, is_updated_geometry=geometry)

    def session(self):
        """A session of the scene, and what it says first."""
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        job = {"scene": self.scene.name, "layer": self.scene.view_layers[0].name, "frame": 1, "subframe": 0.0, "view": True}
        command = [preferences.program(), "serve", "scene.ron", "--no-state", f"--device={software_device()}"]
        session = viewport.Session(job_of(self.scene, folder, job), command, folder)
        self.addCleanup(session.join, 60)
        self.addCleanup(session.close)
        session.start()
        return session, self.event(session, "opened")

    def event(self, session, expected):
        while True:
            word, value = session.events.get(timeout=120)
            if word in (expected, "failed"):
                self.assertEqual(word, expected, value)
                return value

    def of_view(self):
        """The fields of the camera of a view that shows what the scene's camera does."""
        camera, depsgraph = self.scene.camera, bpy.context.evaluated_depsgraph_get()
        window = camera.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1])
        return ron._text(live.camera(camera.matrix_world.normalized().inverted(), window, camera_of.aperture_of(camera, depsgraph)))

    def test_pictures_are_those_of_f12(self):
        """Of each kind of camera, and of changes that are requests."""
        self.stage()
        spot, sun = add_lamp("SPOT", 500, (-3, 0, 4), (0, -30, 0), shadow_soft_size=0), add_lamp("SUN", 1, (0, 0, 5), (40, 10, 30))
        ellipse = add_lamp("AREA", 300, (1.5, -1.5, 4), (20, 20, 0), size=2, shape="ELLIPSE", size_y=1)
        session, answer = self.session()
        camera, cube = self.scene.camera.data, bpy.data.objects["Cube"]
        material = cube.data.materials[0]
        objects, materials = {}, {}
        for number, change in enumerate((
            # F12 shifts by whole pixels.
            lambda: None, lambda: (setattr(camera, "shift_x", 13 / SIZE[0]), setattr(camera, "shift_y", -6 / SIZE[0])),
            lambda: (setattr(camera, "type", "ORTHO"), setattr(camera, "ortho_scale", 7)),
            lambda: (setattr(cube, "location", (0.5, 1, 0.5)), setattr(cube, "rotation_euler", (0.1, 0.2, 0.3)), setattr(cube, "scale", (1.2,) * 3)),
            lambda: [setattr(lamp, "rotation_euler", (0.5, 0.1, 0.2)) for lamp in (spot, sun, ellipse)] + [setattr(spot, "location", (-2, 0, 4))],
            lambda: [setattr(lamp.data, "energy", 2 * lamp.data.energy) for lamp in (spot, sun, ellipse)]
            + [setattr(material.node_tree.nodes["Principled BSDF"].inputs["Base Color"], "default_value", (0.1, 0.2, 0.7, 1))],
        )):
            with self.subTest(number):
                change()
                before = objects, materials
                objects, materials = live.difference(answer["state"], self.state([material]), answer["names"])
                self.assertEqual((objects, materials) != before, number > 2)
                session.send({
                    "camera": self.of_view(), "size": "%dx%d" % SIZE, "spp": SPP, "objects": objects, "materials": materials, "seed": 1,
                    "output": "view.exr", "display": session.viewer.address,
                })
                self.assertIsNone(self.event(session, "answered")["error"])
                image, expected = read(session._folder / "view.exr"), self.f12()["Combined"]
                # Without their headers: F12's is a part of an image if the lens is shifted.
                OpenEXR.File({}, {colour: image[colour] for colour in "RGB"}).write(str(self.folder / "view.exr"))
                OpenEXR.File({}, {colour: np.ascontiguousarray(expected[..., index]) for index, colour in enumerate("RGB")}).write(str(self.folder / "f12.exr"))
                line = [preferences.program(), "compare", self.folder / "view.exr", self.folder / "f12.exr", "--json"]
                report = json.loads(subprocess.run(line, capture_output=True, check=True).stdout)
                self.assertGreaterEqual(report["p"], report["level"], report["verdict"])
        self.assertEqual(len(objects), 4)
        self.assertEqual(len(materials), 4)

    def test_a_session_ends_when_it_is_closed(self):
        for is_open in (True, False):
            session = self.session()[0] if is_open else viewport.Session(["sleep", "60"], ["sleep", "60"], pathlib.Path(tempfile.mkdtemp(dir=self.folder)))
            if not is_open:
                session.start()
            session.close()
            session.join(10)
            self.assertFalse(session.is_alive() or session._folder.exists())
            self.assertTrue(session._program is None or session._program.poll() is not None)

    def test_what_only_an_export_shows(self):
        cube, light = bpy.data.objects["Cube"], bpy.data.objects["Light"]
        material = cube.data.materials[0]
        inputs = material.node_tree.nodes["Principled BSDF"].inputs
        other = matt("Other")
        cube.data.materials[0] = material
        then = self.state([material])
        names = dict.fromkeys(then["objects"], "Cube.001")
        self.assertEqual(live.difference(then, then, names), ({}, {}))
        for thing, name, value in (
            (cube, "scale", (1, 2, 1)), (cube, "scale", (-1, 1, 1)), (cube, "scale", (0, 0, 0)), (cube, "hide_viewport", True), (light.data, "shadow_soft_size", 0.5),
            (light.data, "energy", 0), (light, "hide_viewport", True), (inputs["Transmission Weight"], "default_value", 1), (inputs["Metallic"], "default_value", 1),
            (inputs["Base Color"], "default_value", (0, 0, 0, 1)), (inputs["Emission Strength"], "default_value", 1), (cube.material_slots[0], "material", other),
        ):
            with self.subTest(f"{name} {value}"):
                before = getattr(thing, name)
                before = before if not hasattr(before, "__len__") else tuple(before)
                setattr(thing, name, value)
                if name == "default_value" and thing.name == "Emission Strength":
                    inputs["Emission Color"].default_value = (1, 1, 1, 1)
                self.assertIsNone(live.difference(then, self.state([material]), names))
                setattr(thing, name, before)
                self.assertEqual(live.difference(then, self.state([material]), names), ({}, {}))
        inputs["Roughness"].default_value, inputs["Metallic"].default_value = 0.25, 0.75
        self.assertEqual(live.difference(then, self.state([material]), names)[1], {"scene.glb#Material": "(roughness: 0.25, metallic: 0.75)"})

    def test_updates_that_need_an_export(self):
        cube, light, world = bpy.data.objects["Cube"], bpy.data.objects["Light"], self.scene.world
        image = bpy.data.images.new("An image", 4, 4)
        for update, expected in (
            (self.update(cube), False), (self.update(cube, True), True), (self.update(cube.data), False), (self.update(cube.data, True), True),
            (self.update(light, True), False), (self.update(light.data, True), False), (self.update(self.scene, True), False), (self.update(world), True),
            (self.update(image), True), (self.update(self.scene.camera.data, True), False), (self.update(cube.data.materials[0]), False),
        ):
            with self.subTest(update.id.name):
                self.assertEqual(live.needs_export([update]), expected)
        tree = cube.data.materials[0].node_tree
        tree.links.new(tree.nodes.new("ShaderNodeTexImage").outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
        self.assertTrue(live.needs_export([self.update(cube.data.materials[0])]))


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
