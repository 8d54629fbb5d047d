"""A 3D view that shows what the program renders: one process of `gpu-rt serve` for each, from its choice of the engine until it leaves the mode.

Blender calls `update` and `draw`. A timer takes what the program says, as nothing may wait here: Blender would stand still.
"""

import json
import os
import pathlib
import queue
import shutil
import subprocess
import tempfile
import threading
import time
import weakref

import bpy
import numpy as np
from mathutils import Vector

from . import lamps, live, process, ron
from .camera import aperture_of
from .job import SCENE, answer_of, job_of
from .losses import pixel_filter
from .preferences import program
from .process import Failure
from .viewer import Viewer

# While something moves, the share of the sides of the image, and its samples.
SHARE, SAMPLES = 4, 8
# Seconds without a change before the whole image begins, and between two looks at what the program says.
REST, LOOK = 0.2, 0.02


class Session(threading.Thread):
    """An export, and then the program that renders it. `events` has what happens: a word and a value."""

    def __init__(self, export, command, folder):
        super().__init__(daemon=True)
        self.events, self.viewer = queue.SimpleQueue(), Viewer()
        # The key of the request under way and the share of its sides; and whether that request has been interrupted.
        self.asked, self.interrupted = None, False
        self._export, self._command, self._folder = export, command, folder
        self._program, self._closed, self._lock = None, threading.Event(), threading.Lock()

    def run(self):
        try:
            said = []
            ended = process.run(self._export, self._folder, self._closed.is_set, said.append)
            if not ended.cancelled:
                self._serve(answer_of(self._folder, ended, said))
        except (Failure, OSError, ValueError) as failure:
            self.events.put(("failed", str(failure)))
        finally:
            self.close()
            self.viewer.__exit__()
            shutil.rmtree(self._folder, ignore_errors=True)

    def _serve(self, answer):
        command, pipe = [*self._command, f"--filter={answer['filter']}", f"--temporary={self._folder}"], subprocess.PIPE
        with self._lock:
            if self._closed.is_set():
                return
            self._program = served = process.start(command, self._folder, pipe)
        said = []

        def read_lines():
            for line in served.stderr:
                said.append(line.decode(errors="replace").strip())
                self.events.put(("said", said[-1]))

        reader = threading.Thread(target=read_lines, daemon=True)
        reader.start()
        with served.stdin, served.stdout, served.stderr:
            if served.stdout.readline():
                self.events.put(("opened", answer))
            for line in served.stdout:
                self.events.put(("answered", json.loads(line)))
            served.wait()
            reader.join()
        words = " ".join(" ".join(line for line in said if not line.startswith(("warning", "note"))).split("error: ")[1:])
        self.events.put(("failed", f"The program {command[0]} has failed: {words or f'it ended with status {served.returncode}'}"))

    def send(self, request):
        try:
            os.write(self._program.stdin.fileno(), json.dumps(request).encode() + b"\n")
        except (OSError, ValueError):
            pass  # it has ended, which an event says

    def close(self):
        """Ends the export or the program, without waiting for it."""
        with self._lock:
            self._closed.set()
            if self._program:
                self._program.kill()


class Viewport:
    def __init__(self):
        self._engine = self._scene = self._settings = None
        # The session that renders, and the next one, which exports. `_stale` says that there has to be another one after that.
        self._session, self._next, self._stale, self._flushes = None, None, True, False
        # What the program has failed at, what it says, and the words in the view: None has it drawn anew.
        self._failure, self._said, self._shown = "", "", None
        # What was exported, whether the scene has changed since, which materials ever have, and how requests say that.
        self._exported, self._changed, self._touched, self._changes = None, False, set(), ({}, {})
        # What the view shows, since when; and what has been rendered of it, in part and all.
        self._key, self._since, self._moving, self._whole = None, 0.0, None, None
        self.image, self._texture, self._exposure = None, None, 1.0
        bpy.app.timers.register(lambda view=weakref.ref(self): view().look() if view() else None, first_interval=LOOK)

    def __del__(self):
        for session in filter(None, (self._session, self._next)):
            session.close()

    def update(self, engine, depsgraph):
        """Takes a change of the scene."""
        if self._flushes:
            return
        scene = depsgraph.scene
        self._engine, self._changed = weakref.ref(engine), True
        settings = (scene.gpu_rt.device, scene.gpu_rt.light_paths, scene.cycles.max_bounces, scene.cycles.film_exposure, pixel_filter(scene.cycles)[0])
        self._stale = self._stale or bool(self._failure) or settings != self._settings or live.needs_export(depsgraph.updates)
        self._settings = settings
        self._touched |= {update.id.name for update in depsgraph.updates if isinstance(update.id, bpy.types.Material)}
        self._scene = {
            "scene": scene.name, "layer": depsgraph.view_layer.name, "frame": scene.frame_current, "subframe": scene.frame_subframe, "view": True,
        }

    def draw(self, engine, context, depsgraph):
        """Draws the newest image, and asks for another one if the view or the scene has changed."""
        region, view = context.region, context.region_data
        if self._changed and self._session:
            self._follow(depsgraph)
        own = view.view_perspective == "CAMERA" and (context.space_data.camera or depsgraph.scene.camera)
        lens = aperture_of(own.evaluated_get(depsgraph), depsgraph) if own and own.type == "CAMERA" else {}
        key = {
            "camera": ron._text(live.camera(view.view_matrix, view.window_matrix, lens)), "size": (max(region.width, 1), max(region.height, 1)),
            "spp": depsgraph.scene.gpu_rt.samples, "objects": self._changes[0], "materials": self._changes[1],
        }
        if key != self._key:
            self._key, self._since = key, time.monotonic()
            self._ask()
        if self.image is not None:
            self._paint(engine, depsgraph.scene, region)

    def _follow(self, depsgraph):
        """Finds how requests say what has changed since the export."""
        then = self._exported["state"]
        materials = filter(None, map(bpy.data.materials.get, self._touched))
        now = live.state(depsgraph, lamps.Lamps(depsgraph, ball=(Vector(then["ball"][0]), then["ball"][1])), materials)
        changes = live.difference(then, now, self._exported["names"])
        self._changed, self._stale = False, self._stale or changes is None
        self._changes = changes or self._changes

    def _paint(self, engine, scene, region):
        # There is no such module where Blender has no window.
        import gpu
        from gpu_extras.presets import draw_texture_2d

        if self._texture is None:
            height, width, _ = self.image.shape
            pixels = np.ones((height, width, 4), np.float32)
            pixels[..., :3] = self._exposure * self.image[::-1]
            self._texture = gpu.types.GPUTexture((width, height), format="RGBA32F", data=gpu.types.Buffer("FLOAT", pixels.size, pixels.ravel()))
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (0, 0), region.width, region.height)
        engine.unbind_display_space_shader()

    def look(self):
        """Takes what has happened. Returns the seconds until the next look."""
        try:
            for session in (self._session, self._next):
                while session and not session.events.empty():
                    self._take(session, *session.events.get())
            if self._stale and not self._next and self._scene:
                self._export()
            image = self._session.viewer.take() if self._session else None
            if image is not None:
                self.image, self._texture, self._said, self._shown = image, None, "", None
            self._ask()
        except (Failure, OSError, KeyError) as failure:
            # A scene that has another name now is a KeyError.
            self._failure, self._stale = f"{failure}: leave the mode, and choose it again", False
        self._tell()
        return LOOK

    def _export(self):
        """Begins another session."""
        self._stale, self._failure = False, ""
        scene = bpy.data.scenes[self._scene["scene"]]
        device = [f"--device={scene.gpu_rt.device}"] if scene.gpu_rt.device else []
        command = [program(), "serve", SCENE, "--no-state", f"--light-paths={scene.gpu_rt.light_paths}", *device]
        # What is edited becomes part of the file; the update that comes of it, right here, is no change.
        self._flushes = True
        for edited in (each for each in scene.objects if each.mode == "EDIT"):
            edited.update_from_editmode()
        bpy.context.view_layer.update()
        self._flushes = False
        folder = pathlib.Path(tempfile.mkdtemp(prefix="gpu-rt-view-", dir=bpy.app.tempdir))
        self._next = Session(job_of(scene, folder, self._scene), command, folder)
        self._next.start()

    def _take(self, session, word, value):
        if word == "opened":
            if self._session:
                self._session.close()
            self._session, self._next = session, None
            self._exported, self._exposure, self._changes, self._changed = value, value["exposure"], ({}, {}), True
            self._moving = self._whole = self._key = self._shown = None
        elif word == "said":
            self._said = value if value.startswith("compiling ") else ""
        elif word == "answered":
            (key, share), error, session.asked, self._said = session.asked, value["error"], None, ""
            if error and error["faults"] and (key["objects"] or key["materials"]):
                # Such as a number out of the program's range, or a material that it reads as another one.
                self._stale, self._moving, share = True, key, 1
            elif error and not error["interrupted"]:
                self._failure = error["message"]
            if share > 1:
                self._moving = key
            elif not (error and error["interrupted"]):
                self._whole = key
        elif word == "failed":
            self._failure = value
            self._session, self._next = (None if each is session else each for each in (self._session, self._next))

    def _ask(self):
        """Asks for what the view lacks: an image in part while it moves, and all of it at rest."""
        session, key = self._session, self._key
        if not session or not key or self._changed:
            return
        if session.asked:
            if session.asked[0] != key and session.asked[1] == 1 and not session.interrupted:
                session.interrupted = True
                session.send({"interrupt": True})
            return
        share = 1 if self._moving == key else SHARE
        if self._whole == key or (share == 1 and time.monotonic() - self._since < REST):
            return
        session.asked, session.interrupted = (key, share), False
        session.send({
            **key, "output": "view.exr", "size": "x".join(str(max(side // share, 1)) for side in key["size"]),
            "spp": key["spp"] if share == 1 else min(SAMPLES, key["spp"]), "display": session.viewer.address,
        })

    def _tell(self):
        """Says in the view what is under way, and has it drawn anew if it has changed."""
        engine, at_rest = self._engine and self._engine(), self._whole == self._key
        under_way = "exporting the scene" if self._next or not self._key else f"{self._key['spp']} samples" if at_rest else "rendering"
        words = self._failure or self._said or under_way
        if engine and words != self._shown:
            self._shown = words
            engine.update_stats("", f"gpu-rt: {words}")
            engine.tag_redraw()
