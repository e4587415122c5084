#!/usr/bin/env bash
# viewworth-lab probe from outside: what it adds, that it changes nothing, and what it refuses. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/scenes/clean.json

value() { # value OUT EPOCHS [OPTION]...
    "$program" value "$scene" --out "$folder/$1" --epochs "$2" "${small[@]}" --quiet "${@:3}"
}
probe() { "$lab" probe "$folder/$1" --quiet "${@:2}"; }
asks() { # asks SQL: on the tables and the ledger of the probed run
    sqlite3 -readonly "$folder/probed/ledger.db" "CREATE TEMP TABLE probe (step, probe, kind, name, psnr, pooled, l1)" \
        "CREATE TEMP TABLE own (name, method, value, unit, stderr, visits, sampling)" \
        ".import --csv --skip 1 --schema temp $folder/probed/probes.csv probe" \
        ".import --csv --skip 1 --schema temp $folder/probed/probe_scores.csv own" "$1"
}
answers() { # answers SQL EXPECTED
    local answer
    answer=$(asks "$1")
    [[ $answer == "$2" ]] && return
    echo "$answer, not $2"
    return 1
}

check "a run" run value probed 10
cp -r "$folder/probed" "$folder/before"
check "is probed" run probe probed --same-state 3 --json
check "and says what was measured" test "$(sqlite3 :memory: "
    WITH answer AS (SELECT CAST(readfile('$folder/stdout') AS TEXT) AS j)
    SELECT j ->> '\$.states' = 3 AND j ->> '\$.same_state_steps' = 72 AND j ->> '\$.share' BETWEEN 1e-6 AND 1 AND
        j ->> '\$.steps' = 120 AND j ->> '\$.noise_floor.repeated_db' = 0 AND
        j ->> '\$.noise_floor.zero_learning_rate_db' = 0 AND j ->> '\$.noise_floor.resampled_db' > 0
    FROM answer")" = 1
check "nothing else in the folder changed" test "$(diff -rq "$folder/before" "$folder/probed")" = \
    "$(printf 'Only in %s: %s\n' "$folder/probed" probe_scores.csv "$folder/probed" probes.csv)"
check "every photo has a score of the states" answers "SELECT count(*), min(visits), max(visits) FROM own
    WHERE method = 'same_state_psnr'" '12|6|6'
check "one query gives it" answers "SELECT count(*), max(abs(own.value - mine.value)) < 1e-12 FROM own JOIN (
    SELECT name, avg(psnr - val_psnr) AS value FROM probe JOIN step ON probe.step = step.step WHERE probe.kind = 'same_state'
    GROUP BY name) AS mine USING (name) WHERE method = 'same_state_psnr'" '12|1'
check "what sampling does is beside every score" answers "SELECT min(sampling > 0), count(*) FROM own" '1|36'
check "the folder is intact" run "$program" verify "$folder/probed"
check "which names the new tables as not covered" grep -q '^probes.csv  *not checked' "$folder/stdout"
mv "$folder/probed/probes.csv" "$folder/first.csv"
check "a second time" run probe probed
check "says the same of noise" cmp "$folder/probed/probes.csv" <(grep -v same_state "$folder/first.csv")

cp -r "$folder/before" "$folder/lengthened"
check "steps are lengthened" run probe lengthened --lengthen 20
check "beside the same noise" cmp "$folder/probed/probes.csv" <(grep -Ev ',(longer|shorter),' "$folder/lengthened/probes.csv")
check "on each photo in turn, from burn-in on" test "$(sqlite3 :memory: \
    ".import --csv $folder/lengthened/probes.csv probe" "SELECT count(*), count(DISTINCT name), count(DISTINCT val_psnr),
        min(step) || max(step) FROM probe WHERE kind IN ('longer', 'shorter')")" = '24|12|24|1212'
check "with momentum" run value momentum 3 --beta1 0.9
check "steps belong to several photos" fails 2 'so that --lengthen says nothing' probe momentum --lengthen 20

cp -r "$folder/before" "$folder/edited"
sqlite3 "$folder/edited/ledger.db" "UPDATE step SET val_psnr = val_psnr + 1e-9 WHERE step = 36"
check "an edited run is not probed" fails 1 'step 36 .* was edited' probe edited
check "there are no more states than epochs after burn-in" fails 2 'same-state 10: at most one state .* which are 9' \
    probe before --same-state 10
check "nor fewer than one" fails 2 '1 to 1000000' probe before --same-state 0
check "a run without validation" run "$program" train "$scene" --out "$folder/trained" --epochs 2 "${small[@]}" --quiet
check "has nothing to probe" fails 2 'needs validation after every step' probe trained
check "nor has an empty folder" fails 2 'no ledger here' probe nothing
conclude "$program"
