#!/usr/bin/env bash
# The READMEs are true of the tree: links, paths, commands, options, the SQL that reads a ledger. They are short, and in
# plain English. Takes the program's path.
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
cd "$root" || exit 1
mapfile -t readmes < <(find . -name '*.md' -not -path './build*' -not -path './out*' -not -name CHANGELOG.md -printf '%P\n' | sort)
mapfile -t product < <(printf '%s\n' "${readmes[@]}" | grep -v 'lab/') # what a user or contributor of the product reads

none() { # none TEXT: prints it and fails unless it is empty
    [[ -z $1 ]] || { echo "$1"; return 1; }
}

# ---- Links and paths -----------------------------------------------------------------------------------------------

# The headings of a file as anchors: small letters, hyphens for spaces, no punctuation.
anchors() {
    grep -E '^#+ ' "$1" | sed -E 's/^#+ //' | tr '[:upper:]' '[:lower:]' | sed -E 's/[^a-z0-9 _-]//g; s/ /-/g'
}

broken_links() {
    local file link path
    for file in "${readmes[@]}"; do
        while read -r link; do
            path=$(dirname "$file")/${link%%#*}
            [[ $link == '#'* ]] && path=$file
            [[ $link == http* || -e $path ]] || { echo "$file: there is no $link"; continue; }
            [[ $link != *'#'* ]] || anchors "$path" | grep -qxF "${link##*#}" || echo "$file: $link: no such heading"
        done < <(grep -oE '\]\([^)]+\)|src="[^"]+"' "$file" | sed -E 's/^\]\((.*)\)$/\1/; s/^src="(.*)"$/\1/')
    done
}

# Prints what looks like a path: in backticks, or after the name of a top folder. Leaves out patterns such as <name> and *.
named_paths() { # named_paths FILE
    grep -oE '`[A-Za-z0-9_./-]*/[A-Za-z0-9_./-]*`' "$1" | tr -d '`'
    grep -oE '`[A-Za-z0-9_-]+\.(c|h|cpp|glsl|comp|cmake|sh|sql|js|css)`' "$1" | tr -d '`'
    grep -oE '(^|[ `(])(src|include|shaders|scenes|scripts|tests)/[][A-Za-z0-9_./*<>{}-]*' "$1" | tr -d ' `(' |
        grep -v '[][*<>{}]'
}

# A path may be given from the root, from the README's folder, or as the end of what the tree holds.
missing_paths() {
    local file path tree
    tree=$(find include scripts scenes shaders src tests -printf '%p\n%p/\n')
    for file in "${readmes[@]}"; do
        while read -r path; do
            # Files of runs and scenes.
            case $path in OUT/* | OUT2/* | out/* | build/* | build-package/* | dense/* | sparse/* | images/* | masks/*) continue ;; esac
            [[ -e $path || -e $(dirname "$file")/$path ]] || grep -qE "/${path//./\\.}\$" <<<"$tree" ||
                echo "$file: there is no $path"
        done < <(named_paths "$file" | sort -u)
    done
}

# ---- Commands and options ------------------------------------------------------------------------------------------

commands=$("$program" --help | sed -nE 's/^  ([a-z][a-z-]+) .*/\1/p')

options_of() { # options_of COMMAND
    "$program" help "$1" | sed -nE 's/^  (--[a-z0-9-]+).*/\1/p'
}

# Prints lines "COMMAND OPTION" for every option after a command of the program in the product's READMEs.
calls() {
    cat "${product[@]}" | sed -E ':join; /\\$/{N; s/\\\n//; b join}' | grep -oE 'viewworth [a-z-]+[^`]*' |
        sed -E 's/ #.*//; s/[;|].*//' | while read -r _ command words; do
        grep -qxF -e "$command" <<<"$commands" || { echo "$command -"; continue; }
        grep -oE -- '--[a-z][a-z0-9-]*' <<<"$words" | sed "s/^/$command /"
    done | sort -u
}

wrong_calls() {
    local command option
    calls | while read -r command option; do
        if [[ $option == - ]]; then # prose such as "viewworth trains" is not a call
            ! grep -qE "\`viewworth $command[ \`]" "${product[@]}" || echo "there is no command $command"
        else
            options_of "$command" | grep -qxF -e "$option" || echo "viewworth $command has no option $option"
        fi
    done
}

unlisted_commands() {
    local command
    for command in $commands; do grep -qF "viewworth $command" README.md || echo "$command"; done
}

# Commands of the laboratory that its README does not name.
unlisted_laboratory() {
    local command
    for command in $("$program-lab" --help | sed -nE 's/^  ([a-z][a-z-]+) .*/\1/p'); do
        grep -qF "viewworth-lab $command" src/lab/README.md || echo "$command"
    done
}

# Options named without a command belong to some command, or to a script or a build tool.
unknown_options() {
    local known option command
    known=$(printf '%s\n' --version --generate-docs --vary; for command in $commands; do options_of "$command"; done)
    grep -hoE '`[^`]*`' "${product[@]}" | grep -v 'scripts/\|cmake\|sha256sum' | grep -oE -- '(^|[ `/])--[a-z][a-z0-9-]*' |
        tr -d ' `/' | sort -u | while read -r option; do
        grep -qxF -e "$option" <<<"$known" || grep -rqF -e "$option" scripts || echo "no command has $option"
    done
}

# ---- The ledger ----------------------------------------------------------------------------------------------------

block() { # block LANGUAGE: prints the code in that language
    awk -v open="\`\`\`$1" '$0 == open {inside = 1; next} /^```/ {inside = 0} inside' src/ledger/README.md
}

rows_of() { # rows_of SQL: how many rows it gives
    sqlite3 -bail "$folder/run/ledger.db" "$1" | wc -l
}

sql_reads() { [[ $(rows_of "$(block sql)") -eq 5 ]]; }
python_reads() { # the columns that the snippet names are those of scores.csv
    local column
    for column in $(block python | grep -oE '(index|columns|values)="[a-z]+"' | sed -E 's/.*"(.*)"/\1/'); do
        head -1 "$folder/run/scores.csv" | tr ',' '\n' | grep -qxF "$column" || return 1
    done
}
script_reads() { [[ $(sqlite3 -bail "$folder/run/ledger.db" <scripts/dv_psnr.sql | wc -l) -eq 6 ]]; }

# ---- Words ---------------------------------------------------------------------------------------------------------

# Words that were replaced by standard terms. README, help and public headers must not bring them back.
old_words='contests?|contestants?|judgements?|foretell(ing|s)?|foretold|foresee|exhaustive'
old_words+='|spoil(ed|s)?|planted|--plant'
old_words+='|harmless|twins?|knobs?|dearest|dear ones|gone on with|goe?s? on with|going on|taken for granted|said aloud'
old_words+='|learned by heart|hopeless|house rules|turn takers?|probing run|rungs?|laws?|choice_json|sampling_error'
old_words+='|rank_(low|high)'

help_texts() {
    local command
    "$program" --help
    for command in $commands; do "$program" help "$command" | sed "s/^/$command: /"; done
}

old_words_in() { # old_words_in FILE...
    grep -HnwiE "$old_words" "$@"
}

# Phrases that are not plain English (src/README.md, Conventions). Lines are joined, so that none hides in a break.
phrases='in the mean|as far as|by itself|by themselves|behind'
foreign_phrases() {
    local file
    for file in "${product[@]}" CHANGELOG.md; do
        tr "\n" " " <"$file" | grep -oiE ".{0,30}\b($phrases)\b.{0,20}" | grep -v "ahead and behind" | sed "s#^#$file: #"
        tr '\n' ' ' <"$file" | grep -oE '\w+ (is|are) no [a-z]+' | grep -viE '^(there|where there) ' | sed "s#^#$file: #"
    done
}

# ---- Sizes ---------------------------------------------------------------------------------------------------------

# Cells of the README's tables that have more than one sentence.
long_cells() {
    grep '^|' README.md | tr '|' '\n' | grep -E '[.!?]"? +[A-Z]' || true
}

folders_without_readme() {
    local folder
    for folder in shaders scenes tests src/*/; do [[ -f $folder/README.md ]] || echo "$folder has no README.md"; done
}

help_texts >"$folder/help"

check "the README has under 160 lines" test "$(wc -l <README.md)" -lt 160
check "the change log has under 80 lines" test "$(wc -l <CHANGELOG.md)" -lt 80
check "the product's READMEs have at most 20,000 words" test "$(cat "${product[@]}" | wc -w)" -le 20000
check "a cell of the README's tables has one sentence" none "$(long_cells)"
check "every folder has a README" none "$(folders_without_readme)"
check "every relative link leads somewhere" none "$(broken_links)"
check "every path named exists" none "$(missing_paths)"
check "every command named takes the options named" none "$(wrong_calls)"
check "every option named belongs to a command" none "$(unknown_options)"
check "the README lists every command" none "$(unlisted_commands)"
check "the README of the laboratory lists its commands" none "$(unlisted_laboratory)"
run "$program" value tests/support/tiny.json "${small[@]}" --epochs 3 --out "$folder/run" --quiet
check "the SQL of the ledger's README reads a ledger" sql_reads
check "the Python snippet names columns of scores.csv" python_reads
check "scripts/dv_psnr.sql reads a ledger" script_reads
check "no old word is in the READMEs" none "$(old_words_in "${product[@]}")"
check "the READMEs are plain English" none "$(foreign_phrases)"
check "no old word is in the help" none "$(old_words_in "$folder/help")"
check "no old word is in the public headers" none "$(old_words_in include/viewworth/*.h)"
conclude
