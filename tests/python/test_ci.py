"""The action's shell steps and the steps of the Dockerfile, as they stand, without GitHub and Docker. `make test-python` runs it."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import gpu_rt
import numpy as np
import OpenEXR
import yaml

ROOT = Path(__file__).resolve().parents[2]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
WHEEL = next((ROOT / "target/wheels").glob("*.whl"))
# What a runner has: neither the program nor Rust.
SYSTEM_PATH = f"{sys.base_prefix}/bin:/usr/sbin:/usr/bin:/sbin:/bin"


class Runner:
    """Runs the steps of action.yml that are commands, as a runner of GitHub does."""

    def __init__(self, home):
        self.workspace = home / "workspace"
        self.workspace.mkdir()
        self.files = {name: home / name for name in ("GITHUB_ENV", "GITHUB_PATH", "GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
        for file in self.files.values():
            file.touch()
        self.base = {"HOME": str(home), "GITHUB_ACTION_PATH": str(ROOT), **{name: str(file) for name, file in self.files.items()}}
        self.base |= {"GITHUB_JOB": "images", "RUNNER_TEMP": str(home)}
        # A software driver may be elsewhere than Debian has it.
        self.base.update({name: os.environ[name] for name in ("VK_DRIVER_FILES", "LD_LIBRARY_PATH") if name in os.environ})

    def step(self, name, replaced={}, **inputs):
        """The status and the output of the step of this name. `replaced` is environment that replaces its own."""
        step = next(step for step in ACTION["runs"]["steps"] if step.get("name") == name)
        given = {key: str(spec.get("default", "")) for key, spec in ACTION["inputs"].items()} | inputs

        def value(expression):
            known = {"github.action_path": str(ROOT), "strategy.job-total": "1", "strategy.job-index": "0"}
            known |= {f"inputs.{name}": value for name, value in given.items()}
            return next(filter(None, (known[name.strip()] for name in expression[1].split("||"))), "")

        env = self.base | dict(line.split("=", 1) for line in self.files["GITHUB_ENV"].read_text().splitlines())
        env |= {key: re.sub(r"\$\{\{(.*?)\}\}", value, text) for key, text in step["env"].items()} | replaced
        env["PATH"] = ":".join([*self.files["GITHUB_PATH"].read_text().split(), SYSTEM_PATH])
        bash = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
        ran = subprocess.run(bash, cwd=self.workspace, env=env, capture_output=True, text=True)
        return ran.returncode, ran.stdout + ran.stderr


class Action(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.home = Path(folder.name)
        cls.runner = Runner(cls.home)
        code, cls.installed = cls.runner.step("Install lavapipe and gpu-rt", package=str(WHEEL))
        assert code == 0, cls.installed
        scenes = cls.runner.workspace / "scenes"
        scenes.mkdir()
        shutil.copy(ROOT / "scenes/cornell.ron", scenes / "box.ron")
        cls.goldens = cls.runner.workspace / "goldens"
        cls.goldens.mkdir()

    def compare(self, golden, **inputs):
        """Has this picture as the golden image, and runs the step."""
        OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": golden}).write(str(self.goldens / "box.exr"))
        given = {"scenes": "scenes/b*.ron", "options": "--size 16x16 --spp 32"} | inputs
        return self.runner.step("Render and compare", **given)

    def test_it_installs_the_program_and_keeps_what_is_cached(self):
        self.assertIn("llvmpipe", self.installed)
        code, said = self.runner.step("Install lavapipe and gpu-rt", package="no-such-package")
        self.assertEqual(code, 0, "what is cached is not installed again: " + said)
        self.compare(np.ones((16, 16, 3), np.float32))
        self.assertTrue(any((self.home / ".cache/gpu-rt/kernels").rglob("*")), "the driver keeps its kernels there")
        cached = [step["with"]["path"] for step in ACTION["runs"]["steps"] if step.get("uses", "").startswith("actions/cache@")]
        self.assertEqual(cached, ["~/.cache/gpu-rt/program", "~/.cache/gpu-rt/kernels"])

    def test_another_package_has_another_hash(self):
        wheel = self.home / "a.whl"
        hashes = []
        for package, content in ((str(wheel), "a"), (str(wheel), "b"), ("gpu-rt==1", "b"), ("gpu-rt==2", "b"), ("", "b"), (str(wheel), "a")):
            wheel.write_text(content)
            code, said = self.runner.step("Hash the package", package=package)
            self.assertEqual((code, said), (0, ""))
            hashes.append(self.runner.files["GITHUB_OUTPUT"].read_text().splitlines()[-1])
            self.assertRegex(hashes[-1], "^hash=[0-9a-f]{16}$")
        self.assertEqual((len(set(hashes)), hashes[-1]), (5, hashes[0]))

    def test_images_fail_by_limits_and_by_the_verdict(self):
        options = {"size": (16, 16), "spp": 32, "quiet": True}
        noise = np.array(gpu_rt.render(ROOT / "scenes/cornell.ron", seed=1, **options))
        code, said = self.compare(noise)
        self.assertEqual(code, 0, said)
        self.assertIn("differs by noise only", said)
        output = self.runner.workspace / "gpu-rt-output"
        self.assertEqual((output / "box.heatmap.png").read_bytes()[1:4], b"PNG")
        report = json.loads((output / "box.json").read_text())
        summary = self.runner.files["GITHUB_STEP_SUMMARY"].read_text()
        self.assertIn(f"| scenes/box.ron | {report['relmse']} | {report['flip']} | {report['p']} | A differs by noise only", summary)

        code, said = self.compare(noise, **{"fail-above": "relmse=1 flip=0.0001"})
        self.assertEqual(code, 1, said)
        self.assertIn("::error::--fail-above: flip is ", said)

        code, said = self.compare(2 * noise)
        self.assertEqual(code, 1, said)
        self.assertRegex(said, "::error::scenes/box.ron: A (is darker|differs)")
        code, said = self.compare(2 * noise, verdict="warn")
        self.assertEqual(code, 0, said)
        self.assertIn("::warning::scenes/box.ron: A ", said)

        code, said = self.compare(noise[:8])
        self.assertEqual(code, 1, "images of two sizes: " + said)
        code, said = self.compare(noise, goldens="nowhere")
        self.assertEqual(code, 1, said)
        self.assertIn("::error::nowhere/box.exr is missing", said)

    def test_scenes_that_are_not_there_are_errors(self):
        for scenes, words in (
            ("", "scenes: nothing is to be rendered: name a scene"),
            (" \n ", "scenes: nothing is to be rendered"),
            ("scenes/x*.ron", "scenes: no file is named scenes/x*.ron"),
            ("scenes/box.ron gone.ron", "scenes: no file is named gone.ron"),
            ("scenes/box.ron 'a", "No closing quotation"),
        ):
            code, said = self.runner.step("Render and compare", scenes=scenes)
            self.assertEqual(code, 1, said)
            self.assertRegex(said, f"(?m)^::error::.*{re.escape(words)}")
        code, said = self.runner.step("Hash the driver and the scenes", scenes="'a")
        self.assertEqual((code, said.startswith("::error::")), (1, True), said)
        code, said = self.runner.step("Render and compare", scenes="scenes/box.ron", output="goldens/.")
        self.assertEqual(code, 1, said)
        self.assertIn("::error::output: goldens/. is the folder of the golden images", said)

    def test_scenes_of_one_name_and_with_spaces_have_files_of_their_own(self):
        for name in ("a/room.ron", "b/c/room.ron", "my scenes/two words.ron", "-dash.ron"):
            path = self.runner.workspace / "many" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / "scenes/cornell.ron", path)
        given = {"goldens": "my goldens", "output": "my output", "options": '--size 8x8 --spp 16 --tonemap "soft"'}
        given["scenes"] = "many/**/room.ron many/a/*.ron\nmany/my scenes/*.ron\n many/-*.ron "
        code, said = self.runner.step("Render and compare", **given)
        self.assertEqual(code, 1, said)
        names = ["many/a/room", "many/b/c/room", "two words", "-dash"]
        self.assertEqual(re.findall("::error::(.*) is missing", said), [f"my goldens/{name}.exr" for name in names])
        output, goldens = self.runner.workspace / "my output", self.runner.workspace / "my goldens"
        shutil.copytree(output, goldens)
        # Each is compared with its own: the image of another is a difference.
        dark = np.asarray(gpu_rt.Image(goldens / "many/a/room.exr")) / 2
        OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": dark}).write(str(goldens / "many/b/c/room.exr"))
        code, said = self.runner.step("Render and compare", **given, **{"fail-above": "flip=0.001"})
        self.assertEqual((code, said.count("::error::")), (1, 1), said)
        self.assertRegex(said.split("::group::many/b/c/room.ron")[1].split("::endgroup::")[0], "::error::--fail-above: flip is ")
        (self.runner.workspace / "many/a/room.glb").touch()
        code, said = self.runner.step("Render and compare", **given | {"scenes": "many/**/room.*"})
        self.assertEqual(code, 1, said)
        self.assertIn("::error::scenes: many/a/room.glb and many/a/room.ron have one name, many/a/room", said)

    def test_an_annotation_of_several_lines_is_one(self):
        code, said = self.compare(np.ones((16, 16, 3), np.float32), options="--sps 3 --size 16x16 --exposure 50%")
        self.assertEqual(code, 1, said)
        annotations = re.findall("(?m)^::error::(.*)", said)
        self.assertEqual(len(annotations), 1, said)
        self.assertRegex(annotations[0], "^unexpected argument '--sps' found.*%0A%0AUsage: gpu-rt render")
        code, said = self.compare(np.ones((16, 16, 3), np.float32), options="--exposure 5%0A")
        self.assertIn("::error::invalid value '5%250A'", said)
        self.assertNotIn("\nFor more", said)

    def test_artifacts_have_names_of_their_own(self):
        def name(**environment):
            code, said = self.runner.step("Name the artifact", environment, output=environment.pop("output", "gpu-rt-output"))
            self.assertEqual((code, said), (0, ""))
            return self.runner.files["GITHUB_OUTPUT"].read_text().splitlines()[-1]

        (self.home / "gpu-rt-uses").unlink(missing_ok=True)
        self.assertEqual(name(), "name=gpu-rt-output-images")
        self.assertEqual(name(), "name=gpu-rt-output-images-2")
        for leg in ("0", "1"):
            (self.home / "gpu-rt-uses").unlink()
            self.assertEqual(name(LEGS="2", LEG=leg, output="out/a:b*c"), f"name=out-a-b-c-images-{leg}")

    def test_only_what_changes_kernels_makes_a_new_cache(self):
        def hashes(**inputs):
            code, said = self.runner.step("Hash the driver and the scenes", scenes="scenes/b*.ron", **inputs)
            self.assertEqual((code, said), (0, ""))
            return self.runner.files["GITHUB_OUTPUT"].read_text().splitlines()[-2:]

        before = hashes()
        self.assertRegex(" ".join(before), "^driver=[0-9a-f]{16} scenes=[0-9a-f]{16}$")
        self.assertEqual(hashes(), before)
        self.assertEqual([a == b for a, b in zip(hashes(options="--spp 3"), before)], [True, False])
        scene = self.runner.workspace / "scenes/box.ron"
        text = scene.read_text()
        self.addCleanup(scene.write_text, text)
        scene.write_text(text + " ")
        self.assertNotEqual(hashes(), before)
        key = next(step["with"]["key"] for step in ACTION["runs"]["steps"] if step.get("with", {}).get("path", "").endswith("/kernels"))
        self.assertEqual(re.findall(r"\{ (.*?) \}", key)[1:], [f"steps.{n}" for n in ("scenes.outputs.driver", "package.outputs.hash", "scenes.outputs.scenes")])
        self.assertIn("MESA_SHADER_CACHE_MAX_SIZE=64M", self.runner.files["GITHUB_ENV"].read_text())

    def test_other_systems_are_refused_by_name(self):
        tools = self.home / "tools"
        tools.mkdir()
        (tools / "uname").write_text("#!/bin/sh\necho Darwin\n")
        (tools / "uname").chmod(0o755)
        before = self.runner.files["GITHUB_PATH"].read_text()
        self.addCleanup(self.runner.files["GITHUB_PATH"].write_text, before)
        self.runner.files["GITHUB_PATH"].write_text(f"{tools}\n")
        code, said = self.runner.step("Hash the package")
        self.assertEqual(code, 1)
        self.assertRegex(said, "^::error::this action runs on Linux")

    def test_an_error_of_a_scene_stands_beside_its_line(self):
        (self.runner.workspace / "scenes/wrong.ron").write_text("Scene(\n  camra: 3)")
        code, said = self.compare(np.ones((16, 16, 3), np.float32), scenes="scenes/wrong.ron", options="")
        self.assertEqual(code, 1, said)
        self.assertIn("::error file=scenes/wrong.ron,line=2,col=3::camra: unknown field camra", said)

    def test_the_example_uses_inputs_that_there_are(self):
        examples = re.findall(r"^```yaml\n(.*?)^```$", (ROOT / "docs/ci.md").read_text(), re.M | re.S)
        self.assertEqual(len(examples), 1)
        steps = [step for job in yaml.safe_load(examples[0])["jobs"].values() for step in job["steps"]]
        ours = [step["with"] for step in steps if "gpu-rt" in step["uses"]]
        self.assertEqual(len(ours), 1)
        self.assertLessEqual(set(ours[0]), set(ACTION["inputs"]))
        table = re.findall(r"^\| `([\w-]+)` \|", (ROOT / "docs/ci.md").read_text(), re.M)
        self.assertEqual(table, list(ACTION["inputs"]))


class Docker(unittest.TestCase):
    def test_the_steps_of_the_dockerfile(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        # Nothing of this machine changes: packages are resolved and not installed, no list is removed, and the program is there already.
        tools = Path(folder.name, "tools")
        tools.mkdir()
        built = f'[ "$*" = "build --release --locked" ] && mkdir -p target/release && cp {gpu_rt.program()} target/release/'
        apt = 'if [ "$1" != update ]; then exec /usr/bin/apt-get --simulate "$@"; fi\napt-cache show libegl1 >/dev/null 2>&1 || exec /usr/bin/apt-get "$@"'
        for name, body in (("cargo", built), ("apt-get", apt), ("rm", ":")):
            (tools / name).write_text(f"#!/bin/sh\n{body}\n")
            (tools / name).chmod(0o755)
        stages, installed = {}, ""
        text = re.sub(r"\\\n", " ", (ROOT / "Dockerfile").read_text())
        for line in filter(None, (line.split("#")[0].strip() for line in text.splitlines())):
            word, rest = line.split(None, 1)
            if word == "FROM":
                image, _, name = rest.partition(" AS ")
                self.assertRegex(image, r"^(debian:\w+-slim|rust:1-slim-\w+)$")
                root, env, cwd = Path(folder.name, name or "final"), {}, "/"
                root.mkdir()
                stages[name] = root
            elif word == "WORKDIR":
                cwd = rest
                (root / cwd.strip("/")).mkdir(parents=True, exist_ok=True)
            elif word == "COPY":
                *stage, source, target = rest.split()
                if stage:
                    (root / target.strip("/")).mkdir(parents=True, exist_ok=True)
                    shutil.copy(stages[stage[0].removeprefix("--from=")] / source.strip("/"), root / target.strip("/"))
                else:
                    self.assertEqual((source, target), (".", "."))
                    self.assertTrue((ROOT / ".dockerignore").read_text().split()[0] == "/target")
            elif word == "ENV":
                env |= dict(pair.split("=", 1) for pair in rest.split())
            elif word == "RUN":
                step = {"PATH": f"{tools}:{SYSTEM_PATH}", **env}
                ran = subprocess.run(["sh", "-ec", rest], cwd=root / cwd.strip("/"), env=step, capture_output=True, text=True)
                self.assertEqual(ran.returncode, 0, rest + ran.stderr)
                installed = ran.stdout
            else:
                self.assertEqual(word, "ENTRYPOINT")
                entry = json.loads(rest)
        # What NVIDIA's container runtime needs, to put the driver of the host into the container: its capability, and GLVND.
        self.assertIn("graphics", env["NVIDIA_DRIVER_CAPABILITIES"].split(","))
        for package in ("libgl1", "libegl1", "mesa-vulkan-drivers", "libvulkan1"):
            self.assertRegex(installed, rf"(?m)^Inst {package} |{package} is already the newest version")
        shutil.copy(ROOT / "scenes/cornell.ron", root / "work")
        run = [root / "usr/local/bin" / entry[0], *entry[1:], "render", "cornell.ron", "--size", "16x16", "--spp", "16"]
        env |= {name: os.environ[name] for name in ("VK_DRIVER_FILES", "LD_LIBRARY_PATH") if name in os.environ}
        ran = subprocess.run(run, cwd=root / cwd.strip("/"), env=env, capture_output=True, text=True)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertEqual(gpu_rt.Image(root / "work/cornell.exr").shape, (16, 16, 3))


if __name__ == "__main__":
    unittest.main()
