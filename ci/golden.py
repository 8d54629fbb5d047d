#!/usr/bin/env python3
"""Renders scenes, and compares each with its golden image, by the environment that action.yml names: SCENES, GOLDENS, OUTPUT, OPTIONS,
FAIL_ABOVE, VERDICT. The exit status is 1 if an image fails or has no golden image. Lines that begin with :: are GitHub's annotations.
With the argument `hash` it prints a hash of what kernels follow from: the scenes and the options."""

import glob
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

failed = False


def annotate(level, message, **place):
    """Prints an annotation, which is one line. An error counts, a warning does not."""
    global failed
    failed |= level == "error"
    escape = lambda value: str(value).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    where = ",".join(f"{key}=" + escape(value).replace(":", "%3A").replace(",", "%2C") for key, value in place.items())
    print(f"::{level}{where and ' ' + where}::{escape(message)}", flush=True)


def run(log, *words, **options):
    """Runs the program. Its errors become annotations, those of a scene beside its line. Returns whether it has succeeded."""
    ran = subprocess.run(["gpu-rt", *words], stderr=subprocess.PIPE, text=True, errors="replace", **options)
    Path(log).write_text(ran.stderr)
    said, *errors = re.split("^error: ", ran.stderr, flags=re.M)
    print(said, end="", flush=True)
    for error in errors or ([f"gpu-rt {words[0]} ended with status {ran.returncode}"] if ran.returncode else []):
        place = re.match(r"([^\n]+?):(\d+):(\d+): (.*)", error, re.S)
        if place:
            annotate("error", place[4].strip(), file=place[1], line=place[2], col=place[3])
        else:
            annotate("error", error.strip())
    return ran.returncode == 0


def matches(pattern):
    return [pattern] if os.path.exists(pattern) else sorted(filter(os.path.isfile, glob.glob(pattern, recursive=True)))


def find_scenes(text):
    """The scenes by their names, without an ending: those of files, or of one name in several folders, of paths. And what is wrong."""
    scenes, problems = {}, []
    for line in filter(None, map(str.strip, text.splitlines())):
        # A line is a path or a pattern with spaces in it, or several.
        for word in [line] if matches(line) else shlex.split(line):
            scenes.update(dict.fromkeys(map(os.path.normpath, matches(word))))
            problems += [] if matches(word) else [f"scenes: no file is named {word}"]
    if not scenes and not problems:
        problems.append("scenes: nothing is to be rendered: name a scene, or a pattern such as scenes/*.ron")
    named = {}
    stems = [Path(scene).stem for scene in scenes]
    for scene, stem in zip(scenes, stems):
        name = stem if stems.count(stem) == 1 else os.path.splitext(os.path.relpath(scene))[0].replace("../", "")
        if name in named:
            problems.append(f"scenes: {named[name]} and {scene} have one name, {name}: rename one of them")
        named[name] = scene
    return named, problems


def check(name, scene, env, options, limits):
    """Renders a scene and compares it. Returns its row of the summary."""
    at, golden = f"{env['OUTPUT']}/{name}", f"{env['GOLDENS']}/{name}.exr"
    image, log = f"{at}.exr", f"{at}.log"
    os.makedirs(os.path.dirname(at), exist_ok=True)
    # A name that begins with - is no option.
    path = f"./{scene}" if scene.startswith("-") else scene
    if not run(log, "render", path, *options, "-o", image, "--png", f"{at}.png", "--force"):
        return [scene, "", "", "", "not rendered"]
    if not os.path.exists(golden):
        annotate("error", f"{golden} is missing: if {image} of the uploaded files is right, it becomes {golden}")
        return [scene, "", "", "", "no golden image"]
    with open(f"{at}.json", "w+") as file:
        run(log, "compare", image, golden, *limits, "--heatmap", f"{at}.heatmap.png", "--json", stdout=file)
        file.seek(0)
        report = json.loads(file.read() or "{}")
    p, verdict = report.get("p"), report.get("verdict", "not compared")
    print(f"{scene}: {verdict}")
    # p is null if nothing says how much of a difference is noise: then only limits decide.
    if report and p is None and not limits:
        annotate("error", f"{scene}: noise cannot be told from a difference: give fail-above")
    elif p is not None and p < report["level"]:
        annotate("warning" if env["VERDICT"] == "warn" else "error", f"{scene}: {verdict}")
    return [scene, report.get("relmse", ""), report.get("flip", ""), "" if p is None else p, verdict]


def main(env):
    scenes, problems = find_scenes(env["SCENES"])
    if sys.argv[1:] == ["hash"]:
        parts = [env["OPTIONS"].encode(), *(Path(scene).read_bytes() for scene in scenes.values() if os.path.isfile(scene))]
        print(hashlib.sha256(b"\0".join(parts)).hexdigest()[:16])
        return
    options, limits = shlex.split(env["OPTIONS"]), [f"--fail-above={limit}" for limit in env["FAIL_ABOVE"].split()]
    if os.path.realpath(env["OUTPUT"]) == os.path.realpath(env["GOLDENS"]):
        problems.append(f"output: {env['OUTPUT']} is the folder of the golden images, which would be overwritten: name another")
    for problem in problems:
        annotate("error", problem)
    if problems:
        return
    rows = [["scene", "relMSE", "FLIP", "p", "verdict"], ["---"] * 5]
    for name, scene in scenes.items():
        print(f"::group::{scene}")
        rows.append(check(name, scene, env, options, limits))
        print("::endgroup::", flush=True)
    with open(env.get("GITHUB_STEP_SUMMARY", os.devnull), "a") as summary:
        summary.writelines("| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |\n" for row in rows)


try:
    main(os.environ)
except ValueError as error:  # a quotation mark without its other one
    # What prints the hash has its output taken.
    sys.stdout = sys.stderr
    annotate("error", f"options, scenes: {error}")
sys.exit(failed)
