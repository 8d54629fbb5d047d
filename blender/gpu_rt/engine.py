"""The engine: exports the scene by a second Blender, has the program render it, and shows the image."""

import hashlib
import pathlib
import re

import bpy
import numpy as np

from . import exr, viewport
from .job import SCENE, answer_of, job_of
from .losses import losses
from .preferences import program
from .process import Failure, run
from .viewer import Viewer

# The passes beside Combined: what Blender calls them, their channels, and what kind of value they are.
PASSES = (("Depth", "Z", "VALUE"), ("Position", "XYZ", "VECTOR"), ("Denoising Normal", "XYZ", "VECTOR"),
          ("Denoising Albedo", "RGB", "COLOR"))
AOVS = "--aov=albedo,normal,depth,position"
# The depth where there is nothing, as Cycles has it.
FAR = 1e10


class Cancelled(Exception):
    """Esc."""


class GPU_RT_engine(bpy.types.RenderEngine):
    bl_idname = "GPU_RT"
    bl_label = "gpu-rt"
    bl_use_preview = False
    # The shader nodes of Cycles, and EEVEE where the viewport previews materials.
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

    # What shows in a 3D view, if the engine is of one.
    shown = None

    def view_update(self, context, depsgraph):
        self.shown = self.shown or viewport.Viewport()
        self.shown.update(self, depsgraph)

    def view_draw(self, context, depsgraph):
        self.shown.draw(self, context, depsgraph)

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for name, channels, kind in PASSES:
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        scene, layer = depsgraph.scene, depsgraph.view_layer.name
        size, part = region(scene.render)
        # Blender needs a result even if there is nothing in it.
        result = self.begin_result(0, 0, max(part[2], 1), max(part[3], 1), layer=layer)
        passes = result.layers[0].passes

        def show(image):
            if image is not None:
                fill(passes["Combined"], *np.moveaxis(answer["exposure"] * image[::-1], 2, 0))
                self.update_result(result)

        try:
            found = program()
            if min(part[2:]) < 1:
                raise Failure("The render region is empty: choose a larger one, or turn it off in Output > Format")
            folder = folder_of(scene, layer)
            answer = self._export(scene, layer, folder, size)
            for name, words in losses(scene.original, scene.original.view_layers[layer]):
                self.report({"WARNING"}, f"gpu-rt: {name}: {words}")
            crop = [answer["begin"][0] + part[0], answer["begin"][1] + part[1], *part[2:]]
            image = self._run(found, scene.gpu_rt, answer["filter"], folder, crop, show)
            clean = image.with_suffix(".denoised.exr")
            hand_over(image, clean if scene.gpu_rt.denoise and clean.exists() else image, passes, answer["exposure"])
        except Cancelled:
            pass
        except Failure as failure:
            self.report({"ERROR"}, str(failure))
        except OSError as error:
            # Such as a full disk.
            self.report({"ERROR"}, f"gpu-rt: {error}")
        finally:
            self.end_result(result)

    def _export(self, scene, layer, folder, size):
        """Writes the scene for the program into the folder. Returns what `export.export` says."""
        self.update_stats("", "gpu-rt: exporting the scene")
        for file in folder.iterdir():
            if file.suffix != ".exr" or file.name == "world.exr":
                file.unlink()
        job = {"scene": scene.name, "layer": layer, "frame": scene.frame_current, "subframe": scene.frame_subframe, "size": size}
        said = []
        ended = run(job_of(scene.original, folder, job), folder, self.test_break, said.append)
        if ended.cancelled:
            raise Cancelled
        answer = answer_of(folder, ended, said)
        for note in answer["notes"]:
            self.report({"WARNING"}, f"gpu-rt: {note}")
        return answer

    def _run(self, found, settings, pixel_filter, folder, crop, show):
        """Runs the program, and shows its image meanwhile. Returns the file."""
        options = [AOVS, f"--crop={','.join(map(str, crop))}", f"--light-paths={settings.light_paths}", f"--filter={pixel_filter}"]
        if settings.device:
            options.append(f"--device={settings.device}")
        if settings.denoise:
            options += ["--denoise", *oidn()]
        image = state(folder, options, settings.samples)
        options += [f"--spp={settings.samples}", "--resume=auto", "--json"]
        if settings.noise > 0:
            options.append(f"--noise={settings.noise / 100}")
        if settings.time > 0:
            options.append(f"--time={settings.time}s")
        messages = []

        def say(line):
            samples = re.match(r"(\d+)(?:/| of about )?(\d*) spp", line)
            if samples:
                self.update_stats("", f"gpu-rt: {line}")
                self.update_progress(int(samples[1]) / int(samples[2]) if samples[2] else 0.0)
            elif line.startswith("compiling "):
                self.update_stats("", f"gpu-rt: {line}")
            elif line:
                messages.append(line)

        def render():
            messages.clear()
            self.update_stats("", "gpu-rt: starting")
            with Viewer() as viewer:
                command = [found, "render", SCENE, "-o", image.name, f"--display-server={viewer.address}", *options]
                ended = run(command, folder, self.test_break, say, lambda: show(viewer.take()))
            errors = "\n".join(messages).split("error: ")[1:]
            return ended, [error for error in errors if not error.startswith("interrupted by ")]

        ended, errors = render()
        if any("cannot be resumed" in error for error in errors):
            # Such as by another driver, or with an image of the world that has changed.
            image.unlink()
            ended, errors = render()
        if errors or (ended.status != 0 and not ended.cancelled):
            words = " ".join(" ".join(errors).split()) or f"it ended with status {ended.status}"
            raise Failure(f"The program {found} has failed: {words}")
        for line in messages:
            if line.startswith(("warning: ", "note: ")):
                self.report({"WARNING"}, "gpu-rt: " + re.sub(r"^\w+: (scene\.ron:\d+:\d+: )?", "", line))
        # Without its report the image, if there is one, is that of an earlier render.
        if image.exists() and (ended.cancelled or ended.output.strip().startswith("{")):
            return image
        if ended.cancelled:
            raise Cancelled
        raise Failure(f"The program {found} has written no image: is it gpu-rt?")


def folder_of(scene, layer):
    """The folder of a view layer's export, image and state. Blender removes it when it quits."""
    name = hashlib.sha256(f"{scene.name_full}\0{layer}".encode()).hexdigest()[:16]
    folder = pathlib.Path(bpy.app.tempdir, "gpu-rt", name)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def region(render):
    """The size of the whole image, and the part of it that is rendered: x and y from the upper left, width and height."""
    share = render.resolution_percentage / 100
    width, height = max(int(render.resolution_x * share), 1), max(int(render.resolution_y * share), 1)
    if not render.use_border:
        return (width, height), (0, 0, width, height)
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    return (width, height), (left, height - top, right - left, top - bottom)


def state(folder, options, samples):
    """The image file for this scene and these options. An earlier one of others is removed, and so is one with more samples: what stays,
    the program goes on with."""
    digest = hashlib.sha256("\0".join(options).encode())
    for file in sorted(folder.iterdir()):
        if file.suffix in (".ron", ".glb", ".obj") or file.name == "world.exr":
            digest.update(file.name.encode() + file.read_bytes())
    image = folder / f"{digest.hexdigest()[:16]}.exr"
    for file in folder.glob("*.exr"):
        if file.name != "world.exr" and (not file.name.startswith(image.stem) or exr.held_samples(image) > samples):
            file.unlink()
    return image


def oidn():
    """The option that names the folder of Blender's own Open Image Denoise, where it has one."""
    root = pathlib.Path(bpy.utils.resource_path("LOCAL")).parent
    folders = (folder for folder in (root / "lib", root / "blender.shared") if folder.is_dir())
    return [f"--oidn={folder}" for folder in folders if any(folder.glob("*OpenImageDenoise*"))]


def hand_over(image, combined, passes, exposure):
    """Fills the passes from the program's files. The film's exposure is that of the picture alone, as in Cycles."""
    channels = exr.read(image)
    fill(passes["Depth"], np.minimum(channels["Z"], FAR))
    # Blender's x, y and z are -z, -x and y of the scene file (axes.placed).
    for name, layer in (("Position", "P"), ("Denoising Normal", "N")):
        x, y, z = (channels[f"{layer}.{axis}"] for axis in "XYZ")
        fill(passes[name], -z, -x, y)
    fill(passes["Denoising Albedo"], *(channels[f"albedo.{colour}"] for colour in "RGB"))
    shown = channels if combined == image else exr.read(combined)
    fill(passes["Combined"], *(np.float32(exposure) * shown[colour] for colour in "RGB"))


def fill(render_pass, *channels):
    """Fills a pass, row 0 at the bottom. The program's image has no alpha."""
    values = np.ones((*channels[0].shape, render_pass.channels), np.float32)
    for index, channel in enumerate(channels):
        values[..., index] = channel
    render_pass.rect.foreach_set(values.ravel())


def register():
    bpy.utils.register_class(GPU_RT_engine)


def unregister():
    bpy.utils.unregister_class(GPU_RT_engine)
