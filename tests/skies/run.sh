#!/usr/bin/env bash
# Whether the environment maps that people use are read, with at most the one warning about numbers that are no light: the presets of npm's
# @pmndrs/assets, and the studio lights of Blender. Two of them are rendered. `run.sh PROGRAM FOLDER_OF_STUDIO_LIGHTS`
set -euo pipefail
program=$1
lights=$2
here=$(dirname "$0")
work=target/skies
. "$here/../fetch.sh"
fetch "$here" "$work"
mkdir "$work/skies"
cp "$lights"/*.exr "$work/skies"
# Each preset is a module whose value is a file as a data URL.
node --input-type=module - "$work" <<'JS'
import { readdirSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
const presets = resolve(process.argv[2], "node_modules/@pmndrs/assets/hdri");
for (const name of readdirSync(presets).filter((name) => name.endsWith(".exr.js"))) {
    const url = (await import(resolve(presets, name))).default;
    writeFileSync(resolve(process.argv[2], "skies", `preset-${name.slice(0, -3)}`), Buffer.from(url.split(",")[1], "base64"));
}
JS

scene() {
    cat >"$work/scene.ron" <<RON
Scene(
    image: (width: 16, height: 8),
    camera: (look_from: (0, 1, 4), look_at: (0, 0, 0), vertical_fov: 40),
    background: Image(path: "skies/$1"),
    materials: {"floor": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))},
    objects: [Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: "floor")],
)
RON
}

count=0 warned=0
for file in "$work"/skies/*.exr; do
    scene "$(basename "$file")"
    found=$("$program" check "$work/scene.ron") || { echo "error: $file is refused"; exit 1; }
    others=$(grep '^warning' <<<"$found" | grep -v 'negative, infinite or NaN, the largest of them -[0-9.e-]*: they count as 0' || true)
    [ -z "$others" ] || { echo "error: $others"; exit 1; }
    ! grep -q '^warning' <<<"$found" || warned=$((warned + 1))
    count=$((count + 1))
done
# 18 presets and 8 studio lights, of which one has no such number.
[ "$count $warned" = "26 25" ] || { echo "error: of $count files $warned have a warning, and not 25 of 26"; exit 1; }
for name in interior preset-sky; do
    scene $name.exr
    "$program" render "$work/scene.ron" --spp 4 --quiet -o "$work/$name.exr" --png "$work/$name.png"
done
# What is not read is found.
head -c 5000 "$work/skies/interior.exr" >"$work/skies/cut.exr"
scene cut.exr
! "$program" check "$work/scene.ron" 2>/dev/null || { echo "error: half a file is read"; exit 1; }
