"""The engine gpu-rt in Blender: F12 exports the scene, and the program gpu-rt renders it.

It holds no program: preferences.py says where that is looked for. docs/blender.md describes it for users. This is not the module gpu_rt
of PyPI, which renders from Python without Blender.
"""

from . import engine, panel, preferences, settings

MODULES = (preferences, settings, panel, engine)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
