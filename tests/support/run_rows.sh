# For tests/*/test_*.sh that compare runs, to be sourced after $folder is set: queries on $folder/RUN/ledger.db.

query() { sqlite3 "$folder/$1/ledger.db" "$2"; }

# All rows that the same command must leave again, with the chain's hashes.
rows() {
    query "$1" "SELECT * FROM step ORDER BY step; SELECT * FROM view ORDER BY step, image_id;
                SELECT * FROM score ORDER BY image_id, method"
}

same_rows() { # same_rows RUN RUN: whole runs
    diff <(rows "$1") <(rows "$2") >"$folder/diff" && [[ $(query "$2" 'SELECT count(*) FROM step') -gt 1 ]] && return
    head -n 5 "$folder/diff"
    return 1
}

same_run() { # the trained field and the table of scores, too
    same_rows "$1" "$2" && cmp "$folder/$1/field.vwf" "$folder/$2/field.vwf" && cmp "$folder/$1/scores.csv" "$folder/$2/scores.csv"
}
