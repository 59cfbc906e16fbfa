# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that Blender's glTF exporter does not read, replaced by the principled node that means the same.

Runs in the background Blender, on a copy of the file: materials are changed in place.
"""

import bpy

from .lamps import LAMP_OPACITY

# Inputs of the principled node that glTF cannot carry, with the value at which they do nothing.
LOST_INPUTS = {"Subsurface Weight": 0.0, "Thin Film Thickness": 0.0, "Diffuse Roughness": 0.0}
# The largest value of `Emission Strength`.
LARGEST_STRENGTH = 1e6


def default_material():
    """The material of surfaces without one, as in Cycles: diffuse, 0.8."""
    material = bpy.data.materials.new("surface without a material")
    shader = Rewriter(material, None).principled()
    set_matte(shader)
    shader.inputs["Base Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    connect_to_output(material, shader)
    return material


def prepare(material, warn):
    """Makes a material exportable. `warn(message, name)` is told what cannot be converted."""
    # Emission of Cycles has two sides whatever the viewport culls.
    material.use_backface_culling = False
    output = active_output(material)
    surface = output and source(output.inputs["Surface"])
    if output and source(output.inputs["Volume"]):
        warn("volumes of materials are not rendered", material.name)
    if output is None or surface is None:
        warn("materials without a surface shader are black", material.name)
        replace_by_black(material)
        return
    if surface.type == "BSDF_PRINCIPLED":
        warn_about_principled(material, surface, warn)
        return
    shader = Rewriter(material, warn).convert(surface)
    connect_to_output(material, shader)


def active_output(material):
    return material.node_tree and material.node_tree.get_output_node("CYCLES")


def source(socket):
    """The node at the other end of a link, past reroutes; None without a link."""
    while socket.is_linked:
        link = socket.links[0]
        if link.from_node.type != "REROUTE":
            return link.from_node
        socket = link.from_node.inputs[0]
    return None


def replace_by_black(material):
    shader = Rewriter(material, None).principled()
    set_matte(shader)
    shader.inputs["Base Color"].default_value = (0, 0, 0, 1)
    connect_to_output(material, shader)


def connect_to_output(material, shader):
    tree = material.node_tree
    output = active_output(material) or tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])


def set_matte(shader):
    """No reflection of the interface."""
    shader.inputs["Specular IOR Level"].default_value = 0.0
    shader.inputs["Roughness"].default_value = 1.0


def warn_about_principled(material, shader, warn):
    for name, neutral in LOST_INPUTS.items():
        socket = shader.inputs.get(name)
        if socket and (socket.is_linked or socket.default_value != neutral):
            warn(f"`{name}` of the principled shader is ignored", material.name)


class Rewriter:
    """Builds principled nodes in a material."""

    def __init__(self, material, warn):
        self.material, self.warn = material, warn
        self.tree = material.node_tree

    def principled(self):
        return self.tree.nodes.new("ShaderNodeBsdfPrincipled")

    def take(self, shader, target, node, name):
        """Gives an input of the principled node the value or the link of another node's input."""
        self.take_socket(shader.inputs[target], node.inputs[name])

    def take_socket(self, target, given):
        if given.is_linked:
            self.tree.links.new(given.links[0].from_socket, target)
        elif target.type == given.type or target.type == "RGBA":
            target.default_value = given.default_value
        else:
            target.default_value = float(given.default_value)

    def convert(self, node):
        """A principled node with the meaning of a shader node."""
        if node is None:
            shader = self.principled()
            set_matte(shader)
            shader.inputs["Base Color"].default_value = (0, 0, 0, 1)
            return shader
        rule = getattr(self, "from_" + node.type.lower(), None)
        if rule is None:
            message = f"the shader node `{node.bl_label}` cannot be converted: a diffuse surface of its color replaces it"
            self.warn(message, self.material.name)
            return self.diffuse(node)
        return rule(node)

    def diffuse(self, node):
        shader = self.principled()
        set_matte(shader)
        if node.inputs.get("Color"):
            self.take(shader, "Base Color", node, "Color")
        self.normal(shader, node)
        return shader

    def normal(self, shader, node):
        if node.inputs.get("Normal") and node.inputs["Normal"].is_linked:
            self.take(shader, "Normal", node, "Normal")

    def from_bsdf_principled(self, node):
        warn_about_principled(self.material, node, self.warn)
        copy = self.principled()
        for given in node.inputs:
            if given.enabled and copy.inputs.get(given.name):
                self.take_socket(copy.inputs[given.name], given)
        return copy

    def from_bsdf_diffuse(self, node):
        rough = node.inputs["Roughness"]
        if rough.is_linked or rough.default_value > 0:
            self.warn("the roughness of diffuse shaders is ignored", self.material.name)
        return self.diffuse(node)

    def from_bsdf_glossy(self, node):
        shader = self.diffuse(node)
        shader.inputs["Metallic"].default_value = 1.0
        shader.inputs["Specular IOR Level"].default_value = 0.5
        self.take(shader, "Roughness", node, "Roughness")
        anisotropy = node.inputs["Anisotropy"]
        if anisotropy.is_linked or anisotropy.default_value != 0:
            self.warn("the anisotropy of glossy shaders is ignored", self.material.name)
        return shader

    from_bsdf_anisotropic = from_bsdf_glossy

    def from_bsdf_glass(self, node):
        shader = self.diffuse(node)
        shader.inputs["Specular IOR Level"].default_value = 0.5
        shader.inputs["Transmission Weight"].default_value = 1.0
        self.take(shader, "Roughness", node, "Roughness")
        self.take(shader, "IOR", node, "IOR")
        return shader

    def warn_about_transparent(self, node):
        color = node.inputs["Color"]
        if color.is_linked or tuple(color.default_value)[:3] != (1.0, 1.0, 1.0):
            self.warn("the color of transparent shaders is ignored", self.material.name)

    def from_bsdf_transparent(self, node):
        self.warn_about_transparent(node)
        shader = self.convert(None)
        shader.inputs["Alpha"].default_value = 0.0
        return shader

    def from_emission(self, node):
        shader = self.convert(None)
        self.take(shader, "Emission Color", node, "Color")
        self.take(shader, "Emission Strength", node, "Strength")
        return shader

    def from_mix_shader(self, node):
        factor, first, second = node.inputs[0], source(node.inputs[1]), source(node.inputs[2])
        for transparent, other, is_inverse in ((first, second, False), (second, first, True)):
            if transparent is not None and transparent.type == "BSDF_TRANSPARENT":
                self.warn_about_transparent(transparent)
                shader = self.convert(other)
                self.fade(shader, factor, is_inverse)
                return shader
        share = 0.5 if factor.is_linked else factor.default_value
        message = "mixtures of shaders other than with transparency are replaced by their larger part"
        self.warn(message, self.material.name)
        return self.convert(second if share >= 0.5 else first)

    def from_add_shader(self, node):
        parts = [source(socket) for socket in node.inputs]
        emission = next((part for part in parts if part is not None and part.type == "EMISSION"), None)
        others = [part for part in parts if part is not emission]
        if emission is None:
            message = "sums of shaders other than with emission are replaced by their first part"
            self.warn(message, self.material.name)
            return self.convert(others[0])
        shader = self.convert(others[0] if others else None)
        self.take(shader, "Emission Color", emission, "Color")
        self.take(shader, "Emission Strength", emission, "Strength")
        self.keep_emission(shader)
        return shader

    def fade(self, shader, factor, is_inverse):
        """Multiplies the opacity by the factor of a mixture, or by one minus it."""
        alpha = shader.inputs["Alpha"]
        if not factor.is_linked:
            share = 1.0 - factor.default_value if is_inverse else factor.default_value
            if not alpha.is_linked:
                alpha.default_value *= share
            elif share != 1:
                self.tree.links.new(self.math("MULTIPLY", alpha.links[0].from_socket, share), alpha)
            return
        if alpha.is_linked:
            message = "mixtures of transparency with shaders of linked opacity have the opacity of the shader"
            self.warn(message, self.material.name)
            return
        opacity = factor.links[0].from_socket
        if is_inverse:
            opacity = self.math("SUBTRACT", 1.0, opacity)
        if alpha.default_value != 1:
            opacity = self.math("MULTIPLY", opacity, alpha.default_value)
        self.tree.links.new(opacity, alpha)

    def keep_emission(self, shader):
        """Divides emission by opacity: glTF scales it by that, sums of shaders do not."""
        alpha, strength = shader.inputs["Alpha"], shader.inputs["Emission Strength"]
        if not alpha.is_linked and alpha.default_value == 1:
            return
        if alpha.is_linked or strength.is_linked:
            message = "emission in sums with transparent shaders is scaled by opacity if opacity or strength is linked"
            self.warn(message, self.material.name)
            return
        opacity = max(alpha.default_value, LAMP_OPACITY, strength.default_value / LARGEST_STRENGTH)
        alpha.default_value = min(1.0, opacity)
        strength.default_value /= alpha.default_value

    def math(self, operation, *values):
        """The result of a node; `values` are numbers or sockets."""
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node.outputs[0]
