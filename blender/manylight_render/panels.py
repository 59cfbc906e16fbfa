# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the engine in the properties editor."""

import bpy
from bl_ui.properties_view_layer import ViewLayerLightgroupsPanelHelper

ENGINE = "MANYLIGHT"
# Panels of EEVEE that show what this engine uses as well: surfaces, worlds and lamps.
EEVEE = "BLENDER_EEVEE"
FROM_EEVEE = ("DATA_PT_EEVEE_light", "EEVEE_WORLD_PT_surface", "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface")
# Panels for all engines that show what this one does not use.
UNUSED = ("VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_freestyle", "VIEWLAYER_PT_freestyle")


class EnginePanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def column(self, *names):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()


class RENDER_PT_manylight_method(EnginePanel, bpy.types.Panel):
    bl_label = "Method"

    def draw(self, context):
        settings, column = context.scene.manylight, self.column()
        for name in ("method", "passes", "time", "target_error"):
            column.prop(settings, name)
        column.separator()
        for name in ("walkthrough", "lights", "max_depth", "seed", "threads", "more"):
            column.prop(settings, name)


class RENDER_PT_manylight_film(EnginePanel, bpy.types.Panel):
    bl_label = "Film"

    def draw(self, context):
        column = self.column()
        column.prop(context.scene.manylight, "filter")
        column.prop(context.scene.manylight, "denoise")
        column.prop(context.scene.render, "film_transparent", text="Transparent")


class VIEWLAYER_PT_manylight_passes(EnginePanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layer, column = context.view_layer, self.column()
        column.prop(layer, "use_pass_z", text="Depth")
        column.prop(layer, "use_pass_position")
        column.prop(layer, "use_pass_normal")
        column.prop(layer.manylight, "albedo")
        column.prop(layer.manylight, "terms")


class VIEWLAYER_PT_manylight_light_groups(EnginePanel, ViewLayerLightgroupsPanelHelper, bpy.types.Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"


class OBJECT_PT_manylight_light_group(EnginePanel, bpy.types.Panel):
    bl_label = "Light Group"
    bl_context = "object"

    def draw(self, context):
        self.column().prop_search(context.object, "lightgroup", context.view_layer, "lightgroups", text="Light Group")


class WORLD_PT_manylight_light_group(EnginePanel, bpy.types.Panel):
    bl_label = "Light Group"
    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.world is not None

    def draw(self, context):
        self.column().prop_search(context.world, "lightgroup", context.view_layer, "lightgroups", text="Light Group")


CLASSES = (
    RENDER_PT_manylight_method,
    RENDER_PT_manylight_film,
    VIEWLAYER_PT_manylight_passes,
    VIEWLAYER_PT_manylight_light_groups,
    OBJECT_PT_manylight_light_group,
    WORLD_PT_manylight_light_group,
)


def shared_panels():
    """Panels of Blender that show settings which the engine uses."""
    for panel in bpy.types.Panel.__subclasses__():
        engines, name = getattr(panel, "COMPAT_ENGINES", ()), panel.__name__
        is_general = "BLENDER_RENDER" in engines and not name.startswith(UNUSED)
        if is_general or (EEVEE in engines and name in FROM_EEVEE):
            yield panel


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
