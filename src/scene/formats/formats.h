// The formats of scenes, each with its probe and loader; the table of them is in scene.c.
#ifndef VIEWWORTH_SCENE_FORMATS_FORMATS_H
#define VIEWWORTH_SCENE_FORMATS_FORMATS_H

#include "scene/builder.h"

// A scene format. If its loader assigns no view to val or test, split.c decides the splits.
struct vw_scene_format {
    const char *name;                // as --format takes it
    bool (*probe)(const char *path); // whether the path has this format
    enum vw_status (*load)(struct vw_scene_builder *builder);
};

bool vw_transforms_probe(const char *path);
enum vw_status vw_transforms_load(struct vw_scene_builder *builder); // transforms*.json
bool vw_phototourism_probe(const char *path);
enum vw_status vw_phototourism_load(struct vw_scene_builder *builder); // NeRF-W's Phototourism scenes
bool vw_colmap_probe(const char *path);
enum vw_status vw_colmap_load(struct vw_scene_builder *builder); // photos in images/, or in dense/images

#endif
