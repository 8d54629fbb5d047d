#!/usr/bin/env bash
# Measures a device by the programs beside this file (`make gpu-kit`), in the root of the repository: `run.sh [DEVICE] [SECONDS]`, or `run.sh walks
# [DEVICE] [SECONDS]` for the walks through meshes alone. The figures go to the folder OUT, or to docs.
set -euo pipefail
export NODEVICE_SELECT=1
kit=$(cd "$(dirname "$0")" && pwd)
[ -e "$kit/gpu" ] || gunzip -f "$kit"/*.gz
# The tests look for the repository where it was when they were built.
built=$(cat "$kit/root")
[ -e "$built" ] || { mkdir -p "$(dirname "$built")" && ln -s "$PWD" "$built"; }
mkdir -p "$built/target/release" "$built/target/tmp"
[ -e "$built/target/release/gpu-rt" ] || cp "$kit/gpu-rt" "$built/target/release/"
if [ "${1:-}" = walks ]; then
    exec "$kit/walks" --device "${2:-}" --seconds "${3:-360}" --out "${OUT:-docs}"
fi
exec "$kit/gpu" --program "$kit/gpu-rt" --tests "$kit/kernels" --tests "$kit/images" --device "${1:-}" --seconds "${2:-540}" --out "${OUT:-docs}"
