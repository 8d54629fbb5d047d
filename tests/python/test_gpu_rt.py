"""The module gpu_rt with the program of the wheel, and the examples of docs/python.md. `make test-python` runs it."""

import copy
import gc
import multiprocessing
import os
import pickle
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


def render_seed(seed):
    return gpu_rt.render(CORNELL, seed=seed, **SMALL)


def check_nothing(_):
    gpu_rt.check("Scene(3)")


KEPT = []


def render_and_keep(seed):
    KEPT.append(render_seed(seed))
    return KEPT[0].path


class Processes(InAFolder):
    """An image's temporary folder is of the process that made it, and images go to other processes with all that they hold."""

    def test_a_fork_leaves_the_images_of_its_parent(self):
        images = [render_seed(seed) for seed in range(2)]
        paths = [image.path for image in images]
        for end in (lambda: sys.exit(0), images.clear):
            child = os.fork()
            if child == 0:
                try:
                    end()
                    gc.collect()
                except SystemExit:
                    # As the interpreter does then.
                    multiprocessing.util._exit_function()
                finally:
                    os._exit(0)
            os.waitpid(child, 0)
            self.assertTrue(all(path.exists() for path in paths))
        images.clear()
        self.assertFalse(any(path.parent.exists() for path in paths), "its own end removes them")

    def test_a_fork_that_exits_leaves_the_image_of_its_parent(self):
        code = (
            f"import gpu_rt, os, sys; image = gpu_rt.render({str(CORNELL)!r}, **{SMALL})\n"
            "if os.fork() == 0: sys.exit(0)\n"
            "os.wait(); print(image.path, image.path.exists())"
        )
        path, exists = subprocess.check_output([sys.executable, "-c", code], text=True).split()
        self.assertEqual((exists, Path(path).parent.exists()), ("True", False))

    def test_workers_return_images_and_errors(self):
        expected = np.asarray(render_seed(0))
        for method in ("fork", "spawn"):
            with multiprocessing.get_context(method).Pool(1) as pool:
                images = pool.map(render_seed, [0, 1])
                kept = pool.apply(render_and_keep, [0])
                with self.assertRaises(gpu_rt.SceneError) as raised:
                    pool.map(check_nothing, [0])
                pool.close()
                pool.join()
            self.assertEqual(raised.exception.faults[0].line, 1)
            np.testing.assert_array_equal(images[0], expected)
            self.assertFalse((np.asarray(images[1]) == expected).all())
            self.assertFalse(kept.parent.exists(), "the end of a worker removes what it keeps")

    def test_a_copy_has_all_that_the_image_has(self):
        image = gpu_rt.render(CORNELL, aov="depth", **SMALL)
        layers, path = image.layers, image.path
        copies = [copy.copy(image), copy.deepcopy(image), pickle.loads(pickle.dumps(image))]
        del image
        self.assertFalse(path.exists())
        for each in copies:
            self.assertEqual((set(each.layers), each.report["samples_per_pixel"]), (set(layers), 16))
            for name, layer in layers.items():
                np.testing.assert_array_equal(each[name], layer)
        copies[0].save("a.exr")
        more = gpu_rt.render(CORNELL, output="a.exr", resume=True, aov="depth", **(SMALL | {"spp": 24}))
        self.assertEqual(more.report["resumed_from"], 16)
        os.remove("a.exr")
        with self.assertRaisesRegex(gpu_rt.Error, "a.exr: cannot be read: No such file"):
            pickle.dumps(more)


class Array(InAFolder):
    def test_an_image_behaves_as_its_picture(self):
        image = render_seed(0)
        array = np.array(image)
        for run in (
            lambda x: x * 2, lambda x: 2 * x, lambda x: array - x, lambda x: -x, lambda x: x < 0.5, lambda x: x == x,
            lambda x: x @ np.eye(3), lambda x: x.mean(axis=2), np.mean, lambda x: np.sum(x, axis=(0, 1)), np.add.reduce,
            lambda x: np.stack([x, x]), lambda x: np.where(x > 0.5, x, 0), lambda x: x[2:4, ::2], lambda x: x[..., 0],
            lambda x: x[-1], lambda x: list(x), len, lambda x: x.T, lambda x: x.dtype, lambda x: x.astype("f8"), np.copy,
            lambda x: np.asarray(x, dtype=">f8"), lambda x: np.einsum("ijk->k", x), lambda x: x.shape, lambda x: x.ndim,
        ):  # fmt: skip
            np.testing.assert_array_equal(run(image), run(array))
        self.assertIs(type(image * 2), np.ndarray)
        self.assertEqual(("variance" in image, "fog" in image, {image: 3}[image], bool(image)), (True, False, 3, True))
        for change in (lambda: image.__imul__(2), lambda: np.add(array, 1, out=image)):
            with self.assertRaisesRegex(gpu_rt.Error, "numpy.array.image. is a copy"):
                change()
        with self.assertRaisesRegex(AttributeError, "no attribute men"):
            image.men
        # A path that is relative stays that of the file.
        kept = gpu_rt.render(CORNELL, output="kept.exr", **SMALL)
        os.mkdir("folder")
        os.chdir("folder")
        np.testing.assert_array_equal(kept, array)


class Arguments(InAFolder):
    def test_they_are_right_or_an_error_says_what_is(self):
        image = gpu_rt.render(CORNELL, size=8, samples=range(0, 8), crop=np.array([0, 0, 4, 2]), force=np.bool_(True), quiet=True)
        self.assertEqual(image.shape, (2, 4, 3))
        array = np.array(image)
        for wide in (np.repeat(array, 2, axis=1)[:, ::2], np.asfortranarray(array), array.astype(">f8"), array.tolist()):
            self.assertEqual(gpu_rt.compare(wide, image)["relmse"], 0)
        render = lambda **options: lambda: gpu_rt.render(CORNELL, quiet=True, **options)
        compare = lambda array, **options: lambda: gpu_rt.compare(array, image, **options)
        check = lambda scene: lambda: gpu_rt.check(scene)
        for run, words in (
            (render(samples=range(0, 8, 2)), "without gaps, such as range.0, 64., found range.0, 8, 2"),
            (render(samples=range(0)), "expected A..B with A < B"),
            (render(aov=[]), "expected some of albedo"),
            (render(tonemap="\ud800"), "without surrogates"),
            (render(output="a\0.exr"), "null byte"),
            (render(output=3), "expected a path, found 3"),
            (check("Scene(\ud800"), "without surrogates"),
            (check(None), "expected a path, found None"),
            (check({"objects": {1, 2}}), "no form for {1, 2}"),
            (check({"camera": {"look_from": np.array([])}}), r"expected a point: \(x, y, z\), found \[\]"),
            (check("\ud800.ron"), r"surrogates"),
            (lambda: gpu_rt.Image("\ud800"), r"^\\ud800: there is no such file"),
            (compare(np.zeros((0, 4, 3))), "with pixels in it, not .0, 4, 3"),
            (compare(array * 1j), "real numbers without a mask, found complex"),
            (compare(np.ma.array(array, mask=True)), "without a mask"),
            (compare(array, fail_above=0.1), "expected a mapping such as"),
            (lambda: image.save("none/a.exr"), "none/a.exr: cannot be written"),
        ):
            with self.assertRaisesRegex(gpu_rt.Error, words) as raised:
                run()
            str(raised.exception).encode()

    def test_numbers_in_a_list_are_a_vector(self):
        for values, text in (
            ([0, 1.5, np.float32(2)], "(0, 1.5, 2.0)"),
            (np.array([1, 2, 3], np.uint8), "(1, 2, 3)"),
            (np.arange(9, dtype=">f4")[::4], "(0.0, 4.0, 8.0)"),
            (np.ones(2, np.longdouble), "(1.0, 1.0)"),
            (np.ones((2, 1)), "[(1.0), (1.0)]"),
            (np.array(2.5), "2.5"),
            (np.zeros((0, 3)), "[]"),
            ([], "[]"),
            ([True], "[true]"),
            ([[1, 2], [3, 4]], "[(1, 2), (3, 4)]"),
            ([ron.Scale(2)], "[Scale(2)]"),
            (types.SimpleNamespace, None),
            (signal.SIGINT, "2"),
            (Path("a.hdr"), '"a.hdr"'),
        ):
            if text is None:
                self.assertRaises(TypeError, ron.Word("A"), values)
            else:
                self.assertEqual(repr(ron.Word("A")(values)), f"A({text})")


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

    def test_ctrl_c_stops_renders_in_threads(self):
        stopped = []

        def render(name):
            try:
                gpu_rt.render(CORNELL, **FOREVER, output=name, checkpoint="1s")
            except gpu_rt.Interrupted as stop:
                stopped.append(stop.image.report["interrupted"])

        threads = [threading.Thread(target=render, args=(name,)) for name in ("a.exr", "b.exr")]
        for thread in threads:
            thread.start()
        with self.assertRaises(KeyboardInterrupt):
            until(lambda: Path("a.exr").exists() and Path("b.exr").exists())
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(60)
        for thread in threads:
            thread.join(30)
        self.assertEqual(stopped, [True, True])

    def test_ctrl_c_stops_a_render_that_just_starts(self):
        stopped = []

        def start(*arguments, popen=subprocess.Popen, **options):
            process = popen(*arguments, **options)
            self.assertRaises(KeyboardInterrupt, signal.getsignal(signal.SIGINT), signal.SIGINT, None)
            return process

        def render():
            with self.assertRaises(gpu_rt.Interrupted) as raised:
                gpu_rt.render(CORNELL, **FOREVER)
            stopped.append(raised.exception.image)

        with mock.patch("subprocess.Popen", start):
            thread = threading.Thread(target=render)
            thread.start()
            thread.join(60)
        self.assertEqual(stopped, [None])

    def test_ctrl_c_is_heard_in_notebooks_and_handlers_of_others_stay(self):
        code = (
            "import signal, sys, types; default, mine = signal.getsignal(signal.SIGINT), lambda *_: None\n"
            "if 'mine' in sys.argv: signal.signal(signal.SIGINT, mine)\n"
            "hooks = {}; shell = types.SimpleNamespace(events=types.SimpleNamespace(register=hooks.__setitem__))\n"
            "sys.modules['IPython'] = types.SimpleNamespace(get_ipython=lambda: shell)\n"
            "import gpu_rt; heard = [signal.getsignal(signal.SIGINT) is gpu_rt._interrupt_threads]\n"
            "if 'mine' not in sys.argv: signal.signal(signal.SIGINT, default)\n"
            "hooks['pre_run_cell'](None); print(*heard, signal.getsignal(signal.SIGINT) is gpu_rt._interrupt_threads)"
        )
        for argument, heard in (("", "True True"), ("mine", "False False")):
            said = subprocess.check_output([sys.executable, "-c", code, argument], text=True)
            self.assertEqual(said.strip(), heard)

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
        self.assertEqual(len(examples), 6)
        for folder in ("scenes", "examples"):
            os.symlink(ROOT / folder, folder)
        for example in examples:
            ran = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True)
            self.assertEqual(ran.returncode, 0, example + ran.stderr)

    def test_the_tables_of_scaling_follow_from_its_measurements(self):
        page = (ROOT / "docs/scaling.md").read_text()
        tables = lambda page: subprocess.check_output([sys.executable, ROOT / "docs/scaling.py"], input=page, text=True)
        self.assertIn(tables(page), page)
        # Another time of a merge gives other tables.
        self.assertNotIn(tables(page.replace("| 0.174 |", "| 0.175 |")), page)


if __name__ == "__main__":
    unittest.main()
