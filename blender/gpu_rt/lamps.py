"""Lamps as objects of the scene file: surfaces that emit the same power, or lights without size."""

import json
import math

from mathutils import Matrix, Vector

from . import ron
from .axes import placed
from .blur import key

# The corners of the polygon that stands for an ellipse.
CORNERS = 64
# A sun is a disk this far away, in radii of the scene. From one end of the scene to the other its direction changes by 0.1 degrees.
FAR = 1000.0


class Lamps:
    """`folder` gets the files of lamps, if it is given. `ball` is around the scene: a middle and a radius, by default around what there is.

    `places` has, by the keys of instances, the shape of a lamp and the matrix that places it, in the order of `objects`. `values` has fields of
    materials and of lights without size, by their names."""

    def __init__(self, depsgraph, folder=None, ball=None):
        self.materials, self.objects, self.places, self.values = {}, [], {}, {}
        self._folder = folder
        self.ball = ball or bounds(depsgraph)
        for instance in depsgraph.object_instances:
            if instance.object.type == "LIGHT" and instance.show_self:
                count = len(self.objects)
                place = self._add(instance.object.name, instance.object.data, instance.matrix_world.copy())
                if len(self.objects) > count:
                    self.places[json.dumps(key(instance))] = place

    def _add(self, name, light, matrix):
        power = strength(light, matrix)
        if not any(power) or getattr(light.cycles, "is_portal", False):
            return None
        at, axis, upright = placed(matrix.translation), -matrix.col[2].xyz.normalized(), matrix.normalized()
        if light.type == "SUN":
            return self._add_sun(name, light, power, axis), Matrix.Translation(self.ball[0]) @ upright.to_3x3().to_4x4()
        if light.type == "AREA":
            return self._add_area(name, light, power, matrix, axis), matrix
        if light.type == "SPOT":
            inner, outer = beam(light)
            self._light(name, "SpotLight", "intensity", power / (4 * math.pi), at=at, towards=placed(matrix.translation + axis), inner=inner, outer=outer)
            return (inner, outer), upright
        radius = light.shadow_soft_size
        if radius > 0:
            # All directions see a disk of this radius.
            material = self._material(name, power / (4 * math.pi * math.pi * radius**2))
            self.objects.append(ron.Sphere(center=at, radius=radius, material=material))
        else:
            self._light(name, "PointLight", "intensity", power / (4 * math.pi), at=at)
        return (radius,), Matrix.Translation(matrix.translation)

    def _add_sun(self, name, light, power, axis):
        half = min(light.angle / 2, math.radians(89))
        if half <= 0:
            self._light(name, "DirectionalLight", "irradiance", power, direction=placed(axis))
            return (0.0,)
        middle, radius = self.ball
        distance = FAR * radius
        material = self._material(name, power / (math.pi * math.sin(half) ** 2))
        center = placed(middle - distance * axis)
        self.objects.append(ron.Disk(center=center, normal=placed(axis), radius=distance * math.tan(half), material=material))
        return (half,)

    def _add_area(self, name, light, power, matrix, axis):
        height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        u, v = matrix.col[0].xyz * light.size, matrix.col[1].xyz * height
        area = u.cross(v).length
        if light.shape in ("DISK", "ELLIPSE"):
            area *= math.pi / 4
        shape = (light.shape, light.size, height)
        if area <= 0:
            return shape
        # The lamp emits along its axis: there the corners run counter-clockwise.
        if u.cross(v).dot(axis) < 0:
            u, v = v, u
        material = self._material(name, power / (math.pi * area))
        middle = matrix.translation
        if light.shape in ("SQUARE", "RECTANGLE"):
            self.objects.append(ron.Quad(corner=placed(middle - (u + v) / 2), u=placed(u), v=placed(v), material=material))
            return shape
        # The polygon has the area of the ellipse.
        step = 2 * math.pi / CORNERS
        wider = math.sqrt(step / math.sin(step)) / 2
        corners = [middle + wider * (math.cos(i * step) * u + math.sin(i * step) * v) for i in range(CORNERS)]
        file = f"lamp-{len(self.objects)}.obj"
        lines = ["v %r %r %r" % placed(corner) for corner in corners]
        lines.append("f " + " ".join(str(i + 1) for i in range(CORNERS)))
        if self._folder:
            (self._folder / file).write_text("\n".join(lines) + "\n")
        self.objects.append(ron.Mesh(path=file, material=material))
        return shape

    def _name(self, name, fields):
        """A new name for these fields. Names of Blender may hold any character."""
        name = "".join(letter if letter.isprintable() else " " for letter in name)
        while name in self.values:
            name += f" ({len(self.values) + 1})"
        self.values[name] = fields
        return name

    def _material(self, name, radiance):
        """The name of a new material that emits on one side."""
        name = self._name(name, {"emit": ron.Rgb(*radiance)})
        self.materials[name] = ron.DiffuseLight(**self.values[name], two_sided=False)
        return name

    def _light(self, name, kind, field, strength, **place):
        """Adds a light without size."""
        name = self._name(name, {field: tuple(strength)})
        self.objects.append(ron.Named(name=name, object=getattr(ron, kind)(**place, **self.values[name])))


def bounds(depsgraph):
    """A ball around all objects with a size, and the camera: its middle and its radius."""
    camera = depsgraph.scene.camera
    points = [camera.matrix_world.translation] if camera else [Vector()]
    for instance in depsgraph.object_instances:
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
