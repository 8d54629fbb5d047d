"""The settings of a scene: `scene.gpu_rt`."""

import json
import subprocess

import bpy

from .preferences import program
from .process import Failure

_names = []


def devices(self, context, text):
    """Names of the devices, which are asked for once."""
    if not _names:
        try:
            listed = subprocess.run([program(), "devices", "--json"], capture_output=True, timeout=20).stdout
            _names.extend(device["name"] for device in json.loads(listed)["devices"])
        except (Failure, OSError, subprocess.SubprocessError, ValueError, KeyError):
            return []
    return _names


class GPU_RT_settings(bpy.types.PropertyGroup):
    samples: bpy.props.IntProperty(
        name="Samples", min=1, max=1 << 30, soft_max=1 << 16, default=128,
        description="Samples of each pixel; with a noise goal or a time limit the most samples",
    )
    noise: bpy.props.FloatProperty(
        name="Noise Goal", subtype="PERCENTAGE", min=0.0, max=100.0, precision=2, default=0.0,
        description="Stop when the relative error is below this. 0 is no goal",
    )
    time: bpy.props.FloatProperty(
        name="Time Limit", unit="TIME_ABSOLUTE", min=0.0, default=0.0,
        description="Stop after this time, which counts from the start of the program. 0 is no limit",
    )
    denoise: bpy.props.BoolProperty(
        name="Denoise", default=False,
        description="Denoise the image at the end by Open Image Denoise. This biases the result",
    )
    device: bpy.props.StringProperty(
        name="Device", search=devices,
        description="A device, by its index or a part of its name as `gpu-rt devices` lists them. By default a GPU if there is one",
    )
    light_paths: bpy.props.EnumProperty(
        name="Light Paths", default="auto",
        description="Paths from the lights through mirrors and glass, for each 8 samples of a pixel. They find caustics, and take time",
        items=[
            ("auto", "Automatic", "Where lights are small and something mirrors or refracts"),
            ("off", "Off", "None"),
            *((str(number), str(number), f"{number} for each 8 samples of a pixel") for number in (1, 2, 4, 8)),
        ],
    )


def register():
    bpy.utils.register_class(GPU_RT_settings)
    bpy.types.Scene.gpu_rt = bpy.props.PointerProperty(type=GPU_RT_settings)


def unregister():
    del bpy.types.Scene.gpu_rt
    bpy.utils.unregister_class(GPU_RT_settings)
