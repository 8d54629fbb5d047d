"""The module gpu_rt with the program of the wheel, and the examples of docs/python.md. `make test-python` runs it."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
from pathlib import Path
from unittest import mock

import gpu_rt
import numpy as np
from gpu_rt import ron

ROOT = Path(__file__).resolve().parents[2]
CORNELL = ROOT / "scenes/cornell.ron"
SMALL = {"size": (16, 16), "spp": 16, "quiet": True}
FOREVER = {"size": (64, 64), "spp": 1 << 20, "quiet": True}


class InAFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)


class Package(InAFolder):
    def test_the_program_is_that_beside_the_interpreter(self):
        self.assertEqual(Path(gpu_rt.program()).parent, Path(sys.executable).parent)
        path = Path("gpu-rt")
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
        with mock.patch.dict(os.environ, PATH=os.getcwd()):
            self.assertEqual(Path(gpu_rt.program()).parent, Path(sys.executable).parent)
            # Where nothing stands beside the interpreter, PATH has it.
            with mock.patch("sysconfig.get_path", lambda *_: "/nowhere"):
                self.assertEqual(Path(gpu_rt.program()), Path.cwd() / "gpu-rt")
                path.unlink()
                with self.assertRaisesRegex(gpu_rt.Error, "neither in /nowhere nor on PATH"):
                    gpu_rt.program()

    def test_its_version_is_that_of_the_program(self):
        said = subprocess.run([gpu_rt.program(), "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(said.stdout.split()[1], gpu_rt.__version__)

    def test_the_types_are_right(self):
        from mypy import api

        out, _, status = api.run(["--strict", "--allow-any-generics", "--ignore-missing-imports", "-p", "gpu_rt"])
        self.assertEqual(status, 0, out)
        Path("user.py").write_text('import gpu_rt\ngpu_rt.render("a.ron", spp="many")\n')
        self.assertIn('expected "int | None"', api.run(["user.py"])[0])


class Render(InAFolder):
    def test_an_image_has_the_values_of_the_file(self):
        image = gpu_rt.render(CORNELL, aov=["albedo", "normal", "depth", "object"], output="a.exr", **SMALL)
        shapes = {name: (layer.shape, str(layer.dtype)) for name, layer in image.layers.items()}
        colours, number = (16, 16, 3), (16, 16)
        expected = {name: (colours, "float32") for name in ("RGB", "variance", "albedo", "N")}
        expected |= {name: (number, "float32") for name in ("Z", "object")}
        expected |= {name: (number, "uint32") for name in ("samples", "rejected")}
        self.assertEqual(shapes, expected)
        # The red wall is on the left and the lamp on top: neither channels nor rows are in another order.
        pixels = np.asarray(image)
        self.assertTrue((pixels[8, 14] != pixels[8, 1]).any())
        self.assertEqual(np.unravel_index(pixels.sum(axis=2).argmax(), number)[0] < 4, True)
        np.testing.assert_array_equal(image["depth"], image["Z"])
        np.testing.assert_allclose(np.linalg.norm(image["normal"][1:-1, 1:-1], axis=2).max(), 1, atol=1e-3)
        self.assertEqual((image.report["samples_per_pixel"], image["samples"].max()), (16, 16))
        self.assertEqual(np.asarray(image, dtype=np.float64).dtype, np.float64)
        part = {"crop": (3, 5, 4, 2), "samples": range(0, 16), "size": [16, 16], "quiet": True}
        part = gpu_rt.render(CORNELL, output="-b.exr", **part)
        np.testing.assert_array_equal(np.asarray(part), pixels[5:7, 3:7])
        with self.assertRaisesRegex(KeyError, "no layer fog, but N, RGB"):
            image["fog"]

    def test_a_text_a_dict_and_a_file_are_one_scene(self):
        scene = {
            "image": {"width": 16, "height": 16},
            "camera": {"look_from": (0, 0, 5), "look_at": np.zeros(3), "vertical_fov": 40},
            "background": ron.Solid((1, 1, 1)),
            "materials": {'a "b\\': ron.Lambertian(albedo=ron.Rgb(0.5, 0.5, 0.5))},
            "objects": [
                ron.Transformed(
                    by=[ron.Scale(np.float32(0.5)), ron.Translate((1, 0, 0))],
                    object=ron.Group([ron.Sphere(center=(0, 0, 0), radius=1, material='a "b\\')]),
                )
            ],
            "render": {"samples": 8, "max_depth": 4},
        }
        Path("a.ron").write_text(ron.dumps(scene))
        images = [np.asarray(gpu_rt.render(each, quiet=True)) for each in (scene, ron.dumps(scene), "a.ron", Path("a.ron"))]
        for image in images[1:]:
            np.testing.assert_array_equal(image, images[0])
        # White light on grey: seen directly 1, and by the ball 0.5.
        self.assertEqual({float(images[0].min()), float(images[0].max())}, {0.5, 1.0})
        with self.assertRaisesRegex(TypeError, "no form for <object"):
            ron.dumps({"image": object()})
        with self.assertRaises(AttributeError):
            ron.sphere

    def test_a_picture_of_it_is_that_of_the_program(self):
        image = gpu_rt.render(CORNELL, png="direct.png", exposure=1, **SMALL)
        self.assertEqual(image.develop(exposure=1), Path("direct.png").read_bytes())
        image.save("a.png")
        self.assertEqual(Path("a.png").read_bytes(), image._repr_png_())
        self.assertNotEqual(image._repr_png_(), image.develop(exposure=1))
        image.save("a.exr")
        np.testing.assert_array_equal(np.asarray(gpu_rt.Image("a.exr")), np.asarray(image))

    def test_what_is_no_image_is_refused(self):
        for options, words in (
            ({"sps": 3}, "a similar argument exists: '--spp'"),
            ({"clamp": True}, "invalid value 'on' for '--clamp"),
            ({"output": "a.png"}, "does not end in .exr"),
        ):
            with self.assertRaisesRegex(gpu_rt.Error, words):
                gpu_rt.render(CORNELL, **options)
        with self.assertRaisesRegex(TypeError, "gpu-rt render --watch"):
            gpu_rt.render(CORNELL, watch=True)
        Path("b.exr").write_text("no image")
        with self.assertRaisesRegex(gpu_rt.Error, "b.exr: cannot be read as an EXR"):
            gpu_rt.Image("b.exr").layers

    def test_errors_of_a_scene_have_their_places(self):
        Path("a.ron").write_text("Scene(image: (width: 0, height: 8),\n  camra: 3)")
        for run in (gpu_rt.check, gpu_rt.render):
            with self.assertRaises(gpu_rt.SceneError) as raised:
                run("a.ron")
            places = [(f.file, f.line, f.column, f.field) for f in raised.exception.faults]
            self.assertEqual(places, [("a.ron", 1, 22, "image.width"), ("a.ron", 2, 3, "camra")])
            self.assertIn("did you mean camera?", str(raised.exception))
        with self.assertRaisesRegex(gpu_rt.SceneError, "none.ron.*cannot read the scene file") as raised:
            gpu_rt.render("none.ron")
        self.assertEqual(raised.exception.faults[0][:4], ("none.ron", 0, 0, "Scene"))

    def test_the_driver_that_is_missing_is_named(self):
        with mock.patch.dict(os.environ, VK_DRIVER_FILES="/nowhere", VK_ICD_FILENAMES="/nowhere"):
            with self.assertRaisesRegex(gpu_rt.Error, "no Vulkan.*apt-get install mesa-vulkan-drivers"):
                gpu_rt.render(CORNELL, **SMALL)


class Compare(InAFolder):
    def test_noise_is_told_from_a_difference(self):
        a, b = (gpu_rt.render(CORNELL, size=(16, 16), spp=32, seed=seed, quiet=True) for seed in (0, 1))
        noise = gpu_rt.compare(a, b)
        self.assertGreater(noise["p"], noise["level"])
        brighter = np.asarray(b) * 1.5
        difference = gpu_rt.compare(a, brighter, heatmap="map.png")
        self.assertLess(difference["p"], difference["level"])
        self.assertEqual(Path("map.png").read_bytes()[1:4], b"PNG")
        with self.assertRaisesRegex(gpu_rt.Error, "relmse is .* above 0.000001") as raised:
            gpu_rt.compare(a, b, fail_above={"relmse": 1e-6})
        self.assertEqual(raised.exception.report["relmse"], noise["relmse"])
        with self.assertRaisesRegex(gpu_rt.Error, "height, width, 3"):
            gpu_rt.compare(a, brighter[0])


class Stop(InAFolder):
    def test_ctrl_c_keeps_the_state(self):
        def stop():
            # The first checkpoint says that there is an image.
            until(Path("a.exr").exists)
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=stop).start()
        with self.assertRaises(gpu_rt.Interrupted) as raised:
            gpu_rt.render(CORNELL, **FOREVER, output="a.exr", checkpoint="1s")
        image = raised.exception.image
        done = image.report["samples_per_pixel"]
        self.assertTrue(0 < done < FOREVER["spp"] and image.report["interrupted"])
        self.assertTrue((image["samples"] == done).all())
        image.save("b.exr")
        more = gpu_rt.render(CORNELL, **(FOREVER | {"spp": done + 8}), output="b.exr", resume=True)
        self.assertEqual((more.report["resumed_from"], more["samples"].max()), (done, done + 8))

    def test_progress_is_on_stderr_and_the_program_does_not_outlive_python(self):
        options = FOREVER | {"quiet": False}
        code = f"import gpu_rt; gpu_rt.render({str(CORNELL)!r}, output='a.exr', **{options})"
        python = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        with python:
            lines = [python.stderr.readline()]
            # The lines of a render are those that the bar of a notebook reads.
            while not re.match(r"\d+/\d+ spp  ", lines[-1]):
                self.assertTrue(lines[-1], lines)
                lines.append(python.stderr.readline())
            self.assertRegex(lines[0], "^warning: .* is a software driver")
            child = Path(f"/proc/{python.pid}/task/{python.pid}/children").read_text().split()[0]
            python.kill()
            self.assertEqual(python.communicate()[0], "")

        def has_ended():
            try:
                # Nobody may wait for it: then it stays as a zombie.
                return ") Z " in Path("/proc", child, "stat").read_text()
            except OSError:
                return True

        until(has_ended)


def until(is_so):
    start = time.monotonic()
    while not is_so():
        if time.monotonic() - start > 60:
            raise AssertionError("it never comes so far")
        time.sleep(0.05)


class Progress(InAFolder):
    def test_a_notebook_has_a_bar(self):
        shown = []

        class Bar:
            n = 0

            def __init__(self, **options):
                shown.append(options["unit"])

            def update(self, more):
                self.n += more
                shown.append((self.n, self.total))

            set_postfix_str = lambda self, words, refresh: shown.append(words)
            close = lambda self: shown.append("closed")

        shell = type("ZMQInteractiveShell", (), {})()
        modules = {"IPython": types.SimpleNamespace(get_ipython=lambda: shell)}
        modules |= {"tqdm": types.ModuleType("tqdm"), "tqdm.auto": types.SimpleNamespace(tqdm=Bar)}
        with mock.patch.dict(sys.modules, modules):
            progress = gpu_rt._Progress()
        progress.line("125/500 spp  1.42 Mpaths/s  error 3.2 %")
        progress.line("250 of about 600 spp  1.42 Mpaths/s")
        progress.close()
        self.assertEqual(
            shown,
            ["spp", "1.42 Mpaths/s  error 3.2 %", (125, 500), "1.42 Mpaths/s", (250, 600), "closed"],
        )


class Documents(InAFolder):
    def test_the_examples_run(self):
        examples = re.findall(r"^```python\n(.*?)^```$", (ROOT / "docs/python.md").read_text(), re.M | re.S)
        self.assertEqual(len(examples), 5)
        os.symlink(ROOT / "scenes", "scenes")
        for example in examples:
            ran = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True)
            self.assertEqual(ran.returncode, 0, example + ran.stderr)


if __name__ == "__main__":
    unittest.main()
