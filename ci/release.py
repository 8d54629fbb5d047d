#!/usr/bin/env python3
"""Packs a release: `release.py FOLDER TAG`. Beside each wheel in the folder it writes an archive of the program, and Blender's extension with the
program inside, both of the program that the wheel has. The tag is v and the version, which is one in all of them."""

import io
import re
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# The platforms, as Blender names them, by what the names of wheels have.
PLATFORMS = {
    r"linux.*_x86_64": "linux-x64",
    r"linux.*_aarch64": "linux-arm64",
    r"macosx.*_arm64": "macos-arm64",
    r"macosx.*_x86_64": "macos-x64",
    r"win_amd64": "windows-x64",
}
# For these there is no Blender.
WITHOUT_BLENDER = {"linux-arm64"}


def files(*names):
    """The files of the repository under these names, sorted."""
    found = [path for name in names for path in ([ROOT / name] if (ROOT / name).is_file() else (ROOT / name).rglob("*"))]
    return sorted(path for path in found if path.is_file() and "__pycache__" not in path.parts)


def extension(platform, version, name, program):
    """The extension: its files, the program in bin/, and a manifest that says the platform."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files("blender/gpu_rt"):
            content = path.read_bytes()
            if path.name == "blender_manifest.toml":
                found = re.search('^version = "(.*)"$', content.decode(), re.M)[1]
                if found != version:
                    sys.exit(f"error: {path} has the version {found}, and the wheel {version}")
                content = content.replace(b", which is installed apart", b"", 1)
                content = content.replace(b"\n[permissions]", f'platforms = ["{platform}"]\n\n[permissions]'.encode(), 1)
            archive.writestr(str(path.relative_to(ROOT / "blender/gpu_rt").as_posix()), content)
        archive.writestr(f"bin/{name}", program)
    return packed.getvalue()


def archive(top, name, program):
    """A .tar.gz, which Windows unpacks too."""
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz", compresslevel=6) as archive:
        for path in files("README.md", "LICENSE-APACHE", "LICENSE-MIT", "scenes"):
            archive.add(path, f"{top}/{path.relative_to(ROOT).as_posix()}")
        entry = tarfile.TarInfo(f"{top}/{name}")
        entry.size, entry.mode = len(program), 0o755
        archive.addfile(entry, io.BytesIO(program))
    return packed.getvalue()


def main(folder, tag):
    wheels = sorted(Path(folder).glob("gpu_rt-*.whl"))
    if not wheels:
        sys.exit(f"error: {folder} has no wheel")
    for wheel in wheels:
        _, version, *_, system = wheel.stem.split("-")
        platform = next((platform for pattern, platform in PLATFORMS.items() if re.search(f"{pattern}$", system)), None)
        if tag != f"v{version}" or not platform:
            sys.exit(f"error: {wheel.name}: expected the version of the tag {tag}, and a platform of {', '.join(PLATFORMS.values())}")
        name = "gpu-rt.exe" if platform.startswith("windows") else "gpu-rt"
        with zipfile.ZipFile(wheel) as contents:
            program = contents.read(f"gpu_rt-{version}.data/scripts/{name}")
        top = f"gpu-rt-{version}-{platform}"
        (wheel.parent / f"{top}.tar.gz").write_bytes(archive(top, name, program))
        if platform not in WITHOUT_BLENDER:
            named = f"gpu_rt-{version}-{platform.replace('-', '_')}.zip"
            (wheel.parent / named).write_bytes(extension(platform, version, name, program))


main(*sys.argv[1:])
