#include "gpu/barrier.h"

void vw_barrier_record(VkCommandBuffer commands, struct vw_barrier_params params) {
    const VkPipelineStageFlags device = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT |
                                        (params.indirect ? VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT : 0);
    const VkAccessFlags writes = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    const VkAccessFlags reads = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                                (params.indirect ? VK_ACCESS_INDIRECT_COMMAND_READ_BIT : 0);
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = writes,
                                     .dstAccessMask =
                                         reads | writes | (params.host_reads ? VK_ACCESS_HOST_READ_BIT : 0)};
    vkCmdPipelineBarrier(commands, device, device | (params.host_reads ? VK_PIPELINE_STAGE_HOST_BIT : 0), 0, 1,
                         &barrier, 0, NULL, 0, NULL);
}
