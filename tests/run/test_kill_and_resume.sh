#!/usr/bin/env bash
# Every command that trains can be stopped and resumed: it is killed, resumed, interrupted and resumed again, each time
# partway, and leaves what the same command leaves without interruption. Takes the program's path, and names of cases to run these alone.
# label: once
# sanitized: value compare
. "$(dirname "$0")/../support/program_test.sh"
chosen=("${@:2}")
scene=$root/scenes/clean.json
tiny=$root/tests/support/tiny.json
printf 'view_%03d\n' 0 2 5 >"$folder/half.txt"
tiny_field=(--rays 16 --samples 8 --val-rays 64 --levels 2 --log2-table 6 --width 16 --effects none --device llvmpipe)

ledgers() { find "$folder/$1" -name ledger.db | sort; }

# progress OUT: the steps in all its ledgers, and its retrainings, each of which counts as 20 steps; 0 while nothing can be read.
progress() {
    local file sum=0
    [[ -d $folder/$1 ]] || { echo 0; return; }
    for file in $(ledgers "$1"); do
        sum=$((sum + $(sqlite3 -readonly "$file" 'SELECT count(*) FROM step' 2>/dev/null || echo 0)))
    done
    file=$folder/$1/retrainings.db
    [[ ! -e $file ]] || sum=$((sum + 20 * $(sqlite3 -readonly "$file" 'SELECT count(*) FROM retraining' 2>/dev/null || echo 0)))
    echo "$sum"
}

# contents OUT: all that must be the same after an interruption: rows with their hashes, tables, fields, pictures. Reports name their
# folder; what was timed differs from run to run.
contents() {
    local file
    (
        cd "$folder/$1" || exit
        find . -type f ! -name '*.db' ! -name 'checkpoint_*' ! -name '*.html' ! -name tradeoff.csv ! -name SHA256SUMS \
            -exec sha256sum {} + | sort -k2
    )
    for file in $(ledgers "$1"); do rows "$(dirname "${file#"$folder"/}")" | sed "s|^|${file#"$folder/$1"} |"; done
    [[ ! -e $folder/$1/tradeoff.csv ]] || # configuration, steps, val_psnr, method, seed_pearson, agreement_pearson
        awk -F, '$2 ~ /^(base|full_resolution|epochs|parameter)$/' "$folder/$1/tradeoff.csv" | sed 's/"[^"]*"//' |
            cut -d, -f 1,6,12,14-16
}

same_contents() { # same_contents OUT OUT
    [[ $(contents "$1" | wc -l) -ge 5 ]] && diff <(contents "$1") <(contents "$2") >"$folder/diff" && return
    head -n 5 "$folder/diff"
    return 1
}

# intact OUT: every ledger in it, except one that was killed within a write: its journal waits for --resume, as readers must say.
intact() {
    local file
    for file in $(ledgers "$1"); do
        run "$program" verify "${file%/ledger.db}" && continue
        [[ -s $file-journal ]] || return 1
        grep -q 'a program was killed while it wrote here; repeat its command with --resume' "$folder/stderr" || return 1
    done
}

start() { exec "${by:-$program}" "${words[@]}" --out "$folder/$1" --quiet; } # start OUT: the command of the case

has_status() { [[ ! -e $folder/$1/ledger.db || $(query "$1" 'SELECT status FROM run') == "$2" ]]; } # has_status OUT STATUS: of a single run

# stop SIGNAL OUT PROGRESS: starts or resumes, and signals once there is that much. The command must not have ended by then, so it is
# halted while its progress is read: how fast it is, or how slow this script, does not matter.
stop() {
    local process code=0
    (start "$2") >"$folder/stdout" 2>"$folder/stderr" &
    process=$!
    until [[ $(progress "$2") -ge $3 ]]; do
        kill -CONT "$process" 2>/dev/null || { cat "$folder/stderr"; echo "it ended before the signal"; return 1; }
        sleep 0.02
        kill -STOP "$process" 2>/dev/null
    done
    kill "-$1" "$process"
    kill -CONT "$process" 2>/dev/null
    wait "$process" 2>/dev/null || code=$?
    case $1 in
    KILL) [[ $code -eq 137 ]] && has_status "$2" running ;;
    *) [[ $code -eq 1 ]] && grep -qE '^viewworth(-lab)?: .*(--resume|same command)' "$folder/stderr" && has_status "$2" interrupted ;;
    esac && return
    echo "exit code $code:"
    cat "$folder/stderr"
    return 1
}

finish() { (start "$1") >"$folder/stdout" 2>"$folder/stderr" || { cat "$folder/stderr"; return 1; }; } # finish OUT

is_chosen() { [[ ${#chosen[@]} -eq 0 || " ${chosen[*]} " == *" $1 "* ]]; }

# stops NAME TOTAL: kills the command of the case after an eighth of the total progress, and interrupts it when it has gone further, after a
# third at least.
stops() {
    local further
    check "$1: is killed" stop KILL "$1" $(($2 / 8))
    check "$1: what it leaves is intact" intact "$1"
    further=$(($(progress "$1") + 1))
    check "$1: is resumed, and interrupted" stop "${signal:-INT}" "$1" $((further > $2 / 3 ? further : $2 / 3))
    check "$1: what it leaves is intact" intact "$1"
    check "$1: is resumed, and ends" finish "$1"
}

# resumes NAME WORD...: the words are a command line. With $together, what is stopped takes as many trainings at a time, with $devices=2 on
# two devices; what it is compared with takes one.
resumes() {
    local name=$1 words=("${@:2}")
    is_chosen "$name" || return 0
    check "$name: without interruption" finish "whole_$name"
    [[ -z ${together:-} ]] || words+=(--together "$together")
    if [[ -n ${devices:-} ]]; then
        on_two_devices words stops "$name" "$(progress "whole_$name")"
    else
        stops "$name" "$(progress "whole_$name")"
    fi
    check "$name: leaves the same" same_contents "whole_$name" "$name"
}

resumes value value "$scene" --resume --epochs 80 "${small[@]}" --effects visibility
by=$lab signal=TERM together=3 resumes benchmark benchmark "$tiny" --subsets 8 --curves none --epochs 24 "${tiny_field[@]}"
devices=2 resumes compare compare "$tiny" --list all --list "$folder/half.txt" --list random --seeds 2 --epochs 100 \
     "${tiny_field[@]}"
# The other commands stop and resume as these do.
if [[ -n ${VIEWWORTH_FULL:-} || ${#chosen[@]} -gt 0 ]]; then
    signal=TERM resumes train train "$scene" --resume --epochs 80 "${small[@]}"
    by=$lab resumes same-state value "$scene" --resume --epochs 90 "${small[@]}" --same-state 3
    by=$lab together=3 resumes reproduce reproduce "$scene" --seeds 3 --epochs 15 "${small[@]}"
    together=2 resumes tradeoff tradeoff "$tiny" --seeds 2 --epochs 40 --parameters epochs "${tiny_field[@]}"
fi

# A budget chooses options when the run starts. A resumed run keeps them, and the printed options give the same run.
if [[ -n ${VIEWWORTH_FULL:-} || " ${chosen[*]} " == *" budget "* ]]; then
    own=(--rays 64 --samples 16 --val-rays 64 --levels 4 --effects none --device llvmpipe)
    words=(value "$scene" --resume --budget 10s --epochs 60 "${own[@]}")
    check "budget: is killed" stop KILL budget 37
    check "budget: what it leaves is intact" intact budget
    check "budget: is resumed, and ends" finish budget
    check "budget: takes no more epochs than were asked for" test "$(query budget 'SELECT max(step) FROM step')" -le $((60 * 12))
    read -ra printed <<<"$(sed -n 's/.*the same bits by //p' "$folder/stdout")"
    words=(value "$scene" "${printed[@]}" "${own[@]}")
    check "budget: the printed options" finish whole_budget
    check "budget: leave the same" same_contents whole_budget budget
fi
conclude "$@"
