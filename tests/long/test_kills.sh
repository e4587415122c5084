#!/usr/bin/env bash
# Twenty kills at random moments, anywhere between start and end, and a power cut: every time the ledger is intact, and the run goes on to
# the same rows, field and scores. Takes the program's path. SEED=N draws other moments.
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
seed=${SEED:-1}
RANDOM=$seed
echo "seed $seed"

value() { # value OUT
    "$program" value "$root/scenes/clean.json" --out "$folder/$1" --epochs 120 --device llvmpipe --quiet --resume \
        >"$folder/stdout" 2>"$folder/stderr"
}

kill_run() { # kill_run OUT: goes on for up to 3 s
    value "$1" &
    sleep "$((RANDOM % 3)).$(printf %03d $((RANDOM % 1000)))"
    if pgrep -P $! >/dev/null; then alive=$((alive + 1)); fi
    kill -KILL $! $(pgrep -P $!) 2>/dev/null
    wait $! 2>/dev/null
    return 0
}

intact() {
    [[ ! -e $folder/$1/ledger.db ]] || { "$program" verify "$folder/$1" >"$folder/stdout" && steps "$1"; }
}
steps() { echo "after step $(query "$1" 'SELECT max(step) FROM step')"; }
agrees() { # what is there is the beginning of the whole run, hashes and all
    [[ ! -e $folder/$1/ledger.db ]] || diff <(query "$1" 'SELECT * FROM step ORDER BY step') \
        <(query whole "SELECT * FROM step ORDER BY step LIMIT $(query "$1" 'SELECT count(*) FROM step')") >/dev/null
}

# A power cut in the middle of a transaction: the journal was begun but reached the disk only in part, and the database not at all.
cut_power() { # cut_power OUT JOURNAL_BYTES
    [[ -e $folder/$1/ledger.db ]] || return 0 # sqlite3 would make an empty one
    sqlite3 "$folder/$1/ledger.db" "BEGIN IMMEDIATE; UPDATE step SET train_loss = 0; UPDATE run SET status = 'lost';" \
        ".shell kill -KILL \$PPID" >/dev/null 2>&1
    [[ -s $folder/$1/ledger.db-journal ]] && truncate -s "$2" "$folder/$1/ledger.db-journal"
}

alive=0 # runs that a kill found at work
check "the run without interruption" value whole
for kill in {1..20}; do
    check "kill $kill" kill_run killed
    check "  leaves an intact ledger" intact killed
    check "  with the rows of the whole run" agrees killed
    if [[ $kill == 10 ]]; then
        check "a power cut" cut_power killed 1500
        check "  leaves an intact ledger" intact killed
        check "  with the rows of the whole run" agrees killed
    fi
done
check "most kills met a run at work ($alive of 20)" test "$alive" -ge 15
check "the run goes on to its end" value killed
check "and is the run without interruption" same_run whole killed
conclude "$@"
