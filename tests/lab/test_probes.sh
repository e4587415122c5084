#!/usr/bin/env bash
# value --same-state from outside: what it adds, that it changes nothing else, and that its rows come again. Takes the program's path.
# label: once
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/scenes/clean.json
probing=(--same-state 3)

value() { # value OUT EPOCHS [OPTION]...
    "$lab" value "$scene" --out "$folder/$1" --epochs "$2" "${small[@]}" --quiet "${@:3}"
}
verify() { "$program" verify "$folder/$1" "${@:2}"; }
answers() { # answers RUN SQL EXPECTED
    local answer
    answer=$(query "$1" "$2")
    [[ $answer == "$3" ]] && return
    echo "$answer, not $3"
    return 1
}
own_scores="SELECT image_id, method, value, stderr FROM score WHERE method GLOB 'dv_*' ORDER BY 1, 2"
own_steps="SELECT step, image_id, train_loss, val_psnr, val_l1 FROM step ORDER BY step"

check "a run with probes" run value probed 10 "${probing[@]}" --json
check "says what they cost" test "$(sqlite3 :memory: "
    WITH answer AS (SELECT CAST(readfile('$folder/stdout') AS TEXT) AS j)
    SELECT j ->> '\$.same_state.states' = 3 AND j ->> '\$.same_state.steps' = 72 AND j ->> '\$.same_state.share' BETWEEN 1e-6 AND 1
    FROM answer")" = 1
check "and one without" run value plain 10
check "the steps are the same" answers probed "$own_steps" "$(query plain "$own_steps")"
check "and so are the other scores" answers probed "$own_scores" "$(query plain "$own_scores")"
check "and so is the field" cmp "$folder/probed/field.vwf" "$folder/plain/field.vwf"
check "which can be rendered" eval '"$program" render "$folder/probed" --to "$folder/view.png" --quiet >"$folder/stdout"'
check "every photo has a score of them" answers probed "
    SELECT method, unit, count(*), min(visits), max(visits) FROM score
    WHERE method GLOB 'same_state_*' GROUP BY method" 'same_state_psnr|dB|12|6|6'
check "one query gives a same-state score" answers probed "
    SELECT count(*), max(abs(score.value - mine.value)) < 1e-12 FROM score JOIN (
        SELECT probe.image_id, avg(probe.val_psnr - step.val_psnr) AS value FROM probe JOIN step USING (run_id, step)
        WHERE kind = 'same_state' GROUP BY probe.image_id) AS mine USING (image_id) WHERE method = 'same_state_psnr'" '12|1'
check "all of it comes again" run verify probed --replay 4000000000

cp -r "$folder/probed" "$folder/edited"
query edited "UPDATE probe SET image_id = (SELECT max(image_id) FROM image WHERE split = 'train') WHERE kind = 'same_state' AND probe = 1"
check "a probe given to another photo is found" fails 1 'step 36 or one of its view or probe rows was edited' verify edited

check "more epochs are another run: its states lie elsewhere" fails 2 'epochs = 10, not 12' value probed 12 "${probing[@]}" --resume
check "and so are fewer states" fails 2 'same_state = 3, not 2' value probed 10 --same-state 2 --resume
check "states cannot be added to a run" fails 2 'same_state = 0, not 3' value plain 10 --same-state 3 --resume
check "there are no more states than epochs behind burn-in" fails 2 'same-state 4: at most one state .* which are 3' \
    value none 4 --same-state 4
check "nor fewer than one" fails 2 '1 to 1000000' value none 4 --same-state 0
check "train has nothing to probe" fails 2 'unknown option "--same-state"' "$program" train "$scene" --out "$folder/none" --same-state 3
conclude "$program"
