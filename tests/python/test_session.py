"""gpu_rt.Session: its images are those of the command line, and what ends a session, and what does not."""

import copy
import gc
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path

import gpu_rt
import numpy as np
from gpu_rt import ron
from test_gpu_rt import CORNELL, InAFolder, until

SCENE = {
    "image": {"width": 24, "height": 16},
    "camera": {"look_from": (0, 1, 5), "look_at": (0, 0, 0), "vertical_fov": 50},
    "background": ron.Solid((0.1, 0.1, 0.2)),
    "materials": {"red": ron.Lambertian(albedo=ron.Rgb(0.7, 0.2, 0.1)), "lamp": ron.DiffuseLight(emit=ron.Rgb(5, 5, 5))},
    "objects": [
        ron.Named(name="cup", object=ron.Sphere(center=(0, 0, 0), radius=0.5, material="red")),
        ron.Box(min=(-4, -2, -4), max=(4, -1, 4), material="red"),
        ron.Quad(corner=(-1, 3, -1), u=(2, 0, 0), v=(0, 0, 2), material="lamp"),
    ],
    "render": {"samples": 16, "max_depth": 6},
}
ENDLESS = 1 << 30


def open_session(**options):
    return gpu_rt.Session(SCENE, quiet=True, **options)


def turned(degrees):
    """A turn about y, as scene files have it: 90 takes z to x."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def pose_of(rotation, position):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


class Images(InAFolder):
    def assert_same(self, image, scene, **options):
        fresh = gpu_rt.render(scene, quiet=True, **options)
        self.assertEqual(set(image.layers), set(fresh.layers))
        for name, layer in fresh.layers.items():
            np.testing.assert_array_equal(image[name].view(np.uint32), layer.view(np.uint32), name)
        self.assertEqual(image.report["scene_hash"], fresh.report["scene_hash"])

    def test_they_are_those_of_the_command_line(self):
        K = [[30, 0, 11.5], [0, 28, 6.25], [0, 0, 1]]
        pose = pose_of(turned(30), (2, 0.5, 4))
        with open_session(seed=3) as session:
            self.assertEqual((session.objects, session.materials), (["cup"], ["red", "lamp"]))
            plain = session.render()
            self.assert_same(plain, SCENE, seed=3)
            for given, camera in (
                ({"look_from": np.array([1, 2, 3.5])}, SCENE["camera"] | {"look_from": (1, 2, 3.5)}),
                ({"projection": ron.Orthographic(height=4)}, {"look_from": (0, 1, 5), "look_at": (0, 0, 0), "projection": ron.Orthographic(height=4)}),
                ({"pose": pose, "convention": "opengl"}, gpu_rt.camera(pose, convention="opengl", vertical_fov=50)),
                ({"pose": pose @ np.diag([1, -1, -1, 1]), "K": K}, gpu_rt.camera(pose @ np.diag([1, -1, -1, 1]), K=K)),
            ):
                image = session.render(camera=given, aov="depth", spp=8)
                self.assert_same(image, SCENE | {"camera": camera}, seed=3, spp=8, aov="depth")
                self.assertTrue((image["RGB"] != plain["RGB"]).any())
            cup = ron.Transformed(by=[ron.Translate((0.5, 0.25, 0))], object=ron.Sphere(center=(0, 0, 0), radius=0.5, material="red"))
            moved = [ron.Named(name="cup", object=cup), *SCENE["objects"][1:]]
            image = session.render(objects={"cup": pose_of(np.eye(3), (0.5, 0.25, 0))}, seed=5)
            self.assert_same(image, SCENE | {"objects": moved}, seed=5)
            lit = SCENE["materials"] | {"lamp": ron.DiffuseLight(emit=ron.Rgb(1, 9, 2))}
            self.assert_same(session.render(materials={"lamp": {"emit": (1, 9, 2)}}), SCENE | {"materials": lit}, seed=3)
            # Nothing of all that stays.
            np.testing.assert_array_equal(session.render()["RGB"], plain["RGB"])

    def test_a_lens_stays_focused(self):
        camera = SCENE["camera"] | {"aperture": 0.5}
        pose = pose_of(np.eye(3), (0, 0, 4))
        with gpu_rt.Session(SCENE | {"camera": camera}, quiet=True) as session:
            image = session.render(camera={"pose": pose, "convention": "opengl"})
            placed = gpu_rt.camera(pose, convention="opengl", vertical_fov=50, aperture=0.5, focus_distance=np.sqrt(26))
            self.assert_same(image, SCENE | {"camera": placed})
            sharp = session.render(camera={"pose": pose, "convention": "opengl", "focus_distance": 3.5})
            self.assertTrue((image["RGB"] != sharp["RGB"]).any())

    def test_frames_of_a_gltf_file(self):
        stool = next((Path(__file__).resolve().parents[2] / "scenes").rglob("*.glb"))
        with gpu_rt.Session(stool, size=16, spp=1, quiet=True) as session:
            self.assert_same(session.render(frame=3), stool, frame=3, size=16, spp=1)
            self.assert_same(session.render(), stool, size=16, spp=1)

    def test_frames_of_a_scene_file(self):
        """Each has the light and the motion of its own time, though kernels and buffers stay."""
        keys = [(0, [ron.Translate((-1, 0, 0))]), (1, [ron.Translate((0, 0, 0))]), (2, [ron.Translate((0, 1, 0))])]
        scene = SCENE | {"objects": [ron.Moving(keys=keys, object=SCENE["objects"][0]), *SCENE["objects"][1:]]}
        options = {"aov": "motion,object", "fps": 24, "size": (24, 16), "spp": 1}
        with gpu_rt.Session(scene, quiet=True, **options) as session:
            images = [session.render(frame=frame) for frame in (6, 30, 12)]
            for frame, image in zip((6, 30, 12), images):
                self.assert_same(image, scene, frame=frame, **options)
            self.assertTrue((images[0]["motion"] != images[1]["motion"]).any())

    def test_a_pose_and_its_convention_are_where_they_should_be(self):
        """A ball at a known place, through OpenCV's own formula: K (R^T (X - t)) is where its middle is.

        The pinhole's pixel is counted from the middle of the first, so that the mask's mean index is that very number, but for the outline's
        stretch: a ball of radius r at distance d is shifted by at most r^2/d^2 of its offset from the axis, here 1e-4 of 20 pixels; and the
        mask's own edge, of some 100 pixels that are each off by 1/2 at random, 0.5 / sqrt(12) / sqrt(100) * 2 pixels, 0.03. Half a pixel, the
        planted fault, is far beyond.
        """
        size, at = (64, 48), np.array([0.3, 0.2, -0.4])
        scene = SCENE | {"objects": [ron.Named(name="ball", object=ron.Sphere(center=at, radius=0.03, material="red"))]}
        K = np.array([[400, 0, 30.25], [0, 380, 22.5], [0, 0, 1]])
        rotation = turned(160) @ np.diag([1, -1, -1])  # looks along a direction near +z, its y axis downwards
        position = at + rotation @ np.array([-0.05, 0.04, -1.6])
        seen = rotation.T @ (at - position)
        expected = (K @ (seen / seen[2]))[:2]

        def found(camera):
            mask = session.render(camera=camera, aov="object")["object"] > 0
            rows, columns = np.nonzero(mask)
            return np.array([columns.mean(), rows.mean()])

        for scale in (1, 2):  # K is in pixels of the session's images, whatever the size of the scene's
            with gpu_rt.Session(scene | {"image": {"width": 64 * scale, "height": 48 * scale}}, size=size, spp=1, quiet=True) as session:
                pose = pose_of(rotation, position)
                np.testing.assert_allclose(found({"pose": pose, "K": K}), expected, atol=0.2)
                corner = K + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]
                opengl = {"pose": pose @ np.diag([1, -1, -1, 1]), "convention": "opengl", "K": corner}
                np.testing.assert_allclose(found(opengl), expected, atol=0.2)
                shifted = found({"pose": pose, "K": corner}) - expected
                self.assertTrue((shifted > 0.3).all(), shifted)
                with self.assertRaises(AssertionError):
                    np.testing.assert_allclose(found({"pose": pose, "K": K + [[0, 0, 9], [0, 0, 0], [0, 0, 0]]}), expected, atol=0.2)


class Requests(InAFolder):
    def test_a_bad_one_raises_and_the_session_goes_on(self):
        with open_session() as session:
            plain = np.asarray(session.render())
            for request, words in (
                ({"camera": {"look_fron": (0, 0, 1)}}, "did you mean look_from"),
                ({"camera": {"look_from": object()}}, "no form for <object"),
                ({"camera": {"pose": np.eye(3)}}, "pose: expected a matrix of 4x4 or 3x4"),
                ({"camera": {"pose": np.diag([2, 2, 2, 1])}}, "expected a rotation and a shift"),
                ({"camera": {"pose": np.diag([-1, 1, 1, 1])}}, "expected a rotation and a shift"),
                ({"camera": {"pose": np.eye(4), "convention": "blender"}}, 'expected "opencv" or "opengl"'),
                ({"camera": {"pose": np.eye(4), "K": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]}}, "K: expected"),
                ({"objects": {"cap": np.eye(4)}}, 'did you mean "cup"'),
                ({"objects": {"cup": np.diag([1, 2, 1, 1])}}, "one positive scale"),
                ({"objects": {"cup": np.full((4, 4), np.nan)}}, "finite numbers"),
                ({"materials": {"rad": {}}}, 'did you mean "red"'),
                ({"materials": {"lamp": {"emit": (-1, 0, 0)}}}, "emit"),
                ({"aov": "fog"}, "aov: expected some of"),
                ({"spp": 0}, "expected a number of samples"),
                ({"seed": -1}, "expected u32"),
            ):
                with self.assertRaisesRegex(gpu_rt.Error, words) as raised:
                    session.render(**request)
                pickle.loads(pickle.dumps(raised.exception))
            with self.assertRaises(gpu_rt.SceneError) as raised:
                session.render(camera={"vertical_fov": 200, "aperture": -1})
            self.assertEqual([fault.field for fault in raised.exception.faults], ["camera.vertical_fov", "camera.aperture"])
            np.testing.assert_array_equal(session.render(), plain)
        with self.assertRaisesRegex(gpu_rt.Error, "the session is closed"):
            session.render()
        session.close()

    def test_a_scene_that_is_not_valid_opens_no_session(self):
        with self.assertRaises(gpu_rt.SceneError) as raised:
            gpu_rt.Session(SCENE | {"image": {"width": 0, "height": 3}}, quiet=True)
        self.assertEqual((raised.exception.file, raised.exception.field), ("<stdin>", "image.width"))
        for options, words in (({"sps": 3}, "unexpected argument"), ({"png": "a.png"}, "unexpected argument"), ({"device": 99}, "99")):
            with self.assertRaisesRegex(gpu_rt.Error, words):
                gpu_rt.Session(CORNELL, quiet=True, **options).render()

    def test_a_process_that_is_gone_is_an_error(self):
        session = open_session()
        image = session.render()
        session._link._process.kill()
        for words in ("ended with status -9", "the session is closed"):
            with self.assertRaisesRegex(gpu_rt.Error, words):
                session.render()
        self.assertEqual(image.shape, (16, 24, 3))


class Lives(InAFolder):
    def test_images_outlive_the_session_and_leave_nothing(self):
        session = open_session(aov="depth")
        folder = session.render().path.parents[1]
        self.assertEqual(list(folder.iterdir()), [], "its end removes an image")
        images = [session.render(seed=seed) for seed in range(2)]
        session.close()
        self.assertEqual(len(list(folder.iterdir())), 2)
        for each in (copy.deepcopy(images[1]), pickle.loads(pickle.dumps(images[1]))):
            np.testing.assert_array_equal(each["depth"], images[1]["depth"])
        images[0].save("a.exr")
        np.testing.assert_array_equal(gpu_rt.render(SCENE, output="a.exr", resume=True, aov="depth", quiet=True), images[0])
        del session
        images.clear()
        gc.collect()
        self.assertFalse(folder.exists())
        # A session that nobody has ends.
        session = open_session()
        process = session._link._process
        del session
        gc.collect()
        until(lambda: process.poll() is not None)

    def test_the_program_does_not_outlive_python(self):
        code = (
            "import gpu_rt, os, sys, threading\n"
            f"sys.path.insert(0, {str(Path(__file__).parent)!r}); from test_session import *\n"
            "session = open_session(); image = session.render(); print(session._link._process.pid, image.path.parents[1], flush=True)\n"
            "if 'fork' in sys.argv and os.fork() == 0: time.sleep(60); os._exit(0)\n"
            "if 'idle' in sys.argv: time.sleep(60)\n"
            "if 'end' not in sys.argv: session.render(spp=ENDLESS)\n"
        )
        for how in ("kill", "idle", "fork", "end"):
            python = subprocess.Popen([sys.executable, "-c", code, how], stdout=subprocess.PIPE, text=True, start_new_session=True)
            child, folder = python.stdout.readline().split()
            if how != "end":
                time.sleep(0.3)
                python.kill()
            python.wait()
            until(lambda: not Path("/proc", child).exists() or ") Z " in Path("/proc", child, "stat").read_text())
            until(lambda: not Path(folder).exists())
            if how == "fork":
                os.killpg(python.pid, signal.SIGKILL)
            python.stdout.close()

    def test_threads_share_a_session(self):
        expected = {seed: np.array(gpu_rt.render(SCENE, seed=seed, quiet=True)) for seed in range(2)}
        with open_session() as session, open_session() as other:
            found = []

            def render(which, seed):
                for _ in range(8):
                    found.append((seed, np.array(which.render(seed=seed))))

            threads = [threading.Thread(target=render, args=(which, seed)) for which in (session, other) for seed in range(2)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual(len(found), 32)
        for seed, image in found:
            np.testing.assert_array_equal(image, expected[seed])

    def test_a_session_outlives_the_thread_that_has_opened_it(self):
        opened = []
        thread = threading.Thread(target=lambda: opened.append(open_session()))
        thread.start()
        thread.join()
        time.sleep(0.3)
        self.assertEqual(opened[0].render().shape, (16, 24, 3))
        opened[0].close()

    def test_a_fork_says_what_is_wrong_and_can_open_its_own(self):
        with open_session() as session:
            expected = np.array(session.render())
            context = multiprocessing.get_context("fork")
            results = context.SimpleQueue()

            def work():
                try:
                    session.render()
                except gpu_rt.Error as error:
                    results.put(str(error))
                session.close()
                with open_session() as own:
                    results.put(np.array(own.render()))

            child = context.Process(target=work)
            child.start()
            child.join(60)
            self.assertRegex(results.get(), f"belongs to the process {os.getpid()}, of which this one is a fork")
            np.testing.assert_array_equal(results.get(), expected)
            self.assertEqual(child.exitcode, 0)
            np.testing.assert_array_equal(session.render(), expected)
            with self.assertRaisesRegex(gpu_rt.Error, "stays in its process"):
                pickle.dumps(session)


class Stop(InAFolder):
    def test_ctrl_c_ends_a_render_and_not_the_session(self):
        with open_session() as session:
            plain = np.array(session.render())
            while True:
                timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
                timer.start()
                with self.assertRaises(gpu_rt.Interrupted) as raised:
                    session.render(spp=ENDLESS)
                timer.join()
                # While its kernels compile, there is no image.
                if raised.exception.image is not None:
                    break
            image = raised.exception.image
            self.assertTrue(0 < image.report["samples_per_pixel"] < ENDLESS and image.report["interrupted"])
            np.testing.assert_array_equal(session.render(), plain)

    def test_ctrl_c_stops_renders_in_threads(self):
        with open_session() as session:
            session.render()
            stopped = []

            def render():
                try:
                    session.render(spp=ENDLESS)
                except gpu_rt.Interrupted:
                    stopped.append(True)

            thread = threading.Thread(target=render)
            thread.start()
            with self.assertRaises(KeyboardInterrupt):
                time.sleep(0.3)
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(60)
            thread.join(30)
            self.assertEqual(stopped, [True])
            self.assertEqual(session.render().shape, (16, 24, 3))

    def test_a_handler_that_raises_ends_the_render(self):
        def handler(*_):
            raise TimeoutError("too late")

        with open_session() as session:
            session.render()
            before = signal.signal(signal.SIGALRM, handler)
            self.addCleanup(signal.signal, signal.SIGALRM, before)
            signal.setitimer(signal.ITIMER_REAL, 0.3)
            with self.assertRaises(TimeoutError):
                session.render(spp=ENDLESS)
            self.assertEqual(session.render().shape, (16, 24, 3))


class Memory(InAFolder):
    def test_it_does_not_grow(self):
        """Of the program, after the first images, which fill its caches: 300 images of 24 x 16 pixels take less than 4 MiB more.

        What an image takes, 164 bytes a pixel on the host and in buffers, would be 18 MiB if it were kept once.
        """
        resident = lambda: int(Path(f"/proc/{session._link._process.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        with open_session(spp=1) as session:
            render = lambda count: [session.render(seed=seed, camera={"look_from": (np.sin(seed), 1, 5)}) and None for seed in range(count)]
            render(100)
            before = resident()
            render(300)
            self.assertLess(resident() - before, 4 << 20)
            self.assertEqual(len(session._link._answers), 0)


if __name__ == "__main__":
    unittest.main()
