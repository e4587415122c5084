// One ray per pixel: the camera model and the box, and the target colour composited on the background. In training the
// effects pose and appearance correct cameras and colours.
#include "rays/background.glsl"
#include "rays/camera.glsl"
#include "effects/appearance/appearance.glsl"
#include "effects/pose/pose.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_PIXELS) readonly buffer Pixels { vw_pixel pixels[]; };
BUFFER(VW_SLOT_APPEARANCE) readonly buffer Appearance { vw_appearance appearance[]; };
BUFFER(VW_SLOT_POSES) readonly buffer Poses { vw_pose poses[]; };
BUFFER(VW_SLOT_RAYS) writeonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_STEP_STATE) writeonly buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_rays push; };

void main() {
    uint index = invocation_index();
    if (EFFECT_APPEARANCE != 0u || EFFECT_APPEARANCE_CODE != 0u || EFFECT_APPEARANCE_ENCODER != 0u ||
        EFFECT_VISIBILITY != 0u || EFFECT_TRANSIENT != 0u || EFFECT_POSE != 0u)
        if (index == 0u) state.view = pixels[push.first_pixel].view;
    if (index >= rays.length()) return;
    vw_pixel pixel = pixels[push.first_pixel + min(index, push.ray_count - 1u)];
    vw_gpu_camera camera = cameras[pixel.view];
    if (EFFECT_POSE != 0u) camera = corrected_camera(camera, poses[pixel.view]);
    vw_ray ray = camera_ray(camera, vec2(pixel.x_px, pixel.y_px));
    if (EFFECT_APPEARANCE != 0u) pixel.rgba.rgb = correct(appearance[pixel.view], pixel.rgba.rgb);
    precise vec3 target = pixel.rgba.rgb; // not mix(), of which GPUs make background + a (target - background)
    if (EFFECT_BACKGROUND != 0u)
        target = pixel.rgba.a * target + (1.0 - pixel.rgba.a) * background_colour(index, push.key);
    ray.target_weight = vec4(target, index < push.ray_count ? pixel.weight : 0.0);
    rays[index] = ray;
}
