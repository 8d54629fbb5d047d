#!/usr/bin/env bash
# `tests/slowest.sh cargo test ...`: runs the tests, then lists the 30 slowest. Its status is that of the tests.
set -uo pipefail
log=$(mktemp)
trap 'rm -f "$log"' EXIT
# libtest measures its tests on nightly, or where RUSTC_BOOTSTRAP says so. Cargo must not see that variable: it would build everything again.
"$@" --config "target.'cfg(all())'.runner = ['env', 'RUSTC_BOOTSTRAP=1']" -- -Z unstable-options --report-time 2>&1 | tee "$log"
status=$?
echo "The slowest tests, in seconds of the clock while others ran beside them:"
awk '$1 == "Running" { program = $2; sub(/(\/main)?\.rs$/, "", program); sub(/.*\//, "", program) }
    $1 == "test" && $NF ~ /^<[0-9.]+s>$/ { printf "%8.2f  %s::%s\n", substr($NF, 2), program, $2 }' "$log" | sort -rn | head -30
exit $status
