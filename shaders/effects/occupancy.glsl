// Where training need not look: a grid of cells over the box, each with its density of late (Mueller et al., "Instant
// neural graphics primitives", SIGGRAPH 2022, the appendix on occupancy grids). Samples in empty cells count as density
// 0 and are not evaluated. Validation never skips.
#ifndef OCCUPANCY_GLSL
#define OCCUPANCY_GLSL

uint occupancy_cell(vec3 position) {
    uvec3 cell = min(uvec3(position * float(VW_OCCUPANCY_SIDE)),
                     uvec3(VW_OCCUPANCY_SIDE - 1u)); // position 1.0 belongs to the last cell
    return cell.x + VW_OCCUPANCY_SIDE * (cell.y + VW_OCCUPANCY_SIDE * cell.z);
}

// A density that is not a number counts, so that it is met and noticed.
bool occupied(float density) { return density > VW_EMPTY_DENSITY(float(SAMPLES)) || !finite(density); }

#endif
