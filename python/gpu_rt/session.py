"""Many images of one scene: from other places, with objects placed elsewhere, with other materials and lights."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import tempfile
import threading
import weakref
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

import numpy as np

import gpu_rt as _gpu_rt

from . import ron
from .ron import _text

_SHARED_MEMORY = "/dev/shm"
_LEAST_FREE = 256 << 20  # bytes of shared memory that images leave to others
_PATIENCE = 30.0  # seconds that the program has to end


def camera(
    pose: Any, *, convention: str = "opencv", K: Any = None, _scale: Sequence[float] = (1.0, 1.0), **fields: Any
) -> Dict[str, Any]:
    """The camera of a scene file for a pose: a matrix of 4x4 or 3x4 from the camera to the world.

    With the convention "opencv" the camera's axes are x to the right, y down and z forwards; with "opengl" y up and z backwards. K (3x3, pixels)
    becomes the projection Calibrated. OpenCV counts pixels from the middle of the first one, so that it gets 0.5 added to cx and cy; with
    "opengl" it counts from the corner. `look_at` is a point on the axis, at no distance that means something: a lens needs `focus_distance`, which
    in a session stays that of the scene. Other fields are those of the scene file.
    """
    # `_scale` is that of the pixels of K to those of the scene's image, along x and y.
    if convention not in ("opencv", "opengl"):
        raise _gpu_rt.Error(f'convention: expected "opencv" or "opengl", found {convention!r}')
    matrix = _matrix("pose", pose, ((4, 4), (3, 4)))
    rotation, position = matrix[:3, :3], matrix[:3, 3]
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > 1e-6 or np.linalg.det(rotation) < 0 or (matrix[3:] != [0, 0, 0, 1]).any():
        raise _gpu_rt.Error(f"pose: expected a rotation and a shift, found {matrix.tolist()}")
    sign = 1 if convention == "opencv" else -1
    # Far away, a point near by would have no exact direction.
    distance = 2.0 ** np.ceil(np.log2(max(1.0, np.abs(position).max())))
    place = {"look_from": position, "look_at": position + distance * sign * rotation[:, 2], "up": -sign * rotation[:, 1]}
    if K is not None:
        k = _matrix("K", K, ((3, 3),))
        if k[0, 1] != 0 or k[1, 0] != 0 or (k[2] != [0, 0, 1]).any():
            raise _gpu_rt.Error(f"K: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], found {k.tolist()}")
        corner = 0.5 if convention == "opencv" else 0.0
        (fx, cx), (fy, cy) = ((_scale[axis] * k[axis, axis], _scale[axis] * (k[axis, 2] + corner)) for axis in (0, 1))
        place["projection"] = ron.Calibrated(fx=fx, fy=fy, cx=cx, cy=cy)
    return {**place, **fields}


def _matrix(name: str, value: Any, shapes: Sequence[Sequence[int]]) -> np.ndarray:
    words = f"{name}: expected a matrix of {' or '.join(f'{rows}x{columns}' for rows, columns in shapes)} finite numbers"
    try:
        matrix = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise _gpu_rt.Error(words) from None
    if matrix.shape not in shapes or not np.isfinite(matrix).all():
        raise _gpu_rt.Error(f"{words}, found {matrix.tolist()}")
    return matrix


_camera = camera


class Session:
    """A scene that is rendered again and again by `gpu-rt serve`, whose process keeps the device with its kernels, textures and meshes.

    `size`, `spp`, `seed`, `aov`, `device` and other options are those of gpu_rt.render, as far as `gpu-rt serve --help` has them. An image has the
    bytes of one that the command line renders with the same camera, objects and materials.

    A session may be used by several threads, which wait for each other, and by the process that has opened it alone. It ends with `close`, with the block
    of `with`, or with its process; its images stay.
    """

    objects: List[str]
    """The names that `objects` of render takes. An object without a name has its place: objects[3]."""
    materials: List[str]
    """The names of the materials."""

    def __init__(
        self,
        scene: _gpu_rt.Scene,
        *,
        size: Union[str, int, Sequence[int], None] = None,
        spp: Optional[int] = None,
        seed: Optional[int] = None,
        aov: Union[str, Sequence[str], None] = None,
        device: Union[str, int, None] = None,
        quiet: bool = False,
        **options: Any,
    ) -> None:
        """Opens the scene. SceneError if it is not valid."""
        argument, text = _gpu_rt._scene(scene)
        if isinstance(size, (list, tuple, np.ndarray)):
            size = "x".join(map(str, np.ravel(size)))
        options.update(size=size, spp=spp, seed=seed, aov=aov, device=device, quiet=quiet)
        self._link = link = _Link(argument, text, _gpu_rt._flags(options), quiet)
        Finalize(self, link.close, exitpriority=10)
        opened = link.ask(None)
        self.objects, self.materials = opened["objects"], opened["materials"]
        self._scale = [image / size for image, size in zip(opened["image"], opened["size"])]
        self._lens = {} if opened["focus"] is None else {"focus_distance": opened["focus"]}

    def render(
        self,
        *,
        camera: Optional[Mapping[str, Any]] = None,
        frame: Optional[float] = None,
        seed: Optional[int] = None,
        spp: Optional[int] = None,
        aov: Union[str, Sequence[str], None] = None,
        objects: Optional[Mapping[str, Any]] = None,
        materials: Optional[Mapping[str, Any]] = None,
    ) -> _gpu_rt.Image:
        """Renders an image. What is not given is as the session was opened, whatever was rendered before.

        `camera` has fields of the scene file's camera, or `pose`, `convention` and `K` as gpu_rt.camera has them; K is in pixels of the session's
        images. Fields that are not given stay. `objects` places objects by their names: by a 4x4 matrix of a rotation, a shift and one positive
        scale, which is applied after the object's own transforms, in the space around it. `materials` gives materials, and lights without size,
        other values by their names, such as {"lamp": {"emit": (15, 15, 15)}}.

        SceneError or Error says what is wrong with the request; the session goes on. So it does after Ctrl-C: Interrupted has the image so far.
        """
        request: Dict[str, Any] = {"frame": frame, "seed": seed, "spp": spp}
        if aov is not None:
            request["aov"] = aov if isinstance(aov, str) else ",".join(aov)
        if objects is not None:
            request["objects"] = {name: _matrix(f"objects[{name!r}]", place, ((4, 4),)).tolist() for name, place in objects.items()}
        try:
            if camera is not None:
                if "pose" in camera:
                    camera = _camera(**{"_scale": self._scale, **self._lens, **camera})
                request["camera"] = _text(camera)
            if materials is not None:
                request["materials"] = {name: _text(fields) for name, fields in materials.items()}
            json.dumps(request, default=_plain)
        except (TypeError, ValueError, RecursionError) as error:
            raise _gpu_rt.Error(f"the request: {error}") from None
        return self._link.render(request)

    def close(self) -> None:
        """Ends the session, once a render that another thread has begun is complete. Its images stay."""
        if self._link.is_own():
            with self._link.lock:
                self._link.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __reduce__(self) -> Any:
        raise _gpu_rt.Error("a session stays in its process: open one in each")


def _plain(value: Any) -> Any:
    """A number of NumPy as JSON has it."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"expected a number, found {value!r}")


class _Folder:
    """A folder that lives as long as anybody has this object: the session, and each image in it."""

    def __init__(self) -> None:
        shared = os.path.isdir(_SHARED_MEMORY) and shutil.disk_usage(_SHARED_MEMORY).free > _LEAST_FREE
        self.path = tempfile.mkdtemp(prefix="gpu-rt-", dir=_SHARED_MEMORY if shared else None)
        Finalize(self, shutil.rmtree, (self.path, True), exitpriority=0)


class _Link:
    """The process of a session. Neither its threads nor its images keep the session alive."""

    def __init__(self, scene: str, text: Optional[str], flags: List[str], quiet: bool) -> None:
        self.lock = threading.Lock()  # of a request and its answer
        self._writing, self._came = threading.Lock(), threading.Condition()
        self._answers: Dict[int, bytes] = {}
        self._asked = self._images = 0
        self._ended = self._closed = False
        self._errors: List[str] = []
        self._pid, self._folder = os.getpid(), _Folder()
        line = [_gpu_rt.program(), "serve", scene, f"--temporary={self._folder.path}", *flags]
        pipe = subprocess.PIPE
        try:
            # Its standard input ends with this process, however that ends. In a session of its own it gets no Ctrl-C but by us.
            self._process = subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=pipe, bufsize=0, start_new_session=True)
        except (OSError, ValueError) as error:
            raise _gpu_rt.Error(f"gpu-rt serve cannot be run: {error}") from None
        _LINKS.add(self)
        errors = (self._process.stderr, self._errors, None if quiet else _gpu_rt._Progress())
        self._reading = threading.Thread(target=_gpu_rt._read, args=errors, daemon=True)
        self._reading.start()
        threading.Thread(target=self._listen, daemon=True).start()
        if text is not None:
            self._write(text)

    def _listen(self) -> None:
        """Takes answers. A thread does, because Ctrl-C might lose a part of one between two reads."""
        with io.BufferedReader(self._process.stdout) as answers:  # type: ignore[type-var]
            for number, line in enumerate(answers):
                with self._came:
                    self._answers[number] = line
                    self._came.notify_all()
        with self._came:
            self._ended = True
            self._came.notify_all()

    def _write(self, value: Any) -> None:
        line = json.dumps(value, default=_plain).encode() + b"\n"
        try:
            with self._writing:
                while line:
                    line = line[os.write(self._process.stdin.fileno(), line) :]  # type: ignore[union-attr]
        except (OSError, ValueError):
            pass  # It has ended, which whoever waits for the answer is told.

    def interrupt(self) -> None:
        self._write({"interrupt": True})

    def is_own(self) -> bool:
        """Whether it is of this process, and not of one that this one is a fork of."""
        return os.getpid() == self._pid

    def _waits(self) -> bool:
        return self._asked not in self._answers and not self._ended

    def ask(self, request: Optional[Mapping[str, Any]]) -> Dict[str, Any]:
        """The answer to a request; or, without one, what the program says first."""
        in_thread = threading.current_thread() is not threading.main_thread()
        interrupts = _gpu_rt._interrupts
        stops: List[BaseException] = []
        try:
            if request is not None:
                self._write(request)
                self._asked += 1
            if in_thread:
                _gpu_rt._OF_THREADS.add(self)
                if interrupts != _gpu_rt._interrupts:
                    _gpu_rt._interrupt_all()
            while self._waits():
                try:
                    with self._came:
                        self._came.wait_for(lambda: not self._waits())
                except BaseException as reason:
                    stops.append(reason)
                    if len(stops) > 2:
                        raise
                    self.interrupt()
        except BaseException:
            self.close()  # What is on its way is not known.
            raise
        finally:
            if in_thread and self not in _gpu_rt._OF_THREADS:
                stops.append(KeyboardInterrupt())
            _gpu_rt._OF_THREADS.discard(self)
        if self._asked not in self._answers:
            self.close()
            self._reading.join(_PATIENCE)
            raise _gpu_rt._failure("serve", self._errors, self._process.returncode, {})
        answer: Dict[str, Any] = json.loads(self._answers.pop(self._asked))
        for stop in stops:
            if request is None or not isinstance(stop, KeyboardInterrupt):
                raise stop
            answer["error"] = {**(answer["error"] or {"message": "interrupted"}), "interrupted": True}
        return answer

    def render(self, request: Mapping[str, Any]) -> _gpu_rt.Image:
        if not self.is_own():
            raise _gpu_rt.Error(f"the session belongs to the process {self._pid}, of which this one is a fork: open one in each")
        with self.lock:
            if self._closed:
                raise _gpu_rt.Error("the session is closed")
            self._images += 1
            image, folder = None, os.path.join(self._folder.path, str(self._images))
            try:
                os.mkdir(folder)
                answer = self.ask({**request, "output": os.path.join(folder, "image.exr")})
                error, report = answer["error"], answer["report"] or {}
                if report and (not error or error["interrupted"]):
                    image = _gpu_rt.Image(report["output"], report, folder)
                    image._folder = self._folder  # type: ignore[attr-defined]
            finally:
                if image is None:
                    shutil.rmtree(folder, ignore_errors=True)
            if image is not None and not error:
                return image
            if error["interrupted"]:
                interrupted = _gpu_rt.Interrupted(error["message"], report)
                interrupted.image = image
                raise interrupted
            if error["lost"]:
                self.close()
                raise _gpu_rt.Error(f"{error['message']}; the session is not usable any more: open another one", report)
            faults = [_gpu_rt.Fault(**fault) for fault in error["faults"]]
            raise _gpu_rt.SceneError(error["message"], faults) if faults else _gpu_rt.Error(error["message"], report)

    def close(self) -> None:
        if self._closed or not self.is_own():
            return
        self._write({"interrupt": True, "close": True})
        self._closed = True
        self._process.stdin.close()  # type: ignore[union-attr]
        try:
            self._process.wait(_PATIENCE)
        except BaseException as reason:
            self._process.kill()
            self._process.wait()
            if not isinstance(reason, subprocess.TimeoutExpired):
                raise
        del self._folder


_LINKS: weakref.WeakSet[_Link] = weakref.WeakSet()


def _leave_to_parent() -> None:
    """A fork keeps no session of its parent alive."""
    for link in list(_LINKS):
        for stream in (link._process.stdin, link._process.stdout, link._process.stderr):
            stream.close()  # type: ignore[union-attr]


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)
