#!/usr/bin/env bash
# Many valuations from one file: what they leave, at once or one after another, after a kill and an interrupt, and beside one that fails;
# and what their merged ledger has in common with that of the same commands given by hand. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
rays=16
tiny=(--samples 4 --val-rays 64 --levels 2 --log2-table 6 --width 16 --effects none)
cp "$root/tests/support/tiny.json" "$folder/a.json"
sed 's/"seed": 3/"seed": 4/' "$folder/a.json" >"$folder/b.json"

# jobs_file NAME EPOCHS [MORE]: two scenes with two seeds, of which b takes two epochs more.
jobs_file() {
    cat >"$folder/$1" <<JSON
{"defaults": {"rays": $rays, "samples": 4, "val-rays": 64, "levels": 2, "log2-table": 6, "width": 16, "effects": "none", "epochs": $2},
 "seeds": [0, 1],
 "jobs": [{"name": "a", "scene": "a.json"},
          {"name": "b", "scene": "b.json", "options": {"epochs": $(($2 + 2))}}${3:-}]}
JSON
}

batch() { "$program" batch "$folder/$1" --out "$folder/$2" --devices llvmpipe "${@:3}"; } # batch JOBS OUT [OPTION]...
ends_with() { # ends_with CODE PATTERN COMMAND...: that exit code, and a line on stderr that matches
    local code=0
    "${@:3}" >"$folder/stdout" 2>"$folder/stderr" || code=$?
    [[ $code -eq $1 ]] && grep -qE -- "$2" "$folder/stderr" && return
    echo "exit code $code:"
    cat "$folder/stdout" "$folder/stderr"
    return 1
}
states() { # states OUT: of all its jobs
    sqlite3 :memory: -cmd ".import --csv $folder/$1/summary.csv jobs" 'SELECT group_concat(state) FROM jobs'
}

# ---- Two at a time, one of which fails -----------------------------------------------------------------------------------------

jobs_file jobs.json 2 ', {"name": "none", "scene": "none.json", "seeds": [5]}'
check "a batch of four and one that fails" ends_with 1 '1 of 5 jobs failed; .*none/seed-5: .*none\.json: no such scene' \
    batch jobs.json many --per-device 2
check "tells first how many there are" grep -qx 'batch    5 jobs; Ctrl-C keeps what is done' "$folder/stderr"
check "tells each that is done" test "$(grep -cE '^done [1-4] of 5: [ab]/seed-[01], [0-9]+ s$' "$folder/stderr")" = 4
check "and the one that failed" grep -q '^warning: failed: none/seed-5, exit code 2: .*no such scene' "$folder/stderr"
check "prints a table" grep -qE '^a/seed-0 +done +[0-9.]+ +6 +12 +[0-9.]+ +[0-9.]+$' "$folder/stdout"
check "the state of every job is in summary.csv" test "$(states many)" = done,done,done,done,failed
check "each has an ordinary folder" run "$program" verify "$folder/many/b/seed-1"
check "and a log" grep -q '^no ranks by credit' "$folder/many/a/seed-1.log"
check "summary.csv has a row per job" test "$(sed 1d "$folder/many/summary.csv" | cut -d, -f1,2,5 | tr '\n' ' ')" = \
    "a/seed-0,done,12 a/seed-1,done,12 b/seed-0,done,24 b/seed-1,done,24 none/seed-5,failed, "
check "scores.csv begins with what they are of" grep -qE "^b/seed-1,,.*/b\.json,1,view_00[0-9],,dv_psnr," "$folder/many/scores.csv"
check "and has all scores" test "$(sed 1d "$folder/many/scores.csv" | wc -l)" = \
    "$(sqlite3 "$folder/many/merged.db" 'SELECT count(*) FROM score')"
check "the ledgers keep their heads" test "$(sqlite3 "$folder/many/merged.db" "SELECT final_hash FROM run WHERE job = 'b/seed-0'")" = \
    "$(query many/b/seed-0 'SELECT final_hash FROM run')"
in_order() { echo "SELECT group_concat(method) FROM (SELECT method FROM score $1 GROUP BY method ORDER BY min(rowid))"; }
check "and the scores their order" test "$(sqlite3 "$folder/many/merged.db" "$(in_order "WHERE job = 'a/seed-0'")")" = \
    "$(query many/a/seed-0 "$(in_order '')")"
check "the report shows the jobs" grep -q '"file":"summary.csv"' "$folder/many/report.html"

# ---- One after another, by hand ------------------------------------------------------------------------------------------------

by_hand() { # by_hand OUT EPOCHS
    local name epochs
    for name in a/seed-0 a/seed-1 b/seed-0 b/seed-1; do
        epochs=$2
        [[ $name == a/* ]] || epochs=$((epochs + 2))
        run "$program" value "$folder/${name%/*}.json" --out "$folder/$1/$name" --seed "${name#*-}" "${tiny[@]}" --rays "$rays" \
            --epochs "$epochs" --device llvmpipe --quiet || return
    done
    run "$program" merge "$folder/$1" --out "$folder/$1"
}
check "the same by hand, merged" by_hand single 2
check "has the same canonical dump" same_dump many single

# ---- Again, and after a kill ---------------------------------------------------------------------------------------------------

jobs_file jobs.json 2 ', {"name": "none", "scene": "a.json", "seeds": [5]}'
heads() { find "$folder/$1" -name ledger.db -exec stat -c '%n %Y %i' {} + | sort; }
heads many >"$folder/heads"
check "a failed job is tried again, the others are kept" run batch jobs.json many
check "and now all are done" test "$(states many)" = done,done,done,done,done
check "those that were are as they were" test -z "$(comm -23 "$folder/heads" <(heads many))"
steps() { # steps OUT: of the one of its first two jobs that has fewer
    local seed count least=
    for seed in 0 1; do
        count=$(sqlite3 -readonly "$folder/$1/a/seed-$seed/ledger.db" 'SELECT count(*) FROM step' 2>/dev/null || echo 0)
        [[ -n $least && $least -le $count ]] || least=$count
    done
    echo "$least"
}
# stop SIGNAL OUT STEPS: starts or resumes, and signals once both have so many steps.
stop() {
    local process code=0
    "$program" batch "$folder/long.json" --out "$folder/$2" --devices llvmpipe --per-device 2 >"$folder/stdout" 2>"$folder/stderr" &
    process=$!
    until [[ $(steps "$2") -ge $3 ]]; do
        kill -0 "$process" 2>/dev/null || { cat "$folder/stderr"; echo "it ended before the signal"; return 1; }
        sleep 0.02
    done
    kill "-$1" "$process"
    wait "$process" 2>/dev/null || code=$?
    [[ $1 == KILL && $code -eq 137 ]] && return
    [[ $1 != KILL && $code -eq 1 ]] && grep -q '^viewworth: .*stopped; the same command resumes it$' "$folder/stderr" && return
    echo "exit code $code:"
    cat "$folder/stderr"
    return 1
}
jobs_file short.json 2
rays=3072 # slow enough to be stopped in between
jobs_file long.json 15
check "a batch is killed" stop KILL stopped 20
free_locks() { # free_locks OUT: nobody writes into a job's folder any more
    local lock i
    for lock in "$folder/$1"/*/seed-*/.viewworth.lock; do
        for ((i = 0; i < 100; i++)); do
            [[ -e $lock ]] && ! flock -n "$lock" true || continue 2
            sleep 0.1
        done
        return 1
    done
}
check "and its processes end" free_locks stopped
check "before their jobs do" test "$(query stopped/a/seed-0 'SELECT status FROM run')" = interrupted
check "is resumed, and interrupted" stop INT stopped $(($(steps stopped) + 2))
check "says what was stopped" grep -q '^stopped: [ab]/seed-[01]$' "$folder/stderr"
check "whose ledgers say so" test "$(query stopped/a/seed-0 "SELECT status IN ('interrupted', 'finished') FROM run")" = 1
check "is resumed, and ends" run batch long.json stopped --per-device 2
check "the same without interruption, one after another" by_hand whole 15
check "has the same canonical dump" same_dump stopped whole

rays=16
# What a killed batch began may still save what it has.
mkdir -p "$folder/waits/a/seed-0" # of the first job, so that it is asked for at once
flock "$folder/waits/a/seed-0/.viewworth.lock" sleep 3 &
while flock -n "$folder/waits/a/seed-0/.viewworth.lock" true; do sleep 0.01; done
check "a job waits for another process in its folder" run batch short.json waits --devices all
check "and for no longer" eval '! kill -0 $! 2>/dev/null && [[ $(states waits) = done,done,done,done ]]'

# ---- Single jobs ---------------------------------------------------------------------------------------------------------------

for job in 3 1 4; do check "job $job alone" run batch short.json array --job "$job"; done
check "merges nothing" test ! -e "$folder/array/merged.db"
check "the last job" run batch short.json array --job 2
check "to the same canonical dump, which the last one merges" same_dump array single
check "and all are done" test "$(states array)" = done,done,done,done
check "the whole batch then only merges" eval 'run batch short.json array && ! grep -q ^done "$folder/stderr"'
check "so does one whose file is named otherwise" eval '(cd "$folder" && run "$program" batch short.json --out array) &&
    ! grep -q ^done "$folder/stderr"'
rm -r "$folder/array/a/seed-0"
check "a job whose folder is gone is done again" eval 'run batch short.json array && test "$(grep -c ^done "$folder/stderr")" = 1'
check "a job that there is not" fails 2 '--job 5: there are 4 jobs' batch short.json array --job 5

# ---- What is refused -----------------------------------------------------------------------------------------------------------

refuses_jobs() { # refuses_jobs PATTERN MORE
    jobs_file bad.json 2 "$2"
    fails 2 "bad\.json: $1" batch bad.json refused && [[ ! -e $folder/refused ]]
}
check "an unknown key" refuses_jobs 'jobs\[2\]\.sede: unknown key' ', {"name": "c", "scene": "c", "sede": 1}'
check "a name of two" refuses_jobs 'jobs\[2\]\.name: "a" is the name' ', {"name": "a", "scene": "c"}'
check "an unknown option" refuses_jobs 'job c/seed-0: value: unknown option "--sede' ', {"name": "c", "scene": "c", "options": {"sede": 1}}'
check "a value out of range" refuses_jobs 'job c/seed-0: --rays takes' ', {"name": "c", "scene": "c", "options": {"rays": -1}}'
check "a flag with a value" refuses_jobs 'job c/seed-0: value: --lasting takes no value' \
    ', {"name": "c", "scene": "c", "options": {"lasting": 1}}'
check "an empty name of a device" fails 2 '--devices takes all, or' batch short.json refused --devices 'llvmpipe,'
check "a device that there is not" ends_with 1 '4 of 4 jobs failed; .*a/seed-0: .*abacus' batch short.json nowhere --devices abacus
check "a folder with a run" fails 2 'already contains a run' "$program" batch "$folder/short.json" --out "$folder/many/a/seed-0"
mkdir "$folder/locked"
check "a second start" fails 2 'another viewworth process writes there' flock "$folder/locked/.viewworth.lock" \
    "$program" batch "$folder/short.json" --out "$folder/locked"
check "two runs of one job" fails 2 'both are the job a/seed-0' "$program" merge "$folder/single" "$folder/array" --out "$folder/none"
check "a merge into the folder of a run" fails 2 'already contains a run' "$program" merge "$folder/single" --out "$folder/single/a/seed-0"
latin=$folder/$'caf\xe9'
cp -r "$folder/single" "$latin"
check "a folder whose name is not UTF-8" fails 2 'is not UTF-8' "$program" merge "$latin" --out "$folder/none"
check "a folder without runs" fails 2 'locked: no run lies in it' "$program" merge "$folder/locked" --out "$folder/none"
check "a file in place of a folder" fails 2 'short.json: no run lies in it' "$program" merge "$folder/short.json" --out "$folder/none"
sqlite3 "$folder/array/b/seed-1/ledger.db" 'UPDATE step SET val_psnr = val_psnr + 1 WHERE step = 3'
before=$(sha256sum <"$folder/array/merged.db")
check "a ledger that was edited is named" fails 1 'array/b/seed-1/ledger\.db: step 3 ' \
    "$program" merge "$folder/array" --out "$folder/array"
check "and the merged ledger stays" test "$(sha256sum <"$folder/array/merged.db")" = "$before"
check "without a part of another" test ! -e "$folder/array/merged.db.part"
conclude "$@"
