// Notes in the map of cells which tile of the list each cell is. Cells of no tile keep what they had: a reader asks the
// tile whether it is of the cell.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_SPLAT_TILES) readonly buffer Tiles { vw_splat_tile tiles[]; };
BUFFER(VW_SLOT_TILE_MAP) writeonly buffer Map { uint tile_map[]; };
PUSH uniform Push { vw_push_splats push; };

void main() {
    uint tile = invocation_index();
    if (tile >= push.tile_count) return;
    tile_map[tiles[push.first_tile + tile].cell] = tile;
}
