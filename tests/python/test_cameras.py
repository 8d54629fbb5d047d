"""Calibrated cameras beside OpenCV: where it sees points, and what it makes of chessboards. `make test-python` runs it."""

import unittest

import cv2
import gpu_rt
import numpy as np
from gpu_rt import ron

BROWN = {"k1": -0.2, "k2": 0.05, "p1": 0.002, "p2": -0.003}
KANNALA_BRANDT = {"k1": -0.02, "k2": 0.003, "k3": -0.001, "k4": 0.0001}


def pose(look_from, look_at, up):
    """A camera's axes in the world, right, down and forward, as the rows of OpenCV's rotation, and its shift."""
    forward = np.subtract(look_at, look_from) / np.linalg.norm(np.subtract(look_at, look_from))
    right = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
    rotation = np.stack([right, np.cross(forward, right), forward])
    return rotation, -rotation @ look_from


def from_corner(K):
    """Of OpenCV's K: it counts from the middle of the first pixel, scene files from its corner."""
    return {"fx": K[0, 0], "fy": K[1, 1], "cx": K[0, 2] + 0.5, "cy": K[1, 2] + 0.5}


class ProjectPoints(unittest.TestCase):
    """The inside of a ball, seen from beside its middle: each pixel's point of sample 0 is projected to where that sample went.

    Points are f32 of up to 10 scene units, u = 2^-24 off, and the nearest is 5 units away: with focal lengths below 150 pixels 0.001 pixels are
    dozens of roundings. The issue asks for 0.01.
    """

    PLACE = {"look_from": (1, 0.5, 2), "look_at": (-2, 1, -3), "up": (0.2, 1, 0.1)}
    SIZE = (160, 120)
    LIMIT = 0.001

    def image(self, K, distortion, mirror=False):
        scene = {
            "image": {"width": self.SIZE[0], "height": self.SIZE[1]},
            "camera": {**self.PLACE, "projection": ron.Calibrated(**from_corner(K), distortion=distortion), "mirror": mirror},
            "background": ron.Solid((0, 0, 0)),
            "materials": {"lamp": ron.DiffuseLight(emit=ron.Rgb(1, 1, 1))},
            "objects": [ron.Sphere(center=(0, 0, 0), radius=10, material="lamp")],
        }
        return gpu_rt.render(scene, spp=1, aov=["position0", "offset0"], quiet=True)

    def off(self, image, project):
        """The largest distance, in pixels, over what is less than 87 degrees from the axis; and how many pixels that are."""
        points = image["position0"].reshape(-1, 3).astype(np.float64)
        rotation, shift = pose(**self.PLACE)
        found = project(points[:, None], cv2.Rodrigues(rotation)[0], shift)[0].reshape(-1, 2)
        rows, columns = np.indices(self.SIZE[::-1])
        # The middle of a pixel is OpenCV's whole number; offsets are from its corner.
        expected = np.stack([columns, rows], axis=-1).reshape(-1, 2) + image["offset0"].reshape(-1, 2) - 0.5
        seen = points @ rotation.T + shift
        ahead = seen[:, 2] > np.cos(np.radians(87)) * np.linalg.norm(seen, axis=1)
        return np.linalg.norm(found - expected, axis=1)[ahead].max(), ahead.sum()

    def sees(self, K, distortion, project, plain):
        image = self.image(K, distortion)
        off, count = self.off(image, lambda *at: project(*at, K))
        print(self.id().split(".")[-1], "off by %.1e pixels at most, of %d" % (off, count))
        self.assertLess(off, self.LIMIT)
        self.assertGreater(count, 0.9 * self.SIZE[0] * self.SIZE[1])
        # Controls: K with its corner at another place, no distortion, and a mirrored image.
        shifted = K + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]]
        self.assertGreater(self.off(image, lambda *at: project(*at, shifted))[0], 0.5)
        self.assertGreater(self.off(image, lambda *at: plain(*at, K))[0], 0.5)
        self.assertGreater(self.off(self.image(K, distortion, mirror=True), lambda *at: project(*at, K))[0], 0.5)

    def test_brown(self):
        K = np.array([[120, 0, 74.5], [0, 132, 62.5], [0, 0, 1]])
        words = np.array([*BROWN.values(), 0.01])
        self.sees(
            K, ron.Brown(**BROWN, k3=0.01), lambda *at: cv2.projectPoints(*at, words), lambda *at: cv2.projectPoints(*at, np.zeros(5))
        )

    def test_kannala_and_brandt(self):
        K = np.array([[60, 0, 74.5], [0, 66, 62.5], [0, 0, 1]])
        words = np.array(list(KANNALA_BRANDT.values()))
        self.sees(
            K,
            ron.KannalaBrandt(**KANNALA_BRANDT),
            lambda *at: cv2.fisheye.projectPoints(*at, words),
            lambda *at: cv2.fisheye.projectPoints(*at, np.zeros(4)),
        )


class Chessboards(unittest.TestCase):
    """Twelve pictures of a chessboard give back the camera that has taken them.

    OpenCV's cornerSubPix is 0.05 pixels off at edges as sharp as a renderer's. So the picture is blurred here, and a corner is where a paraboloid
    fitted to it has its saddle. Measured over seeds, that is 0.01 pixels off, and K 0.03.
    """

    CORNERS = (9, 6)
    SIZE = (320, 240)
    K = np.array([[288, 0, 153.1], [0, 304, 126.7], [0, 0, 1]])

    def camera(self, number):
        """The board from 40 degrees beside its axis, each time from another side and turned another way."""
        side, tilt, roll = 2 * np.pi * number / 12, np.radians(40), 0.15 * (number % 4) - 0.2
        middle = np.array([4, 2.5, 0.5])
        away = np.array([np.sin(tilt) * np.cos(side), np.sin(tilt) * np.sin(side), np.cos(tilt)])
        beside = 0.6 * np.array([np.cos(2.4 * number), np.sin(2.4 * number), 0])
        return {
            "look_from": middle + (12 + number % 3) * away,
            "look_at": middle + beside,
            "up": (np.sin(roll), np.cos(roll), 0),
            "projection": ron.Calibrated(**from_corner(self.K), distortion=ron.Brown(**BROWN)),
        }

    def pictures(self):
        lamp = lambda emit: ron.DiffuseLight(emit=emit)
        scene = {
            "image": {"width": self.SIZE[0], "height": self.SIZE[1]},
            "camera": self.camera(0),
            "background": ron.Solid((0, 0, 0)),
            "materials": {
                "board": lamp(ron.Checker(scale=1, even=(0, 0, 0), odd=(1, 1, 1))),
                "margin": lamp(ron.Rgb(1, 1, 1)),
            },
            # The checker is a solid texture: in the middle of a layer of it.
            "objects": [
                ron.Quad(corner=(-1, -1, 0.5), u=(10, 0, 0), v=(0, 7, 0), material="board"),
                ron.Quad(corner=(-3, -3, 0.49), u=(14, 0, 0), v=(0, 11, 0), material="margin"),
            ],
        }
        with gpu_rt.Session(scene, spp=96, max_depth=0, quiet=True) as session:
            for number in range(12):
                yield np.array(session.render(camera=self.camera(number))[..., 1])

    def corners(self, picture):
        found, corners = cv2.findChessboardCorners(np.uint8(np.round(255 * picture.clip(0, 1))), self.CORNERS)
        self.assertTrue(found)
        blurred = cv2.GaussianBlur(picture, (0, 0), 2)
        y, x = np.mgrid[-4:5, -4:5].reshape(2, -1)
        fit = np.linalg.pinv(np.stack([x * x, x * y, y * y, x, y, np.ones(81)], axis=1))
        for corner in corners.reshape(-1, 2):
            for _ in range(10):
                xx, xy, yy, dx, dy, _ = fit @ cv2.getRectSubPix(blurred, (9, 9), corner.tolist()).ravel()
                corner -= np.linalg.solve([[2 * xx, xy], [xy, 2 * yy]], [dx, dy]).clip(-1, 1)
        return corners

    def test_they_give_the_camera_back(self):
        board = np.zeros((54, 3), np.float32)
        board[:, :2] = np.mgrid[:9, :6].T.reshape(-1, 2)
        corners = [self.corners(picture) for picture in self.pictures()]
        def calibrated(flags=0):
            error, K, distortion, _, _ = cv2.calibrateCamera(
                [board] * 12, corners, self.SIZE, None, None, flags=flags + cv2.CALIB_FIX_K3
            )
            print("the camera is off by %.3f pixels, and corners by %.3f" % (np.abs(K - self.K).max(), error))
            return K, distortion.ravel()

        K, (k1, _, p1, p2, _) = calibrated()
        self.assertLess(np.abs(K - self.K).max(), 0.05)
        np.testing.assert_allclose([k1, p1, p2], [BROWN["k1"], BROWN["p1"], BROWN["p2"]], atol=2e-3)
        # Controls: the corner of scene files, which is half a pixel away, and a camera without distortion.
        self.assertGreater(np.abs(K[:2, 2] - self.K[:2, 2] - 0.5).min(), 0.05)
        plain, _ = calibrated(cv2.CALIB_ZERO_TANGENT_DIST + cv2.CALIB_FIX_K1 + cv2.CALIB_FIX_K2)
        self.assertGreater(np.abs(plain - self.K).max(), 0.05)


if __name__ == "__main__":
    unittest.main()
