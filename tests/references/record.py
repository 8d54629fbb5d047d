"""Writes images by other renderers, each with a .json that says how it was made."""

import json
import time

import numpy as np
import OpenEXR


def write(file, image):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(image, dtype=np.float32)}).write(str(file.with_suffix(".exr")))


def record(file, halves, started, how):
    """The mean of two halves. Their difference says its error; `how` is what else the .json has."""
    image = np.mean(halves, axis=0)
    between = float(np.mean((halves[0] - halves[1]) ** 2 / (halves[1] ** 2 + 0.01)))
    made = {
        "scene": file.name,
        **how,
        "seconds": round(time.time() - started, 1),
        "relmse_of_reference": between / 4,
        "relmse_between_halves": between,
        "mean_rgb": image.mean(axis=(0, 1)).tolist(),
    }
    write(file, image)
    file.with_suffix(".json").write_text(json.dumps(made, indent=1))
