#!/usr/bin/env bash
# The rules of the house that a compiler does not know: who may include whom, and what no file may hold.
set -uo pipefail
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh

code=(src include shaders tests scripts CMakeLists.txt .ci)
c_code=(--include='*.c' --include='*.cpp' --include='*.h' --include='*.glsl' --include='*.comp')

# nowhere PATTERN [GREP ARGUMENT]...: succeeds when no line matches; prints those that do.
nowhere() {
    ! grep -rnE --exclude-dir=corpus -e "$1" "${@:2}" # what fuzzers found is no text of ours
}

# nowhere_but ALLOWED PATTERN [GREP ARGUMENT]...: the same, but for lines in the files that begin with ALLOWED.
nowhere_but() {
    ! grep -rnE -e "$2" "${@:3}" | grep -v "^$1"
}

# includes_only FOLDER ALLOWED: every include of our own in the folder matches ALLOWED.
includes_only() {
    ! grep -rnE "${c_code[@]}" '#include "' "$1" | grep -vE "#include \"($2)"
}

# sees_none MODULES FOLDER...: no file there includes a header of these modules, public or private.
sees_none() {
    nowhere "^#include \"(viewworth/($1)\.h|($1)/)" "${@:2}"
}

short_files() {
    local long
    long=$(find "${code[@]}" -type f -not -path '*/corpus/*' -print0 | xargs -0 wc -l | awk '$1 > 600 && $2 != "total"')
    [[ -z $long ]] || { echo "$long"; return 1; }
}

unique_test_names() {
    local twice
    twice=$(find tests -name 'test_*' -type f -printf '%f\n' | sed 's/\.[a-z]*$//' | sort | uniq -d)
    [[ -z $twice ]] || { echo "$twice"; return 1; }
}

check "base includes base alone" includes_only src/base 'viewworth/(status|memory|file|csv|hash|json|log|psnr|random|statistics)\.h"'
check "only gpu sees Vulkan" nowhere_but src/gpu/ '^#include.*(vulkan|volk)' "${c_code[@]}" src include tests shaders
check "only the shim sees OpenImageIO" nowhere_but src/image/oiio_shim.cpp '^#include.*OpenImageIO' "${c_code[@]}" src include tests
check "only the shim is C++" test "$(find src include tests -name '*.cc' -o -name '*.cpp' -o -name '*.cxx')" = src/image/oiio_shim.cpp
check "only ledger sees SQLite" nowhere_but src/ledger/ '^#include.*sqlite3' "${c_code[@]}" src include
check "value sees neither training nor GPU" sees_none 'train|gpu|scene|image|report' src/value
check "report sees neither training nor GPU" sees_none 'train|gpu|scene|image|value' src/report
check "ledger sees neither training nor GPU" sees_none 'train|gpu|scene|image|value|report' src/ledger
check "gpu sees nothing above it" sees_none 'train|scene|image|ledger|value|report' src/gpu
check "scenes do not see training" sees_none 'train|ledger|value|report' src/scene src/image
check "training does not see the ledger" sees_none 'ledger|value|report' src/train
check "nothing but the program includes cli" nowhere_but 'src/\(cli/\|main\.c\)' '^#include "cli/' "${c_code[@]}" src include tests
check "no product code includes tests" nowhere '^#include.*(tests|support|reference)/' src include shaders
check "public headers include public headers alone" includes_only include 'viewworth/'

check "only main may end the program" nowhere_but src/main.c '\b(_exit|exit|quick_exit|abort)\(' src include
check "stdout belongs to the commands" nowhere_but 'src/\(cli/\|main\.c\)' '\b(printf|puts|putchar)\(|printf\(stdout' src include
check "asserts stay in every build" nowhere 'NDEBUG' "${c_code[@]}" src include tests
check "no fast-math in the product" nowhere 'fast-math' src include shaders
check "nothing is left for later" nowhere '[T]ODO|[F]IXME|\b[X]XX\b|[H]ACK' "${code[@]}" scenes
check "no paths of one machine" nowhere '(^|[^.[:alnum:]])/([w]ork|[h]ome|[r]oot|[U]sers)/' "${code[@]}" scenes
check "no tabs and no spaces at line ends" nowhere $'\t|[ \r]$' "${code[@]}"
check "files have at most 600 lines" short_files
check "lines have at most 140 characters" nowhere '^.{141}' "${code[@]}" --exclude=native_step.c --exclude='*.md'
check "test names are unique" unique_test_names
conclude
