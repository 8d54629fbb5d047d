#!/usr/bin/env bash
# Installs Mesa's software driver where no driver answers, and the program: `install.sh PACKAGE`, a wheel or a folder with the source. Both
# stay in ~/.cache/gpu-rt, which action.yml keeps between runs. On Debian and Ubuntu, and on any Linux that has a driver and Python with venv.
set -euo pipefail
cache=$HOME/.cache/gpu-rt
root=; [ "$(id -u)" = 0 ] || root=sudo

if ! ls /usr/share/vulkan/icd.d/lvp_icd*.json >/dev/null 2>&1 || ! python3 -c 'import ensurepip' 2>/dev/null; then
    command -v apt-get >/dev/null || { echo "::error::no apt-get is here: install Mesa's Vulkan drivers, and Python with pip and venv"; exit 1; }
    $root apt-get update -qq
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        libvulkan1 mesa-vulkan-drivers python3 python3-pip python3-venv
fi

# A copy from the cache may be of another runner, whose Python has gone.
if ! "$cache/program/bin/python" -c 'import gpu_rt; gpu_rt.program()' 2>/dev/null; then
    rm -rf "$cache/program"
    python3 -m venv "$cache/program"
    "$cache/program/bin/pip" install --quiet "$1"
fi

mkdir -p "$cache/kernels"
echo "$cache/program/bin" >>"$GITHUB_PATH"
# Mesa's cache of compiled kernels, some 0.1 MB a scene; what is not used leaves it. NODEVICE_SELECT: its layer complains where no desktop can be asked about GPUs.
printf '%s\n' "MESA_SHADER_CACHE_DIR=$cache/kernels" MESA_SHADER_CACHE_MAX_SIZE=64M NODEVICE_SELECT=1 >>"$GITHUB_ENV"
"$cache/program/bin/gpu-rt" devices
