#!/usr/bin/env bash
# Man pages and bash completion: made from the tables of commands and options, with nothing missing. Takes the program's path.
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"

check "the documents are written" run "$program" --generate-docs "$folder"
check "a folder must be named" fails 2 'generate-docs: name the folder' "$program" --generate-docs
commands=$("$program" --help | sed -n 's/^  \([a-z-]\{1,\}\) .*/\1/p')
options_of() { "$program" help "$1" | sed -n 's/^  \(--[a-z0-9-]\{1,\}\).*/\1/p'; }
check "there are commands" test "$(wc -w <<<"$commands")" -ge 13
check "there are options" test "$(options_of value | wc -l)" -ge 40

# ---- Man pages ----

has_all_options() { # has_all_options COMMAND: its page has a heading for every option of its help
    local option page
    page=$(sed 's/\\-/-/g' "$folder/man/viewworth-$1.1")
    for option in $(options_of "$1"); do
        grep -qE "^\.B $option(,| |\$)" <<<"$page" && continue
        echo "$option is missing"
        return 1
    done
}
is_sound() { # is_sound PAGE: the formatter that is installed has no complaint
    if command -v mandoc >/dev/null; then
        mandoc -T lint -W error "$1"
    elif command -v groff >/dev/null; then
        [[ -z $(groff -man -ww -z "$1" 2>&1 | tee "$folder/complaints") ]] || ! cat "$folder/complaints"
    else
        [[ $(head -c 4 "$1") == '.TH ' ]]
    fi
}
check "the program's page is sound" is_sound "$folder/man/viewworth.1"
for command in $commands; do
    check "the page of $command is sound" is_sound "$folder/man/viewworth-$command.1"
    check "and has all its options" has_all_options "$command"
    check "and the program's page names the command" grep -qxF ".B ${command//-/\\-}" "$folder/man/viewworth.1"
done

# ---- Completion ----

# shellcheck disable=SC1091
. "$folder/completion/viewworth"
complete_line() { # complete_line WORD...: what completion offers for the last word
    local COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
    _viewworth
    printf '%s\n' "${COMPREPLY[@]}"
}
offers() { grep -qx -- "$1" <<<"$(complete_line "${@:2}")" || ! complete_line "${@:2}"; } # offers WORD COMMAND_LINE...
offers_not() { ! grep -qx -- "$1" <<<"$(complete_line "${@:2}")"; }
check "completion offers commands" offers value viewworth va
check "completion offers commands to help" offers value viewworth help va
check "and none that begins otherwise" offers_not train viewworth va
for command in $commands; do
    check "completion offers the options of $command" \
        test "$(complete_line viewworth "$command" -- | sort)" = "$(options_of "$command" | sort)"
done
check "completion offers the choices of an option" offers huber viewworth value scene.json --loss h
check "completion offers presets" offers quick viewworth value scene.json --accuracy ''
check "completion leaves operands to file names" test -z "$(complete_line viewworth value '')"
conclude "$@"
