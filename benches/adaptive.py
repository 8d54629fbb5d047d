"""What samples in proportion to the noise would gain: error² x cost of uniform over that of adaptive sampling, by simulation.

    python3 benches/adaptive.py FOLDER [--gpu-rt PROGRAM]       (needs numpy and OpenEXR)

The value of a pixel is w P + (1 - w) R: P is a pilot of 16 samples, R has m times the mean number of samples, where the map m is made of the pilot alone. The
error of both is what renders of other seeds have with that many samples, so that nothing is simulated but the choice of the counts. The cost is in seconds, of the
background and of things. Without light paths, whose number of a pixel does not depend on its samples.
FOLDER keeps the renders. Every line is a setting: how much of the pilot, the least share of samples, over how many pixels the map is smoothed.
"""

import argparse
import itertools
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR

REPOSITORY = Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 192, 108
TILES_X, TILES_Y = 4, 2
# How many renders with so many samples, each with a seed of its own. Those of 16 samples are the pilots, too.
RENDERS = {16: 8, 64: 2, 256: 1}
REQUESTS = (64, 512)
PILOT = 16
LUMINANCE = [0.2126, 0.7152, 0.0722]

SKY = 'Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1))'
KNOT = f'Transformed(by: [Scale(0.4)], object: Mesh(path: "{REPOSITORY}/scenes/meshes/knot.ply", material: "body"))'
TABLE = 'Box(min: (-3, -0.4, -2), max: (3, 0, 2), material: "table")'
LAMP = 'Quad(corner: (-1, 5, 2), u: (0, 0, -2), v: (2, 0, 0), material: "lamp")'


def scene(background, body, objects, look_from="(0, 1.9, 6.5)", look_at="(0, 1.1, 0)", fov=34):
    """Things before something smooth."""
    return f"""Scene(
    image: (width: 960, height: 540),
    camera: (look_from: {look_from}, look_at: {look_at}, vertical_fov: {fov}),
    background: {background},
    materials: {{
        "body": {body},
        "table": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
        "lamp": DiffuseLight(emit: Rgb(12, 11, 10), two_sided: false),
        "ball": DiffuseLight(emit: Rgb(12, 11, 10)),
    }},
    objects: [{", ".join(objects)}],
)"""


GLASS, CLAY = "Dielectric(ior: 1.5)", "Lambertian(albedo: Rgb(0.7, 0.5, 0.3))"
STEEL = "Metal(albedo: Rgb(0.7, 0.6, 0.5), fuzz: 0.2)"
SMOOTH = {
    "clay, sky": scene(SKY, CLAY, [KNOT]),
    "glass, sky": scene(SKY, GLASS, [KNOT]),
    "glass, sky, sun": scene(SKY, GLASS, [KNOT, TABLE, 'DirectionalLight(direction: (-1, -2, -1), irradiance: (3, 2.8, 2.5))']),
    "glass, table": scene(SKY, GLASS, [KNOT, TABLE]),
    "steel, sky": scene(SKY, STEEL, [KNOT]),
    "clay, lamp": scene("Solid((0.02, 0.02, 0.02))", CLAY, [KNOT, TABLE, LAMP]),
    "ball in a dark room": scene("Solid((0, 0, 0))", CLAY, [
        'Sphere(center: (0.5, 1, 0.3), radius: 0.1, material: "ball")', TABLE, KNOT], look_from="(0, 2.5, 9)"),
}
OTHERS = ["cornell", "cornell-smoke", "glass", "lights", "lobes", "marble", "materials", "mesh", "next-week", "sky", "weekend", "workshop"]


def read(path):
    parts = OpenEXR.File(str(path), separate_channels=True).parts
    channels = {name: channel for part in parts for name, channel in part.channels.items()}
    image = lambda prefix: np.stack([channels[prefix + c].pixels for c in "RGB"], -1).astype(np.float64)
    return parts[0].header, channels, image


def render(program, source, output, *arguments):
    if not output.exists():
        subprocess.run([program, "render", source, "-o", output, "--size", f"{WIDTH}x{HEIGHT}", "--quiet", "--no-state", "--light-paths", "off", *map(str, arguments)], check=True)
    return read(output)


def costs_of_pixels(program, source, folder, seconds, of_sky):
    """Seconds a sample of each pixel: `of_sky` where it shows the background alone; the rest of the `seconds` of the image, in proportion to the rays of its tile."""
    _, channels, _ = render(program, source, folder / "objects.exr", "--spp", 16, "--aov", "depth")
    # What misses all objects has no depth.
    sees = channels["Z"].pixels
    is_sky = ~np.isfinite(sees) | (sees <= 0) | (sees > 1e30)
    rays = np.ones((HEIGHT, WIDTH))
    width, height = WIDTH // TILES_X, HEIGHT // TILES_Y
    for y, x in itertools.product(range(TILES_Y), range(TILES_X)):
        area = np.s_[y * height:(y + 1) * height, x * width:(x + 1) * width]
        things = np.count_nonzero(~is_sky[area])
        if things:
            header, _, _ = render(program, source, folder / f"tile-{x}-{y}.exr", "--spp", 8, "--crop", f"{x * width},{y * height},{width},{height}")
            total = header["gpu-rt:rays"] / 8
            rays[area][~is_sky[area]] = max(1, (total - (width * height - things)) / things)
    things = rays[~is_sky].sum()
    return np.where(is_sky, of_sky, max(0, seconds - of_sky * np.count_nonzero(is_sky)) / max(things, 1) * rays)


def smooth(values, radius):
    """The mean over a square."""
    padded = np.pad(values, radius, mode="edge")
    size = 2 * radius + 1
    sums = np.pad(padded.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    return np.maximum(0, sums[size:, size:] - sums[:-size, size:] - sums[size:, :-size] + sums[:-size, :-size]) / size**2


def counts(mean, variance, pairs, least, radius):
    """Pairs of runs of each pixel: in steps of powers of two, `pairs` on the mean."""
    luminance = mean @ LUMINANCE
    noise = (variance / (mean**2 + 0.01 * luminance.mean() ** 2)).sum(-1)
    deviation = np.sqrt(smooth(noise, radius))
    exponent = np.log2(np.maximum(deviation, 1e-9 * deviation.max() + 1e-30))

    def at(offset):
        return np.ceil(2.0 ** np.clip(np.round(exponent + offset), np.log2(least), 4) * pairs)

    low, high = -exponent.max() - 20, 6 - exponent.min()
    while high - low > 1e-3:
        middle = (low + high) / 2
        low, high = (middle, high) if at(middle).mean() < pairs else (low, middle)
    return at(low)


def judge(renders, costs, setting):
    """Error² x cost of uniform over adaptive, the mean over all pilots."""
    share, least, radius = setting
    gains = {}
    for request in REQUESTS:
        weight = share * 64 / request if request > 64 else share
        pairs = request // PILOT - 1
        target = renders["mean"] ** 2 + 0.01 * renders["luminance"] ** 2
        uniform = (renders["error"](np.full(costs.shape, float(request))) / target).mean() * request * costs.mean()
        ratios = []
        for mean, variance in renders["pilots"]:
            n = counts(mean, variance, pairs, least, radius)
            error = weight**2 * renders["error"](np.full(costs.shape, 16.0)) + (1 - weight) ** 2 * renders["error"](n * PILOT)
            ratios.append(uniform / ((error / target).mean() * ((n * PILOT + PILOT) * costs).mean()))
        gains[request] = np.mean(ratios)
    return gains


def errors(variances):
    """The error² of a pixel with n samples, from what renders of few, more and many samples have. Where a pixel is as good as free of noise at one of them, so it is between."""
    points = sorted(variances)
    logs = {n: np.log(np.stack([smooth(v[..., c], 1) for c in range(3)], -1) + 1e-30) for n, v in variances.items()}

    def error(n):
        at = np.log(n)[..., None]
        values = np.empty(logs[points[0]].shape)
        for a, b in zip(points, points[1:]):
            within = (n >= a) & ((n < b) | (b == points[-1]))
            slope = np.clip((logs[b] - logs[a]) / np.log(b / a), -3, 0)
            values[within] = (logs[a] + slope * (at - np.log(a)))[within]
        return np.exp(values)

    return error


def seconds_of(program, source, folder):
    """Seconds a sample of the whole image: the least of three renders, which need a machine that does nothing else."""
    headers = [render(program, source, folder / f"time-{number}.exr", "--spp", 64)[0] for number in range(3)]
    return min(header["gpu-rt:seconds_render"][0] for header in headers) / 64


def prepare(program, source, folder):
    folder.mkdir(parents=True, exist_ok=True)
    seeds = itertools.count()
    means, variances, pilots = [], {}, []
    for samples, number in RENDERS.items():
        squares = []
        for _ in range(number):
            seed = next(seeds)
            _, _, image = render(program, source, folder / f"{samples}-{seed}.exr", "--spp", samples, "--seed", seed)
            means.append((image(""), samples))
            squares.append(image("variance."))
            if samples == PILOT:
                pilots.append((image(""), image("variance.")))
        variances[samples] = np.mean(squares, 0)
    mean = sum(m * n for m, n in means) / sum(n for _, n in means)
    return {"mean": mean, "luminance": (mean @ LUMINANCE).mean(), "error": errors(variances), "pilots": pilots[:4], "variances": variances}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--gpu-rt", default="gpu-rt")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    scenes = {}
    for name, text in SMOOTH.items():
        scenes[name] = options.folder / f"{name.replace(', ', '-').replace(' ', '-')}.ron"
        scenes[name].write_text(text)
    for name in OTHERS:
        scenes[name] = REPOSITORY / "scenes" / f"{name}.ron"
    empty = options.folder / "empty.ron"
    empty.write_text(scene(SKY, CLAY, ['Sphere(center: (0, 0, 99), radius: 1, material: "body")']))
    (options.folder / "empty").mkdir(exist_ok=True)
    of_sky = seconds_of(options.gpu_rt, empty, options.folder / "empty") / (WIDTH * HEIGHT)
    settings = list(itertools.product((0.15, 0.25), (0.125, 0.25, 0.5), (1, 3, 5)))
    table = {setting: {} for setting in settings}
    print("scene".ljust(22), "cost", "bound", sep="\t")
    for name, source in scenes.items():
        folder = options.folder / source.stem
        renders = prepare(options.gpu_rt, source, folder)
        costs = costs_of_pixels(options.gpu_rt, source, folder, seconds_of(options.gpu_rt, source, folder), of_sky)
        noise = (renders["variances"][64] / (renders["mean"] ** 2 + 0.01 * renders["luminance"] ** 2)).sum(-1)
        noise = smooth(noise, 1)
        bound = noise.mean() * costs.mean() / np.sqrt(noise * costs).mean() ** 2
        print(name.ljust(22), f"{costs.mean() / of_sky:.1f}", f"{bound:.2f}", sep="\t", flush=True)
        for setting in settings:
            table[setting][name] = judge(renders, costs, setting)
    print("\nshare least radius | smooth kind | all | lowest, each at 64 and 512")
    for setting, gains in table.items():
        cells = []
        for request in REQUESTS:
            kind = np.exp(np.mean([np.log(gains[name][request]) for name in SMOOTH]))
            whole = np.exp(np.mean([np.log(g[request]) for g in gains.values()]))
            low = min(gains, key=lambda name: gains[name][request])
            cells.append(f"{request}: {kind:.2f} {whole:.2f} {gains[low][request]:.2f} ({low})")
        print(*setting, "|", " | ".join(cells))
    best = max(settings, key=lambda s: np.mean([np.log(g[512]) + np.log(g[64]) for g in table[s].values()]))
    print("\nbest:", best)
    for name, gains in table[best].items():
        print(name.ljust(22), *(f"{g:.2f}" for g in gains.values()), sep="\t")


if __name__ == "__main__":
    main()
