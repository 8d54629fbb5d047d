"""Makes orthographic.exr and orthographic.json by Mitsuba: `pip install mitsuba==3.9.1 OpenEXR numpy`, then `python orthographic.py`.

The scene is that of orthographic.ron.
"""

import json
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
import OpenEXR

VARIANT = "scalar_rgb"
mi.set_variant(VARIANT)
from mitsuba import ScalarTransform4f as T  # noqa: E402

WIDTH, HEIGHT, VIEW = 96, 64, 330
SPP, PARTS = 1024, 8  # of each half


def rgb(values):
    return {"type": "rgb", "value": values}


def lambertian(albedo):
    return {"type": "twosided", "material": {"type": "diffuse", "reflectance": rgb(albedo)}}


def quad(corner, u, v):
    """Mitsuba's rectangle goes from -1 to 1 along x and y; its normal is u x v."""
    corner, u, v = np.array(corner), np.array(u), np.array(v)
    columns = [u / 2, v / 2, np.cross(u, v), corner + u / 2 + v / 2]
    matrix = np.vstack([np.stack(columns, axis=1), [0, 0, 0, 1]])
    return {"type": "rectangle", "to_world": T(matrix)}


def box(size, degrees, shift):
    """Mitsuba's cube goes from -1 to 1."""
    half = [length / 2 for length in size]
    return {"type": "cube", "to_world": T().translate(shift) @ T().rotate([0, 1, 0], degrees) @ T().translate(half) @ T().scale(half)}


RED, WHITE, GREEN = lambertian([0.65, 0.05, 0.05]), lambertian([0.73, 0.73, 0.73]), lambertian([0.12, 0.45, 0.15])
scene = mi.load_dict(
    {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 100, "rr_depth": 5},
        # Its film goes from -1 to 1 along x.
        "sensor": {
            "type": "orthographic",
            "near_clip": 1e-3,
            "to_world": T().look_at([378, 378, -800], [278, 278, 278], [0, 1, 0]) @ T().scale([VIEW / 2 * WIDTH / HEIGHT, VIEW / 2 * WIDTH / HEIGHT, 1]),
            "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}, "component_format": "float32"},
            "sampler": {"type": "multijitter"},
        },
        "green": quad([555, 0, 0], [0, 555, 0], [0, 0, 555]) | {"material": GREEN},
        "red": quad([0, 0, 0], [0, 555, 0], [0, 0, 555]) | {"material": RED},
        "lamp": quad([343, 554, 332], [-130, 0, 0], [0, 0, -105]) | {"light": {"type": "area", "radiance": rgb([15, 15, 15])}},
        "floor": quad([0, 0, 0], [555, 0, 0], [0, 0, 555]) | {"material": WHITE},
        "ceiling": quad([555, 555, 555], [-555, 0, 0], [0, 0, -555]) | {"material": WHITE},
        "back": quad([0, 0, 555], [555, 0, 0], [0, 555, 0]) | {"material": WHITE},
        "tall": box([165, 330, 165], 15, [265, 0, 295]) | {"material": WHITE},
        "low": box([165, 165, 165], -18, [130, 0, 65]) | {"material": WHITE},
    }
)

started = time.time()
halves = [
    np.mean([np.array(mi.render(scene, spp=SPP, seed=half * PARTS + part)) for part in range(PARTS)], axis=0, dtype=np.float64) for half in (0, 1)
]
image = np.float32(np.mean(halves, axis=0))
between = float(np.mean((halves[0] - halves[1]) ** 2 / (halves[1] ** 2 + 0.01)))
made = {
    "scene": "orthographic",
    "renderer": "mitsuba",
    "variant": VARIANT,
    "version": mi.__version__,
    "spp": 2 * PARTS * SPP,
    "max_depth": "100",
    "rr_depth": 5,
    "filter": "box",
    "seconds": round(time.time() - started, 1),
    "relmse_of_reference": between / 4,
    "relmse_between_halves": between,
    "mean_rgb": image.mean(axis=(0, 1), dtype=np.float64).tolist(),
}
name = Path(__file__).with_suffix("")
OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": image}).write(str(name) + ".exr")
Path(str(name) + ".json").write_text(json.dumps(made, indent=1))
