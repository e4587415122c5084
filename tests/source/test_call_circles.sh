#!/usr/bin/env bash
# test_call_circles.sh PROGRAM: no files of the product call each other in a circle. The objects beside PROGRAM say which
# file defines a symbol and which files use it. A source and its header are one file.
# label: unsanitized
set -uo pipefail
build=$(dirname "$1")
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT

# objects FOLDER TREE: lists the objects in FOLDER of sources that are in TREE: a build also keeps those of deleted sources.
objects() {
    find "$1" -path '*.dir/src/*' -name '*.c.o' -print | while read -r object; do
        source=${object##*.dir/}
        [[ ! -e $2/${source%.o} ]] || echo "$object"
    done
}

# circles FOLDER TREE: prints every circle of the sources in TREE whose objects are in FOLDER.
circles() {
    local found
    found=$(objects "$1" "$2" | xargs -d '\n' nm -PA | sed 's/^.*\.dir\/src\///; s/\.c\.o://' |
        awk '
            $3 ~ /^[TDBR]$/ { definer[$2] = $1 }
            $3 == "U" { used[++uses] = $2; user[uses] = $1 }
            END {
                for (i = 1; i <= uses; i++) {
                    file = definer[used[i]]
                    if (file != "" && file != user[i]) print user[i], file
                }
            }' | tsort 2>&1 >/dev/null)
    [[ -z $found ]] || { echo "$found"; return 1; }
}

a_circle_is_found() {
    mkdir -p "$copy/objects.dir/src/base" "$copy/src/base" && touch "$copy/src/base/first.c" "$copy/src/base/second.c"
    echo 'int first(void); int second(void); int first(void) { return second(); }' |
        cc -x c -c -o "$copy/objects.dir/src/base/first.c.o" - || return 1
    echo 'int first(void); int second(void); int second(void) { return first(); }' |
        cc -x c -c -o "$copy/objects.dir/src/base/second.c.o" - || return 1
    ! circles "$copy" "$copy" >"$copy/found" && grep -q base/first "$copy/found"
}

there_are_objects() { [[ $(objects "$build" . | wc -l) -gt 100 ]]; }

check "the build has objects" there_are_objects
check "no circle of files by calls" circles "$build" .
check "  a violation is found" a_circle_is_found
conclude
