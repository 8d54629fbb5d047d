"""The export of a scene by a second Blender: its job, and its answer."""

import json
import pathlib
import sys

import bpy

from .process import Failure

SCENE, ANSWER = "scene.ron", "answer.json"


def job_of(scene, folder, job):
    """Writes a job and a copy of the file into a folder. Returns the command of the second Blender."""
    blend = str(folder / "copy.blend")
    try:
        bpy.data.libraries.write(blend, {scene}, path_remap="ABSOLUTE")
    except (OSError, RuntimeError):
        # Blender's own words may be "Success".
        raise Failure(f"A copy of the file cannot be written to {folder}: is the disk full?") from None
    job = {"blend": blend, "scripts": bpy.context.preferences.filepaths.use_scripts_auto_execute, **job}
    (folder / "job.json").write_text(json.dumps(job), encoding="utf-8")
    script = str(pathlib.Path(__file__).with_name("export.py"))
    blender = bpy.app.binary_path
    command = [blender, "--background", "--factory-startup", "--python", script, "--"] if blender else [sys.executable, script]
    return [*command, str(folder / "job.json")]


def answer_of(folder, ended, said):
    """What the second Blender answers. `ended` is how it has, and `said` its lines of standard error."""
    (folder / "export.log").write_text(ended.output + "\n".join(said), encoding="utf-8")
    try:
        answer = json.loads((folder / ANSWER).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        last = "".join(f": {line}" for line in said[-1:])
        raise Failure(f"The second Blender that exports the scene ended with status {ended.status}{last}") from None
    if "error" in answer:
        raise Failure(answer["error"])
    return answer
