#!/usr/bin/env bash
# next from outside: places among poses of a file and made ones, its files, and what is refused. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
out=$folder/run
next() { run "$program" next "$out" --among "$folder/poses.json" "$@" --device llvmpipe --quiet; }
refuses() { fails 2 "$1" "$program" next "$out" "${@:2}" --device llvmpipe --quiet; } # refuses PATTERN ARGUMENT...

check "a run" run "$program" value "$scene" --out "$out" --epochs 3 "${small[@]}"
check "cameras of the scene" run "$program" export "$out" --cameras "$folder/cameras.json" --device llvmpipe
# Where photos were taken, one place beside them, and one opposite of where all look.
sqlite3 :memory: "SELECT json_object('camera_angle_x', 0.8, 'frames', json_group_array(json_object('file_path', value ->> '\$.name',
    'transform_matrix', value -> '\$.camera_to_world'))) FROM (SELECT value FROM
    json_each(CAST(readfile('$folder/cameras.json') AS TEXT), '\$.cameras') UNION ALL SELECT json('{\"name\": \"away.png\",
    \"camera_to_world\": [[1,0,0,0],[0,1,0,0],[0,0,1,-9],[0,0,0,1]]}'))" >"$folder/poses.json"

check "places among ten" next --count 10 --json
check "are all of them, once" test "$(sqlite3 :memory: "SELECT count(DISTINCT value ->> '\$.name') FROM
    json_each(CAST(readfile('$folder/stdout') AS TEXT), '\$.proposals')")" = 10
check "farthest comes first" test "$(json '$.proposals[0].name')" = away.png
check "and photos that there are last" test "$(json '$.proposals[9].gain')" = 0.0
cp "$folder/stdout" "$folder/all.json"
check "again" next --count 10 --json
check "the same bits" cmp "$folder/stdout" "$folder/all.json"
second=$(json '$.proposals[1].name')
check "fewer" next --count 2 --json
check "begin with the same" test "$(json '$.proposals[1].name')" = "$second"
check "a gain is a distance times an error of validation photos" test "$(sqlite3 :memory: "SELECT json_extract(value, '\$.gain') /
    json_extract(value, '\$.distance') BETWEEN 0.01 AND 0.7 FROM json_each(CAST(readfile('$folder/all.json') AS TEXT), '\$.proposals')
    LIMIT 1")" = 1
check "with other threads" eval 'LP_NUM_THREADS=1 next --count 10 --json'
check "the same bits" cmp "$folder/stdout" "$folder/all.json"
sed 's/"camera_angle_x":0.8,//' "$folder/poses.json" >"$folder/plan.json"
check "a plan without a focal length" eval 'run "$program" next "$out" --among "$folder/plan.json" --count 11 --device llvmpipe'
check "has that of photos, and fewer places are a warning" eval 'says "^10 of 10 places, the farthest from photos first" &&
    grep -q "warning: 10 places were found for --count 11" "$folder/stderr"'
check "a text" eval 'next --count 1 && says "^ 1 .* away.png$"'
printf '{"w": 100, "h": 2000, "fl_x": 90, "frames": [{"file_path": "a", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,3],[0,0,0,1]]}]}' \
    >"$folder/tall.json"
check "renders have no side above 480 px" eval 'run "$program" next "$out" --among "$folder/tall.json" --device llvmpipe --quiet &&
    test "$(head -c 24 "$out/next_01.png" | tail -c 8 | od -An -tu1 | xargs)" = "0 0 0 24 0 0 1 224"'
printf '{"frames": [{"transform_matrix": 3}]}' >"$folder/bad.json"
check "a bad file is refused" refuses 'bad\.json: frame 0' --among "$folder/bad.json"

# ---- Places that are made, and files --------------------------------------------------------------------------------------

made() { run "$program" next "$out" "$@" --device llvmpipe --quiet; }
sums_hold() { (cd "$out" && sha256sum --check --quiet SHA256SUMS) && run "$program" verify "$out" --device llvmpipe --quiet; }
rm "$out"/next*
cp "$out/report.html" "$folder/report.html"
printf mine >"$out/next_05.png"
check "places around the cameras" made --count 3 --json
check "are written, with what was printed" answers "j -> '\$.proposals' =
    (SELECT CAST(readfile('$folder/stdout') AS TEXT) -> '\$.proposals') AND json_array_length(j, '\$.proposals') = 3
    AND j ->> '\$.proposals[2].render' = 'next_03.png'
    AND j ->> '\$.proposals[0].move' LIKE '%: %'" sqlite3 :memory: "SELECT json(CAST(readfile('$out/next.json') AS TEXT))"
check "with a picture each" test "$(head -qc 8 "$out"/next_0[123].png | grep -ac PNG)" = 3
check "and no other file is touched" test "$(cat "$out/next_05.png")" = mine
check "nor the list of results" sums_hold
cp -r "$out" "$folder/first"
check "again" made --count 3
check "the same bits" diff -r "$out" "$folder/first"
check "five of them" made --count 5 --to "$folder/to.json"
check "and two" made --count 2 --to "$folder/to.ply"
check "leave no picture of a third" test "$(cd "$out" && echo next*)" = "next.json next_01.png next_02.png"
check "poses for other programs are proposed in the same order" eval 'made --among "$folder/to.json" --count 5 --json &&
    test "$(json "\$.proposals[0].name"), $(json "\$.proposals[4].name")" = "next_01.png, next_05.png"'
check "with their size, focal length and reason" answers "j ->> '\$.frames[4].w' = 16 AND j ->> '\$.frames[4].fl_x' > 1
    AND j -> '\$.frames[4].reason' IS NOT NULL AND j ->> '\$.frames[4].transform_matrix[3][3]' = 1" cat "$folder/to.json"
check "a pyramid each" grep -qx 'element vertex 10' "$folder/to.ply"
check "the first is yellow, the last violet" test "$(sed '1,/^end_header$/d' "$folder/to.ply" | sed -n '1p;10p' | cut -d' ' -f4- |
    xargs)" = "253 231 37 68 1 84"
check "where poses cannot be written, it fails" eval 'made --count 5 && cp -r "$out" "$folder/before" &&
    fails 1 nodir "$program" next "$out" --to "$folder/nodir/x.json" --device llvmpipe --quiet'
check "and touches nothing" diff -r "$out" "$folder/before"
rm "$out/next.json"
check "the name of a file of OUT is refused" refuses '--to .*next.json: commands write' --to "$out/../run/next.json"
check "and not made" test ! -e "$out/next.json"
check "nor do pictures stay whose list is gone" eval 'made --count 2 &&
    test "$(cd "$out" && echo next*)" = "next.json next_01.png next_02.png"'
check "a camera model that all frames share" answers "j ->> '\$.camera_model' = 'OPENCV'" cat "$folder/to.json"
check "an existing file is refused" refuses '--to .*to.json: exists' --to "$folder/to.json"
check "so is another ending" refuses '--to .*must end in .ply or .json' --to "$folder/to.csv"
check "the report stays until it is made again" cmp "$out/report.html" "$folder/report.html"
check "then it shows them, and the list has it" eval 'run "$program" report "$out" --quiet && sums_hold &&
    grep -q "\"next\":{" "$out/report.html"'
rm "$out/next_01.png" && mkdir "$out/next_01.png"
check "where a picture cannot be written, it fails" fails 1 'next_01.png' "$program" next "$out" --count 2 --to "$folder/failed.ply" \
    --device llvmpipe --quiet
check "and leaves no list of places" test ! -e "$out/next.json"
check "nor poses whose pictures are not there" test ! -e "$folder/failed.ply"
check "and a report without them has the bytes that it had" eval 'run "$program" report "$out" --quiet &&
    cmp "$out/report.html" "$folder/report.html"'
rmdir "$out/next_01.png"
check "new steps take places away" eval 'made --count 2 && run "$program" value "$scene" --out "$out" --resume --epochs 4 "${small[@]}" &&
    test ! -e "$out/next.json"'
out=$folder/trained
check "a run that trains alone" run "$program" train "$scene" --out "$out" --epochs 3 "${small[@]}"
check "has places, too" made --count 2
rm "$out/field.vwf"
check "without its field it is refused" refuses 'field.vwf: no such file'
query trained "UPDATE run SET status = 'interrupted'"
check "so is one that has not ended" refuses 'field.vwf: is missing, as the run is interrupted; go on by'
conclude
