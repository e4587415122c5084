#!/usr/bin/env bash
# The Debian package that CPack makes of a build: its fields, what it holds, and that it works where it is unpacked.
# tests/long/test_package_root.sh installs one in a clean Debian. Usage: test_package.sh PROGRAM
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
for tool in cpack dpkg-deb dpkg-shlibdeps file; do
    command -v "$tool" >/dev/null || { echo "SKIPPED: $tool is missing; scripts/install_packages installs it"; exit 77; }
done

makes_package() {
    run cpack -G DEB --config "$(dirname "$program")/CPackConfig.cmake" -B "$folder/packages" || return
    package=$(find "$folder/packages" -maxdepth 1 -name '*.deb')
    [[ $package == "$folder/packages/viewworth_"*.deb && $package != *$'\n'* ]]
}

has_field() { # has_field NAME PATTERN
    local value
    value=$(dpkg-deb --field "$package" "$1")
    [[ $value =~ $2 ]] || { echo "$1: $value"; return 1; }
}

# The loader is opened by name, so that no tool finds it among the libraries.
has_fields() {
    local version
    version=$("$program" --version | awk '{print $2; exit}')
    has_field Version "^$version-1\$" && has_field Package '^viewworth$' && has_field Depends 'libvulkan1' &&
        has_field Depends 'libopenimageio' && has_field Recommends 'mesa-vulkan-drivers'
}

# The changelog is ours, the example is there, and no file lies outside /usr.
holds_files() {
    run dpkg-deb --extract "$package" "$folder/unpacked" || return
    local documents=$folder/unpacked/usr/share/doc/viewworth
    diff <(zcat "$documents/changelog.gz") "$root/CHANGELOG.md" && [[ -s $documents/examples/value_photos.c && -s $documents/copyright ]] &&
        [[ $(ls "$folder/unpacked") == usr ]]
}

runs_unpacked() {
    local unpacked=$folder/unpacked/usr/bin/viewworth
    run "$unpacked" value "$root/tests/support/tiny.json" --out "$folder/valued" --epochs 2 "${small[@]}" --quiet &&
        run "$unpacked" render "$folder/valued" --quiet && [[ -s $folder/valued/scores.csv ]]
}

check "cpack makes one package" makes_package
check "its fields" has_fields
check "what it holds" holds_files
check "it works where it is unpacked" runs_unpacked
conclude "$@"
