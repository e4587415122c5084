#!/usr/bin/env bash
# viewworth check: every defect of the courtyard with its reason and nothing more, in text, JSON and CSV, without a device where none is
# needed; and that a run advises by it.
# usage: test_check.sh VIEWWORTH
set -uo pipefail
cd "$(dirname "$0")/../.."
. tests/support/shell_test.sh
viewworth=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# answers SQL COMMAND...: the condition on the column j holds of the JSON that the command prints.
answers() {
    local sql=$1
    shift
    "$@" >"$folder/answer.json" 2>/dev/null || return 1
    [[ $(sqlite3 :memory: "CREATE TABLE t (j); INSERT INTO t VALUES (CAST(readfile('$folder/answer.json') AS TEXT));
        SELECT $sql FROM t") == 1 ]]
}

# first_defects: lists photos with a defect and the first of them, sorted, from the table.
first_defects() { sqlite3 -separator ' ' :memory: ".import --csv $1 t" "SELECT name,
    substr(defects || ';', 1, instr(defects || ';', ';') - 1) FROM t WHERE defects != '' ORDER BY name"; }

# Labels of the recipe by the ledger of a run, in the words of the check: a Gaussian blur is seen through the pixels' grid, along which it
# may be uneven.
truth() { sqlite3 -separator ' ' "$1" "SELECT name, CASE ground_truth WHEN 'wrong_pose' THEN 'pose' ELSE ground_truth END FROM image
    WHERE ground_truth != 'clean' ORDER BY name"; }

check "the courtyard is checked" "$viewworth" check scenes/courtyard.json --to "$folder/check.csv" >"$folder/text" 2>/dev/null
check "a run of one epoch notes the truth" eval '"$viewworth" value scenes/courtyard.json --out "$folder/out" --field hash --rays 16 \
    --samples 4 --epochs 3 --effects none --no-thumbnails >/dev/null 2>"$folder/log"'
check "  and says first what is wrong, in short" test "$(sed '/^epoch/,$d' "$folder/log" | grep -cE '^look at  view_[0-9]+: '
    ) $(sed '/^epoch/,$d' "$folder/log" | grep -c 'and 4 more: viewworth check has all photos')" = '8 1'
check "info has them all" answers "json_array_length(j, '\$.defects') = 12" "$viewworth" info scenes/courtyard.json --effects none --json
check "twelve of twelve, each with its reason, and no other photo" diff <(first_defects "$folder/check.csv" | sed 's/motion blur/blur/') \
    <(truth "$folder/out/ledger.db")
check "the text counts them" grep -q '^found    12 photos to look at$' "$folder/text"
check "  and says what to do" grep -qE '^view_007 +pose +taken 8\.0 degrees .* off its pose +correct its pose' "$folder/text"
check "the turned poses are measured" test "$(sqlite3 :memory: ".import --csv $folder/check.csv t" "SELECT count(*) FROM t
    WHERE defects LIKE 'pose%' AND abs(turned_deg - 8) < 0.3")" = 3
check "--json has all photos, and their evidence" answers "j ->> '\$.found' = 12 AND json_array_length(j, '\$.checks') = 48
    AND j ->> '\$.checks[7].turned_deg' > 7 AND json_type(j, '\$.checks[1].remedy') = 'null'" \
    "$viewworth" check scenes/courtyard.json --json
check "the run says look at these that train, whatever their credit" \
    diff <(sqlite3 -separator ' ' :memory: ".import --csv $folder/out/advice.csv t" "SELECT name, reason FROM t
    WHERE advice = 'look' AND description != '' ORDER BY name" | sed 's/motion blur/blur/') \
    <(sqlite3 -separator ' ' "$folder/out/ledger.db" "SELECT name, CASE ground_truth WHEN 'wrong_pose' THEN 'pose' ELSE ground_truth END
    FROM image WHERE ground_truth != 'clean' AND split = 'train' ORDER BY name")
check "advice has the evidence" grep -q '^name,advice,reason,.*,description,in_place,hidden_share,turned_deg,stops,' \
    "$folder/out/advice.csv"

# refused STATUS TEXT COMMAND...: the command fails with the status, and its last line says so.
refused() {
    local status=$1 text=$2
    shift 2
    "$@" >/dev/null 2>"$folder/error"
    [[ $? -eq $status ]] && tail -1 "$folder/error" | grep -q "$text"
}

# Photos of two walls of noise, of a camera that moves to the right; the pose of one is turned by 3 degrees in the file.
turned=$(awk 'BEGIN { a = 3 * atan2(0, -1) / 180
    printf "[%.17g,0,%.17g,0],[0,1,0,0],[%.17g,0,%.17g,4]", cos(a), sin(a), -sin(a), cos(a) }')
mkdir -p "$folder/walls/images"
for k in {0..11}; do
    awk -v k="$k" '
        function draw(x, y) { n = sin(x * 12.9898 + y * 78.233) * 43758.5453; return n - (n < 0 ? int(n) - 1 : int(n)) }
        function smooth(x, y, i, j, u, v) {
            i = int(x + 100) - 100; j = int(y + 100) - 100; u = x - i; v = y - j
            return (1 - v) * ((1 - u) * draw(i, j) + u * draw(i + 1, j)) + v * ((1 - u) * draw(i, j + 1) + u * draw(i + 1, j + 1)) }
        BEGIN {
            print "P2 128 96 255"
            for (y = 0; y < 96; y++) for (x = 0; x < 128; x++) {
                far = x + 7 * k < 104 ? 4 : 3; u = (x - 63.5) / 100 * far + 0.2 * (k - 6); v = (y - 47.5) / 100 * far
                printf "%d\n", 40 + 110 * smooth(4 * u, 4 * v) + 70 * smooth(11 * u, 11 * v)
            } }' >"$folder/walls/images/$k.pgm"
done
{
    printf '{"fl_x": 100, "fl_y": 100, "cx": 64, "cy": 48, "w": 128, "h": 96, "frames": ['
    for k in {0..11}; do
        [[ $k -eq 0 ]] || printf ', '
        pose="[1,0,0,$(awk -v k="$k" 'BEGIN {print 0.2 * (k - 6)}')],[0,1,0,0],[0,0,1,4]"
        [[ $k -ne 6 ]] || pose=$turned
        printf '{"file_path": "images/%d.pgm", "transform_matrix": [%s,[0,0,0,1]]}' "$k" "$pose"
    done
    printf ']}'
} >"$folder/walls/transforms.json"
largest() { # largest K: the largest difference of the copy's turn of photo K from none
    sqlite3 :memory: "WITH f AS (SELECT value AS f FROM json_each(CAST(readfile('$folder/mended/transforms.json') AS TEXT), '\$.frames')
        WHERE value ->> '\$.file_path' = 'images/$1.pgm'), i(i) AS (VALUES (0), (1), (2)), j(j) AS (VALUES (0), (1), (2))
        SELECT max(abs((f ->> ('\$.transform_matrix[' || i || '][' || j || ']')) - (i = j))) FROM f, i, j"
}
check "a scene is copied with the pose that was found" answers "j ->> '\$.found' = 1 AND j ->> '\$.mended' = 1
    AND j ->> '\$.checks[6].defects' = 'pose'" "$viewworth" check "$folder/walls" --copy "$folder/mended" --json
check "  to a fifth of a degree" test "$(sqlite3 :memory: "SELECT $(largest 6) BETWEEN 1e-9 AND 0.0035")" = 1
check "  and the others as they were" test "$(largest 5) $(largest 7)" = '0.0 0.0'
check "it has no defect any more" answers "j ->> '\$.found' = 0 AND json_array_length(j, '\$.checks') = 12" \
    "$viewworth" check "$folder/mended" --json
check "a folder that is there is refused" refused 2 'mended: exists; name a new' "$viewworth" check "$folder/walls" --copy "$folder/mended"
check "a recipe has nothing to copy" refused 2 'a recipe has no photo files' "$viewworth" check scenes/eight.json --copy "$folder/copy"
check "a table that cannot be written fails" refused 1 "no-such-folder" "$viewworth" check scenes/eight.json \
    --to "$folder/no-such-folder/t.csv"
check "a scene that is missing is refused" refused 2 "no-such-scene" "$viewworth" check "$folder/no-such-scene"
conclude "$@"
