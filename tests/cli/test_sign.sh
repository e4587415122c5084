#!/usr/bin/env bash
# keygen, --sign, verify --key and the table of verify from outside; test_run_verify.c has the attacks. Takes the program's path.
# label: once
set -uo pipefail
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/tests/support/tiny.json
key=$folder/key

value() { "$program" value "$scene" --out "$folder/$1" "${small[@]}" --epochs 3 --quiet "${@:2}"; }
train() { "$program" train "$scene" --out "$folder/$1" "${small[@]}" --epochs 2 --quiet "${@:2}"; }
verify() { "$program" verify "$folder/$1" "${@:2}"; }
row() { prints "^$1 +$2( |$)" verify "${@:3}"; } # row ITEM RESULT OUT [OPTION]...: of verify's table
json() { # json SQL OUT [OPTION]...: verify --json prints a j of which it is true
    verify "${@:2}" --json >"$folder/answer.json" &&
        [[ $(sqlite3 :memory: "WITH a AS (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j) SELECT $1 FROM a") == 1 ]]
}
said() { grep -qE -- "$1" "$folder/stderr"; }
files() { (cd "$folder/$1" && sha256sum -- *); }

# ---- Keys ---------------------------------------------------------------------------------------------------------------

check "keygen makes a pair" prints '^public key  .*key\.pub ' "$program" keygen --to "$key"
check "its secret half is for its owner alone" test "$(stat -c %a "$key")" = 600
check "which is told nowhere" test "$(grep -cF "$(sed -n 2p "$key")" "$folder/stdout" "$folder/stderr" | grep -vc ':0$')" = 0
check "keys are not overwritten" fails 2 'key: is there already' "$program" keygen --to "$key"
check "--to is needed" fails 2 '--to is missing' "$program" keygen
check "a folder that is not there is named" fails 1 'no/key: cannot create' "$program" keygen --to "$folder/no/key"

# ---- Signing ------------------------------------------------------------------------------------------------------------

check "a wrong key is refused before any step" fails 2 '--sign: .*key\.pub: is a public key' value none --sign "$key.pub"
check "and leaves nothing" test ! -e "$folder/none/ledger.db"
check "value signs" run value run --sign "$key"
check "the signature holds" row signature intact run --key "$key.pub"
check "and covers the report" row report.html intact run --key "$key.pub"
check "--json tells it" json "j ->> 'signed' = 1 AND j ->> 'intact' = 1 AND (SELECT count(*) FROM json_each(j, '\$.checks')
    WHERE value ->> 'item' = 'report.html' AND value ->> 'result' = 'intact') = 1" run --key "$key.pub"
check "without --key it is not checked" row signature 'not checked' run
check "nor is the report" row report.html 'not checked' run
check "a secret key is no public one" fails 2 'key: is a secret key' verify run --key "$key"
check "a file that is no key is named" fails 2 'scores\.csv: is no public key' verify run --key "$folder/run/scores.csv"
check "reproduce signs nothing" fails 2 'unknown option "--sign"' "$program" reproduce "$scene" --out "$folder/many" --sign "$key"

chmod 644 "$key"
value open --sign "$key" >/dev/null 2>"$folder/stderr"
check "a secret key that others may read is a warning" said '^warning: .*key: others may read this secret key'
chmod 600 "$key"

check "train signs" run train trained --sign "$key"
check "its signature holds" row signature intact trained --key "$key.pub"
printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.3\n1,0,a,11,0.2\n2,0,b,12,0.1\n3,1,a,13,0.1\n4,1,b,14,0.1\n' >"$folder/log.csv"
check "import-steps signs" run "$program" import-steps "$folder/log.csv" --out "$folder/imported" --sign "$key"
check "its signature holds" row signature intact imported --key "$key.pub"
check "an unsigned run is not signed" eval 'run value plain; fails 1 "signature.json: is not there: the run is not signed" \
    verify plain --key "$key.pub"'
check "a finished run is signed afterwards" eval 'run value plain --resume --sign "$key"; row signature intact plain --key "$key.pub"'
check "an edited run is not signed" eval 'echo >>"$folder/plain/scores.csv"; fails 1 "--sign: .*scores.csv: is not what the ledger gives" \
    value plain --resume --sign "$key"'

# ---- Verifying ----------------------------------------------------------------------------------------------------------

before=$(files run)
check "a folder that cannot be written is verified" eval 'chmod 500 "$folder/run"; row scores.csv intact run --key "$key.pub"'
chmod 700 "$folder/run"
check "verify writes nothing" test "$(files run)" = "$before"
check "a replay settles what the ledger claims" row 'scene, shaders, device' intact run --replay 3
check "without one it is a claim" row 'scene, shaders, device' claimed run
sqlite3 "$folder/trained/ledger.db" "UPDATE image SET sha256 = replace(sha256, '1', '2')"
check "an edited photo is found" fails 1 'image row was edited' verify trained
check "another page in place of the report is found" eval 'echo "<p>" >"$folder/run/report.html"
    fails 1 "report.html: is not the file that was signed" verify run --key "$key.pub"'
check "a link in place of a table is not followed" eval 'ln -sf "$folder/open/matrix.csv" "$folder/run/matrix.csv"
    ! verify run 2>&1 | grep -q intact'

# The box that an effect chooses, on which run_id depends.
check "the identity of an unbounded run follows from its ledger" eval 'run value far --effects unbounded; row identity intact far'
check "so does that of a run in a wide box" eval 'run value wide --effects wide_box; row identity intact wide'
conclude "$@"
