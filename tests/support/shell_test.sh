# For tests/*/test_*.sh, to be sourced: checks that are counted and printed as cmocka's are. A failing check does not end the script.

passed=0
failed=0

# check WHAT COMMAND...: passes when the command succeeds.
check() {
    local what=$1
    shift
    if "$@"; then
        passed=$((passed + 1))
        echo "[       OK ] $what"
    else
        failed=$((failed + 1))
        echo "[  FAILED  ] $what"
    fi
}

# skip_unchanged STAMP FILE...: ends the script when these files are as they were when it last passed, which the file STAMP remembers. For
# tests that compile everything. With VIEWWORTH_FULL, which scripts/test --full sets, it runs all the same.
skip_unchanged() {
    stamp=$1
    inputs=$(cat "${@:2}" | sha256sum)
    [[ -z ${VIEWWORTH_FULL:-} && -f $stamp && $(<"$stamp") == "$inputs" ]] || return 0
    echo "SKIPPED: what it reads is unchanged since it last passed; scripts/test --full runs it"
    exit 77
}

# Ends the script.
conclude() {
    echo "[  PASSED  ] $passed test(s)."
    if [[ $failed -eq 0 ]]; then
        [[ -z ${stamp:-} ]] || echo "$inputs" >"$stamp"
        exit 0
    fi
    echo "[  FAILED  ] $failed test(s); rerun: $0${*:+ $*}"
    exit 1
}
