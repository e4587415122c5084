#!/usr/bin/env bash
# export from outside: cameras and points of a tiny run, as another program reads them, and what is refused. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
out=$folder/run
refuses() { fails 2 "$1" "$program" export "$out" "${@:2}" --device llvmpipe --quiet; } # refuses PATTERN ARGUMENT...
export_to() { run "$program" export "$out" "$@" --device llvmpipe; }
rows() { sed '1,/^end_header$/d' "$1"; }

check "a run" run "$program" value "$scene" --out "$out" --epochs 3 "${small[@]}"
check "nothing to export is refused" refuses 'give --cameras'
check "another ending is refused" refuses '--points .*\.ply' --points "$folder/p.json"
check "cameras as JSON and points" export_to --cameras "$folder/c.json" --points "$folder/p.ply"
check "names, poses and scores are there" answers "json_array_length(j, '\$.cameras') = 9 AND j ->> '\$.method' = 'dv_psnr'
    AND j ->> '\$.cameras[0].camera_to_world[3][3]' = 1 AND j ->> '\$.cameras[0].size_px[0]' = 16
    AND j ->> '\$.cameras[0].position[1]' = j ->> '\$.cameras[0].camera_to_world[1][3]'" cat "$folder/c.json"
check "a photo is valued, and coloured, exactly if it trains" answers "(SELECT count(*) = 9 AND sum((value ->> '\$.split' = 'train')
    = (value ->> '\$.score' IS NOT NULL) AND (value ->> '\$.split' = 'train') = (value ->> '\$.colour' <> '[128,128,128]')) = 9
    FROM json_each(j, '\$.cameras'))" cat "$folder/c.json"
check "the best photo is yellow" answers "(SELECT value ->> '\$.colour' = '[253,231,37]' FROM json_each(j, '\$.cameras')
    ORDER BY value ->> '\$.score' DESC LIMIT 1)" cat "$folder/c.json"
check "every point is there" test "$(rows "$folder/p.ply" | awk 'NF == 6' | wc -l)" = "$(sed -n 's/^element vertex //p' "$folder/p.ply")"
check "cameras as PLY" export_to --cameras "$folder/c.ply"
check "five corners and six faces each" test "$(rows "$folder/c.ply" | awk 'NF == 6 { v++ } NF == 4 { f++ } END { print v, f }')" = "45 54"
check "the first is the camera's centre" near "$(rows "$folder/c.ply" | awk 'NR == 1 { print $2 }')" \
    "$(sqlite3 :memory: "SELECT CAST(readfile('$folder/c.json') AS TEXT) ->> '\$.cameras[0].position[1]'")"
check "an existing file is refused" refuses 'exists' --cameras "$folder/c.ply"
check "--json says what was written" answers "j ->> '\$.cameras' IS NULL AND j ->> '\$.points' = '$folder/q.ply'" \
    "$program" export "$out" --points "$folder/q.ply" --device llvmpipe --json --quiet

# Five photos with poses and nothing else.
mkdir "$folder/bare"
for i in 0 1 2 3 4; do write_photo "$folder/bare/$i.png"; printf '%s' "$i" >>"$folder/bare/$i.png"; done
sqlite3 :memory: "SELECT json_object('camera_angle_x', 0.8, 'frames', json_group_array(json_object('file_path', value || '.png',
    'transform_matrix', json('[[1,0,0,' || value || '],[0,1,0,0],[0,0,1,3],[0,0,0,1]]')))) FROM json_each('[0,1,2,3,4]')" \
    >"$folder/bare/transforms.json"
out=$folder/bare.run
check "a run without points" run "$program" value "$folder/bare" --out "$out" --epochs 3 "${small[@]}"
check "points are refused, and why is said" refuses 'no points from structure from motion' --points "$folder/none.ply"
conclude
