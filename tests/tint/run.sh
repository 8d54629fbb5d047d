#!/usr/bin/env bash
# Whether the kernels are valid WGSL by another compiler than naga, which lets pass what the standard forbids: all kernels of the scenes that
# ship, in every way of linking. `run.sh PROGRAM`
set -euo pipefail
program=$1
here=$(dirname "$0")
work=target/tint
rm -rf "$work" && mkdir -p "$work/kernels"
cp "$here"/{package.json,package-lock.json,check.mjs} "$work"
# The package's script only deletes the libraries of other systems.
npm ci --prefix "$work" --ignore-scripts --no-audit --no-fund --silent
for scene in scenes/*.ron; do
    for scatter in fused linked queues; do
        "$program" plan "$scene" --scatter $scatter --wgsl "$work/kernels/$(basename "$scene" .ron)-$scatter" >/dev/null
    done
done
node "$work/check.mjs" "$work/kernels"
