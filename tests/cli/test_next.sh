#!/usr/bin/env bash
# next from outside: places among poses of a file, by every method, and what is refused. Takes the program's path.
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
first=$(sqlite3 :memory: "SELECT CAST(readfile('$folder/cameras.json') AS TEXT) ->> '\$.cameras[0].name'")

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
check "a photo that there is gains nothing alone" test "$(json '$.candidates[0].name'), $(json '$.candidates[0].gain')" = "$first, 0.0"
for method in farthest coverage nearest-error fisher farthest-error spread; do
    check "three by $method" next --count 3 --json --method "$method"
    cp "$folder/stdout" "$folder/once.json"
    check "  gains are numbers" test "$(sqlite3 :memory: "SELECT count(*) FROM json_each(CAST(readfile('$folder/once.json') AS TEXT),
        '\$.candidates') WHERE value ->> '\$.gain' >= 0")" = 10
    check "  again, with other threads" eval 'LP_NUM_THREADS=1 next --count 3 --json --method "$method"'
    check "  the same bits" cmp "$folder/stdout" "$folder/once.json"
done
check "a text" eval 'next --count 1 && says "^ 1 .* away.png$"'
check "another method is refused by its names" refuses '--method nearest: does not score places; one of these does: farthest, coverage' \
    --method nearest --among "$folder/poses.json"
check "without poses it is refused" refuses '--among'
printf '{"frames": [{"transform_matrix": 3}]}' >"$folder/bad.json"
check "a bad file is refused" refuses 'bad\.json: frame 0' --among "$folder/bad.json"
conclude
