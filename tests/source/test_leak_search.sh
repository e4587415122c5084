#!/usr/bin/env bash
# Builds with sanitizers search every program for leaks, also when it opened a Vulkan driver, the validation layer or
# OpenImageIO with its 250 libraries. Usage: test_leak_search.sh PROGRAM
# label: sanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
build=$(dirname "$program")

# clean COMMAND...: succeeds without a word.
clean() {
    run "$@" && [[ ! -s $folder/stderr ]] && return
    cat "$folder/stderr"
    return 1
}

# reports COMMAND...: fails, and the two injected leaks are what is reported.
reports() {
    "$@" >"$folder/stdout" 2>"$folder/stderr" && return 1
    [[ $(grep -c 'leak of' "$folder/stderr") -eq 2 ]] && grep -q 'leak of 4242 byte' "$folder/stderr" &&
        grep -q 'leak of 4243 byte' "$folder/stderr" && return
    cat "$folder/stderr"
    return 1
}

# searched: every program of the build has the names of libraries that may leak, and nothing switches the search off.
searched() {
    local file missing=()
    for file in "$program" "$build"/test_*; do
        [[ -f $file && -x $file ]] || continue
        [[ $(nm "$file") == *" T __lsan_default_suppressions"* ]] || missing+=("$file")
    done
    [[ ${#missing[@]} -eq 0 ]] || { echo "without tests/support/sanitizer.c: ${missing[*]}"; return 1; }
    ! grep -rn --include='*.c' --include='*.sh' 'detect_leaks=[0]' "$root/src" "$root/tests"
}

for what in gpu validation photo; do
    check "$what: nothing is reported where we leak nothing" clean "$build/injected_leak" "$what"
    check "$what: a injected leak is reported" reports "$build/injected_leak" "$what" leak
done
check "every program is searched" searched
conclude
