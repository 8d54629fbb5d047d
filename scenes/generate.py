#!/usr/bin/env python3
"""Writes weekend.ron, next-week.ron, instances.ron, lights.ron, the images under textures/ and the meshes under meshes/.

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
// The final scene of "Ray Tracing: The Next Week" (Shirley, Black, Hollasch, 2016-2024): an orange sphere that moves, a
// floor of 400 boxes, a lamp, glass, fuzzy metal, a glass sphere filled with a blue medium, a thin fog over everything, a
// made-up planet, marble, and a cube of 1000 small spheres.
//
// Written by scenes/generate.py: SplitMix64, seed {seed}, uniforms of 53 bits; first the height of every box within 1 .. 101,
// by x and in it by z, then the centres of the small spheres within 0 .. 165.
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
    camera: (look_from: (478, 278, -600), look_at: (278, 278, 0), vertical_fov: 40, shutter: (0, 1)),
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
        Moving(
            keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((30, 0, 0))])],
            object: Sphere(center: (400, 400, 200), radius: 50, material: "orange"),
        ),
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


def tiles(count=12, side=32):
    """A normal map of square tiles with bevelled edges. Red points right, green up."""
    steps = 3
    slopes = [(0, 0)] + [(x * k, y * k) for k in range(1, steps + 1) for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1))]

    def colour(slope):
        x, y = (0.35 * part for part in slope)
        length = math.sqrt(x * x + y * y + 1.0)
        return [round(127.5 * (part / length + 1.0)) for part in (x, y, 1.0)]

    def index(column, row):
        x, y = column % side, row % side
        # The distances from the edges: left, right, bottom, top. The image's first row is its top.
        distances = [x, side - 1 - x, side - 1 - y, y]
        nearest = min(range(4), key=lambda edge: distances[edge])
        steepness = steps - distances[nearest]
        return 1 + 4 * (steepness - 1) + nearest if steepness > 0 else 0

    size = count * side
    return png(size, size, [colour(slope) for slope in slopes], [[index(c, r) for c in range(size)] for r in range(size)])


def wear(size=192, seed=5):
    """Blotches in greys, as of a floor that is worn: for a roughness. It repeats."""
    def grey(column, row):
        around, along = 2.0 * math.pi * column / size, 2.0 * math.pi * row / size
        point = (2.2 * math.cos(around), 2.2 * math.sin(around) + 1.7 * math.cos(along), 1.7 * math.sin(along))
        return max(0, min(63, round(63 * (0.5 + 1.6 * (fractal_noise(*point, 5, seed) - 0.5)))))

    greys = [[round(255 * i / 63)] * 3 for i in range(64)]
    return png(size, size, greys, [[grey(column, row) for column in range(size)] for row in range(size)])


# --- meshes -----------------------------------------------------------------------------------------------------------


def add(a, b, t=1.0):
    return [p + t * q for p, q in zip(a, b)]


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(dot(a, a))
    return [p / length for p in a]


def ply(vertices, triangles, properties="x y z"):
    """A binary PLY; `vertices` hold the values of the properties."""
    assert len(vertices) < 1 << 16
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {name}" for name in properties.split()]
    head += [f"element face {len(triangles)}", "property list uchar ushort vertex_indices", "end_header\n"]
    count = len(properties.split())
    return (
        "\n".join(head).encode()
        + b"".join(struct.pack(f"<{count}f", *vertex) for vertex in vertices)
        + b"".join(struct.pack("<B3H", 3, *triangle) for triangle in triangles)
    )


def volume(vertices, triangles):
    """Of a closed mesh; positive where its outside is where the winding is counter-clockwise."""
    return sum(dot(vertices[a][:3], cross(vertices[b][:3], vertices[c][:3])) for a, b, c in triangles) / 6.0


def ring_triangles(rows, columns):
    """Of a closed tube of `rows` rings of `columns` vertices."""
    out = []
    for i in range(rows):
        for j in range(columns):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            c, d = (i + 1) % rows * columns + j, (i + 1) % rows * columns + (j + 1) % columns
            out += [(a, b, d), (a, d, c)]
    return out


def knot(rows=400, columns=28, thickness=0.42):
    """A trefoil on a torus of radii 2 and 0.8, a round tube with exact normals; it stands on y = 0, its axis along z."""

    def curve(t):
        ring = 2.0 + 0.8 * math.cos(3.0 * t)
        return [ring * math.cos(2.0 * t), ring * math.sin(2.0 * t), 0.8 * math.sin(3.0 * t)]

    vertices = []
    for i in range(rows):
        t = 2.0 * math.pi * i / rows
        centre, ring = curve(t), 2.0 + 0.8 * math.cos(3.0 * t)
        slope = -2.4 * math.sin(3.0 * t)
        c, s = math.cos(2.0 * t), math.sin(2.0 * t)
        tangent = unit([slope * c - 2.0 * ring * s, slope * s + 2.0 * ring * c, 2.4 * math.cos(3.0 * t)])
        # The torus' normal, which is at right angles to every curve on it.
        a = [math.cos(3.0 * t) * c, math.cos(3.0 * t) * s, math.sin(3.0 * t)]
        b = cross(tangent, a)
        for j in range(columns):
            angle = 2.0 * math.pi * j / columns
            normal = add([math.cos(angle) * p for p in a], b, math.sin(angle))
            vertices.append(add(centre, normal, thickness) + normal)
    low = min(vertex[1] for vertex in vertices)
    for vertex in vertices:
        vertex[1] -= low
    triangles = ring_triangles(rows, columns)
    assert volume(vertices, triangles) > 0.0
    return ply(vertices, triangles, "x y z nx ny nz")


def star():
    """A small stellated dodecahedron of circumradius 1 around the origin, turned to stand on three of its tips."""
    golden = (1.0 + math.sqrt(5.0)) / 2.0
    tips = []
    for p in (-1.0, 1.0):
        for q in (-golden, golden):
            tips += [unit(v) for v in ([0.0, p, q], [p, q, 0.0], [q, 0.0, p])]
    edge = min(math.dist(tips[0], tip) for tip in tips[1:]) * 1.001
    near = [[math.dist(a, b) < edge for b in tips] for a in tips]
    first = next((i, j) for i in range(1, 12) for j in range(i) if near[0][i] and near[0][j] and near[i][j])
    y = unit(add(add(tips[0], tips[first[0]]), tips[first[1]]))
    x = unit(add(tips[0], y, -dot(tips[0], y)))
    z = cross(x, y)
    tips = [[dot(tip, x), dot(tip, y), dot(tip, z)] for tip in tips]
    vertices, corners = list(tips), []
    for i in range(12):
        for j in range(i):
            for k in range(j):
                if near[i][j] and near[j][k] and near[i][k]:
                    # A corner of the dodecahedron within: 1.4013 edges from the middle where the tips are 2.4899.
                    middle = unit(add(add(tips[i], tips[j]), tips[k]))
                    corners.append((i, j, k))
                    vertices.append([0.562793 * p for p in middle])
    triangles = []
    for tip in range(12):
        around = [n for n, corner in enumerate(corners) if tip in corner]
        for m in around:
            for n in around:
                # Two corners of a pyramid's base that share an edge of it.
                if m < n and len(set(corners[m]) & set(corners[n])) == 2:
                    a, b, c = tip, 12 + m, 12 + n
                    outward = dot(cross(add(vertices[b], vertices[a], -1), add(vertices[c], vertices[a], -1)), vertices[b])
                    triangles.append((a, b, c) if outward > 0.0 else (a, c, b))
    assert (len(vertices), len(triangles)) == (32, 60) and volume(vertices, triangles) > 0.0
    return ply(vertices, triangles)


# From the middle of the foot up the outside, over the lip and down the inside: radius and height.
AMPHORA = [
    (0.0, 0.0), (0.46, 0.0), (0.50, 0.03), (0.47, 0.09), (0.26, 0.17), (0.24, 0.22), (0.40, 0.42), (0.66, 0.80), (0.85, 1.20),
    (0.90, 1.55), (0.82, 1.90), (0.58, 2.18), (0.38, 2.34), (0.31, 2.50), (0.30, 2.75), (0.33, 2.95), (0.44, 3.06), (0.46, 3.12),
    (0.42, 3.16), (0.34, 3.10), (0.25, 2.92), (0.23, 2.50), (0.30, 2.30), (0.60, 2.00), (0.80, 1.55), (0.62, 0.90), (0.30, 0.45),
    (0.0, 0.36),
]  # fmt: skip


def smooth_curve(points, steps):
    """Catmull and Rom's spline through points of any dimension; with its derivatives."""
    out = []
    for i in range(len(points) - 1):
        before, a, b, after = (points[min(max(k, 0), len(points) - 1)] for k in (i - 1, i, i + 1, i + 2))
        into, out_of = ([0.5 * (q - p) for p, q in zip(*pair)] for pair in ((before, b), (a, after)))
        for step in range(steps + (i == len(points) - 2)):
            t = step / steps
            h = (2 * t**3 - 3 * t**2 + 1, t**3 - 2 * t**2 + t, 3 * t**2 - 2 * t**3, t**3 - t**2)
            d = (6 * t * t - 6 * t, 3 * t * t - 4 * t + 1, 6 * t - 6 * t * t, 3 * t * t - 2 * t)
            at, slope = ([sum(w * p[k] for w, p in zip(ws, (a, into, b, out_of))) for k in range(len(a))] for ws in (h, d))
            out.append((at, slope))
    return out


def amphora(columns=64, steps=3):
    """A turned vessel with two handles, as an OBJ with normals and texture coordinates: u once around, from behind; v from
    the foot, 0, to the lip, 0.95; what is above has one colour."""
    text = ["# Written by scenes/generate.py: amphora.", "s 1"]
    faces, count = [], 0

    def vertex(position, normal, uv):
        nonlocal count
        text.append("v {:.4f} {:.4f} {:.4f}".format(*position))
        text.append("vt {:.4f} {:.4f}".format(*uv))
        text.append("vn {:.3f} {:.3f} {:.3f}".format(*normal))
        count += 1
        return count

    def surface(rows):
        for low, high in zip(rows, rows[1:]):
            for j in range(len(low) - 1):
                corners = [low[j], low[j + 1], high[j + 1], high[j]]
                # On the axis all positions are one.
                if low[j] in pole:
                    corners.pop(0)
                elif high[j] in pole:
                    corners.pop(3)
                faces.append("f " + " ".join(f"{n}/{n}/{n}" for n in corners))

    rows, pole = [], set()
    for (radius, height), (across, up) in smooth_curve(AMPHORA, steps):
        outside = len(rows) <= 17 * steps
        length = math.hypot(across, up)
        row = []
        for j in range(columns + 1):
            angle = 2.0 * math.pi * (j % columns) / columns
            c, s = math.cos(angle), math.sin(angle)
            # The texture's middle faces +z.
            row.append(vertex(
                [-radius * s, height, -radius * c],
                [-up * s / length, -across / length, -up * c / length],
                (j / columns, 0.95 * height / 3.12 if outside else 0.98),
            ))  # fmt: skip
        if radius < 1e-9:
            pole.update(row)
        rows.append(row)
    surface(rows)
    for side in (-1.0, 1.0):
        path = [(0.28, 2.86), (0.46, 2.93), (0.66, 2.86), (0.76, 2.62), (0.74, 2.30), (0.66, 2.02)]
        rows = []
        for (across, height), (da, dh) in smooth_curve(path, 4):
            length, row = math.hypot(da, dh), []
            for j in range(13):
                angle = 2.0 * math.pi * (j % 12) / 12
                c, s = 0.085 * math.cos(angle), 0.055 * math.sin(angle)
                # Flattened: wider along z.
                n = unit([-s / 0.055**2 * dh / length, s / 0.055**2 * da / length, c / 0.085**2])
                row.append(vertex(
                    [side * (across - s * dh / length), height + s * da / length, side * c],
                    [side * n[0], n[1], side * n[2]],
                    (0.5, 0.98),
                ))  # fmt: skip
            rows.append(row)
        surface(rows)
    return ("\n".join(text + faces) + "\n").encode()


def amphora_image(width=1024, height=256):
    """What is painted on the amphora: bands, rays, a meander and waves, black on clay."""
    clay, black, red = (188, 98, 54), (30, 25, 24), (132, 42, 30)
    key = ["1111111.", "1.....1.", "1.111.1.", "1.1.1.1.", "1.1...1.", "1.11111.", "1.......", "11111111"]

    def within(v, low, high):
        return (v - low) / (high - low) if low <= v < high else None

    def at(column, row):
        u, v = (column + 0.5) / width, 1.0 - (row + 0.5) / height
        t = within(v, 0.075, 0.20)
        if t is not None:
            # Rays that rise from the foot.
            return int(abs(24.0 * u % 1.0 - 0.5) < 0.46 * (1.0 - t))
        t = within(v, 0.25, 0.33)
        if t is not None:
            # Waves: circles that run into each other.
            x = 28.0 * u % 1.0
            return int(t < 0.15 or math.hypot(x - 0.5, 0.8 * (t - 0.15)) < 0.42 and math.hypot(x - 0.66, 0.8 * (t - 0.32)) > 0.26)
        t = within(v, 0.385, 0.545)
        if t is not None:
            return int(key[min(7, int(8 * (1.0 - t)))][int(8 * 20 * u) % 8] == "1")
        t = within(v, 0.60, 0.68)
        if t is not None:
            # Tongues at the shoulder.
            x = abs(36.0 * u % 1.0 - 0.5)
            return 2 * int(x < 0.30 and t > 0.3 or math.hypot(x, 1.5 * (t - 0.3)) < 0.30)
        t = within(v, 0.77, 0.86)
        if t is not None:
            # A zigzag on the neck.
            return int(abs(abs(2.0 * (12.0 * u % 1.0) - 1.0) - t) < 0.25)
        for low, high in ((0.0, 0.06), (0.205, 0.235), (0.345, 0.365), (0.565, 0.58), (0.70, 0.745), (0.88, 1.01)):
            if low <= v < high:
                return 1
        return 0

    return png(width, height, [clay, black, red], [[at(x, y) for x in range(width)] for y in range(height)])


# --- instances.ron ----------------------------------------------------------------------------------------------------

FOREST_SEED = 1854
FOREST_HEAD = """\
// A forest around a lake: {count} trees, instances of two meshes that are stored once, on a hill that is a third, under
// the light of textures/sky.hdr.
//
// Written by scenes/generate.py: SplitMix64, seed {seed}.
"""


def ground(x, z):
    """The hill's height: below 0 in the lake."""
    away = math.hypot((x - 4.0) / 30.0, (z - 12.0) / 17.0)
    rise = min(max((away - 0.75) / 2.6, 0.0), 1.0)
    back = min(max((10.0 - z) / 90.0, 0.0), 1.0)
    rough = fractal_noise(x / 22.0 + 50, 0.5, z / 22.0 + 50, 4, FOREST_SEED) - 0.45
    shore = min(max((away - 0.8) * 3.0, -1.0), 0.25)
    return shore + (3.0 + 15.0 * back) * rise * rise * (3.0 - 2.0 * rise) + 7.0 * rough * min(rise * 3.0, 1.0)


def hill(across=150.0, near=62.0, far=-98.0, columns=112, rows=120):
    """The ground, with normals; the texture coordinates are those of a colour in textures/foliage.png."""
    vertices = []
    for i in range(rows + 1):
        for j in range(columns + 1):
            x, z = across * (j / columns - 0.5), near + (far - near) * i / rows
            y = ground(x, z)
            slope = [(ground(x + dx, z + dz) - ground(x - dx, z - dz)) / 0.8 for dx, dz in ((0.4, 0.0), (0.0, 0.4))]
            tone = 0.1 + 0.8 * fractal_noise(x / 6.0 + 9, 0.5, z / 6.0 + 9, 3, FOREST_SEED + 9)
            vertices.append([x, y, z] + unit([-slope[0], 1.0, -slope[1]]) + [tone, TONES["ground"]])
    stride = columns + 1
    triangles = []
    for i in range(rows):
        for j in range(columns):
            a = i * stride + j
            triangles += [(a, a + 1, a + stride + 1), (a, a + stride + 1, a + stride)]
    return ply(vertices, triangles, "x y z nx ny nz u v")


# Rows of textures/foliage.png, by the v of their middle, and their colours from u = 0 to 1.
FOLIAGE = {
    "ground": ((82, 92, 48), (124, 122, 68), (160, 146, 92)),
    "needles": ((38, 68, 46), (70, 112, 64), (120, 150, 80)),
    "leaves": ((168, 86, 34), (214, 152, 52), (232, 200, 96)),
    "bark": ((46, 34, 26), (84, 66, 52), (206, 200, 190)),
}
TONES = {name: 1.0 - (row + 0.5) / len(FOLIAGE) for row, name in enumerate(FOLIAGE)}


def foliage():
    """Bands of colour, wide enough that none bleeds into the next."""
    steps, rows = 32, []
    palette = []
    for low, middle, high in FOLIAGE.values():
        first = len(palette)
        for i in range(steps):
            t = 2.0 * i / (steps - 1)
            a, b = (low, middle) if t < 1.0 else (middle, high)
            palette.append(tuple(round(p + (q - p) * (t % 1.0 if t < 2.0 else 1.0)) for p, q in zip(a, b)))
        rows += [[first + i for i in range(steps)]] * 4
    return png(steps, len(rows), palette, rows)


def stem(height, radius, tone, columns=7, rows=5):
    """The vertices and triangles of a tapering stem, from a little below the ground."""
    vertices, triangles = [], []
    for i in range(rows):
        t = i / (rows - 1)
        for j in range(columns):
            angle = 2.0 * math.pi * j / columns
            r = radius * (1.0 - 0.93 * t)
            vertices.append([r * math.cos(angle), -0.4 + (height + 0.4) * t, r * math.sin(angle), tone, TONES["bark"]])
    for i in range(rows - 1):
        for j in range(columns):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            triangles += [(a, b + columns, b), (a, a + columns, b + columns)]
    return vertices, triangles


def fir():
    """A fir 5 units high: whorls of boughs, each a bent strip with ragged edges that hang down."""
    random = Random(FOREST_SEED + 1)
    vertices, triangles = stem(4.9, 0.11, 0.35)
    whorls = 25
    for whorl in range(whorls):
        t = whorl / (whorls - 1)
        boughs = round(11 - 5 * t)
        turn = random(0.0, 2.0 * math.pi)
        for bough in range(boughs):
            angle = turn + 2.0 * math.pi * (bough + random(-0.25, 0.25)) / boughs
            length = (1.35 * (1.0 - t) ** 0.85 + 0.10) * random(0.8, 1.12)
            base = 0.55 + 4.35 * t + random(-0.05, 0.05)
            droop = random(0.35, 0.6) - 0.75 * t
            out, side = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
            tone, first, steps = random(0.05, 0.6), len(vertices), 4
            for i in range(steps):
                f = i / (steps - 1)
                width = 0.30 * length * (1.0 - f) ** 0.7 * (0.6 if i == 0 else 1.0) + 0.01
                y = base - droop * length * f + 0.22 * length * f * f
                for across in (-1.0, 0.0, 1.0):
                    ragged = width * across * random(0.7, 1.25)
                    along = length * f + (0.12 * length * random() if across else 0.0)
                    vertices.append([
                        along * out[0] + ragged * side[0], y - 0.45 * abs(ragged), along * out[1] + ragged * side[1],
                        min(tone + 0.4 * f, 0.97), TONES["needles"],
                    ])  # fmt: skip
            for i in range(steps - 1):
                for k in range(2):
                    a = first + 3 * i + k
                    triangles += [(a, a + 1, a + 4), (a, a + 4, a + 3)]
    return ply(vertices, triangles, "x y z u v")


def birch():
    """A birch 4.5 units high in autumn: a crown of 1100 leaves, each two triangles, larger than life."""
    random = Random(FOREST_SEED + 2)
    vertices, triangles = stem(4.0, 0.07, 0.93)
    for _ in range(1100):
        while True:
            p = [random(-1.0, 1.0) for _ in range(3)]
            if 0.2 < dot(p, p) < 1.0:
                break
        # Clumps: leaves are drawn towards the points of a lattice.
        p = [q + 0.10 * math.sin(9.0 * q + 2.0 * k) for k, q in enumerate(p)]
        slim = 1.0 - 0.35 * p[1]
        centre = [1.05 * p[0] * slim, 2.85 + 1.65 * p[1], 1.05 * p[2] * slim]
        a = unit([random(-1.0, 1.0), random(-1.2, 0.2), random(-1.0, 1.0)])
        b = unit(cross(a, [random(-1.0, 1.0), random(-1.0, 1.0), random(-1.0, 1.0)]))
        size, tone, first = random(0.08, 0.15), min(max(0.5 + 0.25 * p[1] + random(-0.3, 0.3), 0.03), 0.97), len(vertices)
        for s, t in ((-1.0, 0.0), (0.0, -0.6), (1.1, 0.0), (0.0, 0.6)):
            vertices.append(add(add(centre, a, s * size), b, t * size) + [tone, TONES["leaves"]])
        triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return ply(vertices, triangles, "x y z u v")


def forest():
    random = Random(FOREST_SEED)
    trees, cells = [], {}
    for _ in range(60000):
        if len(trees) == 2050:
            break
        x, z = round(random(-62.0, 62.0), 1), round(random(-92.0, 44.0), 1)
        y = ground(x, z) - 0.05
        # Nothing in the lake, nor between it and the camera, nor where the camera does not see it.
        if z > 18.0 and abs(x) < 4.0 + 0.25 * (58.0 - z) or z > 40.0:
            continue
        wood = fractal_noise(x / 14.0 + 70, 0.5, z / 14.0 + 70, 3, FOREST_SEED + 3)
        if y < 0.25 or wood < 0.40 or abs(x) > 14.0 + 0.5 * (58.0 - z):
            continue
        cell = math.floor(x / 2.0), math.floor(z / 2.0)
        near = [other for i in (-1, 0, 1) for j in (-1, 0, 1) for other in cells.get((cell[0] + i, cell[1] + j), [])]
        if any(math.dist((x, z), other) < 1.5 for other in near):
            continue
        cells.setdefault(cell, []).append((x, z))
        kind = "birch" if random() < (0.75 if y < 2.2 else 0.45 if wood > 0.56 else 0.05) else "fir"
        size = random(0.55, 1.0) if kind == "birch" else random(0.5, 1.25)
        trees.append(
            f"Transformed(by: [Scale({size:.2f}), RotateY({random(0.0, 360.0):.0f}), Translate(({x:g}, {y:.2f}, {z:g}))], "
            f'object: Mesh(path: "meshes/{kind}.ply", material: "tree")),'
        )
    return (
        FOREST_HEAD.format(seed=FOREST_SEED, count=len(trees))
        + """\
Scene(
    image: (width: 960, height: 540),
    camera: (look_from: (0, 10.5, 60), look_at: (0, 4.8, 0), vertical_fov: 30),
    background: Image(path: "textures/sky.hdr"),
    materials: {
        "tree": Lambertian(albedo: Image(path: "textures/foliage.png")),
        "water": Metal(albedo: Rgb(0.42, 0.50, 0.54), fuzz: 0.02),
    },
    objects: [
        Mesh(path: "meshes/hill.ply", material: "tree"),
        Quad(corner: (-60, 0, 40), u: (120, 0, 0), v: (0, 0, -60), material: "water"),
"""
        + "".join(f"        {tree}\n" for tree in trees)
        + """\
    ],
    render: (samples: 500, max_depth: 30),
)
"""
    ).encode()

# --- the cloud --------------------------------------------------------------------------------------------------------

CLOUD_SEED = 1802
CLOUD_SIDE = 128
CLOUD_VOXEL = 1.0 / 64.0
# Centres and radii of the large heaps; smaller ones grow on their upper sides.
CLOUD_HEAPS = (
    (0.00, -0.12, 0.00, 0.42), (-0.40, -0.14, 0.08, 0.35), (0.44, -0.10, -0.06, 0.34), (0.17, 0.16, 0.04, 0.33),
    (-0.20, 0.10, -0.10, 0.34), (0.12, -0.22, 0.29, 0.30), (-0.10, -0.20, -0.31, 0.30), (0.72, -0.27, 0.06, 0.20),
    (-0.72, -0.28, 0.00, 0.21), (0.24, 0.36, 0.00, 0.24), (-0.14, 0.30, 0.05, 0.20), (0.44, 0.14, 0.10, 0.20),
)  # fmt: skip


def cloud_heaps():
    """The spheres of the cloud: the large heaps, and two generations of smaller ones on them."""
    random = Random(CLOUD_SEED)
    spheres, parents = [], list(CLOUD_HEAPS)
    for count in (9, 4):
        spheres += parents
        children = []
        for x, y, z, radius in parents:
            for _ in range(count):
                out = unit([random(-1.0, 1.0), random(-0.35, 1.0), random(-1.0, 1.0)])
                part = random(0.28, 0.5)
                children.append((*add([x, y, z], out, (1.0 - 0.35 * part) * radius), part * radius))
        parents = children
    return spheres + parents


def cloud_depths():
    """How deep each voxel is in the spheres, below 0 outside: rows of z, by x and y."""
    side, voxel, margin = CLOUD_SIDE, CLOUD_VOXEL, 0.12
    rows = [[[-1.0] * side for _ in range(side)] for _ in range(side)]
    for *centre, radius in cloud_heaps():
        reach = radius + margin
        lows = [max(math.ceil((c - reach) / voxel) + side // 2, 0) for c in centre]
        highs = [min(math.floor((c + reach) / voxel) + side // 2 + 1, side) for c in centre]
        along = [[((i - side // 2) * voxel - c) ** 2 for i in range(low, high)] for c, low, high in zip(centre, lows, highs)]
        for x, xx in enumerate(along[0], lows[0]):
            for y, yy in enumerate(along[1], lows[1]):
                if xx + yy < reach * reach:
                    row, r, c = rows[x][y], xx + yy, slice(lows[2], highs[2])
                    row[c] = [max(a, radius - math.sqrt(r + zz)) for a, zz in zip(row[c], along[2])]
    return rows


def gradients(cells, seed):
    """A gradient for each corner of a lattice of so many cells along an edge."""
    random = Random(seed)
    return [[[[random(-1.0, 1.0) for _ in range(3)] for _ in range(cells + 1)] for _ in range(cells + 1)] for _ in range(cells + 1)]


def gradient_noise_row(lattice, x, y, steps):
    """Perlin's noise along z, at cells (x, y) of a lattice. `steps` are the cell, the place in it and its weight for each sample."""
    i, j = int(x), int(y)
    u, v = x - i, y - j
    a, b = (t * t * t * (t * (6.0 * t - 15.0) + 10.0) for t in (u, v))
    corners = [
        (lattice[i + p][j + q], u - p, v - q, (a if p else 1.0 - a) * (b if q else 1.0 - b)) for p in (0, 1) for q in (0, 1)
    ]
    across, slopes = [], []
    for k in range(len(lattice)):
        across.append(sum(w * (g[k][0] * s + g[k][1] * t) for g, s, t, w in corners))
        slopes.append(sum(w * g[k][2] for g, _, _, w in corners))
    return [
        (1.0 - w) * (across[k] + slopes[k] * z) + w * (across[k + 1] + slopes[k + 1] * (z - 1.0)) for k, z, w in steps
    ]


def cloud_densities():
    """Densities from 0 to 1: the depth in the spheres, which billows move in and out, and a flat base."""
    side, voxel = CLOUD_SIDE, CLOUD_VOXEL
    depths = cloud_depths()
    octaves = []
    for octave, (cells, amplitude) in enumerate(((9, 0.10), (19, 0.055), (37, 0.022))):
        steps = []
        for z in range(side):
            at = (z + 0.5) * cells / side
            t = at - int(at)
            steps.append((int(at), t, t * t * t * (t * (6.0 * t - 15.0) + 10.0)))
        octaves.append((gradients(cells, CLOUD_SEED + 1 + octave), cells / side, amplitude, steps))
    for x in range(side):
        for y in range(side):
            row = depths[x][y]
            if max(row) < -0.12:
                depths[x][y] = None
                continue
            for lattice, scale, amplitude, steps in octaves:
                noise = gradient_noise_row(lattice, (x + 0.5) * scale, (y + 0.5) * scale, steps)
                # Round outwards and sharp inwards.
                row = [depth + amplitude * (2.5 * abs(n) - 0.5) for depth, n in zip(row, noise)]
            base = 0.6 * ((y - side // 2) * voxel + 0.42)
            ramp = [min(max(min(depth, base + 0.2 * depth) / 0.09, 0.0), 1.0) for depth in row]
            depths[x][y] = [round(256.0 * t * t * (3.0 - 2.0 * t)) / 256.0 for t in ramp]
    return depths


def vdb_text(text):
    return struct.pack("<I", len(text)) + text.encode()


def vdb_values(values):
    """The bytes of halves, zipped if that makes them smaller."""
    if not values:
        return b""
    data = struct.pack(f"<{len(values)}e", *values)
    small = zlib.compress(data, 9)
    return struct.pack("<q", len(small)) + small if len(small) < len(data) else struct.pack("<q", -len(data)) + data


def vdb_mask(bits, count):
    return sum(1 << bit for bit in bits).to_bytes(count // 8, "little")


def cloud():
    """An OpenVDB file of version 224, zipped, of halves: a root, one node of nodes, one node of leaves, and the leaves that are not empty."""
    rows = cloud_densities()
    leaves, children, voxels = [], [], []
    for place in range(16**3):
        corner = [8 * (place >> shift & 15) for shift in (8, 4, 0)]
        block = [rows[corner[0] + i][corner[1] + j] for i in range(8) for j in range(8)]
        values = [value for row in block for value in (row[corner[2] : corner[2] + 8] if row else [0.0] * 8)]
        active = [i for i, value in enumerate(values) if value > 0.0]
        if active:
            children.append(place)
            leaves.append((vdb_mask(active, 512), vdb_values([values[i] for i in active])))
            voxels += [[c + (i >> s & 7) for c, s in zip(corner, (6, 3, 0))] for i in active]
    middle = [0.5 * (min(axis) + max(axis)) for axis in zip(*voxels)]
    scale = [CLOUD_VOXEL] * 6 + [1.0 / CLOUD_VOXEL] * 3 + [CLOUD_VOXEL**-2] * 3 + [0.5 / CLOUD_VOXEL] * 3
    tree = struct.pack("<ifII3i", 1, 0.0, 0, 1, 0, 0, 0)
    for place, count in (([0], 32**3), (children, 16**3)):
        # No tile is active, so that no value of one is stored.
        tree += vdb_mask(place, count) + vdb_mask([], count) + b"\0"
    tree += b"".join(mask for mask, _ in leaves) + b"".join(mask + b"\0" + values for mask, values in leaves)
    facts = {"class": ("string", b"fog volume"), "is_saved_as_half_float": ("bool", b"\1"), "name": ("string", b"density")}
    grid = struct.pack("<II", 3, len(facts))
    for name, (kind, value) in facts.items():
        grid += vdb_text(name) + vdb_text(kind) + struct.pack("<I", len(value)) + value
    blocks = vdb_text("UniformScaleTranslateMap") + struct.pack("<18d", *[-CLOUD_VOXEL * m for m in middle], *scale)
    head = b" BDV\0\0\0\0" + struct.pack("<IIIB", 224, 12, 0, 1) + b"00000000-0000-0000-0000-000000000000"
    head += struct.pack("<II", 0, 1) + vdb_text("density") + vdb_text("Tree_float_5_4_3_HalfFloat") + vdb_text("")
    start, end = len(head) + 24, len(head) + 24 + len(grid) + len(blocks) + len(tree)
    leaf_bytes = sum(len(mask) + 1 + len(values) for mask, values in leaves)
    return head + struct.pack("<3q", start, end - leaf_bytes, end) + grid + blocks + tree


# --- lights.ron -------------------------------------------------------------------------------------------------------

LIGHTS_SEED = 1895
LIGHTS_HEAD = """\
// A canal on the night of a feast: {lanterns} paper lanterns on strings across it, {floating} afloat, and {windows} lit windows; {lamps} lamps
// in all, each of which lights what is near it.
//
// Written by scenes/generate.py: SplitMix64, seed {seed}.
"""


def canal():
    random = Random(LIGHTS_SEED)
    houses, lanterns, floating, windows = [], [], [], []
    walls = ["ochre", "rose", "cream", "brick", "sage"]

    def pick(items):
        return items[min(int(random() * len(items)), len(items) - 1)]

    for side in (-1.0, 1.0):
        z, last = 9.0, None
        while z > -62.0:
            width, height, depth = random(4.0, 6.5), random(6.0, 10.5), random(0.0, 0.5)
            wall = pick([name for name in walls if name != last])
            last = wall
            near, far = sorted((side * (5.6 + depth), side * 12.0))
            houses.append(f'Box(min: ({near:.2f}, 0, {z - width:.2f}), max: ({far:.2f}, {height:.2f}, {z:.2f}), material: "{wall}"),')
            # An eave that keeps the wall's top in the dark.
            eave = sorted((side * (5.25 + depth), side * 12.0))
            houses.append(
                f'Box(min: ({eave[0]:.2f}, {height:.2f}, {z - width:.2f}), max: ({eave[1]:.2f}, {height + 0.25:.2f}, {z:.2f}), '
                f'material: "slate"),'
            )
            columns, rows = max(2, round(width / 2.0)), int((height - 1.0) / 2.4)
            face = side * (5.6 + depth - 0.01)
            for row in range(rows):
                for column in range(columns):
                    at = z - width * (column + 0.5) / columns
                    lit = random() < 0.42
                    low, tall, wide = 1.1 + 2.4 * row, 1.35, 0.8
                    # The normal is towards the canal: u x v.
                    u = f"(0, 0, {side * wide:g})"
                    corner = f"({face:.2f}, {low:.2f}, {at - side * wide / 2:.2f})"
                    material = pick(["window", "window", "dim window"]) if lit else "dark window"
                    windows.append((lit, f'Quad(corner: {corner}, u: {u}, v: (0, {tall:g}, 0), material: "{material}"),'))
            z -= width

    colours = ["amber", "amber", "white", "red", "blue", "green"]
    strings = [(5.0 - 4.4 * i, random(4.6, 6.0), random(4.6, 6.0), random(-1.6, 1.6), random(0.9, 1.6)) for i in range(14)]
    for z, left, right, slant, sag in strings:
        for k in range(17):
            t = (k + 0.5) / 17
            x, along = -5.5 + 11.0 * t, 2.0 * t - 1.0
            y = left + (right - left) * t - sag * (1.0 - along * along)
            lanterns.append(f'Sphere(center: ({x:.2f}, {y:.2f}, {z + slant * along:.2f}), radius: 0.15, material: "{pick(colours)}"),')
    placed = []
    while len(floating) < 48:
        x, z = random(-3.4, 3.4), random(-48.0, 3.0)
        if all(math.dist((x, z), other) > 1.1 for other in placed):
            placed.append((x, z))
            floating.append(f'Sphere(center: ({x:.2f}, 0.07, {z:.2f}), radius: 0.13, material: "{pick(["amber", "amber", "white"])}"),')

    lit = sum(1 for window in windows if window[0])
    head = LIGHTS_HEAD.format(
        seed=LIGHTS_SEED, lanterns=len(lanterns), floating=len(floating), windows=lit, lamps=len(lanterns) + len(floating) + lit
    )

    def lines(items):
        return "".join(f"        {item}\n" for item in items)

    return (
        head
        + f"""\
Scene(
    image: (width: 960, height: 540),
    camera: (look_from: (0.9, 2.3, 11.5), look_at: (-0.3, 2.9, -14), vertical_fov: 46),
    background: Gradient(bottom: (0.020, 0.016, 0.030), top: (0.003, 0.006, 0.020)),
    materials: {{
        "ochre": Lambertian(albedo: Rgb(0.72, 0.50, 0.26)),
        "rose": Lambertian(albedo: Rgb(0.70, 0.42, 0.36)),
        "cream": Lambertian(albedo: Rgb(0.78, 0.70, 0.56)),
        "brick": Lambertian(albedo: Rgb(0.55, 0.24, 0.17)),
        "sage": Lambertian(albedo: Rgb(0.46, 0.55, 0.42)),
        "slate": Lambertian(albedo: Rgb(0.16, 0.15, 0.16)),
        "stone": Lambertian(albedo: Noise(scale: 3)),
        "water": Metal(albedo: Rgb(0.36, 0.44, 0.46), fuzz: 0.04),
        "dark window": Metal(albedo: Rgb(0.10, 0.11, 0.13)),
        "window": DiffuseLight(emit: Rgb(1.5, 0.95, 0.42), two_sided: false),
        "dim window": DiffuseLight(emit: Rgb(0.55, 0.33, 0.15), two_sided: false),
        "amber": DiffuseLight(emit: Rgb(13, 5.2, 1.1)),
        "white": DiffuseLight(emit: Rgb(9, 7, 4.4)),
        "red": DiffuseLight(emit: Rgb(12, 1.4, 0.7)),
        "blue": DiffuseLight(emit: Rgb(1.1, 3.2, 12)),
        "green": DiffuseLight(emit: Rgb(1.6, 9, 2.2)),
    }},
    objects: [
        // The water, and a quay before the houses on either side.
        Quad(corner: (-4, 0, 14), u: (8, 0, 0), v: (0, 0, -84), material: "water"),
        Box(min: (-14, -1, -70), max: (-4, 0.35, 14), material: "stone"),
        Box(min: (4, -1, -70), max: (14, 0.35, 14), material: "stone"),
{lines(houses)}{lines(window for _, window in windows)}{lines(lanterns)}{lines(floating)}    ],
    render: (samples: 500, max_depth: 20),
)
"""
    ).encode()


FILES = {
    "weekend.ron": weekend,
    "next-week.ron": next_week,
    "instances.ron": forest,
    "lights.ron": canal,
    "textures/planet.png": planet,
    "textures/world.png": world,
    "textures/sky.hdr": sky,
    "textures/tiles.png": tiles,
    "textures/wear.png": wear,
    "textures/amphora.png": amphora_image,
    "meshes/knot.ply": knot,
    "meshes/star.ply": star,
    "meshes/amphora.obj": amphora,
    "textures/foliage.png": foliage,
    "meshes/hill.ply": hill,
    "meshes/fir.ply": fir,
    "meshes/birch.ply": birch,
    "meshes/cloud.vdb": cloud,
}


def main(names):
    unknown = [name for name in names if name not in FILES]
    if unknown:
        sys.exit(f"error: {', '.join(unknown)}: expected names of {', '.join(FILES)}")
    for name in names or FILES:
        with open(os.path.join(HERE, name), "wb") as file:
            file.write(FILES[name]())


if __name__ == "__main__":
    main(sys.argv[1:])
