"""The release: the steps of its workflow that can run here, as they stand, with wheels for all platforms. `make test-python` runs it."""

import importlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import types
import unittest
import zipfile
from pathlib import Path
from unittest import mock

import gpu_rt
import yaml

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())
STEPS = [step for job in WORKFLOW["jobs"].values() for step in job["steps"]]
WHEEL = next((ROOT / "target/wheels").glob("*.whl"))
VERSION = gpu_rt.__version__
# The platform of each runner, as wheels and as archives name it.
SYSTEMS = {
    "manylinux_2_28_x86_64": "linux-x64",
    "manylinux_2_28_aarch64": "linux-arm64",
    "macosx_11_0_arm64": "macos-arm64",
    "macosx_10_12_x86_64": "macos-x64",
    "win_amd64": "windows-x64",
}


class Release(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for name in ("Cargo.toml", "ci", "scenes"):
            (self.folder / name).symlink_to(ROOT / name)
        self.dist = self.folder / "dist"
        self.dist.mkdir()

    def wheels(self, version=VERSION, systems=tuple(SYSTEMS)):
        """Wheels as maturin makes them, of which that for this platform has the program."""
        with zipfile.ZipFile(WHEEL) as wheel:
            self.program = wheel.read(f"gpu_rt-{VERSION}.data/scripts/gpu-rt")
        for system in systems:
            name = "gpu-rt.exe" if system.startswith("win") else "gpu-rt"
            with zipfile.ZipFile(self.dist / f"gpu_rt-{version}-py3-none-{system}.whl", "w") as wheel:
                wheel.writestr(f"gpu_rt-{version}.data/scripts/{name}", self.program if system == "manylinux_2_28_x86_64" else system)

    def step(self, name, **environment):
        step = next(step for step in STEPS if step.get("name") == name)
        self.assertNotIn("${{", step["run"])
        bash = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
        env = os.environ | {"PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin"} | environment
        ran = subprocess.run(bash, cwd=self.folder, env=env, capture_output=True, text=True)
        return ran.returncode, ran.stdout + ran.stderr

    def pack(self):
        for name in ("Pack", "Write checksums"):
            code, said = self.step(name, GITHUB_REF_TYPE="tag", GITHUB_REF_NAME=f"v{VERSION}")
            self.assertEqual((code, said), (0, ""))

    def test_each_platform_has_a_wheel_an_archive_and_an_extension_with_checksums(self):
        self.assertEqual(len(WORKFLOW["jobs"]["wheel"]["strategy"]["matrix"]["runner"]), len(SYSTEMS))
        self.wheels()
        self.pack()
        names = {f"gpu_rt-{VERSION}-py3-none-{system}.whl" for system in SYSTEMS}
        names |= {f"gpu-rt-{VERSION}-{platform}.tar.gz" for platform in SYSTEMS.values()}
        # Blender is not made for Linux on ARM.
        platforms = set(SYSTEMS.values()) - {"linux-arm64"}
        names |= {f"gpu_rt-{VERSION}-{platform.replace('-', '_')}.zip" for platform in platforms}
        self.assertEqual({path.name for path in self.dist.iterdir()}, names | {"SHA256SUMS"})
        sums = dict(reversed(line.split("  ")) for line in (self.dist / "SHA256SUMS").read_text().splitlines())
        self.assertEqual(set(sums), names)
        self.assertTrue(all(re.fullmatch("[0-9a-f]{64}", value) for value in sums.values()))
        for name in names:
            # Another byte is another sum.
            with open(self.dist / name, "ab") as file:
                file.write(b" ")
        found = subprocess.run(["/usr/bin/sha256sum", "--check", "SHA256SUMS"], cwd=self.dist, capture_output=True, text=True).stdout
        self.assertEqual(found.count(": FAILED"), len(names), found)
        for platform in platforms:
            with zipfile.ZipFile(self.dist / f"gpu_rt-{VERSION}-{platform.replace('-', '_')}.zip") as extension:
                manifest = extension.read("blender_manifest.toml").decode()
                # Behind a table's head it would be a field of the table.
                self.assertIn(f'platforms = ["{platform}"]', manifest.split("\n[")[0])
                self.assertIn(f'\nversion = "{VERSION}"\n', manifest)
                self.assertNotIn("apart", manifest)
                program = "bin/gpu-rt.exe" if platform == "windows-x64" else "bin/gpu-rt"
                self.assertEqual(sorted(name for name in extension.namelist() if name.startswith("bin")), [program])
                plain = {path.name for path in (ROOT / "blender/gpu_rt").iterdir() if path.is_file()}
                self.assertEqual(set(extension.namelist()) - {program}, plain)
                # There a link of the checkout is a file.
                self.assertEqual(extension.read("ron.py"), (ROOT / "python/gpu_rt/ron.py").read_bytes())

    def test_the_program_of_an_archive_runs_and_the_extension_finds_that_inside(self):
        self.wheels(systems=["manylinux_2_28_x86_64"])
        self.pack()
        top = f"gpu-rt-{VERSION}-linux-x64"
        with tarfile.open(self.dist / f"{top}.tar.gz") as archive:
            archive.extractall(self.folder)
        checked = subprocess.check_output(["./gpu-rt", "check", "scenes/cornell.ron"], cwd=self.folder / top, text=True)
        self.assertIn("valid, 8 primitives", checked)
        for name in ("LICENSE-MIT", "LICENSE-APACHE", "README.md"):
            self.assertEqual((self.folder / top / name).read_bytes(), (ROOT / name).read_bytes())

        with zipfile.ZipFile(self.dist / f"gpu_rt-{VERSION}-linux_x64.zip") as extension:
            extension.extractall(self.folder / "unpacked")
        inside = self.folder / "unpacked/bin/gpu-rt"
        self.assertFalse(os.access(inside, os.X_OK), "as Blender unpacks it")
        preferences = types.SimpleNamespace(addons={})
        bpy = mock.MagicMock(context=types.SimpleNamespace(preferences=preferences))
        bpy.types.AddonPreferences = object
        (self.folder / "unpacked/__init__.py").write_text("")
        with mock.patch.dict(sys.modules, bpy=bpy), mock.patch.object(sys, "path", [str(self.folder), *sys.path]):
            found = importlib.import_module("unpacked.preferences").program()
        self.assertEqual(found, str(inside))
        said = subprocess.check_output([found, "--version"], text=True)
        self.assertEqual(said.split()[1], VERSION)

    def test_another_version_and_an_unknown_platform_are_refused(self):
        for version, system, tag in (
            ("9.9.9", "win_amd64", f"v{VERSION}"),
            (VERSION, "win_amd64", "v9.9.9"),
            (VERSION, "plan9", f"v{VERSION}"),
            ("9.9.9", "win_amd64", "v9.9.9"),  # the extension's
        ):
            self.wheels(version, [system])
            code, said = self.step("Pack", GITHUB_REF_TYPE="tag", GITHUB_REF_NAME=tag)
            self.assertEqual(code, 1, said)
            self.assertRegex(said, "^error: .*version")
            shutil.rmtree(self.dist)
            self.dist.mkdir()
        code, said = self.step("Pack", GITHUB_REF_TYPE="branch", GITHUB_REF_NAME="main")
        self.assertEqual((code, said.strip()), (1, "error: dist has no wheel"))

    def test_what_is_tried_on_each_runner_passes_here(self):
        shutil.copy(WHEEL, self.dist)
        code, said = self.step("Try the program", PIP_NO_DEPS="1", PIP_DISABLE_PIP_VERSION_CHECK="1")
        self.assertEqual(code, 0, said)
        self.assertTrue(said.strip().endswith("\n8"), said)

    def test_actions_have_one_version_everywhere(self):
        versions = {}
        for path in [ROOT / "action.yml", *(ROOT / ".github/workflows").glob("*.yml")]:
            for action, version in re.findall(r"uses: (\S+)@(\S+)", path.read_text()):
                self.assertRegex(version, r"^v\d+$", path)
                self.assertEqual(versions.setdefault(action, version), version, action)
        self.assertEqual(WORKFLOW[True]["push"]["tags"], ["v*"])


if __name__ == "__main__":
    unittest.main()
