#!/usr/bin/env bash
# Renders scenes, and compares each with its golden image, by the environment that action.yml names: SCENES, GOLDENS, OUTPUT, OPTIONS,
# FAIL_ABOVE, VERDICT. The exit status is 1 if an image fails or has no golden image. Lines that begin with :: are GitHub's annotations.
set -euo pipefail
mkdir -p "$OUTPUT"
summary=${GITHUB_STEP_SUMMARY:-/dev/null}
printf '| scene | relMSE | FLIP | p | verdict |\n|---|---|---|---|---|\n' >>"$summary"
failed=0

# `fail LEVEL MESSAGE`: an error counts, a warning does not.
fail() {
    echo "::$1::$2"
    [ "$1" = warning ] || failed=1
}

# An error of a scene shows beside its line.
annotate() { sed -E 's/^error: (.+):([0-9]+):([0-9]+): (.*)/::error file=\1,line=\2,col=\3::\4/; s/^error: /::error::/' "$1"; }

# A number or a text of the report that `compare --json` has printed.
value() { sed -n "s/^  \"$2\": \"\{0,1\}\(.*[^,\"]\)\"\{0,1\},\{0,1\}$/\1/p" "$1"; }

limits=()
for limit in $FAIL_ABOVE; do limits+=(--fail-above "$limit"); done

# Unquoted: patterns become names, and options words.
for scene in $SCENES; do
    name=$(basename "${scene%.*}")
    image=$OUTPUT/$name.exr golden=$GOLDENS/$name.exr report=$OUTPUT/$name.json
    echo "::group::$scene"
    log=$OUTPUT/$name.log
    if ! gpu-rt render "$scene" $OPTIONS -o "$image" --png "$OUTPUT/$name.png" --force 2>"$log"; then
        failed=1
        annotate "$log"
    elif annotate "$log" && [ ! -e "$golden" ]; then
        fail error "$golden is missing: if $image of the uploaded files is right, it becomes $golden"
    else
        gpu-rt compare "$image" "$golden" "${limits[@]}" --heatmap "$OUTPUT/$name.heatmap.png" --json >"$report" 2>"$log" || failed=1
        annotate "$log"
        p=$(value "$report" p) level=$(value "$report" level) verdict=$(value "$report" verdict)
        echo "$scene: $verdict"
        # p is null if nothing says how much of a difference is noise: then only limits decide. It is empty if no images were compared.
        if [ "$p" = null ] && [ ${#limits[@]} = 0 ]; then
            fail error "$scene: noise cannot be told from a difference: give fail-above"
        elif [ -n "$p" ] && [ "$p" != null ] && awk "BEGIN { exit !($p < $level) }"; then
            [ "$VERDICT" = warn ] && kind=warning || kind=error
            fail $kind "$scene: $verdict"
        fi
        echo "| $scene | $(value "$report" relmse) | $(value "$report" flip) | $p | $verdict |" >>"$summary"
    fi
    echo "::endgroup::"
done
exit $failed
