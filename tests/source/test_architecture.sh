#!/usr/bin/env bash
# The rules that a compiler does not know: who may include whom, and what no file may hold. Every rule is stated with a
# violation: the rule holds in the tree, and is broken in a copy of the tree that contains the violation.
# label: unsanitized
set -uo pipefail
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh

code=(src include shaders tests scripts CMakeLists.txt .ci)
c_code=(--include='*.c' --include='*.cpp' --include='*.h' --include='*.glsl' --include='*.comp')

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
for root in "${code[@]}" scenes README.md; do [[ ! -e $root ]] || cp -r "$root" "$copy"; done
rm -rf "$copy/tests/fuzz/corpus"

# rule WHAT [FILE TEXT]... -- COMMAND...: the command succeeds in the tree, and fails in the copy that contains these new files.
rule() {
    local what=$1 violation=()
    shift
    while [[ $1 != -- ]]; do violation+=("$1") && shift; done
    shift
    check "$what" "$@"
    check "  a violation is found" finds "${#violation[@]}" "${violation[@]}" "$@"
}

# finds COUNT [FILE TEXT]... COMMAND...: COUNT arguments are the violation.
finds() (
    local injected=("${@:2:$1}") i name status=0
    shift "$(($1 + 1))"
    cd "$copy" || exit 1
    for ((i = 0; i < ${#injected[@]}; i += 2)); do
        [[ ! -e ${injected[i]} ]] || { echo "${injected[i]} exists"; exit 1; }
        mkdir -p "$(dirname "${injected[i]}")" && printf '%s\n' "${injected[i + 1]}" >"${injected[i]}"
    done
    "$@" >found || status=$?
    name=$(basename "${injected[0]%.*}")
    [[ $status -ne 0 ]] && grep -q "$name" found || { echo "$name is not named:"; cat found; status=0; }
    for ((i = 0; i < ${#injected[@]}; i += 2)); do
        rm "${injected[i]}" && rmdir -p --ignore-fail-on-non-empty "$(dirname "${injected[i]}")"
    done
    [[ $status -ne 0 ]]
)

# ---- Folders and includes -------------------------------------------------------------------------------------------------

# layers: every include of ours, as "FILE:LINE: FOLDER includes OWNER", that the folder may not see. A public header belongs to a folder.
# Folders below `run` see training or the ledger, never both: no row above `run` has both.
layers() {
    local wrong
    wrong=$(grep -rnE '^ *# *include *"' --include='*.c' --include='*.cpp' --include='*.h' src | awk -F'[:"]' '
        function allow(folder, list,   part, i, n) {
            n = split(list, part, " ")
            for (i = 1; i <= n; i++) allowed[folder, part[i]] = 1
            known[folder] = 1
        }
        function own(folder, list,   part, i, n) {
            n = split(list, part, " ")
            for (i = 1; i <= n; i++) owner["viewworth/" part[i] ".h"] = folder
        }
        BEGIN {
            allow("base", "base")
            allow("gpu", "base gpu shaders")
            allow("image", "base gpu image")
            allow("scene", "base gpu shaders image scene")
            allow("check", "base image scene check")
            allow("train", "base gpu shaders image scene train")
            allow("detect", "base gpu shaders image scene train detect")
            allow("ledger", "base ledger")
            allow("value", "base ledger value")
            allow("report", "base ledger value report")
            allow("run", "base gpu image scene check train detect ledger value report run")
            allow("experiment", "base gpu image scene check train detect ledger value report run experiment")
            allow("batch", "base ledger report run batch")
            allow("cli", "base gpu image scene check train detect ledger value report run experiment batch cli")
            allow("lab", "base gpu shaders image scene check train detect ledger value report run experiment batch cli lab")
            own("base", "types version status log")
            own("gpu", "gpu")
            own("scene", "scene")
            own("train", "train")
            own("ledger", "ledger")
            own("value", "value selection")
            own("run", "run report")
            owner["interface.h"] = "shaders"
            owner["embedded_shaders.h"] = "gpu"
        }
        {
            n = split($1, path, "/")
            folder = $1 == "src/main.c" ? "cli" : n > 2 ? path[2] : "no folder"
            target = $4 in owner ? owner[$4] : index($4, "/") ? substr($4, 1, index($4, "/") - 1) : "no folder"
            if (target == "viewworth") target = "no folder"
            if (!(folder in known) || !((folder, target) in allowed)) print $1 ":" $2 ": " folder " includes \"" $4 "\" of " target
        }')
    [[ -z $wrong ]] || { echo "$wrong"; return 1; }
}

# circles: prints every circle of files that include each other. A source and its header are one file.
circles() {
    local found
    found=$(grep -roE '^ *# *include *"[^"]+"' --include='*.c' --include='*.cpp' --include='*.h' src include |
        sed -E 's/^(src|include)\///; s/: *# *include *"/ /; s/"$//; s/\.(c|cpp|h)( |$)/\2/g' | tsort 2>&1 >/dev/null)
    [[ -z $found ]] || { echo "$found"; return 1; }
}

folders=(base gpu image scene train detect ledger value report run experiment batch cli lab)
every_pair_is_known() { # every include from a folder to a folder above or beside it is refused
    local folder other refused
    for folder in "${folders[@]}"; do
        mkdir -p "$copy/src/$folder"
        for other in "${folders[@]}"; do echo "#include \"$other/x.h\""; done >"$copy/src/$folder/injected.c"
    done
    refused=$(cd "$copy" && layers | grep -c '/injected\.c:')
    rm "$copy"/src/*/injected.c
    [[ $refused -eq 113 ]] || { echo "$refused of 196 pairs are refused, not 113"; return 1; }
}

# nowhere PATTERN [GREP ARGUMENT]...: succeeds when no line matches; prints those that do.
nowhere() {
    ! grep -rnE --exclude-dir=corpus -e "$1" "${@:2}" # a corpus holds what fuzzers found
}

# nowhere_but ALLOWED PATTERN [GREP ARGUMENT]...: the same, except in the files that begin with ALLOWED.
nowhere_but() {
    ! grep -rnE -e "$2" "${@:3}" | grep -v "^\($1\)"
}

public_headers() {
    local extra
    extra=$(find include -type f | grep -vE \
        '^include/viewworth/(viewworth|version|types|status|log|gpu|scene|train|run|ledger|value|selection|report)\.h$')
    [[ -z $extra ]] || { echo "$extra"; return 1; }
}

one_shim() {
    local others
    others=$(find src include tests \( -name '*.cc' -o -name '*.cpp' -o -name '*.cxx' \) -not -path src/image/decode/oiio_shim.cpp \
        -not -path 'tests/*example*')
    [[ -z $others ]] || { echo "$others"; return 1; }
}

rule "a folder includes only folders below it" src/base/injected.c '#include "cli/options.h"' -- layers
check "  so for every pair of folders" every_pair_is_known
rule "no include is relative" src/run/injected.c '#include "../base/file.h"' -- nowhere '^ *# *include "\.' src include shaders tests
rule "no circle of files" src/base/injected.c '#include "base/other.h"' src/base/other.c '#include "base/injected.h"' -- circles
rule "our own headers stand in quotes" src/base/injected.c '#include <cli/options.h>' -- \
    nowhere '^ *# *include *<(base|gpu|image|scene|train|detect|ledger|value|report|run|experiment|batch|cli|viewworth)/' \
    "${c_code[@]}" src include
rule "no other public headers" include/viewworth/injected.h '' -- public_headers
rule "public headers include public headers alone" include/viewworth/injected.h '#include "base/file.h"' -- \
    nowhere '^ *# *include "([^v]|v[^i]|viewworth[^/])' include
rule "only gpu sees Vulkan" src/scene/injected.c '#include <volk.h>' -- \
    nowhere_but 'src/gpu/\|tests/faults/fault_layer\.c' '^ *# *include.*(vulkan|volk)' "${c_code[@]}" src include tests shaders
rule "only the shim sees OpenImageIO" src/image/injected.c '#include <OpenImageIO/imageio.h>' -- \
    nowhere_but src/image/decode/oiio_shim.cpp '^ *# *include.*OpenImageIO' "${c_code[@]}" src include tests
rule "only the shim is C++" src/image/injected.cpp '' -- one_shim
rule "only ledger sees SQLite" src/value/injected.c '#include <sqlite3.h>' -- \
    nowhere_but src/ledger/ '^ *# *include.*sqlite3' "${c_code[@]}" src include
rule "texts that find no memory are noticed" src/base/injected.c 'char *text = json_dumps(value, 0);' -- \
    nowhere '(open_memstream|json_dumps)\(' "${c_code[@]}" --exclude=json.h src
rule "only the program and its tests include cli" tests/run/injected.c '#include "cli/options.h"' -- \
    nowhere_but 'src/cli/\|src/main\.c\|src/lab/\(main\|options\)\.\|src/lab/commands/\|src/lab/output/\|tests/cli/' \
    '^ *# *include "cli/' "${c_code[@]}" src include tests
rule "only cli sees the options" src/run/injected.h 'void injected(const struct vw_options *options);' -- \
    nowhere_but 'src/cli/\|src/main\.c\|src/lab/options\.\|src/lab/commands/' \
    '\bstruct vw_options\b|^ *# *include ".*options\.h"' "${c_code[@]}" src include tests
rule "the product includes no tests" src/base/injected.c '#include "support/cmocka_test.h"' -- \
    nowhere '^ *# *include.*(tests|support|reference)/' src include shaders
rule "tests include cmocka by its preamble" tests/run/injected.c '#include <cmocka.h>' -- \
    nowhere_but tests/support/cmocka_test.h '^ *# *include <(cmocka|setjmp)\.h>' tests

# ---- What no file may hold --------------------------------------------------------------------------------------------------

short_files() {
    local long
    long=$(find "${code[@]}" -type f -not -path '*/corpus/*' -not -path tests/mutations.txt -print0 | xargs -0 wc -l |
        awk '$1 > 600 && $2 != "total"')
    [[ -z $long ]] || { echo "$long"; return 1; }
}

named_folders() { # in a README.md above it; a folder of tests/ need not be named if src/ has the same
    local folder readme missing=0
    while read -r folder; do
        [[ $folder != tests/* || ! -d src/${folder#tests/} ]] || continue
        for readme in "${folder%/*}" "${folder%%/*}" .; do
            grep -qsE "(^|[^[:alnum:]_])${folder##*/}/" "$readme/README.md" && continue 2
        done
        echo "README.md and ${folder%%/*}/README.md: neither names $folder/"
        missing=1
    done < <(find include scenes scripts shaders src tests -type d -not -path '*/corpus/*')
    return "$missing"
}

unique_test_names() {
    local twice
    twice=$(find tests -name 'test_*' -type f -printf '%f\n' | sed 's/\.[a-z]*$//' | sort | uniq -d)
    [[ -z $twice ]] || { echo "$twice"; return 1; }
}

plain_comments() {
    find src include shaders tests \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.glsl' -o -name '*.comp' -o -name '*.js' \) -print0 |
        xargs -0r awk -f tests/source/comment_rules.awk
}

# named_files: prints every file that a comment names and the tree lacks; a folder before the name counts. CMake makes one header.
named_files() {
    local dead
    dead=$({ find src include shaders tests -type f -not -path '*/corpus/*' && echo src/gpu/embedded_shaders.h; } | awk '
        FILENAME == "-" { for (path = "/" $0; sub(/^[^\/]*\//, "", path);) known[path] = 1; next }
        match($0, /\/\/.*/) {
            text = substr($0, RSTART) " "
            while (match(text, /[[:alnum:]_][[:alnum:]_\/]*\.(c|h|cpp|glsl|comp)[^[:alnum:]_]/)) {
                name = substr(text, RSTART, RLENGTH - 1)
                if (!(name in known)) print FILENAME ":" FNR ": " name
                text = substr(text, RSTART + RLENGTH)
            }
        }' - $(find src include shaders tests \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.glsl' -o -name '*.comp' \)))
    [[ -z $dead ]] || { echo "$dead"; return 1; }
}

sources_with_rows() { # a folder without a README has a row above it
    local source name missing=0
    while read -r source; do
        name=$(basename "${source%.*}")
        [[ ! -e ${source%/*}/README.md ]] || grep -qE "\`([^\`]*[^[:alnum:]_\`])?$name(\.[chp,{}]+)?\`" "${source%/*}/README.md" ||
            { echo "${source%/*}/README.md does not name $name"; missing=1; }
    done < <(find src \( -name '*.c' -o -name '*.cpp' \))
    return "$missing"
}

repeat() { awk -v count="$1" -v text="$2" 'BEGIN { while (count--) printf "%s", text }'; }

rule "only main may end the program" src/run/injected.c '    exit(1);' -- \
    nowhere_but 'src/main\.c\|src/image/decode/main\.c' '\b(_exit|exit|quick_exit|abort)\(' src include
rule "only cli prints to stdout" src/experiment/injected.c '    printf("x");' -- \
    nowhere_but 'src/cli/\|src/main\.c' '\b(v?printf|puts|putchar)\(|[(,] *stdout\b|\bSTDOUT_FILENO\b' "${c_code[@]}" src include
rule "  by any name" src/report/injected.c '    fputs(text, stdout);' -- \
    nowhere_but 'src/cli/\|src/main\.c' '\b(v?printf|puts|putchar)\(|[(,] *stdout\b|\bSTDOUT_FILENO\b' "${c_code[@]}" src include
rule "commands print through cli/output/print.h" src/cli/commands/injected.c '    printf("%s", name);' -- \
    nowhere_but 'src/cli/output/\(print\|progress\)\.c\|src/cli/\(help\|manual\|run_program\)\.c\|src/main\.c' \
    '\b(v?printf|puts|putchar|fputs|fprintf|fwrite)\(' "${c_code[@]}" src/cli
rule "the library leaves stderr alone" src/scene/injected.c '    fprintf(stderr, "x");' -- \
    nowhere_but 'src/cli/\|src/main\.c\|src/gpu/instance\.c\|src/image/decode/oiio_shim\.cpp' \
    '\(stderr,|, stderr\)|\bperror\(|STDERR_FILENO' \
    --include='*.c' --include='*.cpp' src
rule "files are opened where links and pipes are refused" src/run/injected.c '    FILE *file = fopen(path, "r");' -- \
    nowhere_but 'src/base/\|src/image/\|src/gpu/device\.c\|src/run/out_folder\.c\|src/ledger/database_file\.c' \
    '(^|[^>_[:alnum:]])(fopen|freopen|open|openat|creat)\(' "${c_code[@]}" src
rule "JSON is parsed within a bound on memory" src/run/injected.c '    json_loads(text, 0, NULL);' -- \
    nowhere_but 'src/base/json\.[ch]' '\bjson_load' "${c_code[@]}" src
rule "asserts stay in every build" src/base/injected.c '#define NDEBUG' -- nowhere 'NDEBUG' "${c_code[@]}" src include tests
rule "no fast-math in the product" shaders/injected.glsl '// fast-math' -- nowhere 'fast-math' src include shaders
rule "nothing is left for later" src/base/injected.c '// TO''DO' -- \
    nowhere '[T]ODO|[F]IXME|\b[X]XX\b|[H]ACK' "${code[@]}" scenes
rule "no paths of one machine" scripts/injected '/ho''me/someone' -- \
    nowhere '(^|[^.[:alnum:]])/([w]ork|[h]ome|[r]oot|[U]sers)/' "${code[@]}" scenes
rule "no tabs and no spaces at line ends" src/base/injected.c $'\tint x; ' -- nowhere $'\t|[ \r]$' "${code[@]}"
rule "files have at most 600 lines, apart from the list of mutations" src/base/injected.c "$(repeat 601 $'x\n')" -- short_files
rule "C lines have at most 120 characters" src/base/injected.c "$(repeat 121 x)" -- \
    nowhere '^.{121}' --include='*.c' --include='*.cpp' --include='*.h' src include tests
rule "other lines have at most 140 characters" scripts/injected "$(repeat 141 x)" -- nowhere '^.{141}' --exclude='*.md' "${code[@]}"
rule "the comment of a function begins with a verb" src/injected/injected.c $'// The sum.\nint sum(void);' -- plain_comments
rule "no comment begins with What or Of" src/injected/injected.c $'// What is summed.\nstruct injected {' -- plain_comments
rule "no comment begins with From or For" src/injected/injected.c $'// For sums.\nstruct injected {' -- plain_comments
rule "so for JavaScript" src/injected/injected.js $'// Of sums.\nconst injected = 1;' -- plain_comments
rule "messages are plain English" src/injected/injected.c '    vw_fail(VW_ERROR_INPUT, "%s is no photo", name);' -- plain_comments
rule "comments name files that exist" src/injected/injected.c '// The sum (base/absent.h).' -- named_files
rule "a README names every folder" src/injected/injected.c '' -- named_folders
rule "a README names every source beside it" src/base/injected.c '' -- sources_with_rows
rule "test names are unique" tests/run/test_seeds.sh '' -- unique_test_names
conclude
