#!/usr/bin/env bash
# Resuming, extending and auditing runs from outside (decision 11). Takes the program's path; test_kill_and_resume.sh stops runs partway.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/scenes/clean.json

# value OUT EPOCHS [OPTION]...: with an effect, so that there is a state of it to go on with
value() { (exec_value "$@"); }
exec_value() { # in place of the shell, so that signals reach it
    exec "${by:-$program}" value "$scene" --out "$folder/$1" --epochs "$2" "${small[@]}" --effects visibility --quiet "${@:3}"
}
verify() { "$program" verify "$folder/$1" "${@:2}"; }
verifies() { run verify "$@"; }
copy() { rm -rf "${folder:?}/$2" && cp -r "$folder/$1" "$folder/$2"; }
unchanged() { # unchanged OUT COMMAND...: all files of OUT are byte for byte as before
    local before
    before=$(checksums "$1")
    "${@:2}"
    [[ $(checksums "$1") == "$before" ]]
}

epochs=150
check "a run without interruption" run value whole "$epochs"
check "--resume starts where there is nothing" run value short 3 --resume --effects +visibility --pilot-steps 0
check "a finished run is left alone" unchanged short run value short 3 --resume
check "also when fewer epochs are asked for" unchanged short run value short 2 --resume
check "without --resume it is refused" fails 2 'already contains a run; continue it with --resume' value short 3
check "a finished run is extended, its effects decided again" run value short 5 --resume --effects +visibility --pilot-steps 0
check "a longer run with those effects" run value longer 5
check "is the extended one" same_run longer short

copy short corrupted
check "another config is refused by name" fails 2 'learning_rate = 0.003, not 0.01' value corrupted 6 --resume --lr 0.01
printf 'view_%03d\n' 1 2 3 >"$folder/train.txt"
printf 'view_%03d\n' 0 >"$folder/val.txt"
check "so is another choice of photos" fails 2 'other photos to train on' value corrupted 6 --resume \
    --train "$folder/train.txt" --val "$folder/val.txt"
check "and other effects" fails 2 'other --effects' value corrupted 6 --resume --effects visibility,background
check "and the same by train" fails 2 'train instead of value' \
    "$program" train "$scene" --out "$folder/corrupted" --epochs 6 "${small[@]}" --effects visibility --resume --quiet
check "refusals leave the run alone" same_run short corrupted

longer_from() { # longer_from OUT: extends it and compares
    run value "$1" 6 --resume && same_run longest "$1"
}
check "the longest run" run value longest 6
copy short damaged
truncate -s -1 "$folder"/damaged/checkpoint_*.vwc
check "damaged checkpoints are passed over" longer_from damaged
copy short missing
rm "$folder"/missing/checkpoint_*.vwc
check "and missing ones" longer_from missing

forge() { # an edit of step 2, with which no replay agrees
    copy short forged
    rm "$folder"/forged/checkpoint_*.vwc
    query forged "UPDATE step SET val_psnr = val_psnr + 1e-9 WHERE step = 2"
}
check "an edited ledger is not gone on with" eval 'forge; unchanged forged fails 1 "step 2" value forged 6 --resume'
check "and is found by verify" fails 1 'step 2 ' verify forged
check "an untouched run is intact" verifies short
head=$(verify short | awk '$1 == "head" {print $2}')
check "its head is the one expected" verifies short --expect "$head"
check "another head is not" fails 1 "head is $head" verify short --expect "${head/[0-8]/9}"
check "all its steps can be taken again" verifies short --replay 4000000000
check "a replay says how many" grep -q 'replay   [1-9][0-9]* repeated steps gave the same bits' "$folder/stdout"
check "a folder without a run has nothing to verify" fails 2 'no ledger here' verify nothing

# A replay that lasts longer than several checkpoints are apart.
if [[ -n ${VIEWWORTH_FULL:-} ]]; then
    copy whole long
    rm "$folder"/long/checkpoint_*.vwc
    check "a long replay without a checkpoint comes to its end" run value long "$((epochs + 1))" --resume
    check "and its ledger is whole" verifies long
    check "and two checkpoints are back" test "$(ls "$folder"/long/checkpoint_*.vwc | wc -l)" = 2
fi

interrupt_extension() {
    local process steps
    copy short extended
    steps=$(query extended 'SELECT max(step) FROM step')
    exec_value extended 4000 --resume >"$folder/stdout" 2>"$folder/stderr" &
    process=$!
    until [[ $(sqlite3 -cmd '.timeout 5000' "$folder/extended/ledger.db" 'SELECT max(step) FROM step') -gt $steps ]]; do sleep 0.05; done
    kill -TERM "$process"
    wait "$process"
    [[ $(query extended 'SELECT status FROM run') == interrupted ]]
}
check "a finished run is stopped while it is extended" interrupt_extension
check "its scores are those of the steps so far" verifies extended
check "and more than none" test "$(query extended 'SELECT count(*) FROM score')" -gt 0

mkdir "$folder/left" && echo x >"$folder/left/ledger.db-journal"
check "the journal of a removed ledger is refused" fails 2 'ledger.db-journal: is left of another file; remove it' value left 3
check "a head is 64 digits" fails 2 '64 hexadecimal digits' verify short --expect zzz
conclude "$@"
