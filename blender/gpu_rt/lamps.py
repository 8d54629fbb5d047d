"""Lamps as objects of the scene file: surfaces that emit the same power, or lights without size."""

import math

from mathutils import Vector

from . import ron
from .axes import placed

# The corners of the polygon that stands for an ellipse.
CORNERS = 64
# A sun is a disk this far away, in radii of the scene. From one end of the scene to the other its direction changes by 0.1 degrees.
FAR = 1000.0


class Lamps:
    def __init__(self, depsgraph, folder):
        self.materials, self.objects = {}, []
        self._folder = folder
        self._depsgraph = depsgraph
        for instance in depsgraph.object_instances:
            if instance.object.type == "LIGHT" and instance.show_self:
                self._add(instance.object.name, instance.object.data, instance.matrix_world.copy())

    def _add(self, name, light, matrix):
        power = strength(light, matrix)
        if not any(power) or getattr(light.cycles, "is_portal", False):
            return
        at, axis = placed(matrix.translation), -matrix.col[2].xyz.normalized()
        if light.type == "SUN":
            self._add_sun(name, light, power, axis)
        elif light.type == "AREA":
            self._add_area(name, light, power, matrix, axis)
        elif light.type == "SPOT":
            inner, outer = beam(light)
            towards, intensity = placed(matrix.translation + axis), tuple(power / (4 * math.pi))
            self.objects.append(ron.SpotLight(at=at, towards=towards, intensity=intensity, inner=inner, outer=outer))
        elif light.shadow_soft_size > 0:
            radius = light.shadow_soft_size
            # All directions see a disk of this radius.
            material = self._material(name, power / (4 * math.pi * math.pi * radius**2))
            self.objects.append(ron.Sphere(center=at, radius=radius, material=material))
        else:
            self.objects.append(ron.PointLight(at=at, intensity=tuple(power / (4 * math.pi))))

    def _add_sun(self, name, light, power, axis):
        half = min(light.angle / 2, math.radians(89))
        if half <= 0:
            self.objects.append(ron.DirectionalLight(direction=placed(axis), irradiance=tuple(power)))
            return
        middle, radius = self._bounds()
        distance = FAR * radius
        material = self._material(name, power / (math.pi * math.sin(half) ** 2))
        center = placed(middle - distance * axis)
        self.objects.append(ron.Disk(center=center, normal=placed(axis), radius=distance * math.tan(half), material=material))

    def _add_area(self, name, light, power, matrix, axis):
        height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        u, v = matrix.col[0].xyz * light.size, matrix.col[1].xyz * height
        area = u.cross(v).length
        if light.shape in ("DISK", "ELLIPSE"):
            area *= math.pi / 4
        if area <= 0:
            return
        # The lamp emits along its axis: there the corners run counter-clockwise.
        if u.cross(v).dot(axis) < 0:
            u, v = v, u
        material = self._material(name, power / (math.pi * area))
        middle = matrix.translation
        if light.shape in ("SQUARE", "RECTANGLE"):
            self.objects.append(ron.Quad(corner=placed(middle - (u + v) / 2), u=placed(u), v=placed(v), material=material))
            return
        # The polygon has the area of the ellipse.
        step = 2 * math.pi / CORNERS
        wider = math.sqrt(step / math.sin(step)) / 2
        corners = [middle + wider * (math.cos(i * step) * u + math.sin(i * step) * v) for i in range(CORNERS)]
        file = f"lamp-{len(self.objects)}.obj"
        lines = ["v %r %r %r" % placed(corner) for corner in corners]
        lines.append("f " + " ".join(str(i + 1) for i in range(CORNERS)))
        (self._folder / file).write_text("\n".join(lines) + "\n")
        self.objects.append(ron.Mesh(path=file, material=material))

    def _material(self, name, radiance):
        """The name of a new material that emits on one side. Names of Blender may hold any character."""
        name = "".join(letter if letter.isprintable() else " " for letter in name)
        while name in self.materials:
            name += f" ({len(self.materials) + 1})"
        self.materials[name] = ron.DiffuseLight(emit=ron.Rgb(*radiance), two_sided=False)
        return name

    def _bounds(self):
        """A ball around all objects with a size, and the camera."""
        points = [self._depsgraph.scene.camera.matrix_world.translation]
        for instance in self._depsgraph.object_instances:
            if instance.show_self and instance.object.type in ("MESH", "CURVE", "SURFACE", "FONT", "META"):
                points.extend(instance.matrix_world @ Vector(corner) for corner in instance.object.bound_box)
        low, high = (Vector(end(p[axis] for p in points) for axis in range(3)) for end in (min, max))
        return (low + high) / 2, max((high - low).length / 2, 1.0)


def strength(light, matrix):
    """Watts, or for a sun watts per square metre, of red, green and blue."""
    colour = Vector(light.color)
    # Blender has these since 4.5.
    if getattr(light, "use_temperature", False):
        colour *= Vector(light.temperature_color)
    energy = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    if not getattr(light, "normalize", True):
        energy *= light.area(matrix_world=matrix)
    emission = plain_emission(light)
    if emission:
        colour *= Vector(emission.inputs["Color"].default_value[:3])
        energy *= emission.inputs["Strength"].default_value
    return Vector(max(energy * channel, 0.0) for channel in colour)


def plain_emission(light):
    """The Emission of the lamp's nodes, if it is all that they have."""
    output = light.node_tree.get_output_node("CYCLES") if light.use_nodes and light.node_tree else None
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    is_plain = node and node.type == "EMISSION" and not any(socket.is_linked for socket in node.inputs)
    return node if is_plain else None


def beam(light):
    """The inner and the outer angle of a spot, in degrees from its axis.

    Both fall between two cosines: Blender by a smoothstep, and the program by the square of the share. With three quarters of Blender's
    way the light in between is the same: 3/4 · 1/3 + 1/4 = 1/2, the mean of a smoothstep.
    """
    edge = math.cos(light.spot_size / 2)
    inner = edge + 0.75 * light.spot_blend * (1 - edge)
    return math.degrees(math.acos(min(inner, 1.0))), math.degrees(light.spot_size / 2)
