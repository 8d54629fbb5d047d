#!/usr/bin/env python3
"""Writes weekend.ron, next-week.ron, instances.ron, the images under textures/ and the meshes under meshes/.

    python3 scenes/generate.py [FILE ..]      # all of them, or those named as from here: textures/planet.png

Python's own library suffices. All random numbers come from SplitMix64 (Steele, Lea, Flood, "Fast Splittable
Pseudorandom Number Generators", OOPSLA 2014, figure 16) with the seed written beside its use.
"""

import math
import os
import struct
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
WORD = (1 << 64) - 1


def splitmix64(state):
    """The finaliser of SplitMix64: a hash of a 64-bit word."""
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & WORD
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & WORD
    return state ^ (state >> 31)


class Random:
    """SplitMix64; uniforms are the upper 53 bits times 2^-53."""

    def __init__(self, seed):
        self.state = seed

    def __call__(self, low=0.0, high=1.0):
        self.state = (self.state + 0x9E3779B97F4A7C15) & WORD
        return low + (high - low) * (splitmix64(self.state) >> 11) * 2.0**-53


# --- weekend.ron ------------------------------------------------------------------------------------------------------

WEEKEND_SEED = 2016
WEEKEND_HEAD = """\
// The cover scene of "Ray Tracing in One Weekend" (Shirley, Black, Hollasch, 2016-2024): 485 spheres.
//
// Written by scenes/generate.py, which says everything about it. In words: SplitMix64, seed {seed}, uniforms of 53 bits.
// For a = -11 .. 10, and in it for b = -11 .. 10, except (-4, -1), (0, -1) and (4, -1):
// 1. draw the kind k;
// 2. draw x = a + 0.9 u and z = b + 0.9 u; draw them again while the sphere overlaps one of the three large spheres or a
//    small one placed before. y puts the sphere, of radius 0.2, on the ground;
// 3. k < 0.8: Lambertian, the albedo's channels products of two uniforms; k < 0.95: metal, its albedo's channels within
//    0.5 .. 1, then its fuzz within 0 .. 0.5; else glass of index 1.5.
"""


def weekend():
    random = Random(WEEKEND_SEED)
    large = [(x, 1.0, 0.0, 1.0) for x in (-4.0, 0.0, 4.0)]
    placed, materials, objects = [], [], []

    def overlaps(x, y, z, radius):
        return any(math.dist((x, y, z), other[:3]) < radius + other[3] for other in large + placed)

    for a in range(-11, 11):
        for b in range(-11, 11):
            if b == -1 and a in (-4, 0, 4):
                continue
            kind = random()
            while True:
                x, z = round(a + 0.9 * random(), 3), round(b + 0.9 * random(), 3)
                y = round(math.sqrt(1000.2**2 - x * x - z * z) - 1000.0, 4)
                if not overlaps(x, y, z, 0.2):
                    break
            placed.append((x, y, z, 0.2))
            name = f"small {len(placed)}"
            if kind < 0.8:
                albedo = ", ".join(f"{random() * random():.3f}" for _ in range(3))
                materials.append(f'"{name}": Lambertian(albedo: Rgb({albedo})),')
            elif kind < 0.95:
                albedo = ", ".join(f"{random(0.5, 1.0):.3f}" for _ in range(3))
                materials.append(f'"{name}": Metal(albedo: Rgb({albedo}), fuzz: {random(0.0, 0.5):.3f}),')
            else:
                name = "glass"
            objects.append(f'Sphere(center: ({x:g}, {y:g}, {z:g}), radius: 0.2, material: "{name}"),')
    assert len(objects) == 481

    def lines(items):
        return "".join(f"        {item}\n" for item in items)

    return (
        WEEKEND_HEAD.format(seed=WEEKEND_SEED)
        + f"""\
Scene(
    image: (width: 1200, height: 675),
    camera: (look_from: (13, 2, 3), look_at: (0, 0, 0), vertical_fov: 20, aperture: 0.1, focus_distance: 10),
    background: Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1)),
    materials: {{
        "ground": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
        "glass": Dielectric(ior: 1.5),
        "brown": Lambertian(albedo: Rgb(0.4, 0.2, 0.1)),
        "mirror": Metal(albedo: Rgb(0.7, 0.6, 0.5), fuzz: 0),
{lines(materials)}    }},
    objects: [
        Sphere(center: (0, -1000, 0), radius: 1000, material: "ground"),
        Sphere(center: (0, 1, 0), radius: 1, material: "glass"),
        Sphere(center: (-4, 1, 0), radius: 1, material: "brown"),
        Sphere(center: (4, 1, 0), radius: 1, material: "mirror"),
{lines(objects)}    ],
    render: (samples: 500, max_depth: 50),
)
"""
    ).encode()


# --- next-week.ron ----------------------------------------------------------------------------------------------------

NEXT_WEEK_SEED = 2018
NEXT_WEEK_HEAD = """\
// The final scene of "Ray Tracing: The Next Week" (Shirley, Black, Hollasch, 2016-2024), without the motion of its orange
// sphere: a floor of 400 boxes, a lamp, glass, fuzzy metal, a glass sphere filled with a blue medium, a thin fog over
// everything, a made-up planet, marble, and a cube of 1000 small spheres.
//
// Written by scenes/generate.py: SplitMix64, seed {seed}, uniforms of 53 bits; first the height of every box within 1 .. 101,
// by x and in it by z, then the centres of the small spheres within 0 .. 165. The lamp is met by chance alone until light
// sampling is built: it takes thousands of samples.
"""


def next_week():
    random = Random(NEXT_WEEK_SEED)
    boxes = [
        f'Box(min: ({x}, 0, {z}), max: ({x + 100}, {random(1.0, 101.0):.2f}, {z + 100}), material: "ground"),'
        for x in range(-1000, 1000, 100)
        for z in range(-1000, 1000, 100)
    ]
    spheres = [
        "Sphere(center: ({:.2f}, {:.2f}, {:.2f}), radius: 10, material: \"white\"),".format(*(random(0.0, 165.0) for _ in range(3)))
        for _ in range(1000)
    ]

    def lines(items, indent):
        return "".join(" " * indent + item + "\n" for item in items)

    return (
        NEXT_WEEK_HEAD.format(seed=NEXT_WEEK_SEED)
        + f"""\
Scene(
    image: (width: 800, height: 800),
    camera: (look_from: (478, 278, -600), look_at: (278, 278, 0), vertical_fov: 40),
    background: Solid((0, 0, 0)),
    materials: {{
        "ground": Lambertian(albedo: Rgb(0.48, 0.83, 0.53)),
        "lamp": DiffuseLight(emit: Rgb(7, 7, 7)),
        "orange": Lambertian(albedo: Rgb(0.7, 0.3, 0.1)),
        "glass": Dielectric(ior: 1.5),
        "metal": Metal(albedo: Rgb(0.8, 0.8, 0.9), fuzz: 1),
        "planet": Lambertian(albedo: Image(path: "textures/world.png")),
        "marble": Lambertian(albedo: Marble(scale: 0.2)),
        "white": Lambertian(albedo: Rgb(0.73, 0.73, 0.73)),
    }},
    objects: [
        Quad(corner: (123, 554, 147), u: (300, 0, 0), v: (0, 0, 265), material: "lamp"),
        Sphere(center: (400, 400, 200), radius: 50, material: "orange"),
        Sphere(center: (260, 150, 45), radius: 50, material: "glass"),
        Sphere(center: (0, 150, 145), radius: 50, material: "metal"),
        // The medium ends where its glass does.
        Sphere(center: (360, 150, 145), radius: 70, material: "glass"),
        Medium(
            boundary: Sphere(center: (360, 150, 145), radius: 70),
            density: 0.2, albedo: Rgb(0.2, 0.4, 0.9),
        ),
        Medium(
            boundary: Sphere(center: (0, 0, 0), radius: 5000),
            density: 0.0001, albedo: Rgb(1, 1, 1),
        ),
        Sphere(center: (400, 200, 400), radius: 100, material: "planet"),
        Sphere(center: (220, 280, 300), radius: 80, material: "marble"),
        Transformed(
            by: [RotateY(15), Translate((-100, 270, 395))],
            object: Group([
{lines(spheres, 16)}            ]),
        ),
{lines(boxes, 8)}    ],
    render: (samples: 5000, max_depth: 50),
)
"""
    ).encode()


# --- images -----------------------------------------------------------------------------------------------------------


def value_noise(x, y, z, seed):
    """Smooth noise in 0..1 from hashed lattice values."""
    cx, cy, cz = math.floor(x), math.floor(y), math.floor(z)
    fx, fy, fz = x - cx, y - cy, z - cz
    fx, fy, fz = (f * f * (3.0 - 2.0 * f) for f in (fx, fy, fz))
    total = 0.0
    for corner in range(8):
        i, j, k = corner & 1, corner >> 1 & 1, corner >> 2
        key = (((cx + i) & 0xFFFF) << 32 | ((cy + j) & 0xFFFF) << 16 | ((cz + k) & 0xFFFF)) ^ seed << 48
        value = (splitmix64(key) >> 11) * 2.0**-53
        total += value * (fx if i else 1.0 - fx) * (fy if j else 1.0 - fy) * (fz if k else 1.0 - fz)
    return total


def fractal_noise(x, y, z, octaves, seed):
    total, weight, sum_of_weights = 0.0, 1.0, 0.0
    for octave in range(octaves):
        scale = 2.0**octave
        total += weight * value_noise(x * scale, y * scale, z * scale, seed + octave)
        sum_of_weights += weight
        weight *= 0.5
    return total / sum_of_weights


def png(width, height, palette, indices):
    """A palette PNG; `indices` are rows of bytes."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    rows = b"".join(b"\0" + bytes(row) for row in indices)
    colours = b"".join(bytes(colour) for colour in palette)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"PLTE", colours)
        + chunk(b"IDAT", zlib.compress(rows, 9))
        + chunk(b"IEND", b"")
    )


PLANET_SEED = 11


def planet(width=512, height=256, seed=PLANET_SEED, graticule=True):
    """A made-up planet, latitude-longitude, with a graticule every 30 degrees if asked for: the equator and the meridian in
    the middle of the image are red, so that the map's place on a sphere can be read off a picture."""
    sea = [(18 + 5 * i, 52 + 13 * i, 104 + 15 * i) for i in range(6)]
    land = [(62, 118, 58), (84, 132, 62), (118, 146, 74), (150, 146, 88), (168, 136, 94), (146, 112, 84)]
    ice, line, red = (238, 243, 247), (208, 214, 206), (206, 40, 34)
    palette = sea + land + [ice, line, red]

    def at(column, row):
        longitude = 2.0 * math.pi * ((column + 0.5) / width - 0.5)
        latitude = math.pi * (0.5 - (row + 0.5) / height)
        step, half = 30.0, 0.5 * 360.0 / width * graticule
        degrees = math.degrees(longitude), math.degrees(latitude)
        if abs(degrees[1]) < 2 * half or (abs(degrees[0]) < 2 * half / max(math.cos(latitude), 0.05) and abs(degrees[1]) < 80):
            return len(palette) - 1
        off = [abs(d - step * round(d / step)) for d in degrees]
        if off[1] < half or (off[0] < half / max(math.cos(latitude), 0.05) and abs(degrees[1]) < 80):
            return len(palette) - 2
        x, z = math.cos(latitude) * math.cos(longitude), math.cos(latitude) * math.sin(longitude)
        y = math.sin(latitude)
        height_here = fractal_noise(2.1 * x + 7, 2.1 * y + 7, 2.1 * z + 7, 5, seed) - 0.5
        if abs(y) + 0.4 * height_here > 0.93:
            return len(palette) - 3
        if height_here < 0.02:
            return max(0, min(5, int(5.999 + 28.0 * (height_here - 0.02))))
        return 6 + min(5, int(26.0 * (height_here - 0.02)))

    return png(width, height, palette, [[at(x, y) for x in range(width)] for y in range(height)])


WORLD_SEED = 23


def world():
    return planet(seed=WORLD_SEED, graticule=False)


SKY_SEED = 40


def sky(width=256, height=128):
    """A late afternoon with soft clouds, latitude-longitude, +y on top, -z in the middle: Radiance RGBE, not compressed.
    The sun is a wide glow, 32 degrees high and 110 degrees to the right of -z: small suns are found too rarely by chance."""
    azimuth, elevation = math.radians(110.0), math.radians(32.0)
    sun = (math.cos(elevation) * math.sin(azimuth), math.sin(elevation), -math.cos(elevation) * math.cos(azimuth))

    def mix(a, b, t):
        return [p + (q - p) * t for p, q in zip(a, b)]

    def radiance(column, row):
        u, down = (column + 0.5) / width, math.pi * (row + 0.5) / height
        turn = 2.0 * math.pi * (u - 0.5)
        d = (math.sin(down) * math.sin(turn), math.cos(down), -math.sin(down) * math.cos(turn))
        colour = mix((0.95, 0.72, 0.55), (0.16, 0.30, 0.62), max(d[1], 0.0) ** 0.45)
        if d[1] > 0.0:
            # A layer of clouds far above: seen at the point where the direction meets it.
            x, z = d[0] / (d[1] + 0.12), d[2] / (d[1] + 0.12)
            cloud = fractal_noise(0.9 * x + 40, 3.0, 1.6 * z + 40, 5, SKY_SEED)
            cover = min(max((cloud - 0.47) * 4.0, 0.0), 1.0) * min(d[1] * 5.0, 1.0)
            colour = mix(colour, (0.95, 0.88, 0.84), 0.85 * cover)
        else:
            colour = mix(colour, (0.20, 0.17, 0.15), min(-d[1] * 8.0, 1.0))
        away = math.degrees(math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(d, sun))))))
        glow = 11.0 * math.exp(-((away / 13.0) ** 2)) + 0.8 * math.exp(-((away / 35.0) ** 2))
        return [c + g * glow for c, g in zip(colour, (1.0, 0.86, 0.66))]

    def rgbe(colour):
        mantissa, exponent = math.frexp(max(colour))
        scale = mantissa * 256.0 / max(colour)
        return bytes([int(c * scale) for c in colour] + [exponent + 128])

    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    return header + b"".join(rgbe(radiance(x, y)) for y in range(height) for x in range(width))


FILES = {
    "weekend.ron": weekend,
    "next-week.ron": next_week,
    "textures/planet.png": planet,
    "textures/world.png": world,
    "textures/sky.hdr": sky,
}


def main(names):
    for name in names or FILES:
        with open(os.path.join(HERE, name), "wb") as file:
            file.write(FILES[name]())


if __name__ == "__main__":
    main(sys.argv[1:])
