#!/usr/bin/env bash
# The Debian packages that CPack makes of a build: their fields, what they hold, and that they work where they are unpacked.
# tests/long/test_package_root.sh installs one in a clean Debian. Usage: test_package.sh PROGRAM
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
for tool in cpack dpkg-deb dpkg-shlibdeps file; do
    command -v "$tool" >/dev/null || { echo "SKIPPED: $tool is missing; scripts/install_packages installs it"; exit 77; }
done

makes_package() {
    run cpack -G DEB --config "$(dirname "$program")/CPackConfig.cmake" -B "$folder/packages" || return
    package=$(find "$folder/packages" -maxdepth 1 -name 'viewworth_*.deb')
    laboratory=$(find "$folder/packages" -maxdepth 1 -name 'viewworth-lab_*.deb')
    [[ $package == *.deb && $package != *$'\n'* && $laboratory == *.deb && $laboratory != *$'\n'* ]]
}

has_field() { # has_field NAME PATTERN [PACKAGE]
    local value
    value=$(dpkg-deb --field "${3:-$package}" "$1")
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

# The laboratory has a program with man pages, and no file of the product.
is_apart() {
    local version
    version=$("$program" --version | awk '{print $2; exit}')
    has_field Package '^viewworth-lab$' "$laboratory" && has_field Depends "viewworth \\(= $version-1\\)" "$laboratory" || return
    run dpkg-deb --extract "$laboratory" "$folder/laboratory" || return
    [[ -x $folder/laboratory/usr/bin/viewworth-lab && -s $folder/laboratory/usr/share/man/man1/viewworth-lab-benchmark.1 ]] &&
        [[ ! -e $folder/unpacked/usr/bin/viewworth-lab && ! -e $folder/laboratory/usr/bin/viewworth ]] &&
        [[ $("$folder/laboratory/usr/bin/viewworth-lab" --version) == "viewworth-lab $version" ]]
}

check "cpack makes two packages" makes_package
check "its fields" has_fields
check "what it holds" holds_files
check "it works where it is unpacked" runs_unpacked
check "the laboratory is a package apart" is_apart
conclude "$@"
