#!/usr/bin/env bash
# An installed copy works without the build: the program, and the example in tests/example built against the library by
# pkg-config and by CMake's find_package. Usage: test_install.sh PROGRAM
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
build=$(dirname "$program")
prefix=$folder/prefix
example=$root/tests/example/value_photos.c
scene=$root/tests/support/tiny.json
tiny=(--epochs 3 --rays 64 --samples 16 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 4 --log2-table 10
    --width 16)
mkdir "$folder/elsewhere"
cd "$folder/elsewhere" || exit 1

one_file() { # one_file NAME: the only file of that name in the prefix
    local found
    found=$(find "$prefix" -name "$1")
    [[ $found == */* && $found != *$'\n'* ]] || { echo "not one $1 in the prefix: $found" >&2; return 1; }
    echo "$found"
}

installs() {
    run cmake --install "$build" --prefix "$prefix" || return
    local file
    for file in bin/viewworth include/viewworth/viewworth.h share/viewworth/scenes/courtyard.json share/man/man1/viewworth-value.1 \
        share/bash-completion/completions/viewworth bin/viewworth-lab share/man/man1/viewworth-lab-benchmark.1 \
        share/bash-completion/completions/viewworth-lab; do
        [[ -f $prefix/$file ]] || { echo "$file is not installed"; return 1; }
    done
}

# Nothing installed names the build folder or says where to look for libraries.
stands_alone() {
    local file
    ! grep -rlF "$build/" "$prefix" || return
    for file in "$prefix/bin/viewworth" "$prefix/bin/viewworth-lab" "$(one_file viewworth-decode)" "$(one_file 'libviewworth.so.*.*')"; do
        ! readelf --dynamic "$file" | grep -E 'RPATH|RUNPATH' || return
    done
}

# prints_scores COMMAND: values the scene, shows progress, and prints the six train photos, best first.
prints_scores() {
    rm -rf out
    run "$@" "$scene" out 3 || return
    local scores
    scores=$(awk '{print $1}' "$folder/stdout")
    [[ $(wc -l <"$folder/stdout") -eq 6 && $scores == "$(sort -gr <<<"$scores")" ]] &&
        grep -q 'step .* of .*, epoch 3 of 3, validation PSNR' "$folder/stderr" && [[ -s out/report.html ]] && return
    cat "$folder/stdout" "$folder/stderr"
    return 1
}

pkg_config_example() {
    local package flags
    package=$(one_file viewworth.pc) || return
    flags=$(PKG_CONFIG_PATH=$(dirname "$package") pkg-config --cflags --libs viewworth) || return
    # shellcheck disable=SC2086 # the flags are words
    cc -std=c17 -Wall -Wextra -Werror "$example" $flags -o with_pkg_config || return
    LD_LIBRARY_PATH=$(dirname "$(one_file libviewworth.so)") prints_scores ./with_pkg_config
}

cmake_example() {
    mkdir -p project && cat >project/CMakeLists.txt <<END || return
cmake_minimum_required(VERSION 3.25)
project(example C)
find_package(viewworth 0.1 REQUIRED)
add_executable(with_cmake $example)
target_link_libraries(with_cmake PRIVATE viewworth::viewworth)
END
    run cmake -S project -B project/build -DCMAKE_PREFIX_PATH="$prefix" && run cmake --build project/build || return
    prints_scores project/build/with_cmake
}

installed_program() {
    [[ $("$prefix/bin/viewworth" --version) == "$("$program" --version)" ]] || return
    run "$prefix/bin/viewworth" value "$scene" --out valued "${tiny[@]}" --quiet || return
    [[ -s valued/scores.csv ]]
}

# render writes a picture through viewworth-decode: the installed one, without which it fails.
reads_photos() {
    run "$prefix/bin/viewworth" render valued --quiet || return
    mv "$(one_file viewworth-decode)" "$folder/viewworth-decode"
    fails 1 'viewworth-decode' "$prefix/bin/viewworth" render valued --quiet
}

check "cmake --install" installs
check "nothing installed points to the build" stands_alone
check "the installed program values a scene" installed_program
check "the example, built with pkg-config" pkg_config_example
check "the example, built with CMake" cmake_example
check "photos go through the installed viewworth-decode" reads_photos
conclude "$@"
