#!/usr/bin/env bash
# Whether files as people bring them show something: each of 82 controllers, none of which has a lamp, gets a sky, also the 11 with lights that
# glow. `run.sh PROGRAM`
set -euo pipefail
program=$1
here=$(dirname "$0")
work=target/files
. "$here/../fetch.sh"
fetch "$here" "$work"
files=0 glowing=0
for file in "$work"/node_modules/@webxr-input-profiles/assets/dist/profiles/*/*.glb; do
    notes=$("$program" convert "$file" -o "$work/scene.ron" --force 2>&1)
    grep -q "background: Gradient" "$work/scene.ron" || { echo "error: $file has no sky" >&2; exit 1; }
    files=$((files + 1))
    if grep -q "its emitters give only" <<<"$notes"; then glowing=$((glowing + 1)); fi
done
[ "$files $glowing" = "82 11" ] || { echo "error: $glowing of $files files glow, expected 11 of 82" >&2; exit 1; }
# The control: without the sky a controller is nearly black.
"$program" convert "$file" --sky none -o "$work/scene.ron" --force 2>/dev/null
grep -q "background: Solid((0" "$work/scene.ron" || { echo "error: --sky none leaves a sky" >&2; exit 1; }
