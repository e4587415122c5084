#!/usr/bin/env bash
# What the compiler and the linker add against attacks is in every binary that is installed, and a program without it
# fails every check here. Usage: test_hardening.sh PROGRAM
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
build=$(dirname "$program")

# has WHAT FILE: that protection is in the binary.
has() {
    case $1 in
    'an unpredictable place in memory') grep -q 'Type: *DYN' <(readelf -hW "$2") ;;
    'relocations that are read-only') grep -q GNU_RELRO <(readelf -lW "$2") ;;
    'all symbols bound at the start') grep -qE 'FLAGS.*NOW' <(readelf -dW "$2") ;;
    'a stack that holds no code') grep -qE 'GNU_STACK .* RW +0x' <(readelf -lW "$2") ;;
    'guarded return addresses') grep -q __stack_chk_fail <(readelf --dyn-syms -W "$2") ;;
    'checked sizes of buffers') grep -qE '__(mem|str|v?sn?printf|read|fread|vasprintf|asprintf).*_chk' <(readelf --dyn-syms -W "$2") ;;
    'marked targets of jumps') ! has_control_flow || [[ $(objdump -d "$2" | grep -c endbr64) -gt 20 ]] ;;
    esac
}

has_control_flow() { [[ $(uname -m) == x86_64 ]]; }

lacks() { ! has "$@"; }

cat >"$folder/weak.c" <<'END'
#include <stdio.h>
#include <string.h>
int main(int argc, char **argv) {
    char text[64];
    strcpy(text, argv[argc - 1]);
    return puts(text) < 0;
}
END
check "a weak program is built" run cc -O1 -U_FORTIFY_SOURCE -fno-stack-protector -fno-pie -no-pie -Wl,-z,norelro,-z,lazy,-z,execstack \
    -o "$folder/weak" "$folder/weak.c"
binaries=()
while read -r file; do
    [[ $(head -c 4 "$file") == $'\x7fELF' ]] && binaries+=("$file")
done < <(find "$build" -maxdepth 1 -type f \( -name 'viewworth*' -o -name 'libviewworth.so*' \))
check "the program, the library and what they load are found" test ${#binaries[@]} -ge 3
for protection in 'an unpredictable place in memory' 'relocations that are read-only' 'all symbols bound at the start' \
    'a stack that holds no code' 'guarded return addresses' 'checked sizes of buffers' 'marked targets of jumps'; do
    for file in "${binaries[@]}"; do
        [[ $protection == *buffers* && $file == *oiio* ]] || # the shim calls none of those functions
            check "${file##*/} has $protection" has "$protection" "$file"
    done
    [[ $protection == *targets* ]] && ! has_control_flow || check "  the weak program lacks it" lacks "$protection" "$folder/weak"
done
conclude "$program"
