#!/usr/bin/env bash
# What the scores are for, on the courtyard with the default options and two seeds: they find the corrupted photos and agree with
# each other, and without momentum they agree better than with it. Takes the program's path.
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"

value() { # value NAME OPTION...
    "$program" value "$root/scenes/courtyard.json" --out "$folder/$1" --quiet --json "${@:2}" >/dev/null
}

# quality COLUMN RUN [RUN2]: of dv_psnr; column 2 is the AUC, 3 the correlation.
quality() {
    "$root/scripts/lab/score_quality" "$folder/$2" ${3:+"$folder/$3"} | awk -v column="$1" '$1 == "dv_psnr" {print $column}'
}

at_least() { # at_least LIMIT FIGURE
    awk -v limit="$1" -v figure="$2" 'BEGIN {exit !(figure >= limit)}' || { echo "$2 is below $1"; return 1; }
}

for seed in 0 1; do
    check "seed $seed is valued" value "$seed" --seed "$seed"
    check "seed $seed is valued with momentum" value "momentum$seed" --seed "$seed" --beta1 0.9
done
# The aims are 0.9 and 0.95; each figure moves by a few hundredths from device to device.
check "corrupted photos rank low (seed 0)" at_least 0.85 "$(quality 2 0)"
check "corrupted photos rank low (seed 1)" at_least 0.85 "$(quality 2 1)"
check "two seeds agree" at_least 0.92 "$(quality 3 0 1)"
check "they agree better than with momentum" at_least "$(quality 3 momentum0 momentum1)" "$(quality 3 0 1)"
conclude "$@"
