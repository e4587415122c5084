#!/usr/bin/env bash
# The shared library exports what the public headers declare, no more and no less, and every public header compiles alone
# as C17 and as C++17. Usage: test_public_headers.sh PROGRAM
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
library=$(dirname "$program")/libviewworth.so
headers=("$root"/include/viewworth/*.h)
warnings=(-Wall -Wextra -pedantic -Werror -fsyntax-only "-I$root/include")

compiles_alone() { # compiles_alone HEADER
    local include="#include <viewworth/$(basename "$1")>"
    cc -x c -std=c17 "${warnings[@]}" - <<<"$include" && c++ -x c++ -std=c++17 "${warnings[@]}" - <<<"$include"
}

# The names that the headers declare, one a line. GCC lists functions, and types of functions with them.
declared() {
    printf '#include <viewworth/%s>\n' "${headers[@]##*/}" >"$folder/all.c"
    cc -std=c17 "-I$root/include" -aux-info "$folder/declarations" -fsyntax-only "$folder/all.c" || return
    grep -hoE '\btypedef [^;]*\(' "${headers[@]}" | grep -oE 'vw_[a-z0-9_]+\($' | tr -d '(' >"$folder/types"
    {
        grep '/include/viewworth/' "$folder/declarations" | grep -v ' static ' | grep -oE 'vw_[a-z0-9_]+ \(' | tr -d ' (' |
            grep -vxFf "$folder/types"
        grep -hoE '^extern [^(]*;' "${headers[@]}" | grep -oE 'vw_[a-z0-9_]+(\[[^]]*\])?;' | sed -E 's/\W.*//'
    } | sort -u
}

has_all() { # the umbrella header
    local header name
    for header in "${headers[@]}"; do
        name=viewworth/$(basename "$header")
        [[ $name == viewworth/viewworth.h ]] || grep -qxF "#include \"$name\"" "$root/include/viewworth/viewworth.h" ||
            { echo "viewworth.h does not include $name"; return 1; }
    done
}

exported() {
    nm -D --defined-only "$library" | awk '{print $3}' | sort
}

same_names() {
    declared >"$folder/declared" && exported >"$folder/exported" && [[ -s $folder/declared ]] || return 1
    diff "$folder/declared" "$folder/exported" && return
    echo "<: declared in include/viewworth, but not exported by $library; >: exported, but not declared"
    return 1
}

from_cpp() {
    c++ -std=c++17 -x c++ "-I$root/include" - -x none "$library" "-Wl,-rpath,$(dirname "$library")" -o "$folder/cpp" <<'END' || return
#include <viewworth/version.h>
#include <cstdio>
int main() { std::puts(vw_version()); }
END
    [[ "viewworth $("$folder/cpp")" == "$("$program" --version)" ]]
}

for header in "${headers[@]}"; do
    check "$(basename "$header") compiles alone" compiles_alone "$header"
done
check "viewworth.h includes every public header" has_all
check "exported is what is declared" same_names
check "a C++ program links with the library" from_cpp
conclude "$@"
