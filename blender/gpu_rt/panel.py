"""The panel of the engine among the properties of a render, and Blender's own panels that it shares."""

from itertools import groupby

import bpy

from .losses import losses

ENGINE = "GPU_RT"
# The most losses that are listed.
MOST = 30


class GPU_RT_panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


class GPU_RT_PT_sampling(GPU_RT_panel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        for name in ("samples", "noise", "time", "denoise", "light_paths", "device"):
            self.layout.prop(context.scene.gpu_rt, name)


class GPU_RT_PT_losses(GPU_RT_panel, bpy.types.Panel):
    bl_label = "Not Rendered"

    def draw(self, context):
        found = losses(context.scene, context.view_layer)
        column = self.layout.column(align=True)
        for name, told in groupby(found[:MOST], lambda loss: loss[0]):
            column.label(text=name, icon="ERROR")
            for _, words in told:
                column.label(text=words, icon="BLANK1")
        if len(found) > MOST:
            column.label(text=f"and {len(found) - MOST} more, which a render reports")
        if not found:
            column.label(text="Everything is rendered")


CLASSES = (GPU_RT_PT_sampling, GPU_RT_PT_losses)
EEVEE = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"}


def shared():
    """Panels that show what this engine renders, too: those of EEVEE, beside its own settings, which are among the properties of the render
    and of the view layer. Freestyle draws with EEVEE."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", set())
        is_general = "BLENDER_RENDER" in engines or getattr(panel, "bl_context", "") not in ("render", "view_layer")
        if EEVEE & engines and is_general and "freestyle" not in panel.__name__.lower():
            yield panel


def register():
    for panel in CLASSES:
        bpy.utils.register_class(panel)
    for panel in shared():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in shared():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for panel in reversed(CLASSES):
        bpy.utils.unregister_class(panel)
