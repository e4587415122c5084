# For tests/*/test_*.sh that run the program from outside, to be sourced by a script that is given the program's path. Leaves $program,
# $lab (viewworth-lab, beside it), $root of the tree, $scene (a tiny one), an empty $folder that is removed at the end, $small (options of
# a training that takes a second or two), checks (shell_test.sh) and queries (run_rows.sh).
set -uo pipefail

program=$(realpath "$1")
lab=$(dirname "$program")/viewworth-lab
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/support/shell_test.sh"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
. "$root/tests/support/run_rows.sh"
scene=$root/tests/support/tiny.json
# Without --effects auto, which takes longer than such a training: it tries out which effects help. The rate stays, so that a longer
# training begins as a shorter one.
small=(--rays 64 --samples 16 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 4 --log2-table 10
    --width 16 --effects none --device llvmpipe)

# on_two_devices ARRAY COMMAND...: with --devices in place of --device in the array of options; both are lavapipe.
on_two_devices() {
    local -n options_of_test=$1
    local one=("${options_of_test[@]}") code=0
    options_of_test=("${one[@]/#--device/--devices}")
    options_of_test=("${options_of_test[@]/#llvmpipe/llvmpipe,llvmpipe}")
    "${@:2}" || code=$?
    options_of_test=("${one[@]}")
    return "$code"
}

# run COMMAND...: keeps stdout and stderr in $folder, and shows them when the command fails.
run() {
    "$@" >"$folder/stdout" 2>"$folder/stderr" && return
    local code=$?
    cat "$folder/stdout" "$folder/stderr"
    return "$code"
}

# prints PATTERN COMMAND...: the command succeeds and its stdout has a line that matches.
prints() {
    run "${@:2}" || return
    grep -qE -- "$1" "$folder/stdout" && return
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

# fails CODE PATTERN COMMAND...: that exit code, nothing on stdout, and one line on stderr that matches, beside the warning of a ledger
# which the test itself edited.
edited='the ledger was edited, and so may be what follows from it$|validation photos? makes? the scores'
fails() {
    local code=0
    "${@:3}" >"$folder/stdout" 2>"$folder/stderr" || code=$?
    [[ $code -eq $1 && ! -s $folder/stdout && $(grep -vcE "$edited" "$folder/stderr") -eq 1 ]] &&
        grep -qE "^viewworth(-lab)?: .*($2)" "$folder/stderr" && return
    echo "exit code $code:"
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

# says PATTERN: the last command that was run did so, in a line of stdout.
says() { grep -qE -- "$1" "$folder/stdout" || { cat "$folder/stdout" "$folder/stderr"; return 1; }; }

# answers SQL COMMAND...: the command's stdout is JSON, nothing else, and the expression on it, called j, is true.
answers() {
    "${@:2}" >"$folder/answer.json" 2>"$folder/stderr" &&
        [[ $(sqlite3 :memory: "WITH answer AS (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j)
            SELECT CASE WHEN json_valid(j) THEN ($1) END FROM answer") == 1 ]] && return
    cat "$folder/answer.json" "$folder/stderr"
    return 1
}

# json PATH: of what the last command that was run printed.
json() { sqlite3 :memory: "SELECT CAST(readfile('$folder/stdout') AS TEXT) ->> '$1'"; }

# checksums OUT: of all its files.
checksums() { (cd "$folder/$1" && find . -type f -exec sha256sum {} + | sort -k2); }

# near NUMBER NUMBER [TOLERANCE]: they are equal to the rounding of sums in another order.
near() { awk -v a="$1" -v b="$2" -v most="${3:-1e-9}" 'BEGIN { d = a - b; exit !(a != "" && b != "" && d < most && -d < most) }'; }

# same_dump OUT OUT: two batches have merged the same runs.
dump() { sqlite3 -bail "$folder/$1/merged.db" <"$root/tests/support/canonical_dump.sql"; }
same_dump() {
    dump "$1" >"$folder/dump" && dump "$2" >"$folder/other_dump" && [[ $(wc -l <"$folder/dump") -gt 100 ]] || return
    diff "$folder/dump" "$folder/other_dump" >"$folder/diff" && return
    head -n 5 "$folder/diff"
    return 1
}

# write_photo FILE: a PNG of 8 x 6 pixels.
write_photo() {
    base64 -d >"$1" <<<'iVBORw0KGgoAAAANSUhEUgAAAAgAAAAGCAIAAABxZ0isAAAAY0lEQVR4nA3JIQEAMQwEwYgIrpJTUhwRhSsguEpOyeOI+Q6dyCAX
KXKTh7ykyY9QoIWENjroIqMXFdSiRG3qUJcy9aKDXrToTR/60qZfOPDCwhsffLHxiwlmMWI2c5jLmPn4AeieQjFag8aUAAAAAElFTkSuQmCC'
}

# write_photos FOLDER: a photo of each name in the array `names`.
write_photos() {
    local i
    for i in "${!names[@]}"; do
        mkdir -p "$(dirname "$1/${names[i]}")"
        write_photo "$1/${names[i]}"
        printf '%s' "$i" >>"$1/${names[i]}" # behind the image's end: only its hash differs
    done
}
