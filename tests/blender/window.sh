#!/usr/bin/env bash
# The 3D view in a window of Blender: `make test-blender-window`. Debian 12 and Ubuntu 24.04 have older ones than 4.2, and Blender's Python
# module has no window: so Debian 13 with its Blender and Xvfb goes into target/blender-window. Needs root, debootstrap, and the program.
#
# GPU_RT_BIN names the program, and further arguments are those of window.py.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
gpu_rt=$(realpath "${GPU_RT_BIN:-$root/target/release/gpu-rt}")
tree=$root/target/blender-window
if [ ! -d "$tree" ]; then
    rm -rf "$tree.part"
    debootstrap --variant=minbase trixie "$tree.part" >/dev/null
    chroot "$tree.part" apt-get install -y -qq --no-install-recommends \
        blender libgl1-mesa-dri libvulkan1 mesa-vulkan-drivers python3-numpy xauth xvfb >/dev/null
    mv "$tree.part" "$tree"
fi
# The repository has its own path in there, as has the program. Mounts end with the shell that makes them.
export root gpu_rt tree
exec unshare --mount --propagation private bash -euo pipefail -c '
    for folder in "$root" "$(dirname "$gpu_rt")" /proc /dev; do
        mkdir -p "$tree$folder"
        mount --rbind "$folder" "$tree$folder"
    done
    exec chroot "$tree" env -i PATH="$(dirname "$gpu_rt"):/usr/bin:/bin" HOME=/root NODEVICE_SELECT=1 LIBGL_ALWAYS_SOFTWARE=1 \
        xvfb-run --auto-servernum --server-args="-screen 0 640x420x24" \
        blender --factory-startup --window-geometry 0 0 640 420 --python-exit-code 1 --python "$root/tests/blender/window.py" -- "$@"
' bash "$@"
