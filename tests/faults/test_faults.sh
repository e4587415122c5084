#!/usr/bin/env bash
# One or two faults of most kinds (tests/faults/fault_kinds.sh): no crash, messages with a remedy, nothing half-written, nothing lost.
# Takes the program's path. scripts/faults makes them all.
# label: unsanitized
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"

faults=(disk-full write-error read-only small-disk locked damaged newer kill device-lost device-hangs device-memory host-memory photos)
[[ -z ${VIEWWORTH_FULL:-} ]] || faults+=(slow-disk terminate clock)
faults() { "$root/scripts/faults" --program "$program" --most "$1" "${faults[@]}" >"$folder/table" 2>&1; }
shows() { # shows COUNT FAULT: the table has so many injections of it at least
    local count
    count=$(grep -E "^$2(:| )" "$folder/table" | sed -E 's/^.*[a-z]  +([0-9]+) .*/\1/' | awk '{ sum += $1 } END { print sum + 0 }')
    [[ $count -ge $1 ]]
}

check "no rule is broken" faults "${VIEWWORTH_FAULTS:-1}"
cat "$folder/table"
for fault in "${faults[@]}"; do
    [[ $fault != small-disk ]] || ! grep -q 'small-disk is skipped' "$folder/table" || continue # containers refuse mounts
    check "$fault is injected" shows 1 "$fault"
done
check "it is killed in all seven phases" shows 7 kill
check "memory runs out in ten places" shows 10 host-memory
check "photos change before and after they are read" shows 5 photos
conclude "$@"
