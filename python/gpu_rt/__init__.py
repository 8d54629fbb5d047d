"""Renders scenes by the program gpu-rt, and returns their images as NumPy arrays.

Each function runs the program and reads the files that it writes. Options have the names of the program's options
(`gpu-rt render --help`), with _ for -. docs/python.md has examples.
"""

from __future__ import annotations

import ctypes
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import threading
from contextlib import contextmanager
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple, Union

import numpy as np
import OpenEXR

from . import ron

__all__ = ["Error", "Fault", "Image", "Interrupted", "SceneError", "Session", "camera", "check", "compare", "program", "render", "ron"]
try:
    __version__ = version("gpu-rt")
except PackageNotFoundError:  # the folder python/ of a clone is on the path, and nothing is installed
    __version__ = "unknown"

PathLike = Union[str, "os.PathLike[str]"]
Scene = Union[PathLike, Mapping[str, Any]]
"""A path, the text of a scene file, or a dict that becomes one (see gpu_rt.ron)."""


class Error(Exception):
    """The program has failed. The text is the program's own."""

    report: Dict[str, Any]
    """The object that the program had printed by --json; empty if none."""

    def __init__(self, message: str, report: Optional[Mapping[str, Any]] = None) -> None:
        super().__init__(_printable(message))
        self.report = dict(report or {})


class Fault(NamedTuple):
    """An error of a scene, and where it is."""

    file: str
    """<stdin> for a text or a dict."""
    line: int
    """From 1, or 0 if it is about all of the file. Of a dict: in the text of gpu_rt.ron.dumps."""
    column: int
    """From 1, in characters."""
    field: str
    """Such as objects[2].radius; may be empty."""
    message: str


class SceneError(Error):
    """A scene is not valid: `faults` has its errors, 20 at most, in the order of the file."""

    faults: List[Fault]

    # All but the message has a default: with that alone, pickle makes the error anew, before it gets its attributes.
    def __init__(self, message: str, faults: Sequence[Fault] = ()) -> None:
        super().__init__(message)
        self.faults = list(faults)

    file = property(lambda self: self.faults[0].file, doc="The file of the first error.")
    line = property(lambda self: self.faults[0].line, doc="Its line, from 1.")
    column = property(lambda self: self.faults[0].column, doc="Its column, from 1.")
    field = property(lambda self: self.faults[0].field, doc="Its field.")


class Interrupted(KeyboardInterrupt):
    """Ctrl-C has stopped the program. `image` holds the samples of a render so far, or is None if there were none yet."""

    image: Optional[Image] = None

    def __init__(self, message: str, report: Optional[Mapping[str, Any]] = None) -> None:
        super().__init__(message)
        self.report = dict(report or {})


class Image(np.lib.mixins.NDArrayOperatorsMixin):
    """An EXR. It behaves as the array of its picture: height x width x 3, f32, linear Rec. 709, row 0 on top.

    `image["variance"]` is a layer: height x width x channels, or height x width if it has one channel. The file is read
    when a layer is first asked for. Pickled or copied, an image takes all of its file along.
    """

    path: Path
    report: Dict[str, Any]
    """The object of `render --json` (docs/files.md); empty for a file that this process has not rendered."""

    def __init__(self, path: PathLike, report: Optional[Mapping[str, Any]] = None, folder: Optional[str] = None) -> None:
        """Opens a file. `folder` is a temporary folder of this process, which is removed when the image is."""
        self.path = Path(os.path.abspath(_text_of(path)))
        self.report = dict(report or {})
        if folder is not None:
            # Unlike weakref.finalize it works in the process that made it alone, not in its forks, and at the end of a Pool's workers too.
            Finalize(self, shutil.rmtree, (folder, True), exitpriority=0)
        if not os.path.isfile(self.path):
            raise Error(f"{path!s}: there is no such file")

    @cached_property
    def layers(self) -> Dict[str, np.ndarray]:
        """All layers by name: RGB is the picture, then variance, samples, and what --aov has added (docs/files.md)."""
        try:
            channels = OpenEXR.File(str(self.path), separate_channels=True).parts[0].channels
        except Exception as error:  # the package raises many types
            raise Error(f"{self.path}: cannot be read as an EXR: {error}") from None
        groups: Dict[str, List[str]] = {}
        for channel in channels:
            layer, dot, suffix = channel.rpartition(".")
            groups.setdefault(layer if dot else "RGB" if suffix in "RGB" else suffix, []).append(channel)
        layers = {}
        for layer, names in groups.items():
            # R, G, B, A and X, Y, Z, W: files have them in alphabetic order.
            names.sort(key=lambda name: "RGBAXYZW".find(name[-1]))
            pixels = [channels[name].pixels for name in names]
            layers[layer] = np.stack(pixels, axis=-1) if len(pixels) > 1 else pixels[0]
        return layers

    def __getitem__(self, layer: Any) -> Any:
        """A layer, by its name in the file or as `aov` has it: image["depth"] is image["Z"]. KeyError names those that are there.

        What is no name is an index of the picture.
        """
        if not isinstance(layer, str):
            return self["RGB"][layer]
        layer = layer if layer in self.layers else {"normal": "N", "depth": "Z", "position": "P"}.get(layer, layer)
        if layer not in self.layers:
            raise KeyError(f"{self.path.name} has no layer {layer}, but {', '.join(sorted(self.layers))}")
        return self.layers[layer]

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> np.ndarray:
        # NumPy 1 has no None there, and takes False for it.
        return np.array(self["RGB"], dtype=dtype, copy=copy)  # type: ignore[arg-type, unused-ignore]

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if any(isinstance(array, Image) for array in options.get("out", ())):
            raise Error("an image does not change: numpy.array(image) is a copy that does")
        return getattr(ufunc, method)(*(np.asarray(array) if isinstance(array, Image) else array for array in inputs), **options)

    __hash__ = object.__hash__  # type: ignore[assignment, unused-ignore]

    def __getattr__(self, name: str) -> Any:
        """What else an array has: shape is (height, width, 3); mean, dtype, T, …"""
        if name.startswith("_") or not hasattr(np.ndarray, name):
            raise AttributeError(f"an Image has no attribute {name}")
        return getattr(self["RGB"], name)

    def __len__(self) -> int:
        return len(self["RGB"])

    def __contains__(self, item: Any) -> bool:
        return item in self.layers if isinstance(item, str) else item in self["RGB"]

    def __reduce__(self) -> Any:
        try:
            return _unpickled, (self.path.name, self.path.read_bytes(), self.report)
        except OSError as error:
            raise Error(f"{self.path}: cannot be read: {error.strerror}") from None

    def save(self, path: PathLike) -> Path:
        """Writes the image: an .exr with all that it holds, also what `resume` needs; or a .png as `develop` makes it."""
        path = Path(_text_of(path))
        if path.suffix.lower() != ".exr":
            self.develop(path)
            return path
        try:
            shutil.copyfile(self.path, path)
        except shutil.SameFileError:
            pass
        except (OSError, ValueError) as error:
            raise Error(f"{path}: cannot be written: {error}") from None
        return path

    def develop(self, path: Optional[PathLike] = None, **options: Any) -> bytes:
        """The bytes of a PNG, which is also written if a path is given. Options: `exposure` in stops, `tonemap`."""
        with _folder() as folder:
            picture = Path(_text_of(path)) if path is not None else Path(folder, "picture.png")
            _run("develop", [str(self.path.absolute()), "-o", str(picture.absolute())], options)
            return picture.read_bytes()

    def _repr_png_(self) -> bytes:
        """The picture that a notebook shows."""
        return self.develop()

    def __repr__(self) -> str:
        samples = self.report.get("samples_per_pixel")
        return f"<gpu_rt.Image {self.path}{'' if samples is None else f', {samples} samples per pixel'}>"


def _unpickled(name: str, exr: bytes, report: Mapping[str, Any]) -> Image:
    """An image in a temporary folder of this process."""
    folder = tempfile.mkdtemp(prefix="gpu-rt-")
    path = Path(folder, name)
    path.write_bytes(exr)
    return Image(path, report, folder)


@contextmanager
def _folder() -> Iterator[str]:
    """A temporary folder, while it is needed. A fork from another thread leaves it, as it would not that of tempfile."""
    folder = tempfile.mkdtemp(prefix="gpu-rt-")
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _printable(text: str) -> str:
    """The text without surrogates, which no file and no terminal takes."""
    return text.encode(errors="backslashreplace").decode()


def _text_of(path: Any) -> str:
    """A path as text."""
    try:
        return os.fsdecode(path)
    except TypeError:
        raise Error(f"expected a path, found {path!r}") from None


def program() -> str:
    """The path of the program: beside this interpreter, where pip has put it, or else on PATH. Error if it is nowhere."""
    schemes = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    for folder in [*schemes, None]:
        found = shutil.which("gpu-rt", path=folder)
        if found:
            return found
    raise Error(f"the program gpu-rt is neither in {schemes[0]} nor on PATH: install the wheel of a release, or run `pip install .` in a clone")


def render(
    scene: Scene,
    *,
    output: Optional[PathLike] = None,
    size: Union[str, int, Sequence[int], None] = None,
    spp: Optional[int] = None,
    time: Union[str, float, None] = None,
    noise: Optional[float] = None,
    aov: Union[str, Sequence[str], None] = None,
    crop: Optional[Tuple[int, int, int, int]] = None,
    samples: Union[str, range, None] = None,
    seed: Optional[int] = None,
    device: Union[str, int, Sequence[int], None] = None,
    resume: Union[bool, str] = False,
    quiet: bool = False,
    **options: Any,
) -> Image:
    """Renders a scene by `gpu-rt render`, and returns its image.

    `output` is the EXR to write; by default it is in a temporary folder that lives as long as the image. `size` is
    (width, height) in pixels, a width alone, or "50%". `time` is seconds, or "5m". `noise` is a relative error, such as 0.01. `crop` is
    (x, y, width, height) in pixels. `samples` is the range of sample indices. `resume` goes on with the render in `output`.
    Other options are those of the program: max_depth=8, integrator="bsdf", sun="30,0", force=True, …

    The program's progress and warnings go to stderr, or in a notebook to a bar of tqdm; `quiet` hides them.

    SceneError names the places in the scene that are wrong; Error says what else has failed, such as a driver that is missing.
    Ctrl-C stops the render: Interrupted has the image so far, and the output can be resumed.
    """
    for name in ("frames", "watch", "preview"):
        if options.get(name):
            raise TypeError(f"render makes one image; {name} needs the program: gpu-rt render --{name}")
    if output is not None and Path(output := _text_of(output)).suffix.lower() != ".exr":
        raise Error(f"output: {output} does not end in .exr; Image.save and png= write a PNG")
    scene_argument, text = _scene(scene)
    if isinstance(size, (list, tuple, np.ndarray)):
        size = "x".join(map(str, np.ravel(size)))
    if isinstance(time, (int, float, np.number)) and not isinstance(time, bool):
        time = f"{np.format_float_positional(time, trim='-')}s"
    if isinstance(samples, range):
        if samples.step != 1:
            raise Error(f"samples: expected indices without gaps, such as range(0, 64), found {samples}")
        samples = f"{samples.start}..{samples.stop}"
    options.update(size=size, spp=spp, time=time, noise=noise, aov=aov, crop=crop, samples=samples)
    options.update(seed=seed, device=device, resume=resume, quiet=quiet)
    folder = tempfile.mkdtemp(prefix="gpu-rt-") if output is None else None
    path = os.path.join(folder, "image.exr") if folder else output or ""
    try:
        report = _run("render", [scene_argument, f"--output={path}", "--json"], options, text, None if quiet else _Progress())
    except BaseException as error:
        if isinstance(error, Interrupted) and error.report:
            error.image = Image(error.report["output"], error.report, folder)
        elif folder:
            shutil.rmtree(folder, ignore_errors=True)
        raise
    return Image(report["output"], report, folder)


def check(scene: Scene, **options: Any) -> Dict[str, Any]:
    """Validates a scene without a GPU: the object of `gpu-rt check --json`, with `primitives` and `warnings`. SceneError if it is not valid."""
    scene_argument, text = _scene(scene)
    return _run("check", [scene_argument, "--json"], options, text)


def compare(
    image: Union[Image, PathLike, np.ndarray],
    reference: Union[Image, PathLike, np.ndarray],
    *,
    layer: Optional[str] = None,
    heatmap: Optional[PathLike] = None,
    fail_above: Optional[Mapping[str, float]] = None,
) -> Dict[str, Any]:
    """The error of an image against a reference: the object of `gpu-rt compare --json` (docs/files.md).

    They differ by more than noise if `p` is below `level`; `verdict` says so in words. An array is height x width x 3, of linear
    values.
    `heatmap` is a PNG to write. `fail_above` is a mapping such as {"relmse": 0.01}: Error, with its `report`, if a metric is
    above its limit.
    """
    if not isinstance(fail_above or {}, Mapping):
        raise Error(f'fail_above: expected a mapping such as {{"relmse": 0.01}}, found {fail_above!r}')
    with _folder() as folder:
        files = []
        for name, pixels in (("image.exr", image), ("reference.exr", reference)):
            if isinstance(pixels, (np.ndarray, list, tuple)):
                files.append(str(Path(folder, name)))
                channels = {"RGB": _picture(pixels)}
                OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(files[-1])
            else:
                files.append(os.path.abspath(pixels.path if isinstance(pixels, Image) else _text_of(pixels)))
        limits = [f"--fail-above={metric}={value}" for metric, value in (fail_above or {}).items()]
        return _run("compare", [*files, "--json", *limits], {"layer": layer, "heatmap": heatmap})


def _picture(pixels: Any) -> np.ndarray:
    """An array as an EXR has it. Error if that would lose something."""
    try:
        array = np.asarray(pixels)
    except ValueError as error:  # the rows have several lengths
        raise Error(f"compare: {error}") from None
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        raise Error(f"compare: an array has the shape (height, width, 3) with pixels in it, not {array.shape}")
    if array.dtype.kind not in "biuf" or np.ma.is_masked(pixels):
        raise Error(f"compare: expected an array of real numbers without a mask, found {array.dtype}")
    return np.ascontiguousarray(array, dtype=np.float32)


def _scene(scene: Scene) -> Tuple[str, Optional[str]]:
    """The argument that names the scene, and the text for standard input if it is no file."""
    if isinstance(scene, Mapping):
        try:
            return "-", ron.dumps(scene)
        except (TypeError, RecursionError) as error:
            raise Error(f"the scene: {error}") from None
    name = _text_of(scene)
    if isinstance(scene, str) and "(" in scene and not scene.lower().endswith((".ron", ".glb", ".gltf", ".obj", ".ply", ".stl")):
        return "-", scene
    # A name that begins with - is no option.
    return (os.path.join(os.curdir, name) if name.startswith("-") else name), None


def _flags(options: Mapping[str, Any]) -> List[str]:
    """The options as the command line has them. True is a flag, None and False leave it out."""
    flags = []
    for name, value in options.items():
        if isinstance(value, (np.ndarray, np.generic)):
            value = value.tolist()
        # These have values on and off: False must not be their default.
        if isinstance(value, bool) and name in ("roulette", "watts", "light_paths", "clamp"):
            value = "on" if value else "off"
        if value is None or value is False:
            continue
        flag = "--" + name.replace("_", "-")
        if isinstance(value, (list, tuple, range, set)):
            value = ",".join(map(str, value))
        elif isinstance(value, (bytes, os.PathLike)):
            value = os.fsdecode(value)
        flags.append(flag if value is True else f"{flag}={value}")
    return flags


def _shell() -> Any:
    """That of IPython, if it runs us, or None."""
    return getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()


class _Progress:
    """Shows the lines of the program's progress: on stderr, or in a notebook as a bar if tqdm is there."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._tqdm: Any = None
        if type(shell := _shell()).__name__ == "ZMQInteractiveShell":
            try:
                from tqdm.auto import tqdm

                self._tqdm = tqdm
            except ImportError:
                pass

    def line(self, line: str) -> None:
        # 125/500 spp  1.42 Mpaths/s  error 3.2 %  …; until an error: 125 of about 500 spp
        samples = re.match(r"(\d+)(?:/| of about )?(\d*) spp(.*)", line)
        if not samples or not self._tqdm:
            print(line, file=sys.stderr, flush=True)
            return
        if self._bar is None:
            self._bar = self._tqdm(unit="spp")
        self._bar.total = int(samples[2]) if samples[2] else None
        self._bar.set_postfix_str(samples[3].strip(), refresh=False)
        self._bar.update(int(samples[1]) - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


# A file, its line and column unless it is about all of the file, a field that may be missing, and the message.
_FAULT = re.compile(r"(.+?)(?::(\d+):(\d+)|(?=: Scene: )): (?:([\w.\[\]\"]+): )?(.*)")


def _run(
    command: str,
    arguments: Sequence[str],
    options: Mapping[str, Any],
    text: Optional[str] = None,
    progress: Optional[_Progress] = None,
) -> Dict[str, Any]:
    """Runs the program, and returns the object that it prints by --json. Its failure becomes an exception."""
    line = [program(), command, *arguments, *_flags(options)]
    errors: List[str] = []
    interrupts = _interrupts
    with tempfile.TemporaryFile() as stdin, tempfile.TemporaryFile() as stdout:
        try:
            stdin.write((text or "").encode())
            stdin.seek(0)
            # In a session of its own it gets no Ctrl-C but by us: a second one would end it without its image.
            process = subprocess.Popen(
                line, stdin=stdin, stdout=stdout, stderr=subprocess.PIPE, start_new_session=True,
                preexec_fn=_end_with_parent if _LIBC else None,
            )
        except (OSError, ValueError) as error:
            hint = "; expected text without surrogates and null bytes" if isinstance(error, ValueError) else ""
            raise Error(f"gpu-rt {command} cannot be run: {error}{hint}") from None
        in_thread = threading.current_thread() is not threading.main_thread()
        if in_thread:
            _OF_THREADS.add(process)
            if interrupts != _interrupts:  # while it started
                _interrupt_all()
        reader = threading.Thread(target=_read, args=(process.stderr, errors, progress), daemon=True)
        reader.start()
        interrupted = False
        try:
            try:
                process.wait()
                interrupted = in_thread and process not in _OF_THREADS
            except BaseException as reason:
                _interrupt(process)
                process.wait()
                if not isinstance(reason, KeyboardInterrupt):
                    raise
                interrupted = True
        finally:
            _OF_THREADS.discard(process)
            if process.poll() is None:
                process.kill()
            reader.join()
            if progress:
                progress.close()
        stdout.seek(0)
        printed = stdout.read().decode()
    report = json.loads(printed) if printed else {}
    if process.returncode == 0 and not interrupted:
        return report
    failure = _failure(command, errors, process.returncode, report)
    if interrupted:
        raise Interrupted(str(failure), report)
    raise failure


def _failure(command: str, errors: Sequence[str], status: int, report: Mapping[str, Any]) -> Error:
    """The exception for lines of errors that the program has printed."""
    # Each line that begins an error has the prefix; lines of more words, as usage, belong to the one before.
    messages = [message.strip() for message in "\n".join(errors).split("error: ") if message.strip()]
    faults = [Fault(f[1], int(f[2] or 0), int(f[3] or 0), f[4] or "", f[5]) for f in map(_FAULT.match, messages) if f]
    words = "\n".join(messages) or f"gpu-rt {command} ended with status {status}"
    return SceneError(words, faults) if faults else Error(words, report)


_OF_THREADS: Set[Any] = set()  # the programs and sessions that threads wait for, but for the main thread's
_interrupts = 0  # how often Ctrl-C has come


def _interrupt(process: subprocess.Popen) -> None:
    # Windows has no signal to send: its console interrupts the program itself.
    if os.name == "posix":
        process.send_signal(signal.SIGINT)


def _interrupt_all() -> None:
    for process in list(_OF_THREADS):
        _OF_THREADS.discard(process)
        process.interrupt() if isinstance(process, _Link) else _interrupt(process)


def _interrupt_threads(number: int, frame: Any) -> None:
    """Ctrl-C. Python raises KeyboardInterrupt in the main thread alone, and renders in other threads would go on to their end."""
    global _interrupts
    _interrupts += 1
    _interrupt_all()
    signal.default_int_handler(number, frame)


def _listen(*_: Any) -> None:
    """Handles Ctrl-C in place of Python, but whoever has a handler of his own keeps it."""
    if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt_threads)


_listen()
if _shell():
    # A notebook has Python's handler again before each cell.
    _shell().events.register("pre_run_cell", _listen)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_OF_THREADS.clear)

_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


def _end_with_parent() -> None:
    """Has the system stop the program, which then writes its image, if Python is killed: no terminal would. Linux only."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)  # type: ignore[union-attr]


def _read(stream: Any, errors: List[str], progress: Optional[_Progress]) -> None:
    """Reads stderr to its end: the lines from the first error on are kept, those before are shown."""
    show: Callable[[str], None] = progress.line if progress else lambda line: None
    for raw in stream:
        line = raw.decode(errors="replace").rstrip("\n")
        if errors or line.startswith("error: "):
            errors.append(line)
        else:
            show(line)
    stream.close()


from .session import Session, _Link, camera  # noqa: E402 - it needs what is above
