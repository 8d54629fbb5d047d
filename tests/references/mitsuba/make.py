"""Makes the images of the scenes here by Mitsuba: `pip install mitsuba==3.9.1 OpenEXR numpy`, then `python make.py [NAME..]`.

sky.exr and squares.exr, which scenes name, are made first if they are not there. The sky is the same in all rows: Mitsuba's rows reach from pole
to pole, ours have their middles half a row off.
"""

import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

VARIANT = "scalar_rgb"
mi.set_variant(VARIANT)
SPP, PARTS = 1024, 3  # of each half
FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent))
from record import record, write  # noqa: E402


def inputs():
    _, x = np.mgrid[0:16, 0:32] / 16
    sky = np.stack([0.4 + 0.3 * np.sin(np.pi * x), 0.5 + 0.3 * np.cos(np.pi * x), 0.5 + 0 * x], axis=2)
    y, x = np.mgrid[0:8, 0:8]
    squares = np.stack([0.2 + 0.07 * x, 0.2 + 0.07 * y, 0.1 + 0.6 * ((x // 2 + y // 2) % 2)], axis=2)
    for name, image in [("sky", sky), ("squares", squares)]:
        if not (FOLDER / f"{name}.exr").exists():
            write(FOLDER / name, image)


def make(name):
    scene = mi.load_file(str(FOLDER / f"{name}.xml"))
    started = time.time()
    halves = [
        np.mean([np.array(mi.render(scene, spp=SPP, seed=half * PARTS + part)) for part in range(PARTS)], axis=0, dtype=np.float64) for half in (0, 1)
    ]
    record(FOLDER / name, halves, started, {"renderer": "mitsuba", "variant": VARIANT, "version": mi.__version__, "spp": 2 * PARTS * SPP})


inputs()
for name in sys.argv[1:] or sorted(path.stem for path in FOLDER.glob("*.xml") if path.stem not in ("parts", "ball")):
    make(name)
