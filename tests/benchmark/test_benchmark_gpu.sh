#!/usr/bin/env bash
# The tables of scripts/benchmark_gpu, with programs in place of ours that know what they print. Takes the program's path, which it does
# not run.
. "$(dirname "$0")/../support/program_test.sh"
tree=$folder/tree
mkdir -p "$tree/scripts" "$tree/build"
cp "$root/scripts/benchmark_gpu" "$tree/scripts"
cat >"$tree/build/viewworth" <<'END'
#!/usr/bin/env bash
[[ $1 != devices ]] || echo "0   cpu   1.0 GiB   a stand-in"
[[ $1 != --version ]] || echo "viewworth 0"
END
# Fails for runs of 4; otherwise every figure is another.
cat >"$tree/build/benchmark_step" <<'END'
#!/usr/bin/env bash
[[ " $* " != *" together=4 "* ]] || { echo "benchmark_step: no memory" >&2; exit 1; }
echo "train_ms 1.5 val_ms 2.5 host_ms 3.5 scoring_host_ms 4.5 host_bound_percent 12.5 scoring_host_bound_percent 7.5 device_mib 5.5"
END
chmod +x "$tree"/build/*

page() { VIEWWORTH_BUILT=1 run "$tree/scripts/benchmark_gpu" "$@"; }
refuses() { ! page "${@:2}" >/dev/null && grep -q "$1" "$folder/stderr" && [[ ! -s $folder/stdout ]]; } # refuses PATTERN SECTION...
head='training step, ms \| its validation, ms \| host, ms \| host-bound, % \| device, MiB \|'

check "a page of two sections" page --small steps together
check "steps have a column of host-bound submissions" says "^\| size \| $head\$"
check "with its figure" says '^\| splats \| 1\.5 \| 2\.5 \| 3\.5 \| 12\.5 \| 5\.5 \|$'
check "so have runs together" says "^\| runs \| $head\$"
check "with it, too" says '^\| 8 \| 1\.5 \| 2\.5 \| 3\.5 \| 12\.5 \| 5\.5 \|$'
check "rules are as wide as heads" test "$(grep -cx '|---|---|---|---|---|---|' "$folder/stdout")" = 2
check "what fails has a row that says so" says '^\| 4 \| FAILED: benchmark_step: no memory \|$'
check "a CPU is not measured in full" refuses 'the only device is a CPU' steps
check "nor a section that is unknown" refuses '^usage: ' stairs
conclude "$@"
