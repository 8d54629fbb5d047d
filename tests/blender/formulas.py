"""How far Cycles' lobes are from the formulas of glTF's extensions, without this renderer: a ball in the sun, by Cycles and by numpy.

    v/bin/python tests/blender/formulas.py       # a minute on one core

Prints for each lobe the difference of the means, and the mean of the absolute differences of pixels, both in shares of the mean of Cycles. docs/gltf.md
has them. The first line is the control: a matt ball, on which both agree.
"""

import math
import pathlib
import tempfile

import bpy  # first: it brings the other modules
import numpy as np

import lobes
import make
from lobes import along_u, dot, of_charlie, unit, with_inputs
from make import material, matt, thing

SIZE = (64, 48)
TO_SUN, IRRADIANCE = unit(np.array((-0.45, -0.6, 0.66))), 3.0
BASE, METAL, SHEEN = (0.5, 0.25, 0.15), (0.8, 0.7, 0.6), (0.6, 0.7, 0.9)
DISTANCE, FOV = 6.0, 30.0


def by_cycles(made):
    make.empty()
    made = made()
    ball = make.built(lambda shape: make.bmesh.ops.create_uvsphere(
        shape, u_segments=256, v_segments=128, radius=1.0, calc_uvs=bool(shape.loops.layers.uv.new("UVMap"))))
    thing("Ball", ball, made, smooth=True)
    make.light("SUN", "Sun", IRRADIANCE, tuple(5 * TO_SUN), (0, 0, 0))
    make.camera((0, -DISTANCE, 0), (0, 0, 0), FOV)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "ball.exr"
        make.render(path, 64, 1)
        return lobes.pixels_of(path)


def by_formula(value, rays=8):
    """`value` is the BSDF at normals, directions to the viewer and directions to the sun; so many rays along each side of a pixel."""
    width, height = SIZE
    half = math.tan(0.5 * math.radians(FOV))
    x = ((np.arange(width * rays) + 0.5) / (width * rays) * 2.0 - 1.0) * half
    y = (1.0 - (np.arange(height * rays) + 0.5) / (height * rays) * 2.0) * half * height / width
    x, y = np.meshgrid(x, y)
    eye, ray = np.array((0.0, -DISTANCE, 0.0)), unit(np.stack([x, np.ones_like(x), y], -1))
    along = dot(ray, eye)
    inside = along**2 - (DISTANCE**2 - 1.0)
    n = unit(eye + (-along - np.sqrt(np.maximum(inside, 0.0)))[..., None] * ray)
    l = np.broadcast_to(TO_SUN, n.shape)
    arrives = np.where((inside > 0.0) & (dot(n, l) > 0.0), dot(n, l) * IRRADIANCE, 0.0)[..., None]
    image = np.where(arrives > 0.0, value(n, -ray, l), 0.0) * arrives
    return image.reshape(height, rays, width, rays, 3).mean((1, 3))


def schlick(f0, cosine):
    return f0 + (1.0 - f0) * (1.0 - np.clip(cosine, 0.0, 1.0)) ** 5


def ggx(n, v, l, along, across):
    """D · V of GGX with its α along and across the direction in which u grows."""
    t = unit(np.cross(np.broadcast_to((0.0, 0.0, 1.0), n.shape), n))
    b, h = np.cross(n, t), unit(v + l)
    cosine = lambda w: np.maximum(dot(n, w), 1e-6)
    shadowing = lambda w: 0.5 * (np.sqrt(1.0 + ((along * dot(t, w)) ** 2 + (across * dot(b, w)) ** 2) / cosine(w) ** 2) - 1.0)
    d = 1.0 / (math.pi * along * across * ((dot(t, h) / along) ** 2 + (dot(b, h) / across) ** 2 + dot(n, h) ** 2) ** 2)
    return d / ((1.0 + shadowing(v) + shadowing(l)) * 4.0 * cosine(v) * cosine(l))


def coated(share, roughness):
    def value(n, v, l):
        of_coat = share * schlick(0.04, dot(v, unit(v + l))) * ggx(n, v, l, roughness**2, roughness**2)
        return np.array(BASE) / math.pi * (1.0 - share * schlick(0.04, dot(n, v)))[..., None] + of_coat[..., None]
    return value


def sheened(roughness):
    colour = np.array(SHEEN)
    cosines, albedo = lobes.albedo_of_charlie(roughness**2)
    left = lambda cosine: 1.0 - colour.max() * np.interp(cosine, cosines, albedo)

    def value(n, v, l):
        scale = np.minimum(left(dot(n, v)), left(dot(n, l)))[..., None]
        return np.array(BASE) / math.pi * scale + colour * of_charlie(dot(n, l), v, l, n, roughness**2)[..., None]
    return value


def brushed(along, across):
    def value(n, v, l):
        cosine = dot(v, unit(v + l))[..., None]
        return schlick(np.array(METAL), cosine) * ggx(n, v, l, along, across)[..., None]
    return value


def compare(name, made, value):
    found, expected = by_formula(value), by_cycles(made)
    mean, each = found.mean() / expected.mean() - 1.0, np.abs(found - expected).mean() / expected.mean()
    print(f"{name:60s} mean {100.0 * mean:+.2f} %, pixels {100.0 * each:.2f} %", flush=True)


def main():
    make.SIZE = SIZE
    base = lambda **inputs: lambda: with_inputs(matt("Ball", BASE), **inputs)
    compare("matt", base(), lambda n, v, l: np.broadcast_to(np.array(BASE) / math.pi, n.shape))
    for share, roughness in ((1.0, 0.3), (0.5, 0.5)):
        compare(f"coat {share} of roughness {roughness}", base(Coat_Weight=share, Coat_Roughness=roughness), coated(share, roughness))
    for roughness in (0.3, 0.5, 0.8):
        cloth = base(Sheen_Weight=1.0, Sheen_Roughness=roughness, Sheen_Tint=(*SHEEN, 1.0))
        compare(f"sheen of roughness {roughness}", cloth, sheened(roughness))
    for roughness, strength in ((0.4, 0.7), (0.4, 0.5)):
        metal = lambda: along_u(with_inputs(material("Ball", METAL, roughness, metallic=1.0), Anisotropic=strength))

        def as_in_file():
            made = metal()
            lobes.has_roughnesses_of_file(made)
            return made
        alpha, aspect = roughness**2, math.sqrt(1.0 - 0.9 * strength)
        compare(f"anisotropy {strength} at roughness {roughness}: Blender's α", metal, brushed(alpha / aspect, alpha * aspect))
        of_file = brushed(alpha + (1.0 - alpha) * strength**2, alpha)
        compare("    the extension's α", metal, of_file)
        compare("    the extension's α, and Cycles set to it", as_in_file, of_file)


if __name__ == "__main__":
    main()
