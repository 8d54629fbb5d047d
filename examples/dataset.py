"""Makes a data set: a still life from random places in random order under random light, with the truth of each pixel.

    pip install gpu-rt pillow tqdm
    python examples/dataset.py out --count 200

Image 7 is out/000007.exr with all channels and out/000007.npz with arrays; out/coco.json has the masks of all objects. Each image depends on its number
alone, so that any machine makes the same one, and a part of the set can be made again.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from PIL import Image
from tqdm import tqdm

import gpu_rt

HERE = Path(__file__).parent
AOV = "motion,depth0,normal0,object"
MOVED = ("ball", "marble", "box", "card")
FPS = 24


def request(number):
    """Where everything is in an image, by its number."""
    random = np.random.default_rng(number)
    turn, height = random.uniform(0, 2 * np.pi), random.uniform(0.8, 2.2)
    look_from = np.array([3.2 * np.cos(turn), height, 3.2 * np.sin(turn)])
    look_at = random.uniform((-0.3, 0.1, -0.3), (0.3, 0.4, 0.3))
    # In the next frame the camera is a step further, which `motion` shows.
    step = random.normal(scale=0.03, size=3)
    keys = [(0, {"look_from": look_from, "look_at": look_at}), (1 / FPS, {"look_from": look_from + step, "look_at": look_at})]
    camera = {"look_from": look_from, "look_at": look_at, "moving": keys}
    objects = {}
    # One in each quarter of the table, so that none is inside of another.
    for name, quarter in zip(MOVED, random.permutation(4)):
        at = np.array([0.7, 0, 0.55]) * [quarter % 2 * 2 - 1, 0, quarter // 2 * 2 - 1] + random.uniform((-0.3, 0, -0.2), (0.3, 0, 0.2))
        c, s = np.cos(angle := random.uniform(0, 2 * np.pi)), np.sin(angle)
        objects[name] = np.array([[c, 0, s, at[0]], [0, 1, 0, 0], [-s, 0, c, at[2]], [0, 0, 0, 1]])
    warmth = random.uniform(0.7, 1)
    light = random.uniform(8, 40) * np.array([1, (1 + warmth) / 2, warmth])
    return {"camera": camera, "objects": objects, "materials": {"lamp": {"emit": gpu_rt.ron.Rgb(*light)}}, "frame": 0, "seed": number}


def run_lengths(mask):
    """A mask as COCO has it: the lengths of runs of 0 and 1 in turn, column by column."""
    changes = np.flatnonzero(np.diff(mask.flatten(order="F").astype(int), prepend=0))
    return {"size": list(mask.shape), "counts": np.diff([0, *changes, mask.size]).tolist()}


def annotations(number, mask, names):
    """Those of the objects that an image shows."""
    for category, name in enumerate(names, 1):
        own = mask == category
        if own.any():
            y, x = np.nonzero(own)
            box = [int(x.min()), int(y.min()), int(np.ptp(x)) + 1, int(np.ptp(y)) + 1]
            yield {
                "id": number * len(names) + category, "image_id": number, "category_id": category, "iscrowd": 0,
                "area": int(own.sum()), "bbox": box, "segmentation": run_lengths(own),
            }


def picture(image, mask):
    """All channels beside each other: light, depth, normals, objects, motion."""
    depth, motion = np.asarray(image["depth0"]), np.asarray(image["motion"])
    near = np.where(depth < 1e38, 1 / depth, 0)
    colours = np.random.default_rng(5).uniform(0.2, 1, (mask.max() + 1, 3)) * (np.arange(mask.max() + 1) > 0)[:, None]
    motion = np.where(np.abs(motion) < 1e38, motion, 0)
    moved = np.dstack([0.5 + 0.5 * motion / max(np.abs(motion).max(), 1e-9), np.full(mask.shape, 0.5)])
    light = np.clip(np.asarray(image), 0, 1) ** (1 / 2.2)
    parts = [light, np.dstack([near / near.max()] * 3), 0.5 + 0.5 * image["normal0"], colours[mask], moved]
    return Image.fromarray((255 * np.clip(np.hstack(parts), 0, 1)).astype(np.uint8))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--device", help="as of gpu-rt render")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    coco = {"images": [], "annotations": [], "categories": []}
    with gpu_rt.Session(HERE / "table.ron", size=given.size, spp=given.spp, aov=AOV, fps=FPS, device=given.device, no_state=True, quiet=True) as session:
        coco["categories"] = [{"id": number, "name": name} for number, name in enumerate(session.objects, 1)]
        for number in tqdm(range(given.count), unit="image"):
            image = session.render(**request(number))
            mask = image["object"].astype(np.int64)
            name = f"{number:06}"
            image.save(given.folder / f"{name}.exr")
            np.savez_compressed(
                given.folder / f"{name}.npz", rgb=np.asarray(image), depth=image["depth0"], normal=image["normal0"], mask=mask, motion=image["motion"]
            )
            coco["images"].append({"id": number, "file_name": f"{name}.exr", "height": mask.shape[0], "width": mask.shape[1]})
            coco["annotations"] += annotations(number, mask, session.objects)
            if number == 0:
                picture(image, mask).save(given.folder / "channels.png")
    (given.folder / "coco.json").write_text(json.dumps(coco))


if __name__ == "__main__":
    main()
