#!/usr/bin/env bash
# The house stays as light as the table "Weight" of src/README.md says: lines by folder, options, scripts, words of the README.
# A change that needs more raises a number there, and its commit says why. Takes the program's path.
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
cd "$root" || exit 1

# lines FOLDER NAME...: of the files with these endings, without the laboratory where FOLDER does not name it.
lines() {
    local folder=$1 names=() ending lab=()
    for ending in "${@:2}"; do names+=(-o -name "*.$ending"); done
    [[ $folder == src/lab* ]] || lab=(-not -path 'src/lab/*')
    find "$folder" -type f "${lab[@]}" -not -path 'tests/fuzz/corpus/*' \( "${names[@]:1}" \) -exec cat {} + | wc -l
}

# Prints how much there is of what a row of the table names.
weigh() { # weigh ROW
    case $1 in
    "options of viewworth")
        "$program" --generate-docs "$folder/docs" &&
            sed -n "s/.*) options='//p" "$folder/docs/completion/viewworth" | grep -oE -- '--[a-z][a-z0-9-]*' | sort -u | wc -l
        ;;
    "scripts outside scripts/lab") find scripts -mindepth 1 -maxdepth 1 -not -name lab | wc -l ;;
    "words of README.md") wc -w <README.md ;;
    "product") echo $(($(lines src c h cpp) + $(lines include h))) ;;
    "page of the report") lines src/report js css html ;;
    tests) lines tests c h sh py comp awk txt ;;
    shaders) lines shaders comp glsl h ;;
    *) [[ -d $1 ]] && lines "$1" c h cpp || echo "there is no $1" ;;
    esac
}

# too_heavy README: every row of the table with more than it may have; fails if there is one, or no table.
too_heavy() {
    local row most found heavy=0 rows=0
    while IFS='|' read -r _ row most _; do
        row=$(sed -E 's/^ *`?|`? *$//g; s#/$##' <<<"$row") most=${most//[ ,]/}
        found=$(weigh "$row")
        rows=$((rows + 1))
        [[ $found =~ ^[0-9]+$ && $found -le $most ]] && continue
        echo "$row: $found, at most $most: make it lighter, or raise the number in src/README.md with the reason in the commit"
        heavy=1
    done < <(sed -n '/^## Weight$/,/^## /p' "$1" | grep -E '^\| .*[0-9] \|$')
    [[ $heavy -eq 0 && $rows -gt 15 ]]
}

# Every folder of src has a row.
all_have_a_row() {
    local name
    for name in src/*/; do grep -qF "| \`$name\` |" src/README.md || { echo "$name has no row"; return 1; }; done
}

# A table that allows one line less than a folder has is exceeded, and the folder is named.
less_is_found() {
    sed -E "s#^\| \`src/base/\` \| [0-9,]+ \|#| \`src/base/\` | $(($(lines src/base c h cpp) - 1)) |#" src/README.md >"$folder/README.md"
    ! too_heavy "$folder/README.md" >"$folder/heavy" && grep -q '^src/base: ' "$folder/heavy" && [[ $(wc -l <"$folder/heavy") -eq 1 ]]
}

check "every folder is as light as src/README.md says" too_heavy src/README.md
check "every folder of src has a row" all_have_a_row
check "a folder above its number is named" less_is_found
conclude "$program"
