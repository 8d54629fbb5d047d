#!/usr/bin/env bash
# Whether the kernels are valid WGSL by another compiler than naga, which lets pass what the standard forbids: all kernels of the scenes that
# ship, in every way of linking. `run.sh PROGRAM`
set -euo pipefail
program=$1
here=$(dirname "$0")
work=target/tint
. "$here/../fetch.sh"
# The package's script, which is left out, only deletes the libraries of other systems.
fetch "$here" "$work"
mkdir "$work/kernels"
cp "$here/check.mjs" "$work"
for scene in scenes/*.ron; do
    for scatter in fused linked queues; do
        "$program" plan "$scene" --scatter $scatter --wgsl "$work/kernels/$(basename "$scene" .ron)-$scatter" >/dev/null
    done
done
node "$work/check.mjs" "$work/kernels"
