#!/usr/bin/env bash
# A Debian package of this tree, installed by apt in a clean Debian 12: values a recipe, and the example is built with it. Takes the
# program's path. Needs the rights of root and a Debian mirror (MIRROR=URL names one), and is skipped without them.
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
clean=$folder/root
mirror=${MIRROR:-http://deb.debian.org/debian}
[[ $(id -u) -eq 0 ]] || { echo "SKIPPED: only root can make a root to install in"; exit 77; }
command -v debootstrap >/dev/null || { echo "SKIPPED: debootstrap is missing; apt-get install debootstrap"; exit 77; }
trap 'umount "$clean/proc" "$clean/dev" 2>/dev/null; rm -rf --one-file-system "$folder"' EXIT

makes_package() {
    run cmake -S "$root" -B "$folder/build" -G Ninja -DCMAKE_INSTALL_PREFIX=/usr -DBUILD_TESTING=OFF &&
        run cmake --build "$folder/build" && run cpack -G DEB --config "$folder/build/CPackConfig.cmake" -B "$folder"
}

makes_root() {
    run debootstrap --variant=minbase bookworm "$clean" "$mirror" || return
    cp /etc/apt/apt.conf.d/* "$clean/etc/apt/apt.conf.d/" 2>/dev/null # how this machine reaches the mirror
    mount -t proc proc "$clean/proc" && mount --bind /dev "$clean/dev"
}

inside() { run chroot "$clean" env DEBIAN_FRONTEND=noninteractive "$@"; }

installs() {
    cp "$folder"/viewworth_*.deb "$clean/tmp/viewworth.deb" && inside apt-get update -qq && inside apt-get install -y -qq /tmp/viewworth.deb
}

values_recipe() {
    inside viewworth value /usr/share/viewworth/scenes/clean.json --out /tmp/valued --epochs 2 "${small[@]}" &&
        inside viewworth render /tmp/valued && inside viewworth verify /tmp/valued && [[ -s $clean/tmp/valued/scores.csv ]]
}

builds_example() {
    inside apt-get install -y -qq --no-install-recommends gcc libc6-dev pkgconf || return
    inside sh -c 'gcc -std=c17 /usr/share/doc/viewworth/examples/value_photos.c $(pkg-config --cflags --libs viewworth) -o /tmp/example' &&
        inside /tmp/example /usr/share/viewworth/scenes/clean.json /tmp/out 2
}

has_documents() { [[ -s $clean/usr/share/man/man1/viewworth-value.1 && -s $clean/usr/share/bash-completion/completions/viewworth ]]; }

check "a package of this tree" makes_package
check "a clean Debian 12" makes_root
check "apt-get install ./viewworth.deb" installs
check "the installed program values a recipe" values_recipe
check "the example, built with the package" builds_example
check "man pages and completion" has_documents
check "apt-get remove" inside apt-get remove -y -qq viewworth
conclude "$@"
