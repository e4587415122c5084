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

# Ends the script.
conclude() {
    echo "[  PASSED  ] $passed test(s)."
    [[ $failed -eq 0 ]] && exit 0
    echo "[  FAILED  ] $failed test(s); rerun: $0${*:+ $*}"
    exit 1
}
