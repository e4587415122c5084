#!/usr/bin/env bash
# benchmark_step on steps as small as they get: its figures, and its profile. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
benchmark_step=$(dirname "$program")/benchmark_step
tiny=(--run-defaults rays=8 samples=8 levels=2 log2_table=6 width=16 val_rays=128 rounds=1 steps=8 batch=2)

benchmark() { run "$benchmark_step" "${tiny[@]}" "$@"; }
figure() { awk -v name="$1" 'NR == 1 { for (i = 1; i < NF; i++) if ($i == name) print $(i + 1) }' "$folder/stdout"; } # figure NAME
is_share() { awk -v x="$1" 'BEGIN { exit !(x ~ /^[0-9.]+$/ && x <= 100) }'; }
mean_of() { sed -nE "s/^  $1 .* dispatches .* ([0-9.]+) ms each.*/\1/p" "$folder/stdout"; } # mean_of PASS

check "steps are timed" benchmark
check "with the share of host-bound submissions" is_share "$(figure host_bound_percent)"
check "also where they are scored" is_share "$(figure scoring_host_bound_percent)"
check "and where trainings share them" benchmark together=3
check "which says the same" is_share "$(figure host_bound_percent)"

check "passes are timed" benchmark --profile
check "and an empty one" says '^  empty pass +zero line +[1-9][0-9]* dispatches .* ms each$'
check "which takes time" awk -v empty="$(mean_of "empty pass")" 'BEGIN { exit !(empty > 0) }'
check "each has the time of one workgroup" says '^  backward_field .* ms each +[0-9.]+ ms one workgroup alone$'
check "splats are timed" benchmark --profile --splats splats=64 val_rays=256 rays=256
check "with passes of their own" says '^  blend_tiles .* ms each$'
check "and an empty one, too" says '^  empty pass +zero line'
check "but none alone" test "$(grep -c 'one workgroup alone' "$folder/stdout")" = 0

check "a word that means nothing" test "$("$benchmark_step" --profiles 2>&1 >/dev/null | grep -c '^usage: ')" = 1
conclude "$@"
