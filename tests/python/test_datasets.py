"""The examples that make data sets: their images, masks and arrays, and their workers."""

import json
import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

import numpy as np
from pycocotools.coco import COCO

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
sys.path.insert(0, str(EXAMPLES))
# The example of PyTorch needs these two of it alone, and PyTorch is too large for a test: workers are those of Python here, as of its DataLoader.
sys.modules["torch"] = torch = types.ModuleType("torch")
torch.utils = types.SimpleNamespace(data=types.SimpleNamespace(Dataset=object))
torch.from_numpy = lambda array: array

import dataset
import torch_dataset


def light_of(number):
    light, objects = torch_dataset.Renders(4)[number]
    return os.getpid(), float(light.mean()), int(objects.max())


class Datasets(unittest.TestCase):
    def test_images_masks_and_arrays(self):
        """What COCO's own reader decodes from the masks is what the images have."""
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            line = [sys.executable, EXAMPLES / "dataset.py", folder / "all", "--count=4", "--size=48x36", "--spp=4"]
            subprocess.run(line, check=True, stderr=subprocess.PIPE)
            coco = COCO(folder / "all/coco.json")
            names = [category["name"] for category in coco.loadCats(coco.getCatIds())]
            self.assertEqual(names, ["table", "ball", "marble", "box", "card", "lamp"])
            seen = set()
            for image in coco.loadImgs(coco.getImgIds()):
                arrays = np.load(folder / "all" / image["file_name"].replace(".exr", ".npz"))
                self.assertEqual(arrays["rgb"].shape, (36, 48, 3))
                self.assertEqual(arrays["motion"].shape, (36, 48, 2))
                found = np.zeros((36, 48), int)
                for each in coco.loadAnns(coco.getAnnIds(imgIds=image["id"])):
                    mask = coco.annToMask(each)
                    found += each["category_id"] * mask
                    y, x = np.nonzero(mask)
                    self.assertEqual(each["bbox"], [x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1])
                    self.assertEqual(each["area"], mask.sum())
                    seen.add(each["category_id"])
                np.testing.assert_array_equal(found, arrays["mask"])
                # The control: read row by row, a mask is another one.
                self.assertTrue((found.T.reshape(36, 48) != arrays["mask"]).any())
                hit = arrays["mask"] > 0
                # Normals are unit vectors, rounded to f32; the camera is at most 6 units from anything.
                np.testing.assert_allclose(np.linalg.norm(arrays["normal"][hit], axis=1), 1, atol=1e-6)
                self.assertTrue((arrays["depth"][hit] < 6).all() and (arrays["depth"][~hit] > 1e38).all())
                self.assertGreater(np.abs(arrays["motion"][hit]).max(), 0.1)
            self.assertGreaterEqual(len(seen), 5)
            self.assertTrue((folder / "all/channels.png").stat().st_size > 1000)
            # An image depends on its number alone.
            again = folder / "again"
            subprocess.run([*line[:2], again, "--count=1", *line[4:]], check=True, stderr=subprocess.PIPE)
            for each in ("rgb", "mask", "motion"):
                self.assertTrue((np.load(again / "000000.npz")[each] == np.load(folder / "all/000000.npz")[each]).all())

    def test_workers_open_sessions_of_their_own(self):
        """Workers that are forked after the parent has rendered, that are spawned, and that stay from epoch to epoch."""
        own = [light_of(number) for number in range(2)]
        for method in ("fork", "spawn"):
            with multiprocessing.get_context(method).Pool(2) as pool:
                epochs = [pool.map(light_of, range(2), chunksize=1) for _ in range(2)]
            for epoch in epochs:
                self.assertEqual([each[1:] for each in epoch], [each[1:] for each in own], method)
            self.assertNotIn(os.getpid(), {each[0] for epoch in epochs for each in epoch})
        self.assertEqual(light_of(0), own[0])
        self.assertNotEqual(own[0][1], own[1][1])

    def test_run_lengths(self):
        """By hand: the first run is of zeros, and columns come first."""
        self.assertEqual(dataset.run_lengths(np.array([[0, 1], [1, 1]], bool)), {"size": [2, 2], "counts": [1, 3]})
        self.assertEqual(dataset.run_lengths(np.array([[1, 0], [1, 0]], bool)), {"size": [2, 2], "counts": [0, 2, 2]})
        self.assertEqual(dataset.run_lengths(np.array([[1, 1], [1, 0]], bool)), {"size": [2, 2], "counts": [0, 3, 1]})
        self.assertEqual(json.dumps(dataset.run_lengths(np.zeros((2, 2), bool))), '{"size": [2, 2], "counts": [4]}')


if __name__ == "__main__":
    unittest.main()
