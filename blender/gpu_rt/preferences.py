"""Where the program is: a preference, or else in a release's extension, or where installers put it."""

import os
import shutil

import bpy

from .process import Failure


class GPU_RT_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program", subtype="FILE_PATH",
        description="The program gpu-rt. By default it is that of the extension, or looked for on PATH, and where cargo and pip install it",
    )

    def draw(self, context):
        self.layout.prop(self, "program")
        try:
            self.layout.label(text=f"Found: {program()}")
        except Failure as failure:
            self.layout.label(text=str(failure), icon="ERROR")


def program():
    """The path of the program. `Failure` if it is nowhere."""
    # There is none where the package is a plain module.
    addon = bpy.context.preferences.addons.get(__package__)
    chosen = addon.preferences.program if addon and addon.preferences else ""
    if chosen:
        found = shutil.which(bpy.path.abspath(chosen))
        if not found:
            raise Failure(f"{chosen} is not a program: set Preferences > Add-ons > gpu-rt > Program")
        return found
    inside = os.path.join(os.path.dirname(__file__), "bin", "gpu-rt.exe" if os.name == "nt" else "gpu-rt")
    if os.path.isfile(inside):
        # Blender unpacks files without their permissions.
        if not os.access(inside, os.X_OK):
            os.chmod(inside, 0o755)
        return inside
    # A desktop starts Blender without the PATH of a shell.
    others = [os.path.expanduser(folder) for folder in ("~/.cargo/bin", "~/.local/bin")]
    found = shutil.which("gpu-rt") or shutil.which("gpu-rt", path=os.pathsep.join(others))
    if not found:
        raise Failure("The program gpu-rt is not on PATH: install it, or set Preferences > Add-ons > gpu-rt > Program")
    return found


def register():
    bpy.utils.register_class(GPU_RT_preferences)


def unregister():
    bpy.utils.unregister_class(GPU_RT_preferences)
