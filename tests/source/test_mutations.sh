#!/usr/bin/env bash
# That the list of scripts/check_mutations fits the tree: a change of the code that it breaks on purpose changes the list as well.
# label: unsanitized
set -uo pipefail
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh

all_fit() {
    local listed
    listed=$(scripts/check_mutations --list) || return 1
    [[ $(wc -l <<<"$listed") -eq $(grep -c '^breaks: ' tests/mutations.txt) ]]
}

every_test_exists() {
    local missing=0 test
    while read -r test _; do
        [[ -n $(find tests -name "$test" -o -name "$test.c") ]] && continue
        echo "tests/mutations.txt: there is no test $test"
        missing=1
    done < <(sed -n 's/^tests: //p' tests/mutations.txt | tr ',' '\n')
    return "$missing"
}

check "every mutation fits the tree" all_fit
check "every test of the list exists" every_test_exists
conclude "$@"
