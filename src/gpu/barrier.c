#include "gpu/barrier.h"

void vw_barrier_record(VkCommandBuffer commands, bool host_reads) {
    const VkPipelineStageFlags device =
        VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    const VkAccessFlags writes = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    const VkAccessFlags reads =
        VK_ACCESS_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT;
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = writes,
                                     .dstAccessMask = reads | writes | (host_reads ? VK_ACCESS_HOST_READ_BIT : 0)};
    vkCmdPipelineBarrier(commands, device, device | (host_reads ? VK_PIPELINE_STAGE_HOST_BIT : 0), 0, 1, &barrier, 0,
                         NULL, 0, NULL);
}
