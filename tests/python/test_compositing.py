"""Mattes by a reader that is not ours: the code of docs/compositing.md, and its arrays against the light of lamps."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
import OpenEXR

ROOT = pathlib.Path(__file__).parents[2]
SCENE = """Scene(
    image: (width: 24, height: 18),
    camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), vertical_fov: 40, aperture: 0.4),
    background: Solid((0, 0, 0)),
    materials: {
        "red": DiffuseLight(emit: Rgb(1, 0, 0)), "green": DiffuseLight(emit: Rgb(0, 1, 0)), "blue": DiffuseLight(emit: Rgb(0, 0, 1)),
    },
    objects: [
        Named(name: "ball", object: Sphere(center: (-0.5, 0, 0), radius: 1, material: "red")),
        Named(name: "ball", object: Sphere(center: (1, 0.5, 0.5), radius: 0.5, material: "green")),
        Named(name: "wall", object: Quad(corner: (-9, -9, -2), u: (18, 0, 0), v: (0, 18, 0), material: "blue")),
    ],
    render: (samples: 64, max_depth: 1),
)"""


class Mattes(unittest.TestCase):
    def test_reader_of_others_has_the_shares_of_names(self):
        page = (ROOT / "docs/compositing.md").read_text()
        code = page.split("```python\n")[1].split("```")[0]
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            try:
                os.chdir(folder)
                pathlib.Path("scene.ron").write_text(SCENE)
                for names in ([], ["--aov-names", "blender"]):
                    line = ["gpu-rt", "render", "scene.ron", "--aov", "cryptomatte", "--quiet", "--force", "-o", "shot.exr"]
                    subprocess.run([*line, *names], check=True)
                    self.check(code, "ViewLayer." if names else "")
            finally:
                os.chdir(before)

    def check(self, code, prefix):
        found = {}
        exec(code.replace('"CryptoObject"', f'"{prefix}CryptoObject"'), found)
        objects, materials = (found["mattes"][prefix + kind].masks() for kind in ("CryptoObject", "CryptoMaterial"))
        channels = OpenEXR.File("shot.exr", separate_channels=True).parts[0].channels
        red, green, blue = (next(each.pixels for name, each in channels.items() if name in (c, "Combined." + c)) for c in "RGB")
        # A lamp of radiance 1 gives a pixel the share of its samples that see it.
        for share, light in ((found["ball"], red + green), (objects["wall"], blue), (materials["red"], red)):
            self.assertEqual(share.shape, (18, 24))
            np.testing.assert_allclose(share, light, atol=1e-6)
        np.testing.assert_allclose(sum(objects.values()), 1, atol=1e-6)
        # The control: shares are no masks of 0 and 1, and one ball is not both.
        self.assertGreater(((red > 0.05) & (red < 0.95)).sum(), 10)
        self.assertGreater(np.abs(found["ball"] - red).max(), 0.5)


if __name__ == "__main__":
    unittest.main()
