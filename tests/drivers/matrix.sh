#!/usr/bin/env bash
# The tests on several drivers, as a matrix: `tests/drivers/matrix.sh [DRIVER...]`, all by default. On Debian 12 on x86-64; the packages are
# unpacked under target/drivers, nothing is installed. `matrix.sh judge DRIVER LOG` judges what cargo test has written.
# `matrix.sh radv` fetches RADV, Mesa's driver of AMD's GPUs, and prints the environment in which it is found.
set -euo pipefail
cd "$(dirname "$0")/../.."

# `rough-up` and `rough-down` are Mesa 25.0.7 with quotients and roots as inexact as GPUs make them (tests/layer/rough.rs).
drivers=(mesa-22.3.6 mesa-25.0.7 rough-up rough-down swiftshader)
kept=$PWD/target/drivers
known=${KNOWN_FAILURES:-tests/drivers/known.txt}

# What runs where. SwiftShader takes eight times as long: what asks the most of its arithmetic.
tests_on() {
    case $1 in
        swiftshader) echo extremes images kernels program ;;
        rough-*) echo kernels ;;
        *) echo extremes host images kernels program timed ;;
    esac
}
skipped_on() {
    case $1 in
        swiftshader) echo estimators features narrow_lobes references sobol trade_offs warnings ;;
        rough-*) ;;
        *) echo tradeoff ;;
    esac
}

fail() {
    echo "error: $*" >&2
    exit 2
}

# apt-get with lists of its own: Debian's as this machine has them, and the backports of the same mirror.
apt_here() {
    local state=$kept/apt
    if [ ! -e "$state/sources.list" ]; then
        command -v apt-get >/dev/null || fail "there is no apt-get here: the packages of drivers are Debian's"
        local mirror
        mirror=$(apt-get indextargets --format '$(RELEASE) $(REPO_URI)' | awk '$1 == "bookworm" { print $2; exit }')
        [ -n "$mirror" ] || fail "apt-get has no lists of Debian 12 (bookworm): run \`apt-get update\` as root, on Debian 12"
        mkdir -p "$state/lists/partial" "$state/cache/archives/partial"
        printf 'deb %s %s main\n' "$mirror" bookworm "$mirror" bookworm-backports >"$state/sources.list"
    fi
    apt-get -qq -o Dir::Etc::SourceList="$state/sources.list" -o Dir::Etc::SourceParts=/dev/null \
        -o Dir::State::Lists="$state/lists" -o Dir::Cache="$state/cache" -o Debug::NoLocking=true -o APT::Sandbox::User=root "$@"
}

# `unpack DRIVER PACKAGE...` unless that was done before.
unpack() {
    local into=$kept/$1
    shift
    [ ! -e "$into/done" ] || return 0
    rm -rf "$into"
    mkdir -p "$into"
        apt_here update
    (cd "$into" && apt_here download "$@")
    local package
    for package in "$into"/*.deb; do
        dpkg -x "$package" "$into"
        rm "$package"
    done
    touch "$into/done"
}

# Fetches a driver and says by which manifest the Vulkan loader finds it.
manifest_of() {
    # RADV is in the package of Mesa.
    local driver=${1/radv/mesa} library manifest missing
    driver=${driver/#rough-*/mesa-25.0.7}
    local into=$kept/$driver
    case $driver in
        mesa-22.3.6) unpack "$driver" mesa-vulkan-drivers/bookworm libdrm2/bookworm libllvm15/bookworm ;;
        mesa-25.0.7) unpack "$driver" mesa-vulkan-drivers/bookworm-backports libdrm2/bookworm-backports libllvm15/bookworm ;;
        swiftshader) unpack "$driver" chromium-common/bookworm ;;
        *) fail "no driver is named $1, expected one of: ${drivers[*]}" ;;
    esac
    case $1 in
        swiftshader) library=$into/usr/lib/chromium/libvk_swiftshader.so ;;
        radv-*) library=$into/usr/lib/x86_64-linux-gnu/libvulkan_radeon.so ;;
        *) library=$into/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so ;;
    esac
    missing=$(LD_LIBRARY_PATH=${library%/*} ldd "$library" | awk '/not found/ { print $1 }')
    [ -z "$missing" ] || fail "$1 needs libraries that are not here: $missing. \`apt-get install mesa-vulkan-drivers\` brings them"
    manifest=$into/$1.json
    echo "{\"file_format_version\": \"1.0.0\", \"ICD\": {\"library_path\": \"$library\", \"api_version\": \"1.1.0\"}}" >"$manifest"
    echo "$manifest $library"
}

# A line for each test binary, and faults: failures that are not known, and known ones that are gone.
judge() {
    awk -v driver="$1" -v known_file="$known" '
        BEGIN {
            while ((getline line < known_file) > 0) {
                if (line ~ /^#/ || split(line, part, / *[|] */) < 3 || part[1] != driver) continue
                known[part[2]] = part[3]
            }
        }
        $1 == "Running" { binary = $2; sub(/(\/main)?\.rs$/, "", binary); sub(/.*\//, "", binary); order[++binaries] = binary }
        $1 == "test" && $2 == "result:" { ended[binary] = 1 }
        $1 == "test" && $2 != "result:" && $NF ~ /^(ok|FAILED)$/ {
            name = binary "::" $2
            if ($NF == "ok") { ok[binary]++; passed[name] = 1 } else failed[name] = binary
        }
        $1 == "----" && $3 == "stdout" { name = binary "::" $2; next }
        { message[name] = message[name] "\n" $0 }
        END {
            for (name in failed) {
                if (name in known && index(message[name], known[name])) { expected[failed[name]]++; continue }
                unexpected[failed[name]]++
                fault("fails" (name in known ? " with other words than \"" known[name] "\"" : "") ":" message[name])
            }
            for (name in known) if (!(name in failed)) fault(name in passed ? "passes: take it out of known failures" : "is known to fail and was not run")
            for (i = 1; i <= binaries; i++) {
                binary = order[i]
                cell = ok[binary] + 0 " passed"
                if (expected[binary]) cell = cell ", " expected[binary] " known"
                if (unexpected[binary]) cell = cell ", " unexpected[binary] " FAILED"
                if (!ended[binary]) { cell = cell ", DIED"; name = binary; fault("died before its end") }
                printf "%s\t%s\t%s\n", driver, binary, cell
            }
            if (!binaries) { name = "cargo test"; fault("ran nothing") }
            exit faults > 0
        }
        function fault(what) { faults++; gsub(/\n+/, " ", what); printf "fault: %s: %s %s\n", driver, name, substr(what, 1, 600) }
    ' "$2"
}

run_on() {
    local driver=$1 manifest library log=$kept/$1.log arguments=() skipped=() name
    read -r manifest library < <(manifest_of "$driver")
    [ -n "${library:-}" ] || exit 2
    for name in $(tests_on "$driver"); do arguments+=(--test "$name"); done
    for name in $(skipped_on "$driver"); do skipped+=(--skip "$name::"); done
    local run=(env VK_DRIVER_FILES="$manifest" VK_ICD_FILENAMES="$manifest" NODEVICE_SELECT=1 LVP_POISON_MEMORY=true
        LD_LIBRARY_PATH="${library%/*}")
    if [[ $driver = rough-* ]]; then
        mkdir -p "$kept/layer"
        rustc --edition 2024 --crate-type cdylib -o "$kept/layer/libfault.so" tests/layer/fault.rs
        cp tests/layer/fault.json "$kept/layer"
        run+=(GPU_RT_NO_CONTRACTION=1 GPU_RT_ROUGH="${driver#rough-}" VK_LAYER_PATH="$kept/layer" VK_INSTANCE_LAYERS=VK_LAYER_GPU_RT_fault)
    fi
    echo "== $driver"
    "${run[@]}" cargo run --release --quiet -- devices | sed 's/^/   /'
    local begin=$SECONDS
    "${run[@]}" cargo test --release --no-fail-fast "${arguments[@]}" -- "${skipped[@]}" >"$log" 2>&1 || true
    judge "$driver" "$log" >>"$kept/verdicts" || true
    echo "   $((SECONDS - begin)) s, written to $log"
}

if [ "${1:-}" = judge ]; then
    judge "$2" "$3"
    exit
fi
if [ "${1:-}" = radv ]; then
    read -r manifest library < <(manifest_of radv-25.0.7)
    [ -n "${library:-}" ] || exit 2
    echo "VK_DRIVER_FILES=$manifest LD_LIBRARY_PATH=${library%/*}"
    exit
fi
[ $# -eq 0 ] || drivers=("$@")
mkdir -p "$kept"
: >"$kept/verdicts"
cargo test --release --no-run
for driver in "${drivers[@]}"; do run_on "$driver"; done
echo
awk -F '\t' -v drivers="${drivers[*]}" '
    /^fault: / { next }
    NF == 3 { cell[$1, $2] = $3; if (!seen[$2]++) order[++rows] = $2 }
    END {
        columns = split(drivers, driver, " ")
        printf "%-14s", ""; for (c = 1; c <= columns; c++) printf "%-24s", driver[c]; print ""
        for (r = 1; r <= rows; r++) {
            printf "%-14s", order[r]
            for (c = 1; c <= columns; c++) printf "%-24s", ((driver[c], order[r]) in cell ? cell[driver[c], order[r]] : "-")
            print ""
        }
    }' "$kept/verdicts"
if grep -q '^fault: ' "$kept/verdicts"; then
    echo
    grep '^fault: ' "$kept/verdicts"
    exit 1
fi
