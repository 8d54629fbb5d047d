"""Makes the images of the scenes here by pbrt-r4, a port of pbrt-v4: `cargo install pbrt-r4 --version 4.5.2 --no-default-features` and
`pip install OpenEXR numpy pillow`, then `python make.py [NAME..]`.

Each half has a sampler with a seed of its own in place of the scene's. Images that scenes name are made first if they are not there.
"""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

SPP = 8192  # of each half
FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent))
from record import record, write  # noqa: E402


def inputs():
    y, x = np.mgrid[0:32, 0:32]
    sky = 0.3 + 0.2 * np.sin(x / 5) + 0.2 * y / 32
    sky[20, 25], sky[3:5, 10:12] = 60, 8
    y, x = np.mgrid[0:8, 0:8]
    texels = (0.2 + 0.07 * x) * (0.5 + 0.5 * ((x // 2 + y // 2) % 2))
    for name, grey in [("square", sky), ("texels", texels)]:
        if not (FOLDER / f"{name}.exr").exists():
            write(FOLDER / name, np.stack([grey] * 3, axis=2))
    # Codes that vary along one axis alone: the product of both is bilinear where they are.
    codes = np.array([20, 250, 90, 200, 150, 40, 230, 120], np.uint8)
    for name, image in [("columns", np.tile(codes, (8, 1))), ("rows", np.tile(codes[::-1, None], (1, 8)))]:
        Image.fromarray(image).save(FOLDER / f"{name}.png")


def half(name, seed):
    text = (FOLDER / f"{name}.pbrt").read_text()
    sampler = f'Sampler "independent" "integer seed" {seed} "integer pixelsamples" {SPP}'
    with tempfile.TemporaryDirectory(dir=FOLDER) as folder:
        # Files are found beside the first one.
        scene, image = FOLDER / f"{Path(folder).name}.pbrt", Path(folder) / "half.exr"
        scene.write_text(re.sub(r"^WorldBegin", f"{sampler}\nWorldBegin", text, flags=re.MULTILINE))
        try:
            subprocess.run(["pbrt-r4", str(scene), "--outfile", str(image), "--quiet"], check=True, stdout=subprocess.DEVNULL)
        finally:
            scene.unlink()
        return OpenEXR.File(str(image)).channels()["RGB"].pixels.astype(np.float64)


def make(name):
    started = time.time()
    halves = [half(name, seed) for seed in (1, 2)]
    record(FOLDER / name, halves, started, {"renderer": "pbrt-r4", "version": "4.5.2", "spp": 2 * SPP})


inputs()
for name in sys.argv[1:] or ["sky", "lights", "shapes", "materials", "textures"]:
    make(name)
