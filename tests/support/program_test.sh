# For tests/*/test_*.sh that run the program from outside, to be sourced by a script that is given the program's path. Leaves $program,
# $lab (viewworth-lab, beside it), $root of the tree, an empty $folder that is removed at the end, $small (options of a training that
# takes a second or two), checks (shell_test.sh) and queries (run_rows.sh).

program=$(realpath "$1")
lab=$(dirname "$program")/viewworth-lab
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/support/shell_test.sh"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
. "$root/tests/support/run_rows.sh"
# Without --effects auto, which takes longer than such a training: it tries out which effects help.
small=(--rays 64 --samples 16 --val-rays 64 --levels 4 --log2-table 10 --width 16 --effects none --device llvmpipe)

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

# fails CODE PATTERN COMMAND...: that exit code, nothing on stdout, and one line on stderr that matches.
fails() {
    local code=0
    "${@:3}" >"$folder/stdout" 2>"$folder/stderr" || code=$?
    [[ $code -eq $1 && ! -s $folder/stdout && $(wc -l <"$folder/stderr") -eq 1 ]] &&
        grep -qE "^viewworth(-lab)?: .*($2)" "$folder/stderr" && return
    echo "exit code $code:"
    cat "$folder/stdout" "$folder/stderr"
    return 1
}
