#!/usr/bin/env bash
# That every file below OUT is in the table of src/run/out_files.c, which says what protects it: every name of such a file in the source
# must be there, or here with the reason why it is none.
# label: unsanitized
set -uo pipefail
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh

# Files of the user, of scenes and of the laboratory's own results, which the product never reads, and patterns in messages.
declare -A elsewhere=(
    [transforms.json]=scene [transforms_train.json]=scene [transforms_val.json]=scene [transforms_test.json]=scene
    [transforms_*.json]=scene [LOG.csv]=option [JOBS.json]=option [FILE.csv]=option [name.csv]=comment
    [worths.csv]=lab [exact.csv]=lab [photo_features.csv]=lab [probes.csv]=lab [probe_scores.csv]=lab [reproduce.csv]=lab
    [scatter.csv]=lab [lasting_seeds.csv]=lab [evaluation.csv]=lab
    [gradient_scores_*.csv]=lab [verdicts-*.json]=cache [*.csv]=extension [*.part]=temporary [*.txt]=fold
)

# names_in FOLDER: of files that string literals name, without their folders, with * for what is formatted in.
names_in() {
    grep -rhoE '"[^" ]*\.(db|csv|json|html|vwf|vwc|vws|png|txt|log|sh|part)"' "$1" --include='*.[ch]' |
        sed -E 's/^"//; s/"$//; s/.*\///; s/%[^a-zA-Z]*[a-zA-Z]+[0-9]*/*/g; s/\*[^.]*\*/*/; s/^\./*./; s/^\*_\*/*/' | sort -u
}
table() {
    grep -oE '^    \{("[^"]+"|VW_[A-Z_]+_FILE)' src/run/out_files.c | sed 's/^    {//' | while read -r name; do
        [[ $name == VW_* ]] && name=$(sed -n "s/^#define $name \(\"[^\"]*\"\).*/\1/p" src/run/out_files.h)
        name=${name#\"}
        echo "${name%\"}"
    done
}

all_are_in_the_table() {
    local known missing=0 name
    known=$(table)
    while read -r name; do
        [[ -n ${elsewhere[$name]:-} ]] || grep -qxF -- "$name" <<<"$known" && continue
        case $name in render_*.png | frame_*.png | next_*.png | masks*.png) continue ;; esac # covered by *.png; a scene's masks
        echo "src/run/out_files.c: does not have $name: add it with what protects it"
        missing=1
    done < <(names_in "${1:-src}")
    return "$missing"
}

an_added_file_is_noticed() {
    local tree
    tree=$(mktemp -d)
    printf 'char *path = vw_path_join(out, "shortcuts.db");\n' >"$tree/added.c"
    ! all_are_in_the_table "$tree" >/dev/null
    local noticed=$?
    rm -r "$tree"
    return "$noticed"
}

check "every file below OUT is in the table" all_are_in_the_table
check "a file that is not is noticed" an_added_file_is_noticed
conclude "$@"
