"""Makes the scenes of lobes of materials with Blender's Python module: NAME.glb by its exporter, NAME.exr by Cycles.

    python3.11 -m venv v && v/bin/pip install bpy==5.0.1 numpy
    v/bin/python tests/blender/lobes.py                      # all of them, half an hour on one core
    v/bin/python tests/blender/lobes.py velvet --seed 2 --to /tmp/other

tests/images/blender.rs renders each .glb and compares it with the .exr, which has twice its side: 128 by 96 pixels. Cycles is set as for SCENES
of make.py: it renders what the .glb says. Where no setting of Cycles is what the .glb says, docs/gltf.md has the difference.

Two images are of what the file says and not of what Blender shows:

- brushed.exr: the exporter writes Blender's anisotropy as it is, but the extension makes other roughnesses of it. After the export, the two
  numbers of Blender are set so that Cycles has the extension's roughnesses. brushed-in-blender.exr is what Blender shows without that.
- velvet-formula.exr: Cycles has no sheen of the extension's kind. The scene is convex and has no world, so that light scatters once, and numpy
  has its image by the formula of KHR_materials_sheen. numpy's image of the same ball without sheen is checked against Cycles. velvet.exr is what
  Blender shows.
"""

import argparse
import math
import pathlib

import bpy  # first: it brings the other modules
import numpy as np
from mathutils import Matrix

import make
from make import ball, box, globe, lamp, light, link, material, matt, principled, square, thing

FOLDER = make.FOLDER
SIZE = (128, 96)
SPP = 2048


def with_inputs(made, **inputs):
    for name, value in inputs.items():
        principled(made)[name.replace("_", " ")].default_value = value
    return made


def along_u(made):
    """Grooves across the direction in which u grows, as the tangents of the file say."""
    tangent = made.node_tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
    link(made, tangent.outputs["Tangent"], principled(made)["Tangent"])
    return made


def has_roughnesses_of_file(*metals):
    """Has Cycles render the extension's roughnesses: α along the tangent is α + (1 - α) s², and α = r² across it. Blender's are r² / a and r² a with
    a² = 1 - 0.9 s."""
    for made in metals:
        numbers = principled(made)
        alpha, strength = numbers["Roughness"].default_value ** 2, numbers["Anisotropic"].default_value
        along = alpha + (1.0 - alpha) * strength**2
        numbers["Roughness"].default_value = (along * alpha) ** 0.25
        numbers["Anisotropic"].default_value = (1.0 - alpha / along) / 0.9


def stage(wall=(0.45, 0.5, 0.6)):
    thing("Floor", square(), matt("Floor", (0.5, 0.48, 0.45)), scale=(5, 5, 1))
    thing("Wall", square(), matt("Wall", wall), (0, 2.5, 2), (90, 0, 0), (5, 2, 1))
    thing("Panel", square(), lamp("Panel", 3.0), (-1.2, -2.6, 4.0), (145, -15, 0), (2.4, 1.5, 1))
    thing("Side", square(), lamp("Warm", 2.0, (1.0, 0.75, 0.5)), (3.6, -1.0, 1.8), (0, -80, 0), (1.4, 1.8, 1))
    make.camera((0, -6, 1.8), (0, 0, 0.68), 32)


def varnish():
    """A coat on wood, half of one on paint, and one on rough metal."""
    stage()
    wood = with_inputs(matt("Wood", (0.45, 0.22, 0.1)), Coat_Weight=1.0, Coat_Roughness=0.1)
    paint = with_inputs(matt("Paint", (0.1, 0.25, 0.5)), Coat_Weight=0.5, Coat_Roughness=0.3)
    metal = with_inputs(material("Metal", (0.85, 0.65, 0.35), 0.5, metallic=1.0), Coat_Weight=1.0, Coat_Roughness=0.15)
    for index, made in enumerate((wood, paint, metal)):
        thing(made.name, ball(), made, (1.25 * (index - 1), 0.3 * (index % 2), 0.6), scale=(0.6, 0.6, 0.6), smooth=True)


# The velvet ball of radius 1 in the origin, of these numbers.
CLOTH, SHEEN, SHEEN_ROUGHNESS = (0.3, 0.05, 0.06), (0.8, 0.6, 0.55), 0.5
# The sun: the direction towards it, and its irradiance. The panel: its middle, its turn in degrees, half its sides, its radiance.
TO_SUN, SUN = (-0.5, -0.7, 0.5), 2.0
PANEL = ((2.5, -1.5, 2.5), (0, 45, -30), (0.8, 0.6), 6.0)
EYE, FOV = (0, -6, 0), 26.0


def velvet(with_sheen=True):
    """A ball of velvet in the void, in the sun and before a panel."""
    made = matt("Velvet", CLOTH)
    if with_sheen:
        with_inputs(made, Sheen_Weight=1.0, Sheen_Roughness=SHEEN_ROUGHNESS, Sheen_Tint=(*SHEEN, 1.0))
    thing("Ball", ball(5), made, smooth=True)
    at, turn, sides, radiance = PANEL
    thing("Panel", square(), lamp("Panel", radiance), at, turn, (*sides, 1))
    light("SUN", "Sun", SUN, tuple(6 * x for x in TO_SUN), (0, 0, 0))
    make.camera(EYE, (0, 0, 0), FOV)


def brushed():
    """A ball and a plate of brushed metal."""
    stage()
    plate = along_u(with_inputs(material("Plate", (0.75, 0.75, 0.78), 0.35, metallic=1.0), Anisotropic=0.6))
    brass = along_u(with_inputs(material("Brass", (0.9, 0.75, 0.45), 0.4, metallic=1.0), Anisotropic=0.7))
    thing("Ball", globe(), brass, (-0.8, 0, 0.75), (0, 0, 30), scale=(0.75, 0.75, 0.75), smooth=True)
    thing("Plate", square(), plate, (0.9, 0.2, 0.8), (65, 0, -15), (0.7, 0.7, 1))
    return lambda: has_roughnesses_of_file(plate, brass)


def plastic():
    """A ball and a slab of plastic before stripes; half of the light that enters passes, and half is scattered."""
    stage()
    for index in range(-6, 7):
        colour = ((0.75, 0.75, 0.7), (0.15, 0.3, 0.6), (0.7, 0.2, 0.15))[index % 3]
        thing(f"Stripe {index}", square(), matt(f"Stripe {index}", colour), (0.6 * index, 1.6, 1.5), (90, 0, 0), (0.3, 1.5, 1))
    milk = material("Milk", (0.75, 0.85, 0.9), 0.35, transmission=0.5, thickness=1.0)
    amber = material("Amber", (0.9, 0.7, 0.4), 0.4, transmission=0.5, thickness=0.3)
    thing("Ball", ball(), milk, (-0.8, -0.2, 0.7), scale=(0.7, 0.7, 0.7), smooth=True)
    thing("Slab", box(), amber, (0.9, 0, 0.7), (0, 0, -15), (0.6, 0.12, 0.7))


def lobes():
    """A ball of each, and a smaller one that has all of them."""
    stage((0.6, 0.55, 0.5))
    varnished = with_inputs(matt("Varnish", (0.45, 0.22, 0.1)), Coat_Weight=1.0, Coat_Roughness=0.1)
    cloth = with_inputs(matt("Velvet", CLOTH), Sheen_Weight=1.0, Sheen_Roughness=SHEEN_ROUGHNESS, Sheen_Tint=(*SHEEN, 1.0))
    metal = along_u(with_inputs(material("Brushed", (0.8, 0.8, 0.85), 0.4, metallic=1.0), Anisotropic=0.6))
    milk = material("Milk", (0.75, 0.85, 0.9), 0.35, transmission=0.5, thickness=1.0)
    everything = along_u(material("Everything", (0.3, 0.6, 0.35), 0.4, transmission=0.5, thickness=0.5))
    with_inputs(everything, Coat_Weight=1.0, Coat_Roughness=0.15, Sheen_Weight=1.0, Sheen_Roughness=0.6, Sheen_Tint=(0.3, 0.3, 0.4, 1.0),
                Anisotropic=0.5)
    sphere, mapped = ball(), globe()
    for index, (made, mesh) in enumerate(((varnished, sphere), (cloth, sphere), (metal, mapped), (milk, sphere))):
        thing(made.name, mesh, made, (1.0 * (index - 1.5), 0.3, 0.5), scale=(0.5, 0.5, 0.5), smooth=True)
    thing("Everything", mapped, everything, (0.1, -1.0, 0.32), scale=(0.32, 0.32, 0.32), smooth=True)
    return lambda: has_roughnesses_of_file(metal)


# The image of velvet by numpy.


def dot(a, b):
    return (a * b).sum(-1)


def unit(a):
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def of_charlie(cosine_n, v, l, n, alpha):
    """The distribution of Estevez and Kulla times their visibility (KHR_materials_sheen, "Sheen BRDF"), without the colour."""
    to_view, to_light = np.maximum(dot(n, v), 1e-6), np.maximum(cosine_n, 1e-6)
    sine = np.sqrt(np.maximum(1.0 - dot(n, unit(v + l)) ** 2, 0.0))
    distribution = (2.0 + 1.0 / alpha) * sine ** (1.0 / alpha) / (2.0 * math.pi)
    share = (1.0 - alpha) ** 2
    a, b, c, d, e = (share * p + (1.0 - share) * q for p, q in (
        (25.3245, 21.5473), (3.32435, 3.82987), (0.16801, 0.19823), (-1.27393, -1.97760), (-4.85967, -4.32054)))
    curve = lambda x: a / (1.0 + b * x**c) + d * x + e
    shadowing = lambda x: np.where(x < 0.5, np.exp(curve(x)), np.exp(2.0 * curve(0.5) - curve(np.maximum(1.0 - x, 0.0))))
    return distribution / ((1.0 + shadowing(to_view) + shadowing(to_light)) * 4.0 * to_view * to_light)


def albedo_of_charlie(alpha, steps=256):
    """Its directional albedo at cosines from 0.002 to 1, by the midpoints of cells of the hemisphere."""
    cosines = np.linspace(0.002, 1.0, steps)
    z, around = np.meshgrid((np.arange(steps) + 0.5) / steps, (np.arange(steps) + 0.5) / steps * 2.0 * math.pi)
    l = np.stack([np.sqrt(1.0 - z * z) * np.cos(around), np.sqrt(1.0 - z * z) * np.sin(around), z], -1)
    n = np.broadcast_to((0.0, 0.0, 1.0), l.shape)
    view = lambda x: np.broadcast_to((math.sqrt(max(1.0 - x * x, 0.0)), 0.0, x), l.shape)
    return cosines, np.array([2.0 * math.pi * (of_charlie(z, view(x), l, n, alpha) * z).mean() for x in cosines])


def velvet_by_formula(with_sheen=True, rays=4, points=12):
    """The image of the ball: so many rays along each side of a pixel, and points along each side of the panel."""
    width, height = SIZE
    half = math.tan(0.5 * math.radians(FOV))
    x = ((np.arange(width * rays) + 0.5) / (width * rays) * 2.0 - 1.0) * half
    y = (1.0 - (np.arange(height * rays) + 0.5) / (height * rays) * 2.0) * half * height / width
    x, y = np.meshgrid(x, y)
    eye, ray = np.array(EYE, float), unit(np.stack([x, np.ones_like(x), y], -1))
    along = dot(ray, eye)
    inside = along**2 - (eye @ eye - 1.0)
    n = unit(eye + (-along - np.sqrt(np.maximum(inside, 0.0)))[..., None] * ray)
    base, colour = np.array(CLOTH) / math.pi, np.array(SHEEN)
    alpha = SHEEN_ROUGHNESS**2
    cosines, albedo = albedo_of_charlie(alpha)
    left = lambda cosine: 1.0 - colour.max() * np.interp(cosine, cosines, albedo)
    image = np.zeros((*x.shape, 3))

    def add(l, irradiance):
        """Light of this irradiance across its own direction."""
        cosine = dot(n, l)
        value = np.broadcast_to(base, n.shape)
        if with_sheen:
            scale = np.minimum(left(dot(n, -ray)), left(cosine))
            value = value * scale[..., None] + colour * of_charlie(cosine, -ray, l, n, alpha)[..., None]
        arrives = np.where((inside > 0.0) & (cosine > 0.0), cosine * irradiance, 0.0)
        image[...] += np.where(arrives[..., None] > 0.0, value, 0.0) * arrives[..., None]

    add(np.broadcast_to(unit(np.array(TO_SUN)), n.shape), SUN)
    at, turn, sides, radiance = PANEL
    # Blender turns about x, then y, then z.
    a, b, c = (math.radians(angle) for angle in turn)
    about = lambda axis, angle: np.array(Matrix.Rotation(angle, 3, axis))
    matrix = about("Z", c) @ about("Y", b) @ about("X", a)
    u, v, facing = matrix[:, 0] * sides[0], matrix[:, 1] * sides[1], matrix[:, 2]
    share = 4.0 * sides[0] * sides[1] / points**2
    cells = (np.arange(points) + 0.5) / points * 2.0 - 1.0
    for p in cells:
        for q in cells:
            to = np.array(at) + p * u + q * v - n
            distance = np.linalg.norm(to, axis=-1)
            l = to / distance[..., None]
            add(l, radiance * share * np.abs(dot(l, facing)) / distance**2)
    return image.reshape(height, rays, width, rays, 3).mean((1, 3))


def pixels_of(path):
    picture = bpy.data.images.load(str(path))
    picture.colorspace_settings.name = "Non-Color"
    width, height = picture.size
    values = np.empty(4 * width * height, np.float32)
    picture.pixels.foreach_get(values)
    return values.reshape(height, width, 4)[::-1, :, :3].astype(float)


def save(path, rgb):
    """As Cycles writes its images: OpenEXR of 16 bits."""
    height, width, _ = rgb.shape
    picture = bpy.data.images.new(path.stem, width, height, float_buffer=True)
    picture.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = rgb[::-1]
    picture.pixels.foreach_set(rgba.ravel())
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGB", "16", "PIZ"
    view = bpy.context.scene.view_settings.view_transform
    bpy.context.scene.view_settings.view_transform = "Raw"
    picture.save_render(str(path), scene=bpy.context.scene)
    bpy.context.scene.view_settings.view_transform = view


def check_formula(to, threads):
    """numpy's geometry and lights by Cycles: the same ball without sheen, within 0.3 % of the mean."""
    make.empty()
    velvet(with_sheen=False)
    path = to / "velvet-without-sheen.exr"
    make.render(path, 256, threads)
    off = velvet_by_formula(with_sheen=False).mean() / pixels_of(path).mean() - 1.0
    path.unlink()
    print(f"without sheen, numpy is off Cycles by {100.0 * off:+.3f} % of the mean")
    if abs(off) > 0.003:
        raise SystemExit("numpy does not have the scene of Cycles")


SCENES = {"varnish": varnish, "velvet": velvet, "brushed": brushed, "plastic": plastic, "lobes": lobes}


def export(path):
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", export_cameras=True, export_lights=True, export_yup=True,
                              export_animations=False, export_tangents=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scenes", nargs="*", choices=[*SCENES, []], metavar="scene", help=", ".join(SCENES))
    arguments.add_argument("--spp", type=int, default=SPP, help="samples per pixel")
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--threads", type=int, default=1)
    arguments.add_argument("--to", type=pathlib.Path, default=FOLDER, help="another folder")
    options = arguments.parse_args()
    make.SIZE = SIZE
    options.to.mkdir(exist_ok=True)
    for name in options.scenes or SCENES:
        make.empty()
        what_no_file_says = SCENES[name]()
        export(options.to / f"{name}.glb")
        if name == "brushed":
            make.render(options.to / "brushed-in-blender.exr", options.spp, options.threads, seed=options.seed)
        if what_no_file_says:
            what_no_file_says()
        make.render(options.to / f"{name}.exr", options.spp, options.threads, seed=options.seed)
        if name == "velvet":
            save(options.to / "velvet-formula.exr", velvet_by_formula())
            check_formula(options.to, options.threads)


if __name__ == "__main__":
    main()
