#!/usr/bin/env bash
# Less and less address space: every command ends with exit code 0, 1 or 2 and at most one line, and never by a signal. Takes the program's
# path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
ulimit -c 0
grep -q __asan_init <(nm "$program" 2>/dev/null) && { echo "SKIPPED: the address sanitizer takes terabytes of address space"; exit 77; }

# survives WHAT FROM STEP TO COMMAND...: with FROM, FROM + STEP, ... up to TO KiB of address space, by twice the step unless with --full.
# What fails before main, in the loader, is not of the program (127).
survives() {
    local what=$1 from=$2 step=$3 to=$4 kib code failed=0 done=0
    shift 4
    [[ -n ${VIEWWORTH_FULL:-} ]] || step=$((2 * step))
    for ((kib = from; kib <= to; kib += step)); do
        code=0
        rm -rf "$folder/new"
        (ulimit -v "$kib" && exec "$program" "$@") >"$folder/stdout" 2>"$folder/stderr" || code=$?
        [[ $code -eq 0 ]] && done=$((done + 1))
        [[ $code -eq 127 || ($code -eq 0 && ! -s $folder/stderr) ]] && continue
        [[ ($code -eq 1 || $code -eq 2) && $(wc -l <"$folder/stderr") -eq 1 ]] && grep -q '^viewworth: ' "$folder/stderr" &&
            { failed=$((failed + 1)); continue; }
        echo "$what with $kib KiB: exit code $code"
        cat "$folder/stderr"
        return 1
    done
    echo "$what: $failed messages, $done times done"
    [[ $failed -gt 0 && $done -gt 0 ]]
}

check "a run" run "$program" value "$scene" --out "$folder/run" --epochs 3 "${small[@]}" --quiet
printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.1\n' >"$folder/log.csv"
for i in {1..20000}; do echo "$i,$((i / 5)),photo_$((i % 5)),10,0.1"; done >>"$folder/log.csv"
check "info" survives info 200000 300000 1700000 info "$scene" --device llvmpipe --quiet
mkdir -p "$folder/scene"
frames=()
for i in 0 1 2; do
    check "photo $i" run "$program" render "$folder/run" --view 0 --to "$folder/scene/$i.png" --device llvmpipe --quiet
    frames+=("{\"file_path\": \"$i.png\", \"transform_matrix\": [[1,0,0,$i],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}")
done
(IFS=, && echo "{\"fl_x\": 17, \"frames\": [${frames[*]}]}" >"$folder/scene/transforms.json")
without_device() (export VK_DRIVER_FILES=/dev/null && "$@")
check "info of photos" without_device survives "info of photos" 20000 300000 2500000 info "$folder/scene" --quiet
# What the loader takes before main differs by machine and build: the commands without a driver start from there.
least=4000
until (ulimit -v $least && exec "$program" --version) >"$folder/stdout" 2>&1 || [[ $least -gt 1000000 ]]; do least=$((least + 50)); done
check "verify" survives verify "$least" 50 $((least + 1000)) verify "$folder/run" --quiet
check "select" survives select "$least" 50 $((least + 1000)) select "$folder/run" --rule top:2 --to "$folder/new.txt"
check "import-steps" survives import "$least" 1000 $((least + 20000)) import-steps "$folder/log.csv" --out "$folder/new" --quiet
check "report" survives report "$least" 200 $((least + 4000)) report "$folder/run" --no-thumbnails --quiet --to "$folder/report.html"
conclude
